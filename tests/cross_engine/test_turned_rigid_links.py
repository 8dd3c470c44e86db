"""Rigid links that springs and loads turn far: places and forces on them are not linear."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexmech import ExudynEngine, Mechanism, ReferenceEngine, load_mechanism, natural_frequencies
from flexmech.linkages import AttachmentPoint, JointSpring, Load, Spring
from tests.cross_engine.joined_linkages import LArm, Ternary
from tests.cross_engine.test_exudyn_connectors import strips
from tests.cross_engine.test_exudyn_joints import FOUR_BAR

ANGLE = np.array([2.27])

ROCKER = strips(
    Ternary(FOUR_BAR, rigid=("rocker",)),
    loads=(Load("push", AttachmentPoint("rocker", 0.1), ((2.0, 1.0),), (20.0,), axes="link"),),
    springs=(
        Spring(
            "return",
            AttachmentPoint("ground", 0.1, -0.1),
            AttachmentPoint("rocker", 0.15),
            5e3,
            0.1,
        ),
    ),
    joint_springs=(JointSpring("O4", 6.0, 0.0, 0.1), JointSpring("A", 0.4, 0.0, -1.0)),
)
LEG = strips(
    LArm(rigid=("leg",)),
    loads=(Load("push", AttachmentPoint("leg", 0.1), ((3.0, 2.0),), (-0.5,), axes="link"),),
    springs=(
        Spring(
            "ground",
            AttachmentPoint("ground", 0.3, 0.4),
            AttachmentPoint("leg", 0.2),
            40.0,
            0.05,
            0.3,
        ),
    ),
)


@pytest.mark.parametrize(
    ("mechanism", "link", "turn"), [(ROCKER, "rocker", 0.109), (LEG, "leg", -0.184)]
)
def test_springs_and_loads_turn_a_rigid_link(mechanism: Mechanism, link: str, turn: float) -> None:
    """With places linear in the rotation the rocker's frequencies were 9e-3 apart."""
    number = mechanism.linkage.topology.index(link)
    engines = (
        ReferenceEngine(mechanism, 12, "euler", component_modes=False),
        ExudynEngine(mechanism, 12, "ancf", component_modes=False),
    )
    turned = []
    for engine in engines:
        motion = mechanism.linkage.motion(ANGLE, 20.0)
        displacement = engine.stressed_links(motion, "equilibrium").displacement
        assert displacement is not None
        turned.append(float(displacement[number][0, 2]))
    assert turned[0] == pytest.approx(turn, rel=0.05)
    assert turned[1] == pytest.approx(turned[0], rel=3e-6)
    first, second = (natural_frequencies(engine, ANGLE, 20.0, modes=3) for engine in engines)
    np.testing.assert_allclose(second, first, rtol=1e-4)


def test_a_rigid_crank_on_a_free_shaft_meets_what_it_leads_once() -> None:
    """The pin's force is a spring against the shaft's rotation.

    It had counted twice in Exudyn (frequencies were 2 % too low and 25 % too high here), and was
    that of the undeformed linkage in the reference engine (1.3e-3 and 1e-2 off).
    """
    mechanism = replace(
        load_mechanism("models/carton_pusher.toml"), joint_springs=(JointSpring("A", 30.0),)
    )
    found = [
        natural_frequencies(engine, np.radians([60.0, 280.0]), 5.0, modes=1)
        for engine in (
            ReferenceEngine(mechanism, 4, "euler", shaft="free"),
            ExudynEngine(mechanism, 4, "ancf", shaft="free"),
        )
    ]
    np.testing.assert_allclose(found[1], found[0], rtol=1e-5)


@pytest.mark.parametrize(("radial", "close"), [(None, 1e-9), (1e7, 1e-6)])
def test_a_crank_on_a_free_shaft_is_as_stiff_in_a_state_as_at_the_equilibrium(
    radial: float | None, close: float
) -> None:
    """Bearings that give way had their force counted twice, and a run the crank's own mass not."""
    mechanism = load_mechanism("models/carton_pusher.toml")
    if radial is not None:
        mechanism = replace(
            mechanism, joint_springs=(JointSpring("A", 0.0, radial_stiffness=radial),)
        )
    motion, held = mechanism.linkage.motion(np.radians([20.0, 60.0, 130.0]), 5.0), []
    for engine in (
        ReferenceEngine(mechanism, 4, "euler", shaft="free"),
        ExudynEngine(mechanism, 4, "ancf", shaft="free"),
    ):
        state = engine.stressed_links(motion, "equilibrium")
        assert state.displacement is not None
        running = engine.running_links(motion, state.displacement)
        held.append([np.asarray(each.tangent[0])[:, 2, 2] for each in (state, running)])
    (at_rest, in_state), (exudyn, in_run) = held
    np.testing.assert_allclose(in_state, at_rest, rtol=1e-12)
    np.testing.assert_allclose(exudyn, at_rest, rtol=close)
    np.testing.assert_allclose(in_run, at_rest, rtol=2e-3)  # by straight links
