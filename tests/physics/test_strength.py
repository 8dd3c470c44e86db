"""Strength of links by hand: arms, cut links in balance, laminates, factors of loads and speed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import flexmech
from flexmech import (
    BeamSection,
    Exposure,
    HygrothermalState,
    InputError,
    JointSpring,
    Laminate,
    LaminateSection,
    Load,
    Material,
    Mechanism,
    PointMass,
    RotatingArm,
    Spring,
    Strength,
    load_mechanism,
    strength,
)
from flexmech.analyses import StrengthRequest
from flexmech.linkages import GROUND, AttachmentPoint
from flexmech.materials import Ply
from flexmech.sections import residual_ply_stresses
from tests.support.command import MODELS
from tests.support.strength_data import STRENGTH, composite, with_strengths

YIELD, DENSITY, LENGTH = 240e6, 2700.0, 0.5
ALUMINIUM = Material(70e9, DENSITY, 0.33, yield_strength=YIELD)
HEIGHT, WIDTH, SPEED = 10e-3, 20e-3, 100.0
# Stress at the root of an arm that turns: rho omega^2 L^2 / 2.
ROOT = DENSITY * (SPEED * LENGTH) ** 2 / 2


def arm(**others: object) -> Mechanism:
    section = BeamSection.rectangle(ALUMINIUM, HEIGHT, WIDTH)
    return Mechanism(RotatingArm(LENGTH), {"arm": section}, **others)  # type: ignore[arg-type]


def rigid(mechanism: Mechanism, asked: StrengthRequest | float) -> Strength:
    """Strength of links taken as rigid, whose forces follow by hand."""
    request = asked if isinstance(asked, StrengthRequest) else StrengthRequest(asked)
    return strength(mechanism, replace(request, source="rigid"))


def test_an_arm_that_turns_is_pulled_by_its_own_mass() -> None:
    """Stress rho omega^2 (L^2 - x^2) / 2 along the arm, greatest at its root."""
    found = rigid(arm(), SPEED).dataset
    place = found["position"].values[0]
    stress = DENSITY * SPEED**2 * (LENGTH**2 - place**2) / 2
    index = found["failure_index"].values[0, 0, :, 0, :]
    np.testing.assert_allclose(index[:-1].T, [stress[:-1] / YIELD] * 2, rtol=1e-10)
    assert found["margin_load_factor"].values[0] == pytest.approx(YIELD / ROOT, rel=1e-10)
    assert found["margin_speed_factor"].values[0] == pytest.approx(np.sqrt(YIELD / ROOT), rel=1e-10)
    assert found["margin_position"].values[0] == 0.0
    force = found["axial_force"].values[0, 0, :, 0]
    np.testing.assert_allclose(force / (WIDTH * HEIGHT), ROOT, rtol=1e-10)


def test_a_force_across_its_tip_bends_an_arm() -> None:
    """At rest: 6 F L / (b h^2) at the root, on both surfaces."""
    force = 50.0
    load = Load("push", AttachmentPoint("arm", LENGTH), ((0.0, force),))
    found = rigid(arm(loads=(load,)), StrengthRequest(0.0, crank_angles=np.zeros(1))).dataset
    stress = 6 * force * LENGTH / (WIDTH * HEIGHT**2)
    assert found["margin_index"].values[0] == pytest.approx(stress / YIELD, rel=1e-7)
    assert np.isnan(found["margin_speed_factor"].values[0])
    np.testing.assert_allclose(found["load_factor"].values[0, 0, 0, 0], YIELD / stress, rtol=1e-7)


def test_speed_factor_beside_a_load_that_stays() -> None:
    """A tip force along the arm stays as the speed rises: sigma_F + s^2 sigma_omega = yield."""
    force = 4000.0
    load = Load("pull", AttachmentPoint("arm", LENGTH), ((force, 0.0),), axes="link")
    found = rigid(arm(loads=(load,)), SPEED).dataset
    still = force / (WIDTH * HEIGHT)
    expected = np.sqrt((YIELD - still) / ROOT)
    assert found["margin_speed_factor"].values[0] == pytest.approx(expected, rel=1e-8)
    assert found["margin_load_factor"].values[0] == pytest.approx(YIELD / (still + ROOT))


def test_the_axial_force_jumps_at_a_point_mass() -> None:
    found = rigid(arm(link_masses=(PointMass("arm", 0.3, 0.5),)), SPEED).dataset
    place, force = found["position"].values[0], found["axial_force"].values[0, 0, 0]
    before, after = np.flatnonzero(place == 0.3)
    assert force[before] - force[after] == pytest.approx(0.5 * 0.3 * SPEED**2, rel=1e-6)


def loaded_mechanism(name: str) -> Mechanism:
    mechanism = load_mechanism(MODELS / f"{name}.toml")
    strong = {k: replace(s, layers=None) for k, s in mechanism.sections.items()}
    if name == "aluminium_fourbar":
        ends = AttachmentPoint(GROUND, 0.05, 0.3), AttachmentPoint("coupler", 0.1)
        mass = PointMass("rocker", 0.1, 0.05)
        more = {"springs": (Spring("s", *ends, 300.0, 0.05),), "link_masses": (mass,)}
    elif name == "slider_crank":
        rod = mechanism.linkage.topology.link_names[1]
        more = {"loads": (Load("l", AttachmentPoint(rod, 0.05), ((3.0, -8.0),), (0.4,)),)}
    else:
        last, joint = mechanism.linkage.topology.links[-1], mechanism.linkage.topology.joint_names
        turned = AttachmentPoint(last.name, 0.4 * last.length)
        more = {
            "loads": (Load("t", turned, ((-2.0, 5.0),), axes="link"),),
            "joint_springs": (JointSpring(joint[-1], torsional_stiffness=0.8),),
        }
    # A pin whose bush is judged, so that no link needs a strength.
    pin = flexmech.JointPin("B", 8e-3, bush_length=10e-3, allowable_pv=1e6)
    return replace(mechanism, sections=strong, joint_pins=(pin,), gravity=(0.0, -9.81), **more)


@pytest.mark.parametrize("name", ["aluminium_fourbar", "slider_crank", "stephenson_six_bar"])
def test_what_lies_between_two_cuts_is_in_balance(name: str) -> None:
    """Newton's and Euler's laws between neighbouring places of every link, loaded and running."""
    mechanism, angles, speed = loaded_mechanism(name), np.radians(np.arange(0.0, 360.0, 30.0)), 25.0
    found = rigid(mechanism, StrengthRequest(speed, crank_angles=angles)).dataset.isel(engine=0)
    motion = mechanism.linkage.motion(angles, speed, 0.0)
    points, weights = np.polynomial.legendre.leggauss(4)
    checked = 0
    for number, link in enumerate(found["link"].values):
        mass = mechanism.link_mass(str(link))
        own = found.sel(link=link)
        places = own["position"].values[np.isfinite(own["position"].values)]
        names = "axial_force", "bending_moment", "shear_force"
        axial, moment, shear = (own[part].values[:, : len(places)] for part in names)
        size = max(np.abs(axial).max(), np.abs(shear).max())
        angle = motion.angle[:, number]
        along = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        across = np.stack([-np.sin(angle), np.cos(angle)], axis=1)
        for k in np.flatnonzero(np.diff(places) > 0):
            first, step = places[k], places[k + 1] - places[k]
            x = first + step / 2 * (1 + points)
            pull = np.stack([motion.acceleration(number, s, mass.offset) for s in x], axis=1)
            pull = pull - np.asarray(mechanism.gravity)
            weighted = mass.mass_per_length * step / 2 * weights[:, None] * pull
            inertia = weighted.sum(axis=1)
            bent = np.einsum("q,aqi,ai->a", x - first, weighted, across)
            bent -= mass.offset * np.sum(inertia * along, axis=1)
            bent += mass.rotary_inertia * step * motion.angular_acceleration[:, number]
            gained = [part[:, k + 1] - part[:, k] for part in (axial, shear, moment)]
            gained[2] = gained[2] + step * shear[:, k + 1]
            wanted = np.sum(inertia * along, axis=1), np.sum(inertia * across, axis=1), bent
            # To the smoothness of the sides of a cut beside a jump.
            for had, expected in zip(gained, wanted, strict=True):
                np.testing.assert_allclose(had, expected, atol=1e-6 * size)
            checked += 1
    assert checked >= 8 * len(found["link"])


CARBON = Ply(
    *(181e9, 10.3e9, 7.17e9, 7.17e9, 3.8e9, 0.28, 1600.0),
    thermal_expansion=(0.02e-6, 22.5e-6),
    name="T",
    strength=STRENGTH,
)
CROSS_PLY = Laminate.stacked([CARBON] * 4, 1e-3, np.radians([0, 90, 90, 0]))
STILL = StrengthRequest(0.0, crank_angles=np.zeros(1), criterion="max-stress")


def pulled(stress_free: float | None = None, ply: Ply = CARBON) -> Mechanism:
    """An arm of a cross-ply under 1 kN along it."""
    laminate = Laminate.stacked([ply] * 4, 1e-3, np.radians([0, 90, 90, 0]))
    laminate = replace(laminate, stress_free_temperature=stress_free)
    section = BeamSection.of_laminate(LaminateSection(laminate, WIDTH))
    load = Load("pull", AttachmentPoint("arm", LENGTH), ((1000.0, 0.0),), axes="link")
    return Mechanism(RotatingArm(LENGTH), {"arm": section}, loads=(load,))


def test_first_ply_failure_of_a_pulled_cross_ply() -> None:
    """Classical lamination theory by hand: the plies across the load crack first."""
    found = rigid(pulled(), STILL).dataset
    strain = np.linalg.solve(CROSS_PLY.plate_stiffness, [1000 / WIDTH, 0, 0, 0, 0, 0])[:3]
    across = CARBON.reduced_stiffness @ np.array([strain[1], strain[0], 0.0])
    expected = STRENGTH.transverse_tension / across[1]
    assert found["margin_load_factor"].values[0] == pytest.approx(expected, rel=1e-7)
    assert found["margin_mode"].values[0] == "transverse tension"
    assert found["margin_layer"].values[0] in (2, 3)


def test_cure_takes_part_of_the_strength_and_heat_gives_it_back() -> None:
    """The load factor multiplies the load's part alone: (Yt - residual) / mechanical."""
    free = rigid(pulled(), STILL).dataset["margin_load_factor"].values[0]
    cured = rigid(pulled(393.15), STILL).dataset["margin_load_factor"].values[0]
    section = LaminateSection(CROSS_PLY, WIDTH)
    residual = residual_ply_stresses(section, 293.15 - 393.15, np.zeros(4))[1, 0, 1]
    assert residual > 5e6
    yt = STRENGTH.transverse_tension
    assert cured == pytest.approx(free * (yt - residual) / yt, rel=1e-7)
    hot = rigid(pulled(393.15), replace(STILL, environment=HygrothermalState(100.0))).dataset
    assert hot["margin_load_factor"].values[0] == pytest.approx(free, rel=0.01)


def test_plies_that_cure_has_broken_bear_nothing() -> None:
    weak = replace(CARBON, strength=replace(STRENGTH, transverse_tension=5e6))
    found = rigid(pulled(393.15, weak), StrengthRequest(0.0, crank_angles=np.zeros(1)))
    assert found.dataset["margin_load_factor"].values[0] == 0.0
    assert "cure" in found.summary().answer[0]
    assert found.summary().warnings


@pytest.fixture(scope="module")
def laminated() -> Strength:
    return strength(composite(), 950.0, speed_unit="rpm")


def test_margins_are_the_worst_of_all_places(laminated: Strength) -> None:
    tables = laminated.tables()
    margins = tables["margins"].set_index("part")
    assert margins["load_factor"].is_monotonic_increasing
    for link, rows in tables["strength"].groupby("link"):
        worst = rows.loc[rows["load_factor"].idxmin()]
        for column in ("load_factor", "layer", "crank_angle_deg"):
            assert margins.loc[link, column] == worst[column]
    # At the worst crank angle alone the same factor is found.
    first = laminated.dataset.isel(margin=0)
    angle = np.array([float(first["margin_crank_angle"])])
    request = StrengthRequest(950.0, crank_angles=angle, speed_unit="rpm", search_speed=False)
    alone = float(strength(composite(), request).dataset["margin_load_factor"][0])
    assert alone == pytest.approx(float(first["margin_load_factor"]), rel=1e-12)


def test_a_result_is_read_back_as_it_was_saved(laminated: Strength, tmp_path) -> None:
    laminated.save(tmp_path)
    again = Strength.load(tmp_path / "strength.nc")
    xr.testing.assert_identical(again.dataset, laminated.dataset)
    assert str(again.summary()) == str(laminated.summary())


@pytest.mark.thorough
def test_links_in_air_for_a_thousand_years_are_equally_moist() -> None:
    """Judged by slices, they bear what a state of equal moisture bears; after a month less."""
    mechanism = with_strengths(load_mechanism(MODELS / "moist_composite_fourbar.toml"))

    def factors(environment: object) -> np.ndarray:
        request = StrengthRequest(
            20.0, crank_angles=np.radians(np.arange(0.0, 361.0, 30.0)), environment=environment
        )
        return rigid(mechanism, request).dataset["margin_load_factor"].values

    year = 365.25 * 86400.0
    resin = mechanism.sections["coupler"].layers.laminate.layers[0].ply.resin
    equilibrium = resin.hygrothermal.equilibrium
    water = equilibrium.saturation * 0.5**equilibrium.humidity_exponent
    equal = factors(HygrothermalState(40.0, water))
    np.testing.assert_allclose(factors(Exposure(40.0, 0.5, 1000 * year)), equal, rtol=1e-3)
    assert np.abs(factors(Exposure(40.0, 0.5, year / 12)) / equal - 1).max() > 1e-3


def test_links_without_layers_are_told_and_pins_are_judged_without_them() -> None:
    mechanism = composite()
    bare = {name: replace(own, layers=None) for name, own in mechanism.sections.items()}
    one = replace(mechanism, sections={**mechanism.sections, "rocker": bare["rocker"]})
    found = rigid(one, 100.0)
    assert found.tables()["margins"]["part"].tolist() == ["crank", "coupler"]
    assert any("not judged" in line and "rocker" in line for line in found.summary().lines)
    pin = flexmech.JointPin("A", 8e-3, bush_length=10e-3, allowable_pv=1.8e6)
    found = rigid(replace(mechanism, sections=bare, joint_pins=(pin,)), 100.0)
    assert found.tables()["margins"][["part", "kind"]].values.tolist() == [["A", "pin"]]
    assert found.tables()["strength"].empty
    with pytest.raises(InputError, match="no link and no pin of"):
        rigid(replace(mechanism, sections=bare), 100.0)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"criterion": "tresca"}, "criterion"),
        ({"elements": 0}, "elements"),
        ({"crank_angles": [1.0, 0.5]}, "increase"),
        ({"revolutions": 0.0}, "revolutions"),
        ({"source": "static"}, "source"),
    ],
)
def test_requests_that_make_no_sense_are_refused(options: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        StrengthRequest(**options)  # type: ignore[arg-type]


def test_a_strength_that_is_missing_is_named() -> None:
    blunt = replace(CARBON, strength=replace(STRENGTH, transverse_shear=None))
    with pytest.raises(InputError, match=r"links\.arm: .*S23"):
        rigid(pulled(ply=blunt), replace(STILL, criterion="hashin"))
    with pytest.raises(InputError, match=r"\[plies\.T\.strength\]"):
        rigid(pulled(ply=replace(CARBON, strength=None)), 0.0)
    with pytest.raises(InputError, match="yield_strength"):
        strength(load_mechanism(MODELS / "steel_fourbar.toml"))


# --- stress of running links ----------------------------------------------------------------------

SLENDER = BeamSection.rectangle(
    Material(200e9, 7800.0, 0.3, yield_strength=235e6), 4e-3, 20e-3
).with_damping_ratio(0.05, frequency=40.0)


def peaks(speed: float, turns: float, modes: int, section: BeamSection = SLENDER, **more: object):
    mechanism = Mechanism(RotatingArm(0.3), {"arm": section}, **more)  # type: ignore[arg-type]
    request = flexmech.analyses.ResponseRequest(
        speed, turns, start="periodic", modes=modes, samples=360
    )
    return flexmech.response(flexmech.ReferenceEngine(mechanism, 4), request)


def test_a_running_arm_is_pulled_by_its_own_mass_and_yields_above_its_strength() -> None:
    """At the root rho omega^2 L^2 / 2; the vibration along that the rule leaves is 5e-5."""
    pulled = 7800.0 * 100.0**2 * 0.3**2 / 2
    found = peaks(100.0, 0.5, 2)
    assert float(found.dataset["peak_axial_stress"].squeeze()) == pytest.approx(pulled, rel=1e-4)
    assert float(found.dataset["peak_stress"].squeeze()) == pytest.approx(pulled, rel=1e-4)
    assert not found.summary().warnings
    weak = Material(200e9, 7800.0, 0.3, yield_strength=0.9 * pulled)
    section = BeamSection.rectangle(weak, 4e-3, 20e-3).damped_as(SLENDER)
    (warning, *_) = peaks(100.0, 0.5, 2, section).summary().warnings
    assert warning.startswith("the arm yields: its stress reaches 3.510 MPa")


@pytest.mark.thorough
def test_a_force_across_its_tip_bends_a_running_arm_most_at_its_clamp() -> None:
    """F L h / (2 I), at a speed at which inertia counts for nothing."""
    force, second_moment = 10.0, 20e-3 * 4e-3**3 / 12
    load = Load("tip", AttachmentPoint("arm", 0.3), ((0.0, force),), axes="link")
    found = peaks(5.0, 0.02, 6, loads=(load,)).dataset.squeeze()
    bent = force * 0.3 * 4e-3 / 2 / second_moment
    # Its direction turns with the slope of the tip, and pushes by F^2 L^2 / (2 E I) then.
    pushed = force * force * 0.3**2 / (2 * 200e9 * second_moment) / (20e-3 * 4e-3)
    pulled = 7800.0 * 5.0**2 * 0.3**2 / 2 - pushed
    assert float(found["peak_stress"]) == pytest.approx(bent + pulled, rel=1e-3)
    assert float(found["peak_stress_place"]) == 0.0


# --- peaks between places and crank angles, and how far factors are known -----------------------


@pytest.mark.parametrize("elements", [2, 3, 8])
def test_the_greatest_moment_between_two_places_is_found(elements: int) -> None:
    """At rest, by the weight w of a length and a force F up at the tip: F^2/(2 w), F/w from it."""
    weight = DENSITY * WIDTH * HEIGHT * 9.81
    force = 0.6 * weight * LENGTH
    load = Load("lift", AttachmentPoint("arm", LENGTH), ((0.0, force),))
    bent = arm(loads=(load,), gravity=(0.0, -9.81))
    found = rigid(bent, StrengthRequest(0.0, crank_angles=np.zeros(1), elements=elements)).dataset
    stress = 6 * force**2 / (2 * weight) / (WIDTH * HEIGHT**2)
    assert found["margin_load_factor"].values[0] == pytest.approx(YIELD / stress, rel=1e-8)
    assert found["margin_position"].values[0] == pytest.approx(LENGTH - force / weight, rel=1e-5)
    assert found["position"].values[0].tolist() == sorted(found["position"].values[0])


def yielding_fourbar(elements: int = 8) -> flexmech.ReferenceEngine:
    return flexmech.ReferenceEngine(load_mechanism(MODELS / "aluminium_fourbar.toml"), elements)


def factors_of(found: Strength) -> dict[str, float]:
    data = found.dataset
    parts = data["margin_part"].values.tolist()
    return dict(zip(parts, data["margin_load_factor"].values.tolist(), strict=True))


def test_factors_do_not_depend_on_places_and_crank_angles_asked_for() -> None:
    """From 2 to 100 places of a link, from steps of 45 degrees to those of one."""
    turn = [np.radians(np.arange(0.0, 361.0, step)) for step in (45.0, 20.0, 1.0)]
    found = [
        factors_of(
            rigid(
                yielding_fourbar().mechanism, StrengthRequest(20.0, crank_angles=angles, elements=n)
            )
        )
        for angles, n in zip(turn, (2, 9, 100), strict=True)
    ]
    for one in found[:2]:
        assert one == pytest.approx(found[2], rel=1e-8)


def test_the_printed_error_of_factors_holds_against_a_fine_model() -> None:
    """Links bent at rest: four times the elements, steps of a degree."""
    coarse, fine = (
        strength(
            yielding_fourbar(elements),
            20.0,
            crank_angles=np.radians(np.arange(0.0, 361.0, step)),
            elements=4,
            search_speed=False,
        )
        for elements, step in ((4, 30.0), (16, 2.0))
    )
    known, exact = coarse.dataset["margin_error"].values, factors_of(fine)
    errors = [abs(factor / exact[name] - 1) for name, factor in factors_of(coarse).items()]
    assert (np.array(errors) <= known).all()
    assert max(known) < 1e-3
    assert coarse.summary().trust.startswith("load factors are known to 0.0")


def test_a_linkage_that_cannot_be_moved_between_the_angles_is_judged_at_them_alone() -> None:
    """Its crank swings up to 87 degrees to both sides."""
    swinging = flexmech.FourBar(0.3, 0.2, 0.15, 0.2)
    mechanism = replace(yielding_fourbar().mechanism, linkage=swinging)
    angles = np.radians([5.0, 10.0, 350.0])
    found = rigid(mechanism, StrengthRequest(10.0, crank_angles=angles))
    assert "given places and crank angles" in found.summary().trust
    assert set(found.dataset["margin_crank_angle"].values) <= set(angles)
    alone = rigid(mechanism, StrengthRequest(10.0, crank_angles=angles[:1])).summary().trust
    assert alone == "load factors are known to 0.0001 %"


@pytest.mark.thorough
def test_the_printed_error_of_factors_of_a_vibration_holds_against_a_fine_model() -> None:
    request = StrengthRequest(20.0, source="periodic", search_speed=False)
    coarse, fine = (strength(yielding_fourbar(n), request) for n in (4, 16))
    known, exact = coarse.dataset["margin_error"].values, factors_of(fine)
    errors = [abs(factor / exact[name] - 1) for name, factor in factors_of(coarse).items()]
    assert (np.array(errors) <= known).all()
    assert max(known) < 0.01
