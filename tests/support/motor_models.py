"""The slider-crank of validation V16: crank 0.1 m, rod 0.3 m, slender bars of 0.2 kg each."""

from __future__ import annotations

SLIDER_CRANK = f"""
name = "slider-crank with a constant torque"
source = "Exudyn, sliderCrankFloatingTest.py"
[linkage]
kind = "planar"
ground = ["O"]
[linkage.points]
O = ["0 m", "0 m"]
A = ["0.1 m", "0 m"]
B = ["0.4 m", "0 m"]
[links.crank]
points = ["O", "A"]
rigid = true
bodies = [{{ position = "50 mm", mass = "0.2 kg", inertia = "{0.2 * 0.1**2 / 12:.17g} kg m^2" }}]
[links.rod]
points = ["A", "B"]
rigid = true
bodies = [{{ position = "150 mm", mass = "0.2 kg", inertia = "{0.2 * 0.3**2 / 12:.17g} kg m^2" }}]
[joints.O]
kind = "clamp"
[joints.B]
kind = "slider"
mass = "0.4 kg"
direction = "0 deg"
"""
