"""Runs in time of linkages with lines, welds and rigid links."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexmech import ConstantSpeed, ReferenceEngine
from flexmech.dynamical_systems import VibrationState
from flexmech.linear_system import LinkDamping, RotationTerms, StressedLinks
from flexmech.time_domain import DrivenLinkage
from tests.cross_engine.test_exudyn_joints import LINKAGES, strips


@pytest.mark.parametrize("name", LINKAGES)
def test_coordinates_of_a_state_are_those_that_made_it(name: str) -> None:
    """Slides too, which no link has among its coordinates, and rigid links, which are bars."""
    engine = ReferenceEngine(strips(name), 6, "euler", component_modes=False)
    drive, time = ConstantSpeed(20.0), 0.03
    linkage = DrivenLinkage(engine, drive, "none", stretches=True)
    linear = DrivenLinkage(engine, drive, "none")
    random = np.random.default_rng(0)
    position, velocity = 1e-3 * random.normal(size=(2, 1, linear.size))
    vibration = VibrationState(position, velocity, np.zeros_like(position))
    state = linear.link_state(linear.equations(np.array([time])), vibration)
    found = VibrationState(
        *(part[None] for part in linkage.coordinates(state, time)), np.zeros((1, linkage.size))
    )
    again = linkage.link_state(linkage.equations(np.array([time])), found)
    for one, other in zip(again.displacement, state.displacement, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-13)
    for one, other in zip(again.rate, state.rate, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-11)


@pytest.mark.parametrize("prestress", ["axial", "equilibrium"])
def test_forces_on_guides_are_in_the_equations_in_time(prestress: str) -> None:
    """The same stiffness as that of the frozen system, at any position of the turn."""
    engine = ReferenceEngine(strips("rigid guide", 3e-3), 4, "euler", component_modes=False)
    linkage = DrivenLinkage(engine, ConstantSpeed(20.0), prestress)
    angle = 2 * np.pi * 40 / 120  # where the stress is sampled
    equations = linkage.equations(np.array([angle / 20.0]))
    motion = engine.mechanism.linkage.motion(np.array([angle]), 20.0)
    stressed = engine.stressed_links(motion, prestress)
    assert stressed.guide_stiffness is not None
    assert np.abs(stressed.guide_stiffness).max() > 0.1
    # In time, coordinates of rigid links stay in the frames of the rigid motion.
    straight: StressedLinks = replace(stressed, displacement=None)
    nothing = [LinkDamping(0 * x.damping, 0 * x.damping) for x in engine.links]
    with_guides, without = (
        linkage.frames.assemble(
            motion, straight.tangent, RotationTerms(), nothing, guide_stiffness
        ).stiffness
        for guide_stiffness in (stressed.guide_stiffness, None)
    )
    scale = np.abs(with_guides - without).max()
    assert scale > 0.1
    added = equations.stiffness - without
    np.testing.assert_allclose(added, with_guides - without, rtol=0, atol=1e-3 * scale)
