"""Steady-state deflection against crank speed, and critical speeds."""
