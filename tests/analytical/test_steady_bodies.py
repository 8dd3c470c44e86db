"""Bodies and links at rest in frames that turn evenly: one balance, by different equations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexmech import (
    BeamSection,
    ComputationError,
    ExudynEngine,
    Material,
    Mechanism,
    ReferenceEngine,
    RotatingArm,
    natural_frequencies,
)
from flexmech.arrays import FloatArray
from flexmech.linear_system import DisplacedInertia, Engine, RigidBody
from flexmech.mechanism import AttachedBody
from flexmech.time_domain import nonlinear_orbit
from tests.cross_engine.joined_linkages import LArm
from tests.cross_engine.test_exudyn_connectors import strips

SECTION = BeamSection.rectangle(Material(69e9, 2700.0), 2e-3, 25e-3)
LENGTH = 0.3


@pytest.mark.parametrize(
    ("make", "element"), [(ReferenceEngine, "euler"), (ExudynEngine, "geometrically-exact")]
)
def test_an_arm_that_turns_evenly_rests_in_its_equilibrium(
    make: type[Engine], element: str
) -> None:
    """Its periodic motion is none; a body off the axis bows it by a tenth of its length."""
    body = AttachedBody("arm", LENGTH, 0.25, 3e-4, (0.02, 0.06))
    mechanism = Mechanism(RotatingArm(LENGTH), {"arm": SECTION}, bodies=(body,))
    engine = make(mechanism, 2, element, component_modes=False)
    orbit = nonlinear_orbit(engine, 8.0, samples=4)
    assert np.abs(orbit.displacement[0]).max() > 0.1 * LENGTH
    assert orbit.distance < 1e-7


def test_an_arm_that_is_folded_back_buckles_under_its_own_inertia() -> None:
    """What lies inward of its clamp is pressed outward, the more the farther it moves."""
    folded = LArm(0.25, 0.2, np.pi, rigid=("arm",))
    mechanism = replace(strips(folded), gravity=(0.0, 0.0))
    engine = ReferenceEngine(mechanism, 4, "euler", component_modes=False)
    slow, fast = (natural_frequencies(engine, [0.0], speed, modes=1) for speed in (20.0, 250.0))
    assert fast.item() < 0.5 * slow.item()
    with pytest.raises(ComputationError, match="springs on its displaced links at crank angle 0"):
        engine.linear_system([0.0], 350.0)


def test_tangential_inertia_turns_with_the_arm() -> None:
    """An arm that is turned on by a small angle is pulled along by what pulled it across."""
    engine = ReferenceEngine(Mechanism(RotatingArm(LENGTH), {"arm": SECTION}), 2, "euler")
    motion = engine.mechanism.linkage.motion(np.zeros(1), np.zeros(1), np.array([50.0]))
    inertia = DisplacedInertia.of(engine.topology, engine.links, motion)
    assert inertia is not None
    [link], angle = engine.links, 1e-3
    [force] = inertia.forces([angle * link.fields.tangential[None]])
    pulled = 50.0 * angle * SECTION.mass_per_length * LENGTH**2 / 2
    assert force[0] @ link.fields.along == pytest.approx(pulled, rel=1e-9)


def test_forces_of_a_body_have_the_derivatives_that_are_told() -> None:
    """By displacement and rotation, in a frame that turns ever faster."""
    body = RigidBody(0.3, (0.01, -0.02), 4e-3, 1e-3)
    speed, change, place = np.array([7.0]), np.array([30.0]), np.array([[0.02, -0.01, 0.4]])
    pull, rate, acceleration = np.array([[3.0, -9.0]]), 0.5 + place, 2.0 - place

    def moving(q: FloatArray) -> FloatArray:
        return body.inertia(speed, change, pull, q, rate, acceleration)[0][0]

    def still(q: FloatArray) -> FloatArray:
        return body.displaced_inertia(speed, change, q)[0][0]

    step = 1e-6
    for force, told in (
        (moving, body.inertia(speed, change, pull, place, rate, acceleration)[1][0]),
        (still, body.displaced_inertia(speed, change, place)[1][0]),
    ):
        columns = [
            (force(place + move) - force(place - move)) / (2 * step)
            for move in step * np.eye(3)[:, None]
        ]
        np.testing.assert_allclose(np.stack(columns, axis=1), told, rtol=1e-6, atol=1e-7)
