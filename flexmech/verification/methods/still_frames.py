"""Frames of welded beams at rest, and the exact dynamic stiffness of their members."""

from __future__ import annotations

from typing import Literal

import numpy as np
from scipy.optimize import brentq

from flexmech.arrays import FloatArray
from flexmech.choices import EngineName
from flexmech.linkages import PlanarJoint, PlanarLink, PlanarLinkage
from flexmech.materials import Material
from flexmech.mechanism import Mechanism
from flexmech.sections import BeamSection
from flexmech.solvers import solve_modes
from flexmech.verification.methods.engines import SLENDER, engine_of_name

# A steel strip, and lengths in m whose ratio is not simple, so that no two frequencies are alike.
SECTION = BeamSection.rectangle(Material(200e9, 7800.0), 10e-3, 30e-3)
HEIGHT, SPAN = 0.5, 0.7
FrameName = Literal["L", "portal"]
# Step in Hz at which roots of exact frequencies are bracketed; no two roots are nearer.
STEP = 1.0


WELDED = tuple(PlanarJoint(point, "weld") for point in ("A", "B"))
CLAMPED = tuple(PlanarJoint(point, "clamp") for point in ("O", "Q"))
FRAMES: dict[FrameName, PlanarLinkage] = {
    "L": PlanarLinkage(
        {"O": (0.0, 0.0), "A": (0.0, HEIGHT), "Q": (SPAN, HEIGHT)},
        (PlanarLink("column", ("O", "A")), PlanarLink("beam", ("A", "Q"))),
        ("O", "Q"),
        (*CLAMPED, WELDED[0]),
    ),
    "portal": PlanarLinkage(
        {"O": (0.0, 0.0), "A": (0.0, HEIGHT), "B": (SPAN, HEIGHT), "Q": (SPAN, 0.0)},
        (
            PlanarLink("left", ("O", "A")),
            PlanarLink("beam", ("A", "B")),
            PlanarLink("right", ("Q", "B")),
        ),
        ("O", "Q"),
        (*CLAMPED, *WELDED),
    ),
}


def frame_frequencies(
    *, frame: FrameName, engine: EngineName, elements: int, modes: int, reduced: bool = False
) -> FloatArray:
    """Natural frequencies of a frame at rest.

    Parameters
    ----------
    frame : {"L", "portal"}
    engine : {"reference", "exudyn"}
    elements : int
        On each member.
    modes : int
    reduced : bool
        Whether to component modes.

    Returns
    -------
    ndarray, shape (modes,)
        In Hz.
    """
    linkage = FRAMES[frame]
    mechanism = Mechanism(linkage, dict.fromkeys(linkage.topology.link_names, SECTION))
    chosen = engine_of_name(
        engine, mechanism, elements, element=SLENDER[engine], component_modes=reduced
    )
    detail = 8.0 if reduced else 1.0
    system = chosen.linear_system(0.0, modes=modes, detail=detail)
    return np.asarray(solve_modes(system, modes).frequency[0])


def exact_frame_frequencies(*, frame: FrameName, modes: int) -> FloatArray:
    """Where the exact dynamic stiffness of a frame's joints loses its rank.

    Clough & Penzien, *Dynamics of Structures*, 2nd ed., ch. 20: exact for bending and stretching.

    Parameters
    ----------
    frame : {"L", "portal"}
    modes : int

    Returns
    -------
    ndarray, shape (modes,)
        In Hz.
    """

    def positive(frequency: float) -> int:
        return int(np.sum(np.linalg.eigvalsh(_joints(frame, 2 * np.pi * frequency)) > 0))

    roots: list[float] = []
    low, before = STEP, positive(STEP)
    while len(roots) < modes:
        high = low + STEP
        now = positive(high)
        # An eigenvalue falls through zero at a root; at a pole one jumps up.
        if now < before:
            falling = before - 1

            def passing(trial: float, place: int = falling) -> float:
                values = np.linalg.eigvalsh(_joints(frame, 2 * np.pi * trial))
                return float(values[::-1][place])

            roots.append(brentq(passing, low, high))
        low, before = high, now
    return np.array(roots)


def _joints(frame: FrameName, omega: float) -> FloatArray:
    """Dynamic stiffness of the joints that move."""
    column, beam = _member(HEIGHT, np.pi / 2, omega), _member(SPAN, 0.0, omega)
    if frame == "L":
        return np.asarray(column[3:, 3:] + beam[:3, :3])
    total = beam.copy()
    total[:3, :3] += column[3:, 3:]
    total[3:, 3:] += column[3:, 3:]
    return total


def _member(length: float, angle: float, omega: float) -> FloatArray:
    """Exact dynamic stiffness of a member in ground axes, (6, 6)."""
    ei, ea = SECTION.bending_stiffness, SECTION.axial_stiffness
    line = SECTION.mass_per_length
    b = (line * omega**2 / ei) ** 0.25
    s, c, sh, ch = np.sin(b * length), np.cos(b * length), np.sinh(b * length), np.cosh(b * length)
    f = ei / (1 - c * ch)
    k11, k12 = f * b**3 * (c * sh + s * ch), f * b**2 * s * sh
    k13, k14 = -f * b**3 * (s + sh), f * b**2 * (ch - c)
    k22, k24 = f * b * (s * ch - c * sh), f * b * (sh - s)
    a = omega * np.sqrt(line / ea)
    along, across = ea * a / np.tan(a * length), -ea * a / np.sin(a * length)
    local = np.array(
        [
            [along, 0, 0, across, 0, 0],
            [0, k11, k12, 0, k13, k14],
            [0, k12, k22, 0, -k14, k24],
            [across, 0, 0, along, 0, 0],
            [0, k13, -k14, 0, k11, -k12],
            [0, k14, k24, 0, -k12, k22],
        ]
    )
    cosine, sine = np.cos(angle), np.sin(angle)
    turn = np.array([[cosine, sine, 0], [-sine, cosine, 0], [0, 0, 1]])
    both = np.kron(np.eye(2), turn)
    return np.asarray(both.T @ local @ both)
