"""Elastic arms that carry bodies in frames that turn: elastica, balance, buckling, close masses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_bvp

from flexmech import (
    AttachedBody,
    BeamSection,
    ComputationError,
    ExudynEngine,
    FourBar,
    Material,
    Mechanism,
    PointMass,
    ReferenceEngine,
    RotatingArm,
    TableDrive,
    natural_frequencies,
    response,
)
from flexmech.analyses import ResponseRequest
from tests.support.mechanisms import drawn, strips

LENGTH, MASS, INERTIA, OFFSET = 0.3, 0.3, 2e-4, (0.02, 0.06)
SECTION = BeamSection.rectangle(Material(69e9, 2700.0), 2e-3, 25e-3).with_damping_time(1e-4)


def elastica(speed: float, acceleration: float) -> float:
    """Displacement in m across the arm of the tip of an elastic line at rest in the turning frame.

    Matter at a place r of the frame is pulled by ``omega^2 r - alpha J r``, J the quarter turn:
    the line's, and the body's at its displaced centre behind the rotated tip.
    """
    bending, axial = SECTION.bending_stiffness, SECTION.axial_stiffness

    def pull(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.array([speed**2 * x + acceleration * y, speed**2 * y - acceleration * x])

    def rates(_: np.ndarray, state: np.ndarray) -> np.ndarray:
        x, y, angle, along, across, moment = state
        cosine, sine = np.cos(angle), np.sin(angle)
        stretch = 1 + (along * cosine + across * sine) / axial
        load = SECTION.mass_per_length * pull(x, y)
        bend = -stretch * (cosine * across - sine * along)
        return np.array([stretch * cosine, stretch * sine, moment / bending, *-load, bend])

    def ends(first: np.ndarray, last: np.ndarray) -> np.ndarray:
        x, y, angle, *inner = last
        arm = np.array(
            [
                OFFSET[0] * np.cos(angle) - OFFSET[1] * np.sin(angle),
                OFFSET[0] * np.sin(angle) + OFFSET[1] * np.cos(angle),
            ]
        )
        force = MASS * pull(x + arm[0], y + arm[1])
        couple = arm[0] * force[1] - arm[1] * force[0] - INERTIA * acceleration
        return np.array([*first[:3], *(np.array(inner) - [*force, couple])])

    place = np.linspace(0.0, LENGTH, 41)
    start = np.zeros((6, 41))
    start[0] = place
    solved = solve_bvp(rates, ends, place, start, tol=1e-9, max_nodes=20_000)
    assert solved.success
    return float(solved.y[1, -1])


@pytest.mark.parametrize(
    ("speed", "acceleration"),
    [
        (0.0, 40.0),
        (8.0, 0.0),
        pytest.param(6.0, -30.0, marks=pytest.mark.thorough),
    ],
    ids=["start", "turn", "stop"],
)
def test_an_arm_that_carries_a_body_hangs_back_as_an_elastica(
    speed: float, acceleration: float
) -> None:
    """By a hundredth to a tenth of its length, at the equilibrium from which a run starts."""
    body = AttachedBody("arm", LENGTH, MASS, INERTIA, OFFSET)
    mechanism = Mechanism(RotatingArm(LENGTH), {"arm": SECTION}, bodies=(body,))
    time = np.linspace(0.0, 2e-3, 5)
    law = TableDrive(tuple(time), tuple(speed * time + acceleration * time**2 / 2))
    drive, samples = (law, 8) if acceleration else (speed, 800)
    asked = ResponseRequest(drive, 0.01, samples=samples, step=2.5e-4, start="equilibrium", modes=2)
    data = response(ExudynEngine(mechanism, 8, "ancf"), asked).dataset
    expected = elastica(speed, acceleration)
    assert abs(expected) > 0.01 * LENGTH
    assert float(data["deflection"].values[0, 0, 0]) == pytest.approx(expected, rel=1e-4)


def test_an_arm_that_is_folded_back_buckles_under_its_own_inertia() -> None:
    """Mass inward of the clamp is pressed outward, the more the farther it moves."""
    points = {"O2": (0.0, 0.0), "B": (0.25, 0.0), "C": (0.05, 0.0)}
    links = {"arm": ("O2", "B"), "leg": ("B", "C")}
    folded = drawn(points, links, {"O2": "clamp", "B": "weld"}, rigid=("arm",))
    mechanism = replace(strips(folded, 3e-3), gravity=(0.0, 0.0))
    engine = ReferenceEngine(mechanism, 4, "euler", component_modes=False)
    slow, fast = (natural_frequencies(engine, [0.0], speed, modes=1) for speed in (20.0, 250.0))
    assert fast.item() < 0.5 * slow.item()
    with pytest.raises(ComputationError, match="displaced links at crank angle 0"):
        engine.linear_system([0.0], 350.0)


# Elements between points so close would be 1e11 times as stiff as the link; the first frequency
# was 1 to 3 % off by round-off, another amount in each mesh.
NEAR, COUPLER = 1.6e-5, 0.0963
ENGINES = pytest.mark.parametrize(
    "engine", [(ReferenceEngine, "euler"), (ExudynEngine, "ancf")], ids=["reference", "exudyn"]
)


def first_frequency(masses: list[tuple[float, float]], engine: tuple, elements: int) -> np.ndarray:
    """First frequency of a four-bar with a soft crank and point masses on its coupler."""
    material = Material(70e9, 2700, 0.3)
    sections = {
        link: BeamSection.rectangle(material, thickness, 20e-3)
        for link, thickness in (("crank", 2.7e-4), ("coupler", 1.7e-3), ("rocker", 1.9e-3))
    }
    points = tuple(PointMass("coupler", place, mass) for place, mass in masses)
    mechanism = Mechanism(FourBar(0.1123, 0.0316, COUPLER, 0.1117), sections, link_masses=points)
    kind, element = engine
    angles = np.radians([30.0, 60.0])
    return natural_frequencies(
        kind(mechanism, elements, element), angles, modes=1, prestress="none"
    )


@ENGINES
def test_two_close_masses_are_as_one(engine: tuple) -> None:
    pair = [(0.0163, 8.7e-4), (0.0163 + NEAR, 14.4e-4)]
    centre = 0.0163 + NEAR * 14.4 / (8.7 + 14.4)
    for elements in (4, 16):
        one = first_frequency([(centre, 23.1e-4)], engine, elements)
        np.testing.assert_allclose(first_frequency(pair, engine, elements), one, rtol=1e-6)


@ENGINES
@pytest.mark.parametrize("end", [0.0, COUPLER])
def test_a_mass_close_to_an_end_moves_with_the_end(engine: tuple, end: float) -> None:
    """The frequency changes in proportion to the distance."""
    at_end, near, far = (
        first_frequency([(abs(end - away), 20e-4)], engine, 16) for away in (0.0, NEAR, 1e-3)
    )
    np.testing.assert_allclose(near - at_end, (far - at_end) * NEAR / 1e-3, rtol=0.05)
