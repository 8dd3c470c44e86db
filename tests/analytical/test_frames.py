"""Frames of welded beams against the exact dynamic stiffness of their members.

The members' dynamic stiffness (Clough & Penzien, *Dynamics of Structures*, 2nd ed., ch. 20) is
exact for bending and stretching; natural frequencies are where the frame's loses its rank.
"""

from __future__ import annotations

import numpy as np
import pytest

from flexmech import BeamSection, Material, Mechanism, ReferenceEngine
from flexmech.analyses import solve_modes
from flexmech.verification.methods.still_frames import (
    FRAMES,
    HEIGHT,
    SECTION,
    SPAN,
    FrameName,
    exact_frame_frequencies,
    frame_frequencies,
)

PORTAL = FRAMES["portal"]


@pytest.mark.parametrize("frame", FRAMES)
def test_natural_frequencies_by_component_modes(frame: FrameName) -> None:
    """All coordinates are cases of the verification."""
    found = frame_frequencies(frame=frame, engine="reference", elements=48, modes=4, reduced=True)
    exact = exact_frame_frequencies(frame=frame, modes=4)
    np.testing.assert_allclose(found, exact, rtol=1e-6)
    if frame == "portal":
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
