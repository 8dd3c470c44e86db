"""What a laboratory does with a hammer test: signals and identification, whatever was hit.

This room knows arrays alone and nothing of mechanisms: windows, averages and noise of records,
frequency-response functions, and the modes that are identified from them.
"""

from flexmech.modal_testing.estimate import FrfEstimate, estimate_frf, with_noise
from flexmech.modal_testing.harmonic_orders import HarmonicEstimate, estimate_harmonics
from flexmech.modal_testing.identified import IdentifiedModes
from flexmech.modal_testing.identify import (
    ORDERS,
    IdentificationMethod,
    best_method,
    identify,
)
from flexmech.modal_testing.lscf import check_lscf, has_lscf
from flexmech.modal_testing.shapes import complexity_factor, mac
from flexmech.modal_testing.stabilisation import StabilisationChart
from flexmech.modal_testing.synchronous import without_synchronous_average
from flexmech.modal_testing.windows import ExponentialWindow, ForceWindow

__all__ = [
    "ORDERS",
    "ExponentialWindow",
    "ForceWindow",
    "FrfEstimate",
    "HarmonicEstimate",
    "IdentificationMethod",
    "IdentifiedModes",
    "StabilisationChart",
    "best_method",
    "check_lscf",
    "complexity_factor",
    "estimate_frf",
    "estimate_harmonics",
    "has_lscf",
    "identify",
    "mac",
    "with_noise",
    "without_synchronous_average",
]
