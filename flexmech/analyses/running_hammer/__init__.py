"""Hammer test on the running linkage: harmonic transfer functions, identified and predicted."""

from flexmech.analyses.running_hammer.compute import running_hammer_test
from flexmech.analyses.running_hammer.request import RunningHammerRequest
from flexmech.analyses.running_hammer.result import RunningHammerTest

__all__ = ["RunningHammerRequest", "RunningHammerTest", "running_hammer_test"]
