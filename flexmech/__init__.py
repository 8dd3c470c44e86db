"""Flexible linkages: moving natural frequencies and response, by two independent engines.

Examples
--------
>>> import numpy as np
>>> import flexmech
>>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
>>> engine = flexmech.ReferenceEngine(mechanism, elements=8)
>>> result = flexmech.moving_frequencies(engine, np.radians([0, 60, 120]), [0, 20])
>>> result.dataset["frequency"].shape
(1, 2, 3, 4)

>>> request = flexmech.ResponseRequest(flexmech.CrankDrive(20.0), revolutions=0.25)
>>> run = flexmech.response(engine, request)
>>> [str(name) for name in run.dataset["deflection"].dims]
['engine', 'time', 'link']

``result.plot()`` gives a matplotlib figure and ``result.save(folder)`` writes files. The
Exudyn engine is ``flexmech.ExudynEngine``.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from flexmech.analyses import MovingFrequencies, moving_frequencies, natural_frequencies
    from flexmech.analyses.response import (
        Response,
        ResponseRequest,
        SpeedSweep,
        response,
        speed_sweep,
    )
    from flexmech.errors import ComputationError, FlexmechError, InputError
    from flexmech.linkages import CrankDrive, FourBar, RotatingArm
    from flexmech.materials import Material
    from flexmech.mechanism import Mechanism, PointMass
    from flexmech.modelfile import load_mechanism
    from flexmech.multibody import ExudynEngine
    from flexmech.reference import ReferenceEngine
    from flexmech.sections import BeamSection

__all__ = [
    "BeamSection",
    "ComputationError",
    "CrankDrive",
    "ExudynEngine",
    "FlexmechError",
    "FourBar",
    "InputError",
    "Material",
    "Mechanism",
    "MovingFrequencies",
    "PointMass",
    "ReferenceEngine",
    "Response",
    "ResponseRequest",
    "RotatingArm",
    "SpeedSweep",
    "load_mechanism",
    "moving_frequencies",
    "natural_frequencies",
    "response",
    "speed_sweep",
]

_HOMES = {
    "BeamSection": "sections",
    "ComputationError": "errors",
    "CrankDrive": "linkages",
    "ExudynEngine": "multibody",
    "FlexmechError": "errors",
    "FourBar": "linkages",
    "InputError": "errors",
    "Material": "materials",
    "Mechanism": "mechanism",
    "MovingFrequencies": "analyses",
    "PointMass": "mechanism",
    "ReferenceEngine": "reference",
    "Response": "analyses.response",
    "ResponseRequest": "analyses.response",
    "RotatingArm": "linkages",
    "SpeedSweep": "analyses.response",
    "load_mechanism": "modelfile",
    "moving_frequencies": "analyses",
    "natural_frequencies": "analyses",
    "response": "analyses.response",
    "speed_sweep": "analyses.response",
}


def __getattr__(name: str) -> Any:
    # Names are loaded when first used: the command line answers --help without waiting for
    # xarray or exudyn.
    if name not in _HOMES:
        raise AttributeError(f"module 'flexmech' has no attribute {name!r}")
    return getattr(import_module(f"flexmech.{_HOMES[name]}"), name)
