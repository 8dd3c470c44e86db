"""Steady-state deflection against crank speed, and critical speeds."""

from flexmech.analyses.speed_sweep.compute import highest_frequency, speed_sweep, steady_peaks
from flexmech.analyses.speed_sweep.result import SpeedSweep

__all__ = ["SpeedSweep", "highest_frequency", "speed_sweep", "steady_peaks"]
