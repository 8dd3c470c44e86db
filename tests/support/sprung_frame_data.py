"""Mechanisms whose frames are on springs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import flexmech
from flexmech.mechanism import Mechanism

FRAME = """
[frame]
mass = "2 kg"
inertia = "0.03 kg m^2"
centre = ["127 mm", "-20 mm"]

[[frame.springs]]
point = ["0 mm", "-60 mm"]
stiffness = ["2e4 N/m", "4e4 N/m"]
damping = ["5 N s/m", "5 N s/m"]

[[frame.springs]]
point = ["254 mm", "-60 mm"]
stiffness = ["2e4 N/m", "4e4 N/m"]
damping = ["5 N s/m", "5 N s/m"]
"""


def framed_file(folder: Path, model: Path, frame: str = FRAME) -> Path:
    """A model file with a frame on springs."""
    file = folder / f"{model.stem}_on_springs.toml"
    file.write_text(model.read_text(encoding="utf-8") + frame, encoding="utf-8")
    return file


def sprung(
    stiffness: tuple[float, float], mass: float = 2.0, inertia: float = 0.03
) -> flexmech.SprungFrame:
    """A frame on two springs about 0.1 m from its centre."""
    springs = (flexmech.FrameSpring((x, -0.02), stiffness) for x in (0.027, 0.227))
    return flexmech.SprungFrame(mass, inertia, (0.127, -0.02), tuple(springs))


def on_springs(mechanism: Mechanism, frame: flexmech.SprungFrame) -> Mechanism:
    """The mechanism with a frame on springs."""
    return replace(mechanism, frame=frame)


def stiffened(mechanism: Mechanism, factor: float) -> Mechanism:
    """The mechanism with stiffer links of the same mass."""
    sections = {
        link: replace(
            section,
            axial_stiffness=factor * section.axial_stiffness,
            bending_stiffness=factor * section.bending_stiffness,
        )
        for link, section in mechanism.sections.items()
    }
    return replace(mechanism, sections=sections)
