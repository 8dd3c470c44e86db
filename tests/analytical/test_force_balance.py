"""Counterweights: by hand, by closed forms, and the shaking force of what is read back."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import flexmech
from flexmech import AttachedBody, Balance, BalanceRequest, Mechanism, PointMass
from flexmech.analyses.balance.compromise import WeighedSum, inertia_loads, least_moments
from flexmech.analyses.balance.compute import counterweights
from flexmech.analyses.balance.counterweights import Counterweight, balanced
from flexmech.analyses.shaking import shaking_of
from flexmech.linkages import assemblable
from flexmech.linkages.force_balance import OneCouplerLinkage
from tests.support.strategies import LINKS, fourbar, numbers, postures

MODELS = Path(__file__).parents[2] / "models"
SPEED = 20.0
TURN = np.radians(np.arange(0.0, 361.0))


def rigidly(mechanism: Mechanism, **asked: object) -> Balance:
    return flexmech.balance(mechanism, BalanceRequest(SPEED, elastic=False, **asked))  # type: ignore[arg-type]


def peak(mechanism: Mechanism, angles: np.ndarray = TURN) -> float:
    """Of the shaking force in N, by joint forces."""
    request = flexmech.KinematicsRequest(angles, SPEED)
    force = flexmech.kinematics(mechanism, request).dataset["shaking_force"].values
    return float(np.linalg.norm(force, axis=-1).max())


def test_of_uniform_links_by_hand() -> None:
    """At half the lengths each counterweight is its link and half the coupler's two ends.

    Crank: m r = (m2 / 2 + m3 / 2) l2, so that at l2 / 2 it is m2 + m3; rocker: m3 + m4.
    """
    mechanism = fourbar()
    masses = {link: mechanism.link_mass(link).moment(0) for link in LINKS}
    data = rigidly(mechanism).dataset
    np.testing.assert_allclose(
        data["counterweight_mass"],
        [masses["crank"] + masses["coupler"], masses["coupler"] + masses["rocker"]],
        rtol=1e-14,
    )
    np.testing.assert_allclose(data["counterweight_radius"], [0.051, 0.13335], rtol=1e-14)
    places = [[-0.051, 0.0], [-0.13335, 0.0]]
    np.testing.assert_allclose(data["counterweight_place"], places, rtol=1e-14)
    assert data["counterweight_about"].values.tolist() == ["O2", "O4"]


def test_of_a_coupler_of_one_point_by_the_lever() -> None:
    """A mass on the coupler is shared between its pins; one beside it turns the counterweights."""
    light = fourbar().sections
    massless = {link: replace(own, mass_per_length=1e-12) for link, own in light.items()}
    coupler = fourbar().linkage.topology.links[1].length
    body = AttachedBody("coupler", coupler / 4, 0.2, offset=(0.0, 0.05))
    mechanism = replace(fourbar(), sections=massless, bodies=(body,))
    linkage = OneCouplerLinkage.of(mechanism.linkage.topology)
    crank, rocker = linkage.balancing_moments(mechanism.link_masses_in_order)
    second = 0.2 * (coupler / 4 + 0.05j) / coupler
    assert crank == pytest.approx(-(0.2 - second) * 0.102, rel=1e-9)
    assert rocker == pytest.approx(-second * 0.2667, rel=1e-9)


@given(posture=postures(), data=st.data())
def test_whatever_the_masses_nothing_is_left(posture, data) -> None:  # type: ignore[no-untyped-def]
    """Any four-bar, with masses anywhere, within what can be assembled around its posture."""
    linkage = posture.linkage
    lengths = {link.name: link.length for link in linkage.topology.links}
    points = tuple(
        PointMass(name, data.draw(numbers(0.0, length)), data.draw(numbers(0.1, 2.0)))
        for name, length in lengths.items()
    )
    bodies = tuple(
        AttachedBody(
            name,
            0.0,
            data.draw(numbers(0.1, 2.0)),
            0.01,
            (data.draw(numbers(-length, length)), data.draw(numbers(-length, length))),
        )
        for name, length in lengths.items()
    )
    mechanism = replace(fourbar(linkage), link_masses=points, bodies=bodies)
    angles = posture.crank_angle + np.array([0.0, 0.02, 0.05])
    weights, _ = counterweights(mechanism, BalanceRequest(SPEED))
    assume(assemblable(linkage, angles).all())
    motion, after = linkage.motion(angles, SPEED), balanced(mechanism, weights)
    forces = [each.inverse_dynamics(motion) for each in (mechanism, after)]
    before, left = (
        np.abs(shaking_of(each, own).force).max()
        for each, own in zip((mechanism, after), forces, strict=True)
    )
    # Forces of the joints, of which the shaking force is the sum, have this round-off.
    largest = max(float(np.abs(force).max()) for force in forces[1].joint_force.values())
    assert left < 1e-12 * max(before, largest)


@pytest.mark.parametrize(
    "name", ["aluminium_fourbar", "steel_fourbar", "composite_fourbar", "sandwich_fourbar"]
)
def test_the_file_that_is_written_shakes_no_frame(name: str, tmp_path: Path) -> None:
    given_one = flexmech.load_mechanism(MODELS / f"{name}.toml")
    rigidly(given_one, radii=(0.03, 0.05)).save(tmp_path)
    written = flexmech.load_mechanism(tmp_path / "balanced.toml")
    assert peak(written) < 1e-12 * peak(given_one)
    assert [body.mass > 0 for body in written.bodies[-2:]] == [True, True]
    # At speeds and accelerations that it was not balanced at, too.
    request = flexmech.KinematicsRequest(TURN, 3.0, crank_acceleration=500.0)
    states = (flexmech.kinematics(each, request).dataset for each in (written, given_one))
    after, before = (np.abs(data["shaking_force"]).max() for data in states)
    assert after < 1e-12 * before


def test_a_four_bar_that_is_drawn_is_one() -> None:
    """A planar linkage whose links have their ends in another order has the same counterweights."""
    four = fourbar()
    angle = 0.7
    a, b = (four.linkage.motion(angle).position(1, x) for x in (0.0, 0.2794))
    linkage = flexmech.PlanarLinkage(
        points={"O2": (0, 0), "A": tuple(a), "B": tuple(b), "O4": (0.254, 0)},
        links=(
            flexmech.PlanarLink("rocker", ("B", "O4")),
            flexmech.PlanarLink("crank", ("O2", "A")),
            flexmech.PlanarLink("coupler", ("B", "A")),
        ),
        ground=("O2", "O4"),
        joints=(flexmech.PlanarJoint("O2", "clamp"),),
        drawn_at=angle,
    )
    drawn = Mechanism(linkage, four.sections, gravity=(0.0, -9.81))
    data, wanted = rigidly(drawn).dataset, rigidly(four).dataset
    np.testing.assert_allclose(data["counterweight_mass"], wanted["counterweight_mass"], rtol=1e-9)
    assert data["counterweight"].values.tolist() == ["crank", "rocker"]
    # Behind the rocker's end, where its ground pivot is.
    np.testing.assert_allclose(
        data["counterweight_place"].sel(counterweight="rocker"), [1.5 * 0.2667, 0.0], atol=1e-12
    )
    # Fixed to the section there, which bends least.
    weights, _ = counterweights(drawn, BalanceRequest(SPEED))
    assert [weight.body.position for weight in weights] == [0.0, pytest.approx(0.2667)]
    force = np.abs(data["shaking_force"])
    assert float(force.sel(state="balanced").max()) < 1e-12 * float(force.max())


class TestSliderCrank:
    def test_the_rest_of_a_share(self) -> None:
        """Across the line the share's counterweight alone: c m r omega^2 sin theta."""
        mechanism = flexmech.load_mechanism(MODELS / "slider_crank.toml")
        rod = mechanism.link_mass("rod")
        reciprocating = rod.moment(1) / 0.3
        for share in (0.0, 0.5, 1.0):
            data = rigidly(mechanism, share=share).dataset.sel(state="balanced")
            across = data["shaking_force"].sel(component="y").values
            wanted = -share * reciprocating * 0.15 * SPEED**2 * np.sin(TURN)
            assert across == pytest.approx(wanted, abs=1e-9 * reciprocating * 0.15 * SPEED**2)

    def test_half_of_it_is_better_than_none_and_all(self) -> None:
        mechanism = flexmech.load_mechanism(MODELS / "slider_crank.toml")
        peaks = []
        for share in (0.0, 0.5, 1.0):
            force = rigidly(mechanism, share=share).dataset["shaking_force"].sel(state="balanced")
            peaks.append(float(np.linalg.norm(force, axis=-1).max()))
        assert peaks[1] < min(peaks[0], peaks[2])


class TestCompromise:
    RADII = (0.03, 0.04)

    def sums(self, mechanism: Mechanism, weights: tuple[float, ...]) -> WeighedSum:
        linkage = OneCouplerLinkage.of(mechanism.linkage.topology)
        motion = mechanism.linkage.motion(TURN, SPEED)
        lengths = mechanism.linkage.topology.links
        links = [
            (link, lengths[link.number].length, radius)
            for link, radius in zip(linkage.turning, self.RADII, strict=True)
        ]
        return WeighedSum.of(mechanism, motion, links, weights, None)

    def direct(
        self, mechanism: Mechanism, moments: list[complex], weights: tuple[float, ...]
    ) -> float:
        """The sum from the inverse dynamics of the mechanism with its counterweights."""
        linkage = OneCouplerLinkage.of(mechanism.linkage.topology)
        motion = mechanism.linkage.motion(TURN, SPEED)
        lengths = mechanism.linkage.topology.links
        added = [
            Counterweight.of_moment(link, lengths[link.number].length, moment, radius)
            for link, moment, radius in zip(linkage.turning, moments, self.RADII, strict=True)
        ]
        rows = zip(
            inertia_loads(mechanism, motion).rows,
            inertia_loads(balanced(mechanism, added), motion).rows,
            weights,
            strict=True,
        )
        return sum(weight * np.sum(after**2) / np.sum(before**2) for before, after, weight in rows)

    @pytest.mark.parametrize("gravity", [(0.0, 0.0), (0.0, -9.81)])
    def test_the_form_is_the_sum(self, gravity: tuple[float, float]) -> None:
        """Whatever the counterweights: linear in moments and their sizes, with weight too."""
        mechanism, weights = replace(fourbar(), gravity=gravity), (1.0, 0.3, 0.7)
        form = self.sums(mechanism, weights)
        for moments in ([-3e-3 + 1e-3j, 2e-3 - 4e-3j], [0j, -8e-3 + 0j], [1e-3j, 0j]):
            parts = np.array([[one.real, one.imag] for one in moments]).ravel()
            wanted = self.direct(mechanism, moments, weights)
            assert form.value(parts) == pytest.approx(wanted, rel=1e-10)
            step = 1e-9
            for number in np.flatnonzero(parts):
                moved = parts.copy()
                moved[number] += step
                slope = (form.value(moved) - form.value(parts)) / step
                assert form.gradient(parts)[number] == pytest.approx(slope, rel=1e-4, abs=1e-3)

    @pytest.mark.parametrize(
        "weights", [(1.0, 1.0, 1.0), (1.0, 0.2, 0.2), (0.0, 1.0, 0.0), (0.1, 0.0, 1.0)]
    )
    def test_no_counterweight_near_it_is_better(self, weights: tuple[float, ...]) -> None:
        mechanism = fourbar()
        linkage = OneCouplerLinkage.of(mechanism.linkage.topology)
        full = linkage.balancing_moments(mechanism.link_masses_in_order)
        form = self.sums(mechanism, weights)
        found = least_moments(form, full)
        least = form.value(np.array([[one.real, one.imag] for one in found]).ravel())
        assert least == pytest.approx(self.direct(mechanism, found, weights), rel=1e-9)
        # A grid about it and one over all that is of the size of a full balance.
        random = np.random.default_rng(7)
        scale = max(abs(one) for one in full)
        for size in (1e-3, 1e-2, 0.1, 1.0, 3.0):
            for _ in range(200):
                step = size * scale * random.normal(size=4)
                there = np.array([[one.real, one.imag] for one in found]).ravel() + step
                assert form.value(there) >= least * (1 - 1e-9)

    def test_of_the_force_alone_it_is_the_full_balance(self) -> None:
        data = rigidly(fourbar(), weights=(1, 0, 0)).dataset
        full = rigidly(fourbar()).dataset
        for name in ("counterweight_mass", "counterweight_place"):
            np.testing.assert_allclose(data[name], full[name], rtol=1e-6, atol=1e-9)

    def test_a_shaking_moment_about_another_point(self) -> None:
        """A balanced force has the same moment about all points, a compromise has not."""
        peaks = [
            float(
                np.abs(rigidly(fourbar(), moment_point=point, **asked).dataset["shaking_moment"])
                .sel(state="balanced")
                .max()
            )
            for asked in ({}, {"weights": (1, 1, 1)})
            for point in ((0.0, 0.0), (0.254, 0.3))
        ]
        assert peaks[0] == pytest.approx(peaks[1], rel=1e-12)
        assert peaks[2] != pytest.approx(peaks[3], rel=0.1)
