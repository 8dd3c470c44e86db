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
    from flexmech.hygrothermal import Exposure, HygrothermalState, mechanism_in_state
    from flexmech.linkages import (
        CouplerCurve,
        CouplerPoint,
        CrankDrive,
        FourBar,
        RotatingArm,
        double_points,
        synthesize_crank_rocker,
    )
    from flexmech.materials import (
        Laminate,
        Material,
        Ply,
        ply_from_constituents,
        published_constituents,
        woven_ply,
    )
    from flexmech.mechanism import Mechanism, PointMass
    from flexmech.modelfile import load_mechanism
    from flexmech.multibody import ExudynEngine
    from flexmech.reference import ReferenceEngine
    from flexmech.sections import BeamSection, LaminateSection

__all__ = [
    "BeamSection",
    "ComputationError",
    "CouplerCurve",
    "CouplerPoint",
    "CrankDrive",
    "Exposure",
    "ExudynEngine",
    "FlexmechError",
    "FourBar",
    "HygrothermalState",
    "InputError",
    "Laminate",
    "LaminateSection",
    "Material",
    "Mechanism",
    "MovingFrequencies",
    "Ply",
    "PointMass",
    "ReferenceEngine",
    "Response",
    "ResponseRequest",
    "RotatingArm",
    "SpeedSweep",
    "double_points",
    "load_mechanism",
    "mechanism_in_state",
    "moving_frequencies",
    "natural_frequencies",
    "ply_from_constituents",
    "published_constituents",
    "response",
    "speed_sweep",
    "synthesize_crank_rocker",
    "woven_ply",
]

_HOMES = {
    "BeamSection": "sections",
    "ComputationError": "errors",
    "CouplerCurve": "linkages",
    "CouplerPoint": "linkages",
    "CrankDrive": "linkages",
    "Exposure": "hygrothermal",
    "ExudynEngine": "multibody",
    "FlexmechError": "errors",
    "FourBar": "linkages",
    "HygrothermalState": "hygrothermal",
    "InputError": "errors",
    "Laminate": "materials",
    "LaminateSection": "sections",
    "Material": "materials",
    "Mechanism": "mechanism",
    "MovingFrequencies": "analyses",
    "Ply": "materials",
    "PointMass": "mechanism",
    "ReferenceEngine": "reference",
    "Response": "analyses.response",
    "ResponseRequest": "analyses.response",
    "RotatingArm": "linkages",
    "SpeedSweep": "analyses.response",
    "double_points": "linkages",
    "load_mechanism": "modelfile",
    "mechanism_in_state": "hygrothermal",
    "moving_frequencies": "analyses",
    "natural_frequencies": "analyses",
    "ply_from_constituents": "materials",
    "published_constituents": "materials",
    "response": "analyses.response",
    "speed_sweep": "analyses.response",
    "synthesize_crank_rocker": "linkages",
    "woven_ply": "materials",
}


def __getattr__(name: str) -> Any:
    # Names are loaded when first used: the command line answers --help without waiting for
    # xarray or exudyn.
    if name not in _HOMES:
        raise AttributeError(f"module 'flexmech' has no attribute {name!r}")
    return getattr(import_module(f"flexmech.{_HOMES[name]}"), name)
