"""Flexible linkages: moving natural frequencies, by two independent engines.

Examples
--------
>>> import numpy as np
>>> import flexmech
>>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
>>> engine = flexmech.ReferenceEngine(mechanism, elements=8)
>>> result = flexmech.moving_frequencies(engine, np.radians([0, 60, 120]), [0, 20])
>>> result.dataset["frequency"].shape
(1, 2, 3, 4)

``result.plot()`` gives a matplotlib figure and ``result.save(folder)`` writes files. The
Exudyn engine is ``flexmech.ExudynEngine``.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from flexmech.analyses import MovingFrequencies, moving_frequencies, natural_frequencies
    from flexmech.errors import ComputationError, FlexmechError, InputError
    from flexmech.linkages import FourBar, RotatingArm
    from flexmech.materials import Material
    from flexmech.mechanism import Mechanism, PointMass
    from flexmech.modelfile import load_mechanism
    from flexmech.multibody import ExudynEngine
    from flexmech.reference import ReferenceEngine
    from flexmech.sections import BeamSection

__all__ = [
    "BeamSection",
    "ComputationError",
    "ExudynEngine",
    "FlexmechError",
    "FourBar",
    "InputError",
    "Material",
    "Mechanism",
    "MovingFrequencies",
    "PointMass",
    "ReferenceEngine",
    "RotatingArm",
    "load_mechanism",
    "moving_frequencies",
    "natural_frequencies",
]

_HOMES = {
    "BeamSection": "sections",
    "ComputationError": "errors",
    "ExudynEngine": "multibody",
    "FlexmechError": "errors",
    "FourBar": "linkages",
    "InputError": "errors",
    "Material": "materials",
    "Mechanism": "mechanism",
    "MovingFrequencies": "analyses",
    "PointMass": "mechanism",
    "ReferenceEngine": "reference",
    "RotatingArm": "linkages",
    "load_mechanism": "modelfile",
    "moving_frequencies": "analyses",
    "natural_frequencies": "analyses",
}


def __getattr__(name: str) -> Any:
    # Names are loaded when first used: the command line answers --help without waiting for
    # xarray or exudyn.
    if name not in _HOMES:
        raise AttributeError(f"module 'flexmech' has no attribute {name!r}")
    return getattr(import_module(f"flexmech.{_HOMES[name]}"), name)
