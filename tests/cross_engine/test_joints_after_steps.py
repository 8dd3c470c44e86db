"""Joints of a running Exudyn system that are put in place after every step."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexmech import ConstantSpeed, ExudynEngine, Mechanism, RotatingArm
from flexmech.arrays import FloatArray
from flexmech.mechanism import AttachedBody
from flexmech.multibody.running.model import RunningModel
from flexmech.multibody.running.simulation import Simulation
from flexmech.time_domain import LinkState
from tests.cross_engine.test_exudyn_joints import KINDS, strips

# In m and rad: more than any step leaves.
TORN = 1e-5


def check_closing(mechanism: Mechanism, kind: str) -> None:
    """Newton's method squares a gap with each step; a wrong derivative leaves most of it."""
    engine, drive = ExudynEngine(mechanism, 2, kind), ConstantSpeed(20.0, start_angle=0.7)
    model = RunningModel(mechanism, 2, kind, drive, engine.links)
    whole, _ = Simulation(model, 1e-4, 1, "trapezoidal").set_start(LinkState.rigid(engine.links))
    torn = whole + TORN * np.random.default_rng(1).uniform(-1.0, 1.0, len(whole))
    closed = torn.copy()
    model.joints.correct_coordinates(closed, 0.0)

    def gap(coordinates: FloatArray) -> float:
        return model.greatest_gap(model.assembly.arms.to_axis(coordinates[:-3]))

    assert gap(torn) > 0.1 * TORN
    assert gap(closed) < 1e-12
    assert np.linalg.norm(closed - torn) < np.linalg.norm(torn - whole)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("name", "bodies"),
    [
        ("L-arm", True),
        ("rigid leg", False),
        ("rigid crank", True),
        ("rigid connecting rod", False),
        ("rigid coupler", False),
        ("rigid guide", False),
        ("slider-crank uphill", False),
    ],
)
def test_torn_joints_close_by_the_least_change(name: str, bodies: bool, kind: str) -> None:
    check_closing(strips(name, bodies=bodies), kind)


@pytest.mark.parametrize("name", ["L-arm", "rigid connecting rod", "rigid coupler"])
def test_torn_joints_of_eccentric_links_close_on_the_axis_of_the_pins(name: str) -> None:
    """Their nodes are on the neutral axis, off the places that are joined."""
    mechanism = strips(name)
    sections = {
        link: replace(own, neutral_axis=6e-4, mass_axis=2e-4, layers=None)
        for link, own in mechanism.sections.items()
    }
    check_closing(replace(mechanism, sections=sections), "geometrically-exact")


@pytest.mark.parametrize("kind", KINDS)
def test_a_torn_arm_closes_on_its_turned_hub(kind: str) -> None:
    """The clamp is beside the axis; a body on the arm asks for more than moving one node."""
    arm = RotatingArm(0.3, hub_radius=0.05)
    section = strips("L-arm").sections["leg"]
    bodies = (AttachedBody("arm", 0.2, 0.02, 3e-6, (0.01, 0.015)),)
    check_closing(Mechanism(arm, {"arm": section}, bodies=bodies), kind)


def test_small_gaps_are_closed_by_the_answer_of_a_posture_nearby() -> None:
    """It leaves a hundredth of them, and a greater gap asks for the answer of its own posture."""
    mechanism, kind, turned, small = strips("rigid coupler"), KINDS[0], 0.009, 1e-10
    engine = ExudynEngine(mechanism, 2, kind)

    def posture(angle: float) -> tuple[RunningModel, FloatArray]:
        drive = ConstantSpeed(20.0, start_angle=angle)
        model = RunningModel(mechanism, 2, kind, drive, engine.links)
        simulation = Simulation(model, 1e-4, 1, "trapezoidal")
        return model, simulation.set_start(LinkState.rigid(engine.links))[0]

    (model, whole), (other, nearby) = posture(0.7), posture(0.7 + turned)
    random = np.random.default_rng(1).uniform(-1.0, 1.0, len(whole))

    def left(size: float) -> float:
        closed = nearby + size * random
        model.joints.correct_coordinates(closed, turned / 20.0)
        return other.greatest_gap(other.assembly.arms.to_axis(closed[:-3]))

    model.joints.correct_coordinates(whole + TORN * random, 0.0)
    assert 1e-4 * small < left(small) < 0.05 * small
    assert left(TORN) < 1e-12
    assert left(small) < 1e-5 * small
