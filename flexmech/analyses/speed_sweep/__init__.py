"""Steady-state deflection against crank speed, and critical speeds."""

from flexmech.analyses.speed_sweep.compute import (
    highest_frequency,
    periodic_peaks,
    quasi_static_peaks,
    speed_sweep,
    vibrating_linkage,
)
from flexmech.analyses.speed_sweep.result import SpeedSweep

__all__ = [
    "SpeedSweep",
    "highest_frequency",
    "periodic_peaks",
    "quasi_static_peaks",
    "speed_sweep",
    "vibrating_linkage",
]
