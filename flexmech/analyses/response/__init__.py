"""The linkage running: response in time at constant crank speed."""

from flexmech.analyses.response.compute import response
from flexmech.analyses.response.request import STARTS, ResponseRequest
from flexmech.analyses.response.result import Response
from flexmech.analyses.response.spectra import Spectrogram, ridge

__all__ = [
    "STARTS",
    "Response",
    "ResponseRequest",
    "Spectrogram",
    "response",
    "ridge",
]
