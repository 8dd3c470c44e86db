"""A frame on springs against closed forms, and its energies against the work of the drive."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import flexmech
from flexmech.time_domain import DrivenLinkage, linear_run, periodic_state
from tests.support.sprung_frame_data import on_springs, sprung, stiffened

ANGLES = np.radians([0.0, 100.0, 250.0])


@pytest.fixture
def fourbar(models: Path) -> flexmech.Mechanism:
    return flexmech.load_mechanism(models / "aluminium_fourbar.toml")


def total_mass(mechanism: flexmech.Mechanism) -> float:
    return sum(float(link.moment(0)) for link in mechanism.link_masses_in_order)


def test_stiff_links_and_their_frame_are_one_mass(fourbar: flexmech.Mechanism) -> None:
    """sqrt(k / (M + m)) of a frame that hardly turns, whatever the crank angle."""
    frame = sprung((1e4, 3e4), inertia=1e9)
    mechanism = on_springs(stiffened(fourbar, 1e4), frame)
    found = flexmech.natural_frequencies(flexmech.ReferenceEngine(mechanism), ANGLES, modes=3)
    mass = frame.mass + total_mass(fourbar)
    expected = np.sqrt(np.array([2e4, 6e4]) / mass) / (2 * np.pi)
    assert found[:, 1:] == pytest.approx(np.tile(expected, (3, 1)), rel=1e-5)


def test_weight_stiffens_and_softens_a_frame_that_rocks(fourbar: flexmech.Mechanism) -> None:
    """The weight of links above the centre takes m g h from the stiffness against rocking."""
    centre = (0.127, -0.02)
    springs = tuple(flexmech.FrameSpring((x, -0.02), (1e9, 5e3)) for x in (0.027, 0.227))
    frame = flexmech.SprungFrame(2.0, 0.03, centre, springs)
    mechanism = on_springs(stiffened(fourbar, 1e6), frame)
    engines = [
        flexmech.ReferenceEngine(replace(mechanism, gravity=gravity))
        for gravity in ((0.0, 0.0), (0.0, -9.81))
    ]
    systems = [engine.linear_system(ANGLES[:1], prestress="none") for engine in engines]
    change = systems[1].stiffness[0, -1, -1] - systems[0].stiffness[0, -1, -1]
    motion = fourbar.linkage.motion(ANGLES[:1])
    height = 0.0
    for number, link in enumerate(fourbar.link_masses_in_order):
        arm = link.moment(1) / link.moment(0)
        place = motion.position(number, arm)[0]
        height += float(link.moment(0)) * (place[1] - centre[1])
    assert change == pytest.approx(-9.81 * height, rel=1e-9)


def test_a_stiff_frame_and_a_heavy_one_are_the_ground(fourbar: flexmech.Mechanism) -> None:
    def frequencies(mechanism: flexmech.Mechanism, modes: int) -> np.ndarray:
        engine = flexmech.ReferenceEngine(mechanism, elements=4, component_modes=False)
        return flexmech.natural_frequencies(engine, ANGLES, 20.0, modes=modes)

    fixed = frequencies(fourbar, 3)
    stiff = on_springs(fourbar, sprung((1e12, 1e12)))
    assert frequencies(stiff, 3) == pytest.approx(fixed, rel=1e-6)
    heavy = on_springs(fourbar, sprung((1e6, 1e6), mass=1e9, inertia=1e9))
    assert frequencies(heavy, 6)[:, 3:] == pytest.approx(fixed, rel=1e-6)


def test_an_unbalanced_arm_shakes_its_frame_as_a_rotor_does(models: Path) -> None:
    """m e W^2 / (k - (M + m) W^2) along x and y (Den Hartog, Mechanical Vibrations, sec. 2.6)."""
    arm = stiffened(flexmech.load_mechanism(models / "rotating_arm.toml"), 1e5)
    arm = replace(arm, gravity=(0.0, 0.0))
    speed, stiffness = 20.0, (4e3, 9e3)
    springs = tuple(flexmech.FrameSpring((x, 0.0), stiffness) for x in (-0.1, 0.1))
    frame = flexmech.SprungFrame(1.5, 1e9, (0.0, 0.0), springs)
    engine = flexmech.ReferenceEngine(on_springs(arm, frame), elements=4)
    linkage = DrivenLinkage(engine, flexmech.ConstantSpeed(speed), "none")
    start = linkage.drive.crank_angle(0.0)
    state = periodic_state(linkage, 2000)
    (link,) = arm.link_masses_in_order
    moment = float(link.moment(1)) + arm.linkage.hub_radius * float(link.moment(0))
    forced, mass = moment * speed**2, frame.mass + float(link.moment(0))
    expected = forced * np.cos(float(start)) / (2 * stiffness[0] - mass * speed**2)
    assert state.position[-3] == pytest.approx(expected, rel=1e-4)
    expected = forced * speed * np.cos(float(start)) / (2 * stiffness[1] - mass * speed**2)
    assert state.velocity[-2] == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("gravity", [(0.0, 0.0), (0.0, -9.81)])
def test_the_work_of_the_drive_is_the_energy_with_that_of_the_frame(
    fourbar: flexmech.Mechanism, gravity: tuple[float, float]
) -> None:
    """What is left is the error of the time step: of second order in it."""
    mechanism = replace(on_springs(fourbar, sprung((2e4, 4e4))), gravity=gravity)
    engine = flexmech.ReferenceEngine(mechanism, elements=4)
    linkage = DrivenLinkage(engine, flexmech.ConstantSpeed(20.0), "none")
    time = np.linspace(0.0, 0.3, 301)
    nothing = np.zeros(linkage.size)
    errors = [
        linear_run(linkage, linkage.unstressed(), nothing, time, step).energy_error
        for step in (2e-4, 1e-4)
    ]
    assert errors[1] < 1e-5
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.2)


def test_a_frame_alone() -> None:
    frame = sprung((2e4, 4e4))
    squares = (2 * np.pi * frame.natural_frequencies) ** 2
    assert squares == pytest.approx(sorted([4e4 / 2.0, 8e4 / 2.0, 2 * 4e4 * 0.1**2 / 0.03]))
