"""The linkage running: response in time at constant crank speed, and its Exudyn system."""

from flexmech.analyses.response.compute import exudyn_system, response
from flexmech.analyses.response.measurements import deflections, deflections_of, probes
from flexmech.analyses.response.request import ResponseRequest
from flexmech.analyses.response.result import Response

__all__ = [
    "Response",
    "ResponseRequest",
    "deflections",
    "deflections_of",
    "exudyn_system",
    "probes",
    "response",
]
