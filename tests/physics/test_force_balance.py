"""Counterweights: by hand, by closed forms, and the shaking force of what is read back."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexmech import (
    AttachedBody,
    Balance,
    FourBar,
    InputError,
    Mechanism,
    PointMass,
    balance,
    example_model,
    kinematics,
    load_mechanism,
)
from flexmech.analyses import KinematicsRequest
from flexmech.modelfile import mechanism_from_toml
from tests.support.mechanisms import drawn
from tests.support.strategies import LINKS, arm, fourbar

SPEED = 20.0
TURN = np.radians(np.arange(0.0, 361.0, 5.0))


def rigidly(mechanism: Mechanism, **asked: object) -> Balance:
    """The balance of rigid links, in full where nothing else is asked for."""
    if asked.get("weights") is None and "share" not in asked:
        asked["full"] = True
    return balance(mechanism, SPEED, rigid=True, **asked)  # type: ignore[arg-type]


def peak(force: object) -> float:
    return float(np.linalg.norm(np.asarray(force), axis=-1).max())


def written(result: Balance) -> Mechanism:
    """The mechanism of the model file that a balance writes."""
    return mechanism_from_toml(result.texts()["balanced.toml"])


def test_counterweights_of_uniform_links_by_hand() -> None:
    """At half the lengths each counterweight is its link and half the coupler's two ends.

    Crank: m r = (m2 / 2 + m3 / 2) l2, so that at l2 / 2 it is m2 + m3; rocker: m3 + m4.
    """
    mechanism = fourbar()
    crank, coupler, rocker = (mechanism.link_mass(link).moment(0) for link in LINKS)
    data = rigidly(mechanism).dataset
    np.testing.assert_allclose(
        data["counterweight_mass"], [crank + coupler, coupler + rocker], rtol=1e-14
    )
    np.testing.assert_allclose(data["counterweight_radius"], [0.051, 0.13335], rtol=1e-14)
    places = [[-0.051, 0.0], [-0.13335, 0.0]]
    np.testing.assert_allclose(data["counterweight_place"], places, rtol=1e-14)
    assert data["counterweight_about"].values.tolist() == ["O2", "O4"]
    # Half as far out, twice the mass.
    near = rigidly(mechanism, radii=(0.0255, 0.066675)).dataset
    np.testing.assert_allclose(
        near["counterweight_mass"], 2 * data["counterweight_mass"], rtol=1e-14
    )


def test_a_body_on_the_coupler_is_shared_by_the_lever() -> None:
    """Between its pins; one beside the coupler turns the counterweights out of their links."""
    massless = {
        link: replace(own, mass_per_length=1e-12) for link, own in fourbar().sections.items()
    }
    length = fourbar().linkage.topology.links[1].length
    body = AttachedBody("coupler", length / 4, 0.2, offset=(0.0, 0.05))
    data = rigidly(replace(fourbar(), sections=massless, bodies=(body,))).dataset
    at_b = 0.2 * (length / 4 + 0.05j) / length
    moments = np.array([-(0.2 - at_b) * 0.102, -at_b * 0.2667])
    found = data["counterweight_mass"].values * (data["counterweight_place"].values @ [1, 1j])
    assert found == pytest.approx(moments, rel=1e-8)


@pytest.mark.parametrize("seed", range(4))
def test_whatever_the_masses_of_a_four_bar_nothing_is_left(seed: int) -> None:
    random = np.random.default_rng(seed)
    linkage = FourBar(1.0, random.uniform(0.1, 0.4), *random.uniform(0.75, 1.0, 2))
    assert linkage.crank_turns_fully
    points, bodies = [], []
    for link in linkage.topology.links:
        place = random.uniform(0.0, link.length)
        points.append(PointMass(link.name, place, random.uniform(0.1, 2.0)))
        offset = tuple(random.uniform(-link.length, link.length, 2).tolist())
        bodies.append(AttachedBody(link.name, 0.0, random.uniform(0.1, 2.0), 0.01, offset))
    mechanism = replace(fourbar(linkage), link_masses=tuple(points), bodies=tuple(bodies))
    data = rigidly(mechanism, crank_angles=TURN[::12]).dataset
    before, after = data["shaking_force"].values
    # Forces of the joints, of which the shaking force is the sum, have this round-off.
    assert peak(after) < 1e-12 * max(peak(before), float(abs(data["joint_force"]).max()))


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["aluminium_fourbar", "composite_fourbar", "sandwich_fourbar"])
def test_the_file_that_is_written_shakes_no_frame(name: str, tmp_path: Path) -> None:
    """At speeds and accelerations that it was not balanced at, too."""
    given_one = load_mechanism(example_model(name))
    rigidly(given_one, radii=(0.03, 0.05)).save(tmp_path)
    balanced = load_mechanism(tmp_path / "balanced.toml")
    for asked in (
        KinematicsRequest(SPEED, crank_angles=TURN),
        KinematicsRequest(3, crank_angles=TURN, crank_acceleration=500),
    ):
        after, before = (
            peak(kinematics(each, asked).dataset["shaking_force"]) for each in (balanced, given_one)
        )
        assert after < 1e-12 * before
    # Balanced once more nothing is left to add.
    assert np.all(rigidly(balanced).dataset["counterweight_mass"] == 0)


def test_a_four_bar_that_is_drawn_in_another_order_has_the_same_counterweights() -> None:
    """Behind the rocker's end, where its ground pivot is."""
    four = fourbar()
    a, b = (four.linkage.motion(0.7).position(1, x) for x in (0.0, 0.2794))
    points = {"O2": (0, 0), "A": tuple(a), "B": tuple(b), "O4": (0.254, 0)}
    links = {"rocker": ("B", "O4"), "crank": ("O2", "A"), "coupler": ("B", "A")}
    linkage = replace(drawn(points, links, {"O2": "clamp"}, ("O4",)), drawn_at=0.7)
    data = rigidly(Mechanism(linkage, four.sections, gravity=(0.0, -9.81))).dataset
    same = rigidly(four).dataset["counterweight_mass"]
    np.testing.assert_allclose(data["counterweight_mass"], same, rtol=1e-9)
    place = data["counterweight_place"].sel(counterweight="rocker")
    np.testing.assert_allclose(place, [1.5 * 0.2667, 0.0], atol=1e-12)
    before, after = data["shaking_force"].values
    assert peak(after) < 1e-12 * peak(before)


def test_a_share_of_a_slider_cranks_reciprocating_mass_turns_with_the_crank() -> None:
    """Across the line its counterweight alone is left: c m r omega^2 sin theta; half is best."""
    mechanism = load_mechanism(example_model("slider_crank"))
    reciprocating = mechanism.link_mass("rod").moment(1) / 0.3
    size, peaks = reciprocating * 0.15 * SPEED**2, []
    for share in (0.0, 0.5, 1.0):
        data = rigidly(mechanism, share=share, crank_angles=TURN).dataset.sel(state="balanced")
        across = data["shaking_force"].sel(component="y").values
        assert across == pytest.approx(-share * size * np.sin(TURN), abs=1e-9 * size)
        peaks.append(peak(data["shaking_force"]))
    assert peaks[1] < min(peaks[0], peaks[2])


RADII = np.array([0.03, 0.04])


def weighed(mechanism: Mechanism, moments: np.ndarray, weights: tuple[float, ...]) -> float:
    """The sum that a compromise makes least, by inverse dynamics of links with point masses.

    Weighed squares of shaking force, shaking moment and driving torque over those as given; the
    weight counts in the torque alone.
    """
    places = RADII * moments / abs(moments)
    bodies = tuple(
        AttachedBody(link, 0.0, float(abs(moment) / radius), 0.0, (place.real, place.imag))
        for link, moment, radius, place in zip(
            ("crank", "rocker"), moments, RADII, places, strict=True
        )
    )
    rows = []
    for each in (mechanism, replace(mechanism, bodies=bodies)):
        asked = KinematicsRequest(SPEED, crank_angles=TURN)
        free = kinematics(replace(each, gravity=(0.0, 0.0)), asked).dataset
        torque = kinematics(each, asked).dataset["driving_torque"]
        values = free["shaking_force"], free["shaking_moment"], torque
        rows.append([float((value**2).sum()) for value in values])
    return sum(w * after / before for w, before, after in zip(weights, *rows, strict=True))


@pytest.mark.thorough
def test_no_counterweights_near_a_compromise_are_better() -> None:
    """In any direction by a fiftieth: the sum rises with the square of the step."""
    mechanism, weights = fourbar(gravity=(0.0, -9.81)), (1.0, 0.3, 0.7)
    data = rigidly(mechanism, weights=weights, radii=tuple(RADII), crank_angles=TURN).dataset
    places = data["counterweight_place"].values @ [1, 1j]
    moments = data["counterweight_mass"].values * places
    assert abs(places) == pytest.approx(RADII)
    least, scale = weighed(mechanism, moments, weights), abs(moments)
    for direction in ((1, 0), (1j, 0), (0, 1), (0, 1j)):
        step = 0.02 * scale * direction
        up, down = (weighed(mechanism, moments + s * step, weights) - least for s in (1, -1))
        assert up > 0
        assert down > 0
        # Flat: the slope is a small part of the curvature's rise.
        assert abs(up - down) < 0.05 * (up + down)


def test_of_the_force_alone_a_compromise_is_the_full_balance() -> None:
    """No weight on the crank reduces the shaking moment alone, which is about the crank's axis."""
    data, full = (rigidly(fourbar(), weights=w).dataset for w in ((1, 0, 0), None))
    for name in ("counterweight_mass", "counterweight_place"):
        np.testing.assert_allclose(data[name], full[name], rtol=1e-6, atol=1e-9)
    masses = rigidly(fourbar(), weights=(0.0, 1.0, 0.0)).dataset["counterweight_mass"]
    assert float(masses.sel(counterweight="crank")) == 0.0
    assert float(masses.sel(counterweight="rocker")) > 0.0


def test_a_balanced_force_has_one_moment_about_all_points() -> None:
    """A compromise has not."""
    peaks = [
        float(abs(data["shaking_moment"].sel(state="balanced")).max())
        for weights in (None, (1, 1, 1))
        for point in ((0.0, 0.0), (0.254, 0.3))
        for data in [rigidly(fourbar(), weights=weights, moment_point=point).dataset]
    ]
    assert peaks[0] == pytest.approx(peaks[1], rel=1e-12)
    assert peaks[2] != pytest.approx(peaks[3], rel=0.1)


def test_equal_weights_are_the_default_and_the_full_balance_is_its_limit() -> None:
    found = balance(fourbar(), SPEED, rigid=True).dataset
    weighed_alike, full = (rigidly(fourbar(), weights=w).dataset for w in ((1, 1, 1), None))
    np.testing.assert_array_equal(found["counterweight_mass"], weighed_alike["counterweight_mass"])
    assert found["state"].values.tolist() == ["as given", "balanced", "full balance"]
    assert full["state"].values.tolist() == ["as given", "balanced"]
    for name in ("shaking_force", "shaking_moment", "driving_torque", "moving_mass", "greatest"):
        limit = found[name].sel(state="full balance").values
        np.testing.assert_array_equal(limit, full[name].sel(state="balanced").values)
    sums = [
        sum(
            float((data[name].sel(state=state) ** 2).sum() / (data[name][0] ** 2).sum())
            for name in ("shaking_force", "shaking_moment", "driving_torque")
        )
        for data, state in ((found, "balanced"), (found, "full balance"))
    ]
    # As given the sum is 3.
    assert sums[0] < min(3.0, sums[1])


@pytest.mark.parametrize(
    ("mechanism", "said"),
    [
        (lambda: arm(), "one coupler; this linkage has 1 link"),
        (lambda: load_mechanism(example_model("carton_pusher")), "5 links, 1 clamp, 3 pins"),
    ],
)
def test_other_linkages_are_refused_with_what_they_have(mechanism: object, said: str) -> None:
    with pytest.raises(InputError, match=said):
        balance(mechanism(), 5.0, rigid=True)  # type: ignore[operator]


def test_greatest_values_are_sought_between_the_crank_angles() -> None:
    """Steps of 30 degrees give those of 0.1 degrees, and those of the model with the weights."""
    coarse, fine = (
        rigidly(fourbar(), crank_angles=np.radians(np.arange(0.0, 360.05, step))).dataset
        for step in (30.0, 0.1)
    )
    np.testing.assert_allclose(coarse["greatest"][:, 1:], fine["greatest"][:, 1:], rtol=1e-9)
    torque = fine["greatest"].sel(quantity="driving_torque").values
    sampled = abs(fine["driving_torque"]).max("crank_angle").values
    assert (torque >= sampled).all()
    np.testing.assert_allclose(torque, sampled, rtol=1e-5)
    assert abs(coarse["driving_torque"]).max("crank_angle").values[0] < 0.999 * torque[0]
    told = rigidly(fourbar()).summary().trust
    assert told == "numbers of rigid links are known to 0.0001 %"
