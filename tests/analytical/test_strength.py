"""Strength of links by hand: arms, cut links in balance, and factors of loads and speed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexmech.analyses.strength.compute import strength
from flexmech.analyses.strength.forces import cuts_of, forces_over_the_turn, internal_forces
from flexmech.analyses.strength.request import StrengthRequest
from flexmech.analyses.strength.result import Strength
from flexmech.errors import InputError
from flexmech.hygrothermal import HygrothermalState
from flexmech.linkages import GROUND, AttachmentPoint, JointSpring, Load, RotatingArm, Spring
from flexmech.linkages.motion import direction, normal
from flexmech.materials import Laminate, Material, Ply, PlyStrength
from flexmech.mechanism import Mechanism, PointMass
from flexmech.modelfile import load_mechanism
from flexmech.sections import BeamSection, LaminateSection, residual_ply_stresses

MODELS = Path(__file__).parents[2] / "models"
YIELD, DENSITY, LENGTH = 240e6, 2700.0, 0.5
ALUMINIUM = Material(70e9, DENSITY, 0.33, yield_strength=YIELD)
HEIGHT, WIDTH = 10e-3, 20e-3
SPEED = 100.0


def arm(**others: object) -> Mechanism:
    section = BeamSection.rectangle(ALUMINIUM, HEIGHT, WIDTH)
    return Mechanism(RotatingArm(LENGTH), {"arm": section}, **others)  # type: ignore[arg-type]


def rigid(mechanism: Mechanism, speed: StrengthRequest | float) -> Strength:
    """Of links that are taken as rigid, whose forces can be had by hand."""
    asked = speed if isinstance(speed, StrengthRequest) else StrengthRequest(crank_speed=speed)
    return strength(mechanism, replace(asked, source="rigid"))


# --- factors by hand ----------------------------------------------------------------------------


def test_rotating_arm_by_hand() -> None:
    """Stress rho omega^2 (L^2 - x^2) / 2 along the arm, greatest at its root."""
    found = rigid(arm(), SPEED).dataset
    place = found["position"].values[0]
    stress = DENSITY * SPEED**2 * (LENGTH**2 - place**2) / 2
    inside = place < LENGTH
    index = found["failure_index"].values[0, 0, :, 0, :]
    np.testing.assert_allclose(
        index[inside], np.stack([stress / YIELD] * 2, axis=1)[inside], rtol=1e-10
    )
    root = DENSITY * (SPEED * LENGTH) ** 2 / 2
    assert found["margin_load_factor"].values[0] == pytest.approx(YIELD / root, rel=1e-10)
    assert found["margin_speed_factor"].values[0] == pytest.approx(np.sqrt(YIELD / root), rel=1e-10)
    assert found["margin_position"].values[0] == 0.0
    # Cut at the root itself.
    forces = forces_over_the_turn(arm(), np.zeros(1), SPEED)
    area = WIDTH * HEIGHT
    assert forces.axial_force(0, 0.0).item() / area == pytest.approx(root, rel=1e-10)


def test_bent_strip_by_hand() -> None:
    """A force across the tip of an arm at rest: 6 F L / (b h^2) at its root."""
    force = 50.0
    load = Load("push", AttachmentPoint("arm", LENGTH), ((0.0, force),))
    found = rigid(arm(loads=(load,)), StrengthRequest(np.zeros(1), 0.0)).dataset
    stress = 6 * force * LENGTH / (WIDTH * HEIGHT**2)
    assert found["margin_index"].values[0] == pytest.approx(stress / YIELD, rel=1e-7)
    assert np.isnan(found["margin_speed_factor"].values[0])
    # Bent towards +y, the lower side is stretched: both surfaces are as near to yielding.
    factor = found["load_factor"].values[0, 0, 0, 0]
    np.testing.assert_allclose(factor, YIELD / stress, rtol=1e-7)


def test_speed_factor_beside_a_load_that_stays() -> None:
    """A tip force along the arm stays as the speed rises: sigma_F + s^2 sigma_omega = yield."""
    force = 4000.0
    load = Load("pull", AttachmentPoint("arm", LENGTH), ((force, 0.0),), axes="link")
    found = rigid(arm(loads=(load,)), SPEED).dataset
    still = force / (WIDTH * HEIGHT)
    inertia = DENSITY * (SPEED * LENGTH) ** 2 / 2
    expected = np.sqrt((YIELD - still) / inertia)
    assert found["margin_speed_factor"].values[0] == pytest.approx(expected, rel=1e-8)
    assert found["margin_load_factor"].values[0] == pytest.approx(YIELD / (still + inertia))


def test_a_point_mass_makes_a_jump() -> None:
    mechanism = arm(link_masses=(PointMass("arm", 0.3, 0.5),))
    found = rigid(mechanism, SPEED).dataset
    place, force = found["position"].values[0], found["axial_force"].values[0, 0, 0]
    before, after = np.flatnonzero(place == 0.3)
    assert force[before] - force[after] == pytest.approx(0.5 * 0.3 * SPEED**2, rel=1e-6)


# --- internal forces in balance -----------------------------------------------------------------


def loaded_mechanisms() -> dict[str, Mechanism]:
    four_bar = load_mechanism(MODELS / "aluminium_fourbar.toml")
    springs = (
        Spring(
            "s", AttachmentPoint(GROUND, 0.05, 0.3), AttachmentPoint("coupler", 0.1), 300.0, 0.05
        ),
    )
    slider = load_mechanism(MODELS / "slider_crank.toml")
    rod = slider.linkage.topology.link_names[1]
    six_bar = load_mechanism(MODELS / "stephenson_six_bar.toml")
    last = six_bar.linkage.topology.links[-1]
    joint = six_bar.linkage.topology.joint_names[-1]
    load = Load("l", AttachmentPoint(rod, 0.05), ((3.0, -8.0),), (0.4,))
    turned = Load("t", AttachmentPoint(last.name, 0.4 * last.length), ((-2.0, 5.0),), axes="link")
    return {
        "four-bar": replace(
            four_bar,
            gravity=(0.0, -9.81),
            springs=springs,
            link_masses=(PointMass("rocker", 0.1, 0.05),),
        ),
        "slider-crank": replace(slider, loads=(load,), gravity=(0.0, -9.81)),
        "six-bar": replace(
            six_bar, loads=(turned,), joint_springs=(JointSpring(joint, torsional_stiffness=0.8),)
        ),
    }


@pytest.mark.parametrize("name", ["four-bar", "slider-crank", "six-bar"])
def test_parts_between_cuts_are_in_balance(name: str) -> None:
    """Newton's and Euler's laws for what lies between two neighbouring cuts, in every link."""
    mechanism = loaded_mechanisms()[name]
    angles, topology = np.radians(np.arange(0.0, 360.0, 15.0)), mechanism.linkage.topology
    speed = 25.0
    motion = mechanism.linkage.motion(angles, speed, 0.0)
    forces = forces_over_the_turn(mechanism, angles, speed)
    points, weights = np.polynomial.legendre.leggauss(4)
    checked = 0
    for link, link_name in enumerate(topology.link_names):
        mass, cuts = mechanism.link_mass(link_name), cuts_of(mechanism, link_name, 8)
        loads = internal_forces(forces, link, cuts).loads
        size = np.abs(loads).max(axis=(0, 1)) + 1e-12
        along, across = direction(motion.angle[:, link]), normal(motion.angle[:, link])
        for here, there in zip(range(len(cuts.cut) - 1), range(1, len(cuts.cut)), strict=True):
            first, second = cuts.cut[here], cuts.cut[there]
            if cuts.place[here] == cuts.place[there]:
                continue  # what acts there is between them
            half = (second - first) / 2
            x = (first + second) / 2 + half * points
            pull = np.stack([motion.acceleration(link, s, mass.offset) for s in x], axis=1)
            pull = pull - np.asarray(mechanism.gravity)
            inertia = mass.mass_per_length * half * np.einsum("q,aqi->ai", weights, pull)
            lever = x - first
            bent = mass.mass_per_length * half * np.einsum(
                "q,aqi,ai->a", weights * lever, pull, across
            ) - mass.offset * np.sum(inertia * along, axis=-1)
            gained = loads[:, there] - loads[:, here]
            step = second - first
            np.testing.assert_allclose(
                gained[:, 0], np.sum(inertia * along, axis=-1), atol=1e-9 * size[0]
            )
            np.testing.assert_allclose(
                gained[:, 2], np.sum(inertia * across, axis=-1), atol=1e-9 * size[2]
            )
            balance = gained[:, 1] + step * loads[:, there, 2]
            np.testing.assert_allclose(balance, bent, atol=1e-9 * (size[1] + step * size[2]))
            checked += 1
    assert checked >= 8 * len(topology.links)


def test_pinned_ends_carry_no_moment() -> None:
    mechanism = loaded_mechanisms()["four-bar"]
    forces = forces_over_the_turn(mechanism, np.radians([0.0, 77.0, 200.0]), 25.0)
    for link in (1, 2):
        name = mechanism.linkage.topology.link_names[link]
        moment = internal_forces(forces, link, cuts_of(mechanism, name, 8)).loads[..., 1]
        assert np.abs(moment[:, [0, -1]]).max() < 1e-6 * np.abs(moment).max()


# --- laminates ----------------------------------------------------------------------------------

STRENGTH = PlyStrength(1500e6, 1200e6, 40e6, 246e6, 68e6, 90e6, 0.35, 0.30)
CARBON = Ply(
    181e9,
    10.3e9,
    7.17e9,
    7.17e9,
    3.8e9,
    0.28,
    1600.0,
    thermal_expansion=(0.02e-6, 22.5e-6),
    name="T",
    strength=STRENGTH,
)


def cross_ply(stress_free: float | None = None, ply: Ply = CARBON) -> Mechanism:
    laminate = Laminate.stacked([ply] * 4, 1e-3, np.radians([0, 90, 90, 0]).tolist())
    laminate = replace(laminate, stress_free_temperature=stress_free)
    section = BeamSection.of_laminate(LaminateSection(laminate, WIDTH))
    load = Load("pull", AttachmentPoint("arm", LENGTH), ((1000.0, 0.0),), axes="link")
    return Mechanism(RotatingArm(LENGTH), {"arm": section}, loads=(load,))


def test_first_ply_failure_of_a_pulled_cross_ply() -> None:
    """Classical lamination theory by hand: the plies across the load crack first."""
    request = StrengthRequest(np.zeros(1), 0.0, criterion="max-stress")
    found = rigid(cross_ply(), request).dataset
    laminate = Laminate.stacked([CARBON] * 4, 1e-3, np.radians([0, 90, 90, 0]).tolist())
    strain = np.linalg.solve(laminate.plate_stiffness, [1000 / WIDTH, 0, 0, 0, 0, 0])[:3]
    across = CARBON.reduced_stiffness @ np.array([strain[1], strain[0], 0.0])
    expected = STRENGTH.transverse_tension / across[1]
    assert found["margin_load_factor"].values[0] == pytest.approx(expected, rel=1e-7)
    assert found["margin_mode"].values[0] == "transverse tension"
    assert found["margin_layer"].values[0] in (2, 3)


def test_cure_takes_part_of_the_strength() -> None:
    """The load factor multiplies the load's part alone: (Yt - residual) / mechanical."""
    request = StrengthRequest(np.zeros(1), 0.0, criterion="max-stress")
    free = rigid(cross_ply(), request).dataset["margin_load_factor"].values[0]
    cured = rigid(cross_ply(393.15), request).dataset["margin_load_factor"].values[0]
    layers = cross_ply().layers_of("arm")
    assert layers is not None
    residual = residual_ply_stresses(layers, 293.15 - 393.15, np.zeros(4))[1, 0, 1]
    assert residual > 5e6
    yt = STRENGTH.transverse_tension
    assert cured == pytest.approx(free * (yt - residual) / yt, rel=1e-7)
    # Tsai-Wu's quadratic equation in the factor, solved another way: by what is on its surface.
    request = replace(request, criterion="tsai-wu")
    assert rigid(cross_ply(393.15), request).dataset["margin_load_factor"].values[0] < free


def test_heat_relieves_the_stress_of_cure() -> None:
    """At the stress-free temperature nothing is left of it."""
    request = StrengthRequest(
        np.zeros(1), 0.0, criterion="max-stress", environment=HygrothermalState(100.0)
    )
    free = rigid(cross_ply(), replace(request, environment=None)).dataset
    hot = rigid(cross_ply(393.15), request).dataset
    np.testing.assert_allclose(hot["load_factor"], free["load_factor"], rtol=0.01)


def test_plies_that_cure_has_broken() -> None:
    weak = replace(CARBON, strength=replace(STRENGTH, transverse_tension=5e6))
    found = rigid(cross_ply(393.15, weak), StrengthRequest(np.zeros(1), 0.0))
    assert found.dataset["margin_load_factor"].values[0] == 0.0
    assert "cure" in found.summary().answer[0]
    assert found.summary().warnings
    (bar,) = (axes for axes in found.plot().axes if axes.get_label() == "<colorbar>")
    assert bar.get_ylim() == (0.0, 100.0)


def test_what_is_missing_is_named() -> None:
    blunt = replace(CARBON, strength=replace(STRENGTH, transverse_shear=None))
    request = StrengthRequest(np.zeros(1), 0.0, criterion="hashin")
    with pytest.raises(InputError, match=r"links\.arm: .*S23"):
        rigid(cross_ply(ply=blunt), request)
    with pytest.raises(InputError, match=r"\[plies\.T\.strength\]"):
        rigid(cross_ply(ply=replace(CARBON, strength=None)), 0.0)
    with pytest.raises(InputError, match="yield_strength"):
        strength(load_mechanism(MODELS / "steel_fourbar.toml"))
