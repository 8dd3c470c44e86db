"""Strength of pins by hand: a slider-crank at its dead centre, and speeds at which pins fail."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from flexmech.analyses.strength.compute import strength
from flexmech.analyses.strength.forces import cuts_of, forces_over_the_turn, internal_forces
from flexmech.analyses.strength.joint_loads import JointLoads
from flexmech.analyses.strength.pin_speeds import speed_of_force, speed_of_pull, speed_of_wear
from flexmech.analyses.strength.pin_speeds import tearing_force as tearing
from flexmech.analyses.strength.pin_stresses import (
    bearing_pressure,
    net_tension,
    pressure_velocity,
    shear_out,
)
from flexmech.analyses.strength.request import StrengthRequest
from flexmech.analyses.strength.result import Strength
from flexmech.linkages import AttachmentPoint, Load, PlanarJoint, PlanarLink, PlanarLinkage
from flexmech.materials import Material
from flexmech.mechanism import JointPin, Mechanism, PinEye
from flexmech.modelfile import load_mechanism
from flexmech.reference import ReferenceEngine
from flexmech.sections import BeamSection

MODELS = Path(__file__).parents[2] / "models"
YIELD = 240e6
# Without weight, so that slider and load alone make the forces.
LIGHT = Material(70e9, 1e-6, 0.33, yield_strength=YIELD)
STEEL = replace(LIGHT, youngs_modulus=200e9, density=7800.0)
WIDTH, HEIGHT = 12e-3, 20e-3
DIAMETER, EDGE = 8e-3, 14e-3
SPEED = 150.0


def test_formulas_by_hand() -> None:
    """5 kN on a pin of 10 mm in a hole of 8 mm, in an eye of 30 mm whose end is 20 mm away."""
    assert bearing_pressure(5e3, 10e-3, 8e-3) == pytest.approx(62.5e6)
    assert net_tension(5e3, 30e-3, 10e-3, 8e-3) == pytest.approx(31.25e6)
    assert shear_out(5e3, 20e-3, 10e-3, 8e-3) == pytest.approx(5e3 / (2 * 15e-3 * 8e-3))
    # 300 N on a bush of 20 mm x 15 mm at 60 rpm: 1 MPa times 62.8 mm/s.
    turning = 2 * np.pi
    assert pressure_velocity(300.0, turning, 20e-3, 15e-3) == pytest.approx(1e6 * np.pi * 0.02)


def in_sections(mechanism: Mechanism, material: Material) -> Mechanism:
    """The mechanism with sections of one size and material, and no masses at its joints."""
    section = BeamSection.rectangle(material, HEIGHT, WIDTH)
    sections = dict.fromkeys(mechanism.linkage.topology.link_names, section)
    return replace(mechanism, sections=sections, joint_masses={}, link_masses=())


def pinned(mechanism: Mechanism, **allowed: float) -> Mechanism:
    """The mechanism with pins of one size in all pins and pivots."""
    ends = mechanism.linkage.topology.turning_ends
    pins = tuple(
        JointPin(
            joint,
            DIAMETER,
            tuple(PinEye(end.link, edge_distance=EDGE) for end in own if end is not None),
            **allowed,
        )
        for joint, own in ends.items()
    )
    return replace(mechanism, joint_pins=pins)


def slider_crank() -> Mechanism:
    mechanism = load_mechanism(MODELS / "slider_crank.toml")
    light = in_sections(mechanism, LIGHT)
    return pinned(
        replace(light, joint_masses={"B": 0.5}), allowable_pv=5e6, allowable_bearing_pressure=30e6
    )


def rigid(mechanism: Mechanism, speed: StrengthRequest | float) -> Strength:
    """Of links that are taken as rigid, whose forces can be had by hand."""
    asked = speed if isinstance(speed, StrengthRequest) else StrengthRequest(crank_speed=speed)
    return strength(mechanism, replace(asked, source="rigid"))


def checks(dataset: xr.Dataset, joint: str, link: str = "") -> dict[str, xr.Dataset]:
    """Checks of a pin in one link, or of its bush, by their modes."""
    own = (dataset["pin_joint"].values == joint) & (dataset["pin_link"].values == link)
    found = dataset.isel(pin_check=own, engine=0)
    return {
        str(mode): found.isel(pin_check=number)
        for number, mode in enumerate(found["pin_mode"].values)
    }


@pytest.mark.parametrize(("angle", "sign"), [(0.0, 1.0), (np.pi, -1.0)])
def test_slider_crank_at_its_dead_centres(angle: float, sign: float) -> None:
    """The slider alone: F = m r w^2 (1 +- r/l), which pulls at the outer one, pushes at the inner.

    Crank and rod turn against each other by w (1 +- r/l).
    """
    mechanism = slider_crank()
    crank, rod = (link.length for link in mechanism.linkage.topology.links)
    found = rigid(mechanism, StrengthRequest(np.array([angle]), SPEED)).dataset
    ratio = 1 + sign * crank / rod
    force = 0.5 * crank * SPEED**2 * ratio
    own = checks(found, "A", "rod")
    bearing = force / (DIAMETER * WIDTH)
    assert float(own["bearing pressure"]["pin_stress"]) == pytest.approx(bearing, rel=1e-6)
    assert float(own["bearing yield"]["pin_load_factor"]) == pytest.approx(YIELD / bearing)
    assert float(own["bearing yield"]["pin_speed_factor"]) == pytest.approx(
        np.sqrt(YIELD / bearing), rel=1e-6
    )
    wear = force * SPEED * ratio / (2 * WIDTH)
    bush = checks(found, "A")["p v"]
    assert float(bush["pin_stress"]) == pytest.approx(wear, rel=1e-6)
    assert float(bush["pin_speed_factor"]) == pytest.approx(np.cbrt(5e6 / wear), rel=1e-6)
    pulls = max(sign, 0.0) * force
    net = pulls / ((HEIGHT - DIAMETER) * WIDTH)
    out = pulls / (2 * (EDGE - DIAMETER / 2) * WIDTH)
    for mode, stress in (("net tension", net), ("shear-out", out)):
        assert float(own[mode]["pin_stress"]) == pytest.approx(stress, rel=1e-6, abs=1.0)
    assert float(own["shear-out"]["pin_allowable"]) == pytest.approx(YIELD / np.sqrt(3))


def three_links_on_a_pin() -> Mechanism:
    """Coupler, rocker and rod meet at B."""
    ends = {"crank": "O2 A", "coupler": "A B", "rocker": "O4 B", "rod": "B C", "output": "O6 C"}
    linkage = PlanarLinkage(
        points={
            "O2": (0.0, 0.0),
            "O4": (0.3, 0.0),
            "O6": (0.6, 0.0),
            "A": (0.05, 0.08),
            "B": (0.3, 0.2),
            "C": (0.6, 0.2),
        },
        links=tuple(PlanarLink(name, tuple(own.split())) for name, own in ends.items()),
        ground=("O2", "O4", "O6"),
        joints=(PlanarJoint("O2", "clamp"),),
    )
    section = BeamSection.rectangle(LIGHT, HEIGHT, WIDTH)
    return Mechanism(linkage, dict.fromkeys(ends, section))


def test_pin_of_a_slider_carries_its_block() -> None:
    """Through a rod without mass: the force of the other pin, whichever way the block pulls.

    A load on the block goes the same way. The rod alone turns, at the dead centre by w r/l.
    """
    mechanism = slider_crank()
    crank, rod = (link.length for link in mechanism.linkage.topology.links)
    gas = Load("gas", AttachmentPoint("rod", rod), ((-900.0, 0.0),))
    for pushed in (mechanism, replace(mechanism, loads=(gas,))):
        found = rigid(pushed, SPEED).dataset
        for mode, own in checks(found, "B", "rod").items():
            other = checks(found, "A", "rod")[mode]
            for name in ("pin_load_factor", "pin_speed_factor", "pin_worst_angle"):
                assert float(own[name]) == pytest.approx(float(other[name]), rel=1e-5)
    dead = rigid(mechanism, StrengthRequest(np.zeros(1), SPEED)).dataset
    force = 0.5 * crank * SPEED**2 * (1 + crank / rod)
    bearing = checks(dead, "B", "rod")["bearing pressure"]["pin_stress"]
    assert float(bearing) == pytest.approx(force / (DIAMETER * WIDTH), rel=1e-6)
    wear = force * SPEED * (crank / rod) / (2 * WIDTH)
    assert float(checks(dead, "B")["p v"]["pin_stress"]) == pytest.approx(wear, rel=1e-6)


def test_a_block_on_a_link_turns_with_it() -> None:
    """A quick return, crank r at the distance 2 r from the pivot of its slotted link.

    In line with it the slotted link turns by w/3 and by -w, the crank against it by the rest.
    """
    linkage = PlanarLinkage(
        points={"O2": (0.0, 0.0), "O4": (0.0, -0.2), "A": (0.0, 0.1), "E": (0.0, 0.3)},
        links=(PlanarLink("crank", ("O2", "A")), PlanarLink("slotted", ("O4", "E"), rigid=True)),
        ground=("O2", "O4"),
        joints=(PlanarJoint("O2", "clamp"), PlanarJoint("A", "slider", (), 0.0, "slotted")),
    )
    section = BeamSection.rectangle(STEEL, HEIGHT, WIDTH)
    mechanism = Mechanism(linkage, dict.fromkeys(("crank", "slotted"), section))
    found = forces_over_the_turn(mechanism, np.radians([90.0, 270.0, 30.0]), SPEED)
    loads = JointLoads.of_steady_links(found, linkage.topology)
    np.testing.assert_allclose(loads.turning("A")[:2], [2 / 3 * SPEED, 2 * SPEED], rtol=1e-9)
    # Without a mass of its own the block hands on what its line gives.
    size = np.hypot(*found.joint_force["A"][2])
    assert size > 1.0
    assert np.hypot(*loads.vector("A")[2]) == pytest.approx(size, rel=1e-6)


@pytest.mark.parametrize("model", ["steel_fourbar", "stephenson_six_bar", "slider_crank", ""])
def test_force_on_an_eye_is_what_its_link_carries_there(model: str) -> None:
    """Tension and shear force at a link's end, cut free, are the pin's pull and its part across.

    Where three links meet on a pin, an eye carries what both of the others feel.
    """
    known = load_mechanism(MODELS / f"{model}.toml") if model else three_links_on_a_pin()
    mechanism = in_sections(known, replace(LIGHT, density=2700.0))
    topology = mechanism.linkage.topology
    found = forces_over_the_turn(mechanism, np.radians([10.0, 75.0, 200.0, 310.0]), 20.0)
    loads = JointLoads.of_steady_links(found, topology)
    ends = {end for own in topology.pinned_ends.values() for end in own if end is not None}
    welded = {end for weld in topology.welds for end in (weld.leader, weld.follower)}
    assert len(ends - welded) > 1
    for end in ends - welded:
        number, at = topology.index(end.link), 0 if end.end == "start" else -1
        cut = internal_forces(found, number, cuts_of(mechanism, end.link, 2)).loads[:, at]
        on_eye = loads.on_eye(end)
        scale = np.abs(on_eye).max()
        np.testing.assert_allclose(on_eye[:, 0], cut[:, 0], atol=1e-6 * scale)
        # The face of the link's start looks the other way.
        across = cut[:, 2] if end.end == "end" else -cut[:, 2]
        np.testing.assert_allclose(on_eye[:, 1], across, atol=1e-6 * scale)


def loaded() -> Mechanism:
    """A four-bar with weight and a load that stay as the speed rises."""
    mechanism = load_mechanism(MODELS / "steel_fourbar.toml")
    mechanism = in_sections(mechanism, replace(LIGHT, density=7800.0))
    pull = Load("pull", AttachmentPoint("coupler", 0.1), ((800.0, -300.0),))
    mechanism = replace(mechanism, gravity=(0.0, -9.81), loads=(pull,))
    return pinned(mechanism, allowable_pv=8e6, allowable_bearing_pressure=40e6)


def test_at_its_speed_factor_each_check_is_at_its_bound() -> None:
    """Weight and load stay, inertia grows: seen by computing anew at the faster speed."""
    mechanism = loaded()
    slow = rigid(mechanism, 100.0).dataset
    seen = set()
    for number, factor in enumerate(slow["pin_speed_factor"].values[0]):
        fast = rigid(mechanism, 100.0 * float(factor)).dataset.isel(pin_check=number, engine=0)
        assert float(fast["pin_load_factor"]) == pytest.approx(1.0, rel=1e-9)
        seen.add(str(fast["pin_mode"].item()))
        assert factor**2 != pytest.approx(float(slow["pin_load_factor"][0, number]), rel=1e-2)
    assert seen == {"bearing yield", "bearing pressure", "net tension", "shear-out", "p v"}


def test_inertia_alone_grows_by_square_and_by_cube() -> None:
    mechanism = replace(loaded(), gravity=(0.0, 0.0), loads=())
    found = rigid(mechanism, 100.0).dataset
    power = np.where(found["pin_mode"] == "p v", 3, 2)
    np.testing.assert_allclose(
        found["pin_speed_factor"].values[0] ** power, found["pin_load_factor"].values[0], rtol=1e-9
    )


def test_at_rest_no_bush_wears_and_no_speed_follows() -> None:
    found = rigid(loaded(), 0.0).dataset
    wear = found["pin_mode"].values == "p v"
    assert np.isinf(found["pin_load_factor"].values[0, wear]).all()
    assert np.isfinite(found["pin_load_factor"].values[0, ~wear]).all()
    assert np.isnan(found["pin_speed_factor"]).all()


def first_crossing(size: object, most: float = 1e3) -> float:
    """Least factor at which a function reaches 1, by looking and halving."""
    grid = np.concatenate([np.linspace(0, 10, 20_001), np.geomspace(10, most, 5_000)])
    beyond = np.flatnonzero(size(grid) >= 1)  # type: ignore[operator]
    if not len(beyond):
        return np.inf
    low, high = grid[max(beyond[0] - 1, 0)], grid[beyond[0]]
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (low, middle) if size(np.array([middle]))[0] >= 1 else (middle, high)  # type: ignore[operator]
    return float(high)


@pytest.mark.parametrize("scale", [0.1, 1.0])
def test_speed_factors_by_searching(scale: float) -> None:
    rng = np.random.default_rng(7)
    still = rng.uniform(-0.7, 0.7, (60, 2))
    growing = scale * rng.uniform(-1.0, 1.0, (60, 2))
    still[:5], growing[5:8] = 0.0, 0.0
    growing[8, 0], growing[9, 1], still[10, 1] = 0.0, 0.0, 0.0
    of_force, of_pull, of_wear = (
        function(still, growing) for function in (speed_of_force, speed_of_pull, speed_of_wear)
    )
    for number, (rest, more) in enumerate(zip(still, growing, strict=True)):

        def force(s: np.ndarray) -> np.ndarray:
            return rest + s[:, None] ** 2 * more  # noqa: B023

        expected = first_crossing(lambda s: np.hypot(*force(s).T))
        assert of_force[number] == pytest.approx(expected, rel=1e-9)
        expected = first_crossing(lambda s: tearing(force(s)))
        assert of_pull[number] == pytest.approx(expected, rel=1e-9)
        expected = first_crossing(lambda s: s * np.hypot(*force(s).T))
        assert of_wear[number] == pytest.approx(expected, rel=1e-9)


def test_a_force_at_rest_that_is_too_large_already() -> None:
    still, growing = np.array([[0.0, 1.5], [-1.5, 0.2]]), np.array([[0.0, -0.1], [0.5, 0.0]])
    assert speed_of_force(still, growing).tolist() == [0.0, 0.0]
    # The second one pushes at rest; it begins to pull at sqrt(3) and fails beyond.
    pulled = speed_of_pull(still, growing)
    assert pulled[0] == 0.0
    assert pulled[1] == pytest.approx(np.sqrt((1.5 + np.sqrt(1 - 0.04)) / 0.5))


@pytest.mark.thorough
def test_speed_of_a_bush_is_searched_by_runs() -> None:
    """Slowly running links are nearly rigid: p v passes its bound near the cube root."""
    mechanism = in_sections(load_mechanism(MODELS / "steel_fourbar.toml"), STEEL)
    request = StrengthRequest(crank_speed=60.0, source="periodic")
    wear = rigid(pinned(mechanism, allowable_pv=1.0), request.crank_speed).dataset
    greatest = float(wear["pin_stress"].values[0, wear["pin_mode"].values == "p v"].max())
    limited = pinned(mechanism, allowable_pv=4 * greatest)
    data = strength(ReferenceEngine(limited, 2), request).dataset
    assert str(data["margin_kind"].values[0]) == "pin"
    assert str(data["margin_mode"].values[0]) == "p v"
    factors = data["margin_speed_factor"].values
    assert factors[0] == pytest.approx(np.cbrt(4.0), rel=0.02)
    assert np.isnan(factors[1:]).all()
    failing = data["searched_part"].values[data["searched_load_factor"].values <= 1]
    assert set(failing) == {f"pin {data['margin_part'].values[0]}"}
