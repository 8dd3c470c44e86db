"""Internal forces, stresses and margins of elastic links: both engines, and rigid limits."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

from flexmech import (
    AttachedBody,
    BeamSection,
    ComputationError,
    ExudynEngine,
    HygrothermalState,
    InputError,
    JointPin,
    Load,
    Material,
    Mechanism,
    ReferenceEngine,
    load_mechanism,
    mechanism_in_state,
    response,
    strength,
)
from flexmech.analyses import ResponseRequest, StrengthRequest
from flexmech.linkages import AttachmentPoint
from tests.support.command import MODELS
from tests.support.mechanisms import loaded_rigid_rocker
from tests.support.stations import at_common_places
from tests.support.strength_data import with_strengths

FORCES = ("axial_force", "bending_moment", "shear_force")
ANGLES = np.radians(np.arange(0.0, 361.0, 30.0))


def aluminium() -> Mechanism:
    """The paper's four-bar, of a material whose yield strength is stated."""
    mechanism = load_mechanism(MODELS / "aluminium_fourbar.toml")
    material = Material(68.9e9, 2923.0, 0.3, yield_strength=240e6)
    sections = {
        name: BeamSection.rectangle(material, own.in_plane_thickness, 25.4e-3)
        for name, own in mechanism.sections.items()
    }
    return replace(mechanism, sections=sections)


def largest_gaps(first: xr.DataArray, second: xr.DataArray) -> np.ndarray:
    """Largest difference of each link, over its greatest value."""
    one, other = (each.transpose("link", ...).values for each in (first, second))
    gaps = np.nanmax(np.abs(one - other), axis=(1, 2))
    return np.asarray(gaps / np.nanmax(np.abs(one), axis=(1, 2)))


@pytest.mark.parametrize(
    "asked",
    [
        StrengthRequest(40.0, crank_angles=ANGLES, search_speed=False),
        pytest.param(
            StrengthRequest(15.0, source="periodic", search_speed=False),
            marks=pytest.mark.thorough,
        ),
    ],
    ids=["equilibrium", "periodic"],
)
def test_both_engines_have_the_same_forces_and_load_factors(asked: StrengthRequest) -> None:
    """Corotational beams and Exudyn's solver, of links that bend by a twentieth; runs of both."""
    mechanism = aluminium()
    engines = [ReferenceEngine(mechanism, 8), ExudynEngine(mechanism, 8)]
    data = strength(engines, asked).dataset
    assert data["engine"].values.tolist() == ["reference", "exudyn"]
    for name in FORCES:
        assert largest_gaps(*data[name]).max() < 1e-3
    reference, exudyn = data["load_factor"].min(["station", "layer", "surface"])
    np.testing.assert_allclose(exudyn, reference, rtol=1e-3)
    # Those of rigid links would not do.
    rigid = strength(mechanism, replace(asked, source="rigid", crank_angles=ANGLES)).dataset
    least = rigid["load_factor"].isel(engine=0).min(["station", "layer", "surface"])
    assert np.abs(least / reference - 1).max() > 0.02


@pytest.mark.thorough
def test_forces_of_a_run_are_those_of_its_curvature() -> None:
    """D'Alembert's forces of a periodic run with a body off a link's axis."""
    body = AttachedBody("coupler", 0.1, 0.05, 1e-5, (0.0, 0.02))
    mechanism = replace(aluminium(), bodies=(body,))
    asked = StrengthRequest(10.0, source="periodic", search_speed=False)
    data = strength(ReferenceEngine(mechanism, 6), asked).dataset
    assert float(data.attrs["moment_gap"].split()[0]) < 0.1


@pytest.mark.thorough
def test_slow_links_bear_what_rigid_ones_do() -> None:
    """Vibration adds in proportion to the square of the speed."""
    mechanism = aluminium()
    rigid = strength(mechanism, 5.0, source="rigid").dataset
    asked = StrengthRequest(5.0, source="periodic", search_speed=False)
    running = strength(mechanism, asked).dataset.interp(crank_angle=rigid["crank_angle"].values)
    for name in FORCES:
        assert largest_gaps(rigid[name][0], running[name][0]).max() < 6e-3


@pytest.mark.thorough
def test_a_run_from_straight_links_is_worse() -> None:
    """A start that is not the motion's own lets links ring beyond it."""
    asked = StrengthRequest(15.0, source="periodic", revolutions=0.25, search_speed=False)
    steady, rung = (
        strength(aluminium(), replace(asked, source=source)).dataset["margin_load_factor"].values[0]
        for source in ("periodic", "transient")
    )
    assert rung < 0.8 * steady


@pytest.mark.thorough
def test_each_part_fails_at_its_speed_factor() -> None:
    """Seen by equilibria at the faster speed; it is not the root of the load factor."""
    mechanism = aluminium()
    data = strength(mechanism, 40.0, crank_angles=ANGLES).dataset
    names = data["margin_part"].values.tolist()
    factors = dict(zip(names, data["margin_speed_factor"].values.tolist(), strict=True))
    for name in ("rocker", "coupler"):
        faster = StrengthRequest(40.0 * factors[name], crank_angles=ANGLES, search_speed=False)
        there = strength(mechanism, faster).dataset["load_factor"].sel(link=name)
        assert float(there.min()) == pytest.approx(1.0, rel=2e-3)
        slow = float(data["load_factor"].sel(link=name).min())
        assert factors[name] < 0.8 * np.sqrt(slow)
    # The links bend too far before the crank yields.
    assert np.isnan(factors["crank"])


def test_a_part_that_fails_is_searched_downwards() -> None:
    mechanism = load_mechanism(MODELS / "composite_fourbar.toml")
    fast = strength(mechanism, 1300.0, crank_angles=ANGLES)
    assert float(fast.dataset["margin_load_factor"][0]) < 1
    factor = float(fast.dataset["margin_speed_factor"].min())
    assert factor < 1
    there = StrengthRequest(1300.0 * factor, crank_angles=ANGLES, search_speed=False)
    slower = strength(mechanism, there).dataset
    assert float(slower["margin_load_factor"][0]) == pytest.approx(1.0, rel=2e-3)


def test_at_rest_weight_and_loads_bend_links_and_no_speed_raises_them() -> None:
    push = Load("push", AttachmentPoint("coupler", 0.1397), ((0.0, -60.0),))
    mechanism = replace(aluminium(), loads=(push,))
    found = strength(mechanism, 0.0, crank_angles=ANGLES).dataset
    rigid = strength(mechanism, 0.0, crank_angles=ANGLES, source="rigid").dataset
    assert np.isnan(found["margin_speed_factor"]).all()
    factors = (float(one["margin_load_factor"][0]) for one in (found, rigid))
    assert next(factors) != pytest.approx(next(factors), rel=1e-3)


@pytest.mark.thorough
def test_heat_and_moisture_are_in_the_equilibrium() -> None:
    """Swollen longer links: forces of the mechanism as it is then."""
    mechanism = with_strengths(load_mechanism(MODELS / "moist_composite_fourbar.toml"))
    state = HygrothermalState(40.0, 0.02)
    asked = StrengthRequest(30.0, crank_angles=ANGLES[:3], environment=state, search_speed=False)
    wet = strength(mechanism, asked).dataset
    same = strength(mechanism_in_state(mechanism, state), replace(asked, environment=None)).dataset
    for name in FORCES:
        for first, second in at_common_places(wet, same, name):
            np.testing.assert_allclose(first, second, rtol=1e-12, atol=1e-12)


def test_what_has_no_equilibrium_is_refused_with_the_other_source_named() -> None:
    with pytest.raises(ComputationError, match=r"displaced by .*source rigid"):
        strength(aluminium(), 200.0)
    place, values = AttachmentPoint("coupler", 0.1), ((1.0, 0.0), (2.0, 0.0))
    late = Load("late", place, values, (0.0, 0.0), over="time", at=(0.0, 1.0))
    with pytest.raises(InputError, match=r"load late: .*source transient, or rigid"):
        strength(replace(aluminium(), loads=(late,)), 10.0)


def test_greatest_stresses_of_running_links_agree() -> None:
    """Bending by the displacements of each engine, the normal force by its joint forces."""
    mechanism = load_mechanism(MODELS / "steel_fourbar.toml")
    engines = [ReferenceEngine(mechanism, 4), ExudynEngine(mechanism, 4)]
    found = response(engines, ResponseRequest(20.0, 0.25, start="rigid")).dataset
    for name in ("peak_stress", "peak_axial_stress"):
        own, other = found[name].values
        np.testing.assert_allclose(own, other, rtol=0.02)
    place = found["peak_stress_place"] / found["length"]
    np.testing.assert_allclose(place[0], place[1], atol=0.15)


@pytest.mark.parametrize("engine", [ReferenceEngine, ExudynEngine])
def test_the_force_in_an_end_that_a_spring_turns_is_carried_from_the_section_before(
    engine: Any,
) -> None:
    """At 0.42 rad: what N and V turn by along the end of the crank is the curvature M / EI there.

    The segment's own mass turns them by 1e-4 rad; the angle for its sine was 0.0133 rad.
    """
    mechanism = loaded_rigid_rocker()
    stiffness = mechanism.sections["crank"].bending_stiffness
    # A pin whose bush is judged, so that no link needs a strength.
    pins = (JointPin("B", 8e-3, bush_length=10e-3, allowable_pv=1e6),)
    plain = {name: replace(section, layers=None) for name, section in mechanism.sections.items()}
    mechanism = replace(mechanism, joint_pins=pins, sections=plain)
    request = StrengthRequest(20.0, crank_angles=np.radians([130.0, 250.0]), search_speed=False)
    data = strength(engine(mechanism, 10), request).dataset.isel(engine=0).sel(link="crank")
    last = np.flatnonzero(np.isfinite(data["position"].values))[-2:]
    step = np.diff(data["position"].values[last]).item()
    axial, shear, moment = (
        data[name].values[..., last] for name in ("axial_force", "shear_force", "bending_moment")
    )
    turned = np.diff(np.arctan2(shear, axial), axis=-1)[..., 0]
    assert turned == pytest.approx(-step * moment.mean(axis=-1) / stiffness, abs=3e-4)
