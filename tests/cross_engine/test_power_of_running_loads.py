"""Work of loads and dampers on links that bend far while Exudyn runs them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from flexmech import (
    BeamSection,
    ConstantSpeed,
    ExudynEngine,
    Load,
    Material,
    Mechanism,
    PlanarJoint,
    PlanarLink,
    PlanarLinkage,
    RotatingArm,
    Spring,
)
from flexmech.linkages import AttachmentPoint, Linkage
from flexmech.time_domain import LinkState
from tests.cross_engine.test_exudyn_joints import KINDS

ARM = RotatingArm(0.3)


def energy_error(kind: str, linkage: Linkage = ARM, **acting: Any) -> float:
    """Of a soft arm that runs up within a fraction of a turn."""
    section = BeamSection.rectangle(Material(69e9, 2700.0), 2e-3, 25e-3)
    engine = ExudynEngine(Mechanism(linkage, {"arm": section}, **acting), 4, kind)
    drive, time = ConstantSpeed(20.0, run_up_time=0.05), np.linspace(0.0, 0.1, 21)
    return engine.simulate(drive, LinkState.rigid(engine.links), time, 1e-4).energy_error


@pytest.mark.parametrize("kind", KINDS)
def test_a_torque_does_work_on_the_section_that_it_turns(kind: str) -> None:
    """Counted on the rigid arm alone, its work misses the energies by 0.13 of their peak."""
    load = Load("couple", AttachmentPoint("arm", 0.3), torque=(0.3,))
    assert energy_error(kind, loads=(load,)) < 1e-3


@pytest.mark.parametrize("kind", KINDS)
def test_a_spring_stores_and_its_damper_takes_what_the_shaft_gives(kind: str) -> None:
    """Between the bent tip and the ground, from nearly no force on."""
    ends = AttachmentPoint("arm", 0.3), AttachmentPoint("ground", 0.1, 0.35)
    spring = Spring("return", *ends, stiffness=300.0, free_length=0.4, damping=5.0)
    assert energy_error(kind, springs=(spring,)) < 1e-3


@pytest.mark.parametrize("kind", KINDS)
def test_a_load_over_the_crank_angle_does_work_where_it_acts(kind: str) -> None:
    """The arm is drawn one radian behind the crank angle, from which the load counts."""
    arm = PlanarLinkage(
        {"O": (0.0, 0.0), "P": (0.3, 0.0)},
        (PlanarLink("arm", ("O", "P")),),
        ("O",),
        (PlanarJoint("O", "clamp"),),
        drawn_at=1.0,
    )
    force = ((0.0, 0.0), (1.0, 2.0), (-2.0, 1.0), (0.0, 0.0))
    load = Load(
        "push",
        AttachmentPoint("arm", 0.3),
        force,
        (0.0,) * 4,
        over="crank_angle",
        at=(0.0, 0.6, 1.2, 1.8),
    )
    assert energy_error(kind, arm, loads=(load,)) < 2e-3
