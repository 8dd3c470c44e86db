"""Steady-state deflection against crank speed, and critical speeds."""

from flexmech.analyses.speed_sweep.compute import speed_sweep
from flexmech.analyses.speed_sweep.result import SpeedSweep

__all__ = ["SpeedSweep", "speed_sweep"]
