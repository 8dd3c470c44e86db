"""Periodic motion at constant crank speed, and the linear periodic system about it.

Periodic motion is found by shooting or, with nonlinear internal forces, by collocation; moving
modes make the small system whose stability and response are wanted.
"""
