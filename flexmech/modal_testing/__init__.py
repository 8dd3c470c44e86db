"""Hammer tests of a laboratory: signals and identification, for any structure.

This room knows arrays alone and nothing of mechanisms: windows, averages and noise of records,
frequency-response functions, and the modes that are identified from them.
"""

from flexmech.modal_testing.estimate import (
    ExponentialWindow,
    ForceWindow,
    FrfEstimate,
    estimate_frf,
    with_noise,
)
from flexmech.modal_testing.harmonic_orders import (
    HarmonicEstimate,
    estimate_harmonics,
    without_synchronous_average,
)
from flexmech.modal_testing.identified import IdentifiedModes, complexity_factor, mac
from flexmech.modal_testing.identify import ORDERS, IdentificationMethod, identify
from flexmech.modal_testing.lscf import StabilisationChart
from flexmech.modal_testing.noise import FrfNoise

__all__ = [
    "ORDERS",
    "ExponentialWindow",
    "ForceWindow",
    "FrfEstimate",
    "FrfNoise",
    "HarmonicEstimate",
    "IdentificationMethod",
    "IdentifiedModes",
    "StabilisationChart",
    "complexity_factor",
    "estimate_frf",
    "estimate_harmonics",
    "identify",
    "mac",
    "with_noise",
    "without_synchronous_average",
]
