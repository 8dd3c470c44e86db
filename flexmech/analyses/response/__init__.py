"""The linkage running: response in time at constant crank speed."""

from flexmech.analyses.response.compute import response
from flexmech.analyses.response.request import STARTS, ResponseRequest
from flexmech.analyses.response.result import Response
from flexmech.analyses.response.spectra import Spectrogram, ridge
from flexmech.analyses.response.speed_sweep import SpeedSweep, speed_sweep

__all__ = [
    "STARTS",
    "Response",
    "ResponseRequest",
    "Spectrogram",
    "SpeedSweep",
    "response",
    "ridge",
    "speed_sweep",
]
