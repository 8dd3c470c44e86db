"""Time integration of the equations of motion by the trapezoidal rule and Lobatto's method."""

from flexmech.time_domain.integrators.linear_march import StepTable
from flexmech.time_domain.integrators.runs import StruckLinkage, linear_run, simulator, step_lag
from flexmech.time_domain.integrators.stretch_march import UnbalancedStepError

__all__ = [
    "StepTable",
    "StruckLinkage",
    "UnbalancedStepError",
    "linear_run",
    "simulator",
    "step_lag",
]
