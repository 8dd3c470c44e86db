"""Energies of runs by the linear equations about a state of stress."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexmech import BeamSection, ConstantSpeed, Material, Mechanism, ReferenceEngine, RotatingArm
from flexmech.choices import Prestress
from flexmech.linkages import AttachmentPoint, Load
from flexmech.mechanism import AttachedBody
from flexmech.time_domain import DrivenLinkage, linear_run
from tests.cross_engine.joined_linkages import Ternary
from tests.cross_engine.test_exudyn_connectors import strips
from tests.cross_engine.test_exudyn_joints import FOUR_BAR

LENGTH, FORCE = 0.3, 0.5
SECTION = BeamSection.rectangle(Material(70e9, 2700.0), 2e-3, 25e-3)


@pytest.mark.parametrize("prestress", ["none", "axial", "equilibrium"])
def test_strain_energy_of_a_bent_arm(prestress: Prestress) -> None:
    """``F^2 L^3 / (6 EI)`` of a force across the tip, to which the links are bent or come."""
    load = Load("tip", AttachmentPoint("arm", LENGTH), ((0.0, FORCE),), axes="link")
    mechanism = Mechanism(RotatingArm(LENGTH), {"arm": SECTION}, loads=(load,))
    linkage = DrivenLinkage(ReferenceEngine(mechanism, 2, "euler"), ConstantSpeed(0.05), prestress)
    still = linkage.equations(np.zeros(1), frozen=True).quasi_static()[0]
    energy = linear_run(linkage, still, 0 * still, np.array([0.0, 0.01]), 1e-3).energy
    wanted = FORCE**2 * LENGTH**3 / (6 * SECTION.bending_stiffness)
    np.testing.assert_allclose(energy.strain, wanted, rtol=1e-3)


def test_a_bowed_link_loses_what_its_damping_takes() -> None:
    """Damping of the bowed shape changes along the turn."""
    damped = SECTION.with_damping_time(2e-4)
    mechanism = Mechanism(RotatingArm(0.4), {"arm": damped}, gravity=(0.0, -9.81))
    linkage = DrivenLinkage(ReferenceEngine(mechanism, 2, "euler"), ConstantSpeed(10.0))
    start, time = linkage.unstressed(), np.array([0.0, 0.05])
    found = linear_run(linkage, start, 0 * start, time, 0.05 / 400)
    assert found.energy.dissipated[-1] > 1e-4 * found.energy.kinetic.max()
    assert found.energy_error < 1e-5


@pytest.mark.parametrize("rigid", [(), ("coupler",)])
def test_energies_balance_where_a_body_is_off_the_axis_of_its_link(rigid: tuple[str, ...]) -> None:
    """In a run-up, where the frames of the links turn ever faster."""
    body = AttachedBody("coupler", 0.1, 0.1, 2e-4, (0.02, 0.05))
    mechanism = replace(strips(Ternary(FOUR_BAR, rigid=rigid)), bodies=(body,))
    engine = ReferenceEngine(mechanism, 2, "euler", component_modes=False)
    linkage = DrivenLinkage(engine, ConstantSpeed(20.0, run_up_time=0.05), "none")
    start = linkage.equations(np.zeros(1), frozen=True).quasi_static()[0]
    found = linear_run(linkage, start, 0 * start, np.array([0.0, 0.04]), 0.04 / 800)
    assert np.ptp(found.energy.drive_work) > 0.1 * found.energy.kinetic.max()
    assert found.energy_error < 2e-5
