"""A six-bar linkage, defined here alone: a new linkage comes without touching the engines.

The four-bar of crank, coupler and rocker drives a second loop: a connector from joint B and
an output link from a third ground pivot meet in joint C. At B three links share a pin, the
coupler leads both others.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, Literal

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from flexmech import (
    BeamSection,
    ExudynEngine,
    FourBar,
    HygrothermalState,
    InputError,
    Material,
    Mechanism,
    PointMass,
    ReferenceEngine,
    mechanism_in_state,
    moving_frequencies,
    natural_frequencies,
)
from flexmech.linkages import (
    Clamp,
    Link,
    Linkage,
    LinkEnd,
    LinkMass,
    Pin,
    Pivot,
    RigidMotion,
    Topology,
    inverse_dynamics,
)
from flexmech.linkages.motion import direction, normal
from flexmech.materials import Hygrothermal

FloatArray = NDArray[np.float64]
CRANK, COUPLER, ROCKER, CONNECTOR, OUTPUT = range(5)
TURN = np.radians(np.arange(0, 360, 45))


@dataclass(frozen=True)
class SixBar:
    """A four-bar with a dyad, connector B-C and output link O6-C, on its joint B.

    ``side`` tells on which side of the line from B to O6 joint C lies; ``led_by`` is the link
    whose end leads the connector: the coupler, or the rocker that follows the coupler itself.
    """

    fourbar: FourBar
    connector: float
    output: float
    pivot: tuple[float, float]
    side: Literal["left", "right"] = "left"
    led_by: Literal["coupler", "rocker"] = "coupler"

    kind: ClassVar[str] = "six-bar"

    @property
    def topology(self) -> Topology:
        lengths = self.fourbar.lengths
        return Topology(
            links=(
                *(Link(name, lengths[name]) for name in ("crank", "coupler", "rocker")),
                Link("connector", self.connector),
                Link("output", self.output),
            ),
            clamps=(Clamp("O2", LinkEnd("crank", "start")),),
            pivots=(
                Pivot("O4", LinkEnd("rocker", "start")),
                Pivot("O6", LinkEnd("output", "start")),
            ),
            pins=(
                Pin("A", leader=LinkEnd("crank", "end"), follower=LinkEnd("coupler", "start")),
                Pin("B", leader=LinkEnd("coupler", "end"), follower=LinkEnd("rocker", "end")),
                Pin(
                    "B2", leader=LinkEnd(self.led_by, "end"), follower=LinkEnd("connector", "start")
                ),
                Pin("C", leader=LinkEnd("connector", "end"), follower=LinkEnd("output", "end")),
            ),
        )

    def motion(
        self,
        crank_angle: ArrayLike,
        crank_speed: ArrayLike = 0.0,
        crank_acceleration: ArrayLike = 0.0,
    ) -> RigidMotion:
        driver = self.fourbar.motion(crank_angle, crank_speed, crank_acceleration)
        b = driver.position(COUPLER, self.fourbar.coupler)
        velocity = driver.velocity(COUPLER, self.fourbar.coupler)
        acceleration = driver.acceleration(COUPLER, self.fourbar.coupler)
        theta = self._dyad_angles(b)
        arms = np.array([self.connector, -self.output])  # signed: the loop runs B, C, O6
        # Columns: velocity of C about B, less velocity of C about O6, at unit speed each.
        turning = np.swapaxes(arms[:, None] * normal(theta), -1, -2)
        omega = np.linalg.solve(turning, -velocity[..., None])[..., 0]
        inward = np.sum((arms * omega**2)[..., None] * direction(theta), axis=-2)
        alpha = np.linalg.solve(turning, (inward - acceleration)[..., None])[..., 0]
        o6 = np.broadcast_to(self.pivot, b.shape)
        zero = np.zeros_like(b)

        def with_dyad(first: FloatArray, *others: FloatArray) -> FloatArray:
            return np.concatenate([first, np.stack(others, axis=-2)], axis=-2)

        return RigidMotion(
            crank_angle=driver.crank_angle,
            crank_speed=driver.crank_speed,
            angle=np.concatenate([driver.angle, theta], axis=-1),
            angular_velocity=np.concatenate([driver.angular_velocity, omega], axis=-1),
            angular_acceleration=np.concatenate([driver.angular_acceleration, alpha], axis=-1),
            origin=with_dyad(driver.origin, b, o6),
            origin_velocity=with_dyad(driver.origin_velocity, velocity, zero),
            origin_acceleration=with_dyad(driver.origin_acceleration, acceleration, zero),
        )

    def resized(self, lengths: Mapping[str, float], ground_growth: float) -> SixBar:
        x, y = self.pivot
        return replace(
            self,
            fourbar=self.fourbar.resized(lengths, ground_growth),
            connector=lengths["connector"],
            output=lengths["output"],
            pivot=(x * ground_growth, y * ground_growth),
        )

    def described(self) -> list[str]:
        return ["kind: six-bar", *self.fourbar.described()[1:]]

    def to_table(self) -> dict[str, object]:
        return {**self.fourbar.to_table(), "kind": self.kind}

    def _dyad_angles(self, b: FloatArray) -> FloatArray:
        """Angles of connector and output link: circles about B and O6 meet in C."""
        line = np.asarray(self.pivot) - b
        distance = np.linalg.norm(line, axis=-1)
        cosine = (self.connector**2 + distance**2 - self.output**2) / (
            2 * self.connector * distance
        )
        if np.any(np.abs(cosine) >= 1):
            raise InputError("connector and output link do not meet")
        opening = np.arccos(cosine) * (1 if self.side == "left" else -1)
        connector = np.arctan2(line[..., 1], line[..., 0]) + opening
        from_o6 = self.connector * direction(connector) - line
        return np.stack([connector, np.arctan2(from_o6[..., 1], from_o6[..., 0])], axis=-1)


FOUR_BAR = FourBar(ground=0.254, crank=0.102, coupler=0.2794, rocker=0.2667)
LEFT = SixBar(FOUR_BAR, connector=0.28, output=0.24, pivot=(0.5, 0.05))
RIGHT = SixBar(FOUR_BAR, connector=0.28, output=0.24, pivot=(0.5, 0.05), side="right")


@pytest.fixture(params=[LEFT, RIGHT], ids=["left", "right"])
def linkage(request: pytest.FixtureRequest) -> Linkage:
    return request.param


@pytest.fixture(scope="module")
def six_bar() -> Mechanism:
    """Aluminium strips with bearing masses; the last two links unlike the others."""
    aluminium = Material(68.9e9, 2923.0)
    thickness = (4.24e-3, 1.6e-3, 1.6e-3, 2.2e-3, 1.9e-3)
    return Mechanism(
        LEFT,
        {
            name: BeamSection.rectangle(aluminium, h, 25.4e-3)
            for name, h in zip(LEFT.topology.link_names, thickness, strict=True)
        },
        joint_masses={"A": 0.03, "B": 0.02, "B2": 0.01, "C": 0.025},
    )


def joints(linkage: SixBar, motion: RigidMotion, what: str) -> dict[str, list[FloatArray]]:
    """Position, velocity or acceleration of each joint by every link end that meets there."""
    of = getattr(motion, what)
    coupler, rocker = linkage.fourbar.coupler, linkage.fourbar.rocker
    pivots = {"O2": (0.0, 0.0), "O4": (linkage.fourbar.ground, 0.0), "O6": linkage.pivot}
    held = {name: np.array(p) * (what == "position") for name, p in pivots.items()}
    return {
        "O2": [held["O2"], of(CRANK, 0.0)],
        "O4": [held["O4"], of(ROCKER, 0.0)],
        "O6": [held["O6"], of(OUTPUT, 0.0)],
        "A": [of(CRANK, linkage.fourbar.crank), of(COUPLER, 0.0)],
        "B": [of(COUPLER, coupler), of(ROCKER, rocker), of(CONNECTOR, 0.0)],
        "C": [of(CONNECTOR, linkage.connector), of(OUTPUT, linkage.output)],
    }


def test_heat_enlarges_a_linkage_of_any_kind():
    aluminium = Material(68.9e9, 2923.0, hygrothermal=Hygrothermal(thermal_expansion=2.3e-5))
    section = BeamSection.rectangle(aluminium, 4e-3, 25.4e-3)
    cold = Mechanism(
        LEFT, dict.fromkeys(LEFT.topology.link_names, section), ground_thermal_expansion=2.3e-5
    )
    hot = mechanism_in_state(cold, HygrothermalState(100.0))
    growth = 1 + 2.3e-3
    for before, after in zip(LEFT.topology.links, hot.linkage.topology.links, strict=True):
        assert after.length == pytest.approx(before.length * growth, rel=1e-14)
    angle = np.linspace(0, 2 * np.pi, 20)
    assert hot.linkage.motion(angle).origin == pytest.approx(
        growth * LEFT.motion(angle).origin, abs=1e-13
    )


@pytest.mark.parametrize("what", ["position", "velocity", "acceleration"])
def test_the_loops_close(linkage, what):
    speed = np.array([[-7.0], [0.0], [15.0]])
    motion = linkage.motion(np.linspace(0, 2 * np.pi, 50), speed, 30.0)
    largest = {"position": 0.3, "velocity": 0.3 * 15, "acceleration": 0.3 * 15**2}[what]
    for name, (first, *others) in joints(linkage, motion, what).items():
        for other in others:
            assert np.abs(other - first).max() < 1e-13 * largest * 10, name


def test_the_dyad_keeps_its_side():
    for linkage, sign in ((LEFT, 1), (RIGHT, -1)):
        motion = linkage.motion(np.linspace(0, 2 * np.pi, 50))
        b, c = motion.position(CONNECTOR, 0.0), motion.position(CONNECTOR, linkage.connector)
        line, arm = np.asarray(linkage.pivot) - b, c - b
        assert np.all(sign * (line[:, 0] * arm[:, 1] - line[:, 1] * arm[:, 0]) > 0)


def test_rates_are_derivatives(linkage):
    """Five-point differences in time of a crank that speeds up."""
    start, speed, acceleration, step = np.linspace(0, 6, 25), 15.0, 40.0, 1e-4

    def at(time: float) -> RigidMotion:
        angle = start + speed * time + acceleration * time**2 / 2
        return linkage.motion(angle, speed + acceleration * time, acceleration)

    def rate(name: str) -> FloatArray:
        value = {n: getattr(at(n * step), name) for n in (-2, -1, 1, 2)}
        if name == "angle":
            value = {n: np.unwrap([value[-2], v], axis=0)[1] for n, v in value.items()}
        return (value[-2] - 8 * value[-1] + 8 * value[1] - value[2]) / (12 * step)

    now = at(0.0)
    for name, derivative in (
        ("angle", "angular_velocity"),
        ("angular_velocity", "angular_acceleration"),
        ("origin", "origin_velocity"),
        ("origin_velocity", "origin_acceleration"),
    ):
        exact = getattr(now, derivative)
        assert np.abs(rate(name) - exact).max() < 1e-9 * np.abs(exact).max(), derivative


def test_a_dyad_that_is_too_short_is_refused():
    short = SixBar(FOUR_BAR, connector=0.1, output=0.1, pivot=(0.5, 0.05))
    with pytest.raises(InputError, match="do not meet"):
        short.motion(TURN)


def lumps(mass: LinkMass) -> list[tuple[float, float]]:
    """Masses and places with the link's moments up to the seventh (Gauss)."""
    points, weights = np.polynomial.legendre.leggauss(4)
    half = mass.length / 2
    return [
        *zip(mass.mass_per_length * half * weights, half * (points + 1), strict=True),
        *zip(mass.point_masses, mass.point_positions, strict=True),
    ]


@pytest.mark.parametrize("gravity", [(0.0, 0.0), (1.5, -9.81)])
def test_virtual_power_of_torque_and_inertia_forces_is_zero(six_bar, linkage, gravity):
    motion = linkage.motion(np.linspace(0, 2 * np.pi, 60), 15.0, -30.0)
    masses = six_bar.link_masses_in_order
    forces = inverse_dynamics(linkage.topology, motion, masses, gravity)
    power = forces.driving_torque * motion.crank_speed
    scale = np.zeros_like(power)
    for link, mass in enumerate(masses):
        for m, x in lumps(mass):
            load = -m * (motion.acceleration(link, x) - np.asarray(gravity))
            velocity = motion.velocity(link, x)
            power = power + np.sum(load * velocity, axis=-1)
            scale += np.linalg.norm(load, axis=-1) * np.linalg.norm(velocity, axis=-1)
    assert np.all(np.abs(power) <= 1e-12 * scale)


def test_the_rocker_and_connector_both_pull_on_the_coupler(six_bar):
    """At B the coupler's end carries what both followers ask for."""
    motion = LEFT.motion(TURN, 15.0)
    masses = six_bar.link_masses_in_order
    forces = inverse_dynamics(LEFT.topology, motion, masses)
    pin = forces.joint_force
    at_end = -(pin["B"] + pin["B2"])
    inertia = forces.inertia_force[:, COUPLER]
    balance = pin["A"] + at_end + inertia
    assert np.abs(balance).max() < 1e-12 * np.abs(pin["A"]).max()
    assert np.abs(pin["B2"]).max() > 0.1 * np.abs(pin["B"]).max()


def frequencies(engine, mechanism, speed, elements, **options):
    return natural_frequencies(engine(mechanism, elements), TURN, speed, modes=4, **options)


def test_both_engines_agree_at_rest(six_bar):
    first, second = (
        frequencies(engine, six_bar, 0.0, 8) for engine in (ReferenceEngine, ExudynEngine)
    )
    np.testing.assert_allclose(second, first, rtol=1e-5)


@pytest.mark.parametrize("rotation_terms", [True, False])
def test_both_engines_agree_at_equilibrium(six_bar, rotation_terms):
    still = frequencies(ReferenceEngine, six_bar, 0.0, 12)
    first, second = (
        frequencies(engine, six_bar, 15.0, 12, rotation_terms=rotation_terms)
        for engine in (ReferenceEngine, ExudynEngine)
    )
    np.testing.assert_allclose(second, first, rtol=1e-4)
    # The agreement means something: speed moves the frequencies far more.
    assert np.abs(first / still - 1).max() > 3e-3


def test_both_engines_agree_with_masses_gravity_and_damping(six_bar):
    loaded = Mechanism(
        RIGHT,
        {name: section.with_damping_time(1e-5) for name, section in six_bar.sections.items()},
        joint_masses={"B2": 0.03, "C": 0.02, "O6": 0.5},
        link_masses=(PointMass("connector", 0.11, 0.015), PointMass("output", 0.12, 0.01)),
        gravity=(0.0, -9.81),
    )
    first, second = (
        frequencies(engine, loaded, 15.0, 12) for engine in (ReferenceEngine, ExudynEngine)
    )
    np.testing.assert_allclose(second, first, rtol=1e-4)


@pytest.mark.parametrize("engine", [ReferenceEngine, ExudynEngine])
@pytest.mark.parametrize("speed", [0.0, 15.0])
def test_component_modes_change_nothing(six_bar, engine, speed):
    reduced, full = (
        natural_frequencies(engine(six_bar, 8, component_modes=on), TURN, speed, modes=4)
        for on in (True, False)
    )
    np.testing.assert_allclose(reduced, full, rtol=2e-5)


def test_a_mass_at_a_shared_joint_belongs_to_the_joint(six_bar):
    """At B the coupler leads two pins: a mass there is the same under either name."""
    values = [
        frequencies(
            ReferenceEngine,
            Mechanism(LEFT, six_bar.sections, joint_masses=masses),
            15.0,
            8,
        )
        for masses in ({"B": 0.03}, {"B2": 0.03}, {"B": 0.01, "B2": 0.02})
    ]
    np.testing.assert_allclose(values[1], values[0], rtol=1e-9)
    np.testing.assert_allclose(values[2], values[0], rtol=1e-9)


@pytest.mark.parametrize("engine", [ReferenceEngine, ExudynEngine])
def test_a_pin_may_follow_a_follower(six_bar, engine):
    """The coupler carries B's displacement in the end, whoever leads on the way."""
    chained = replace(six_bar, linkage=replace(LEFT, led_by="rocker"))
    values = [frequencies(engine, mechanism, 15.0, 8) for mechanism in (six_bar, chained)]
    np.testing.assert_allclose(values[1], values[0], rtol=1e-7)


@pytest.fixture(scope="module")
def result(six_bar):
    engines = [ReferenceEngine(six_bar, 8), ExudynEngine(six_bar, 8)]
    return moving_frequencies(engines, TURN, [0.0, 15.0], modes=3)


def test_moving_frequencies_of_five_links(result):
    dataset = result.dataset
    names = ["crank", "coupler", "rocker", "connector", "output"]
    assert dataset["link"].values.tolist() == names
    assert dataset.sizes["link"] == 5
    assert dataset["frequency"].shape == (2, 2, len(TURN), 3)
    assert np.all(np.diff(dataset["frequency"].values, axis=-1) > 0)
    assert float(dataset["reduction_error"].max()) < 2e-5
    assert result.agreement().relative_difference < 1e-3


def test_mode_shapes_keep_the_joints_together(result):
    """Displacements of all link ends at a joint are one, in ground axes."""
    shape = result.dataset["mode_shape"]
    at = {
        (link, end): shape.sel(link=link).isel(station=station).values
        for link in shape["link"].values.tolist()
        for end, station in (("start", 0), ("end", -1))
    }
    for pin in LEFT.topology.pins:
        leader, follower = (at[place.link, place.end] for place in (pin.leader, pin.follower))
        np.testing.assert_allclose(follower, leader, atol=1e-9)
    for link in ("crank", "rocker", "output"):
        assert np.abs(at[link, "start"]).max() < 1e-12
    assert np.abs(shape.sel(link="output")).max() > 1e-2
