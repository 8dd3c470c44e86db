"""Frames of welded beams against the exact dynamic stiffness of their members.

The members' dynamic stiffness (Clough & Penzien, *Dynamics of Structures*, 2nd ed., ch. 20) is
exact for bending and stretching; natural frequencies are where the frame's loses its rank.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

from flexmech import BeamSection, Material, Mechanism, ReferenceEngine
from flexmech.analyses import solve_modes
from flexmech.linkages import Clamp, Link, LinkEnd, RigidMotion, Topology, Weld
from tests.cross_engine.joined_linkages import Plain

FloatArray = NDArray[np.float64]
SECTION = BeamSection.rectangle(Material(200e9, 7800.0), 10e-3, 30e-3)
HEIGHT, SPAN = 0.5, 0.7


@dataclass(frozen=True)
class Frame(Plain):
    """Beams that stand still, welded at their ends."""

    topology: Topology
    angles: tuple[float, ...]

    def motion(
        self,
        crank_angle: ArrayLike,
        crank_speed: ArrayLike = 0.0,
        crank_acceleration: ArrayLike = 0.0,
    ) -> RigidMotion:
        theta = np.asarray(crank_angle, dtype=float)
        nothing = np.zeros((*theta.shape, len(self.angles)))
        nowhere = np.zeros((*nothing.shape, 2))
        still = np.zeros(theta.shape)
        angle = nothing + self.angles
        return RigidMotion(theta, still, angle, nothing, nothing, nowhere, nowhere, nowhere)


L_FRAME = Frame(
    Topology(
        links=(Link("column", HEIGHT), Link("beam", SPAN)),
        clamps=(Clamp("O", LinkEnd("column", "start")), Clamp("Q", LinkEnd("beam", "end"))),
        welds=(Weld("A", LinkEnd("column", "end"), LinkEnd("beam", "start")),),
    ),
    (np.pi / 2, 0.0),
)
PORTAL = Frame(
    Topology(
        links=(Link("left", HEIGHT), Link("beam", SPAN), Link("right", HEIGHT)),
        clamps=(Clamp("O", LinkEnd("left", "start")), Clamp("Q", LinkEnd("right", "start"))),
        welds=(
            Weld("A", LinkEnd("left", "end"), LinkEnd("beam", "start")),
            Weld("B", LinkEnd("beam", "end"), LinkEnd("right", "end")),
        ),
    ),
    (np.pi / 2, 0.0, np.pi / 2),
)


def member(length: float, angle: float, omega: float) -> FloatArray:
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
    return both.T @ local @ both


def l_frame(omega: float) -> FloatArray:
    column, beam = member(HEIGHT, np.pi / 2, omega), member(SPAN, 0.0, omega)
    return column[3:, 3:] + beam[:3, :3]


def portal(omega: float) -> FloatArray:
    column, beam = member(HEIGHT, np.pi / 2, omega), member(SPAN, 0.0, omega)
    total = beam.copy()
    total[:3, :3] += column[3:, 3:]
    total[3:, 3:] += column[3:, 3:]
    return total


def nearest_root(stiffness: Any, frequency: float) -> float:
    """Where an eigenvalue of the frame's dynamic stiffness passes zero, near a frequency."""

    def smallest(trial: float) -> float:
        values = np.linalg.eigvalsh(stiffness(2 * np.pi * trial))
        return float(values[np.argmin(np.abs(values))])

    return float(brentq(smallest, frequency * (1 - 1e-4), frequency * (1 + 1e-4), xtol=1e-12))


@pytest.mark.parametrize(
    ("frame", "stiffness"), [(L_FRAME, l_frame), (PORTAL, portal)], ids=["L", "portal"]
)
@pytest.mark.parametrize("reduced", [False, True])
def test_natural_frequencies(frame: Frame, stiffness: Any, reduced: bool) -> None:
    mechanism = Mechanism(frame, dict.fromkeys(frame.topology.link_names, SECTION))
    engine = ReferenceEngine(mechanism, 48, "euler", component_modes=reduced)
    detail = 8.0 if reduced else 1.0
    found = solve_modes(engine.linear_system(0.0, modes=4, detail=detail), 4).frequency[0]
    exact = [nearest_root(stiffness, f) for f in found]
    np.testing.assert_allclose(found, exact, rtol=1e-6)
    if stiffness is portal:
        # Sway of a clamped portal frame, inextensible members: about 3.2 sqrt(EI / m h^4).
        assert found[0] < 0.5 * found[1]


@pytest.mark.parametrize("element", ["timoshenko", "reddy", "zigzag"])
def test_other_beams_are_welded_alike(element: str) -> None:
    """Slender members: theories that shear differ by little, and by the same as clamped ones do."""
    mechanism = Mechanism(PORTAL, dict.fromkeys(PORTAL.topology.link_names, SECTION))
    euler, other = (
        solve_modes(ReferenceEngine(mechanism, 16, kind).linear_system(0.0, modes=3), 3).frequency
        for kind in ("euler", element)
    )
    assert np.all((other < euler) & (other > 0.99 * euler))


def test_sag_of_a_portal_frame_under_its_weight() -> None:
    """Clamped feet, loaded beam: moment at the corners ``w l^2 / (6 (2 + k))`` for stiff members.

    With k the stiffness of the columns to that of the beam, ``I_b h / (I_c l)``; Kleinlogel,
    *Rahmenformeln*, frame 44. Members that hardly stretch; the columns' weight only compresses.
    """
    thin = BeamSection.rectangle(Material(2e9, 7800.0), 2e-3, 30e-3)
    mechanism = Mechanism(
        PORTAL, dict.fromkeys(PORTAL.topology.link_names, thin), gravity=(0.0, -2e-4)
    )
    engine = ReferenceEngine(mechanism, 16, "euler")
    motion = PORTAL.motion(np.zeros(1))
    stressed = engine.stressed_links(motion, "equilibrium")
    assert stressed.displacement is not None
    assert stressed.internal_force is not None
    line = thin.mass_per_length * 2e-4
    corner = line * SPAN**2 / (6 * (2 + HEIGHT / SPAN))
    beam = engine.links[1]
    couple = stressed.internal_force[1][0, beam.start_rotation[0]]
    loads = stressed.loads[1][0, beam.start_rotation[0]] if stressed.loads else 0.0
    assert abs(couple - loads) == pytest.approx(corner, rel=1e-4)
    across = beam.shape[:, 1] @ stressed.displacement[1][0]
    middle = across[10] - across[0]  # the columns are shorter by the weight that they carry
    sag = 5 * line * SPAN**4 / (384 * thin.bending_stiffness)
    sag -= corner * SPAN**2 / (8 * thin.bending_stiffness)
    assert middle == pytest.approx(-sag, rel=1e-4)
