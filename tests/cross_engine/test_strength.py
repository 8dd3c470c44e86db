"""Internal forces and margins of elastic links: both engines, and against rigid links."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from flexmech.analyses.response.run import run_engine
from flexmech.analyses.strength.compute import strength
from flexmech.analyses.strength.equilibria import Equilibria
from flexmech.analyses.strength.forces import cuts_of
from flexmech.analyses.strength.request import StrengthRequest
from flexmech.analyses.strength.running import Runs
from flexmech.arrays import silent
from flexmech.errors import ComputationError, InputError
from flexmech.hygrothermal import HygrothermalState, mechanism_in_state
from flexmech.linear_system import Engine, RunningLinks
from flexmech.linkages import AttachmentPoint, Load, RotatingArm
from flexmech.materials import Material
from flexmech.mechanism import AttachedBody, Mechanism
from flexmech.modelfile import load_mechanism
from flexmech.multibody import ExudynEngine
from flexmech.reference import ReferenceEngine
from flexmech.sections import BeamSection

MODELS = Path(__file__).parents[2] / "models"
FORCES = ("axial_force", "bending_moment", "shear_force")


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
    """Of each link, over its greatest value."""
    one, other = (each.transpose("link", ...).values for each in (first, second))
    gaps = np.abs(one - other).max(axis=(1, 2))
    return np.asarray(gaps / np.abs(one).max(axis=(1, 2)))


def test_both_engines_at_the_periodic_motion() -> None:
    """One by linear equations in link frames, one by simulation in absolute coordinates."""
    mechanism = aluminium()
    engines = [ReferenceEngine(mechanism, 8), ExudynEngine(mechanism, 8)]
    found = strength(
        engines, StrengthRequest(crank_speed=15.0, source="periodic", search_speed=False)
    ).dataset
    assert found["engine"].values.tolist() == ["reference", "exudyn"]
    for name in FORCES:
        assert largest_gaps(*found[name]).max() < 1e-3
    reference, exudyn = found["load_factor"].min(["station", "layer", "surface"])
    np.testing.assert_allclose(exudyn, reference, rtol=1e-3)


@pytest.mark.parametrize(
    ("speed", "gap"), [(5.0, 6e-3), pytest.param(10.0, 2.4e-2, marks=pytest.mark.thorough)]
)
def test_slow_links_bear_what_rigid_ones_do(speed: float, gap: float) -> None:
    """Vibration adds in proportion to the square of the speed: four times at twice the speed."""
    mechanism = aluminium()
    rigid = strength(mechanism, StrengthRequest(crank_speed=speed, source="rigid")).dataset
    request = StrengthRequest(crank_speed=speed, source="periodic", search_speed=False)
    running = strength(mechanism, request).dataset
    at_angles = running.interp(crank_angle=rigid["crank_angle"].values)
    for name in FORCES:
        gaps = largest_gaps(rigid[name][0], at_angles[name][0])
        assert gaps.max() < gap
    factors = (each["margin_load_factor"].values.min() for each in (rigid, running))
    assert next(factors) == pytest.approx(next(factors), rel=gap)


def test_a_run_from_straight_links_is_worse() -> None:
    """A start that is not the motion's own lets links ring beyond it."""
    mechanism = aluminium()
    request = StrengthRequest(
        crank_speed=15.0, source="periodic", revolutions=0.25, search_speed=False
    )
    steady = strength(mechanism, request).dataset
    rung = strength(mechanism, replace(request, source="transient")).dataset
    assert rung["margin_load_factor"].values[0] < 0.8 * steady["margin_load_factor"].values[0]
    assert np.isnan(rung["margin_speed_factor"]).all()


def test_no_revolution_is_refused() -> None:
    with pytest.raises(InputError, match="revolutions"):
        StrengthRequest(revolutions=0.0)
    with pytest.raises(InputError, match="source"):
        StrengthRequest(source="static")  # type: ignore[arg-type]


@pytest.mark.thorough
def test_speed_is_searched_through_a_resonance() -> None:
    """Undamped links break near a resonance, long before inertia alone would break them."""
    found = strength(aluminium(), StrengthRequest(crank_speed=52.0, source="periodic"))
    data = found.dataset
    by_inertia = float(np.sqrt(data["margin_load_factor"][0]))
    factors = data["margin_speed_factor"].values
    assert 1 < np.nanmin(factors) < 0.9 * by_inertia
    beyond = data["searched_speed_factor"] >= np.nanmin(factors)
    assert np.all(data["searched_load_factor"][~beyond] > 1)
    assert any("runs by speed" in line for line in found.summary().lines)


# --- at rest in their frames --------------------------------------------------------------------


def test_both_engines_at_equilibrium() -> None:
    """Corotational beams and Exudyn's static solver, of links that bend by a twentieth."""
    mechanism = aluminium()
    engines = [ReferenceEngine(mechanism, 8), ExudynEngine(mechanism, 8)]
    found = strength(engines, StrengthRequest(crank_speed=40.0, search_speed=False))
    data = found.dataset
    assert data["engine"].values.tolist() == ["reference", "exudyn"]
    for name in FORCES:
        assert largest_gaps(*data[name]).max() < 1e-3
    reference, exudyn = data["load_factor"].min(["station", "layer", "surface"])
    np.testing.assert_allclose(exudyn, reference, rtol=1e-3)
    assert "internal forces of reference and exudyn are within 0.0" in found.summary().trust
    # Those of rigid links would not do: coupler 10.7, rocker 11.0 in place of these.
    factors = dict(zip(data["margin_part"].values, data["margin_load_factor"].values, strict=True))
    assert factors["coupler"] > 13
    assert factors["rocker"] < 9.5
    (told,) = (line for line in found.summary().details if line.startswith("if the links"))
    assert "coupler 10.7 (3.27)" in told


def test_each_part_fails_at_its_speed_factor() -> None:
    """Seen by equilibria at the faster speed; it is not the root of the load factor."""
    mechanism = aluminium()
    found = strength(mechanism, 40.0)
    data = found.dataset
    names = data["margin_part"].values.tolist()
    factors = dict(zip(names, data["margin_speed_factor"].values.tolist(), strict=True))
    for name in ("rocker", "coupler"):
        faster = strength(
            mechanism, StrengthRequest(crank_speed=40.0 * factors[name], search_speed=False)
        ).dataset
        own = faster["load_factor"].sel(link=name)
        assert float(own.min()) == pytest.approx(1.0, rel=2e-3)
        slow = float(data["load_factor"].sel(link=name).min())
        assert factors[name] < 0.8 * np.sqrt(slow)
    # The links bend too far before the crank yields.
    assert np.isnan(factors["crank"])
    assert any("do not fail: crank" in line for line in found.summary().details)


def test_search_counts_few_of_many_crank_angles() -> None:
    mechanism = load_mechanism(MODELS / "composite_fourbar.toml")
    angles = np.radians(np.arange(0.0, 361.0, 2.0))
    fine = strength(mechanism, StrengthRequest(angles, 700.0))
    factor = float(fine.dataset["margin_speed_factor"][0])
    there = StrengthRequest(angles, 700.0 * factor, search_speed=False)
    faster = strength(mechanism, there).dataset
    assert float(faster["margin_load_factor"][0]) == pytest.approx(1.0, rel=2e-3)
    (line,) = (one for one in fine.summary().details if one.startswith("speed factor: searched"))
    assert " of 181 crank angles" in line
    counted = int(line.partition(" of 181")[0].split()[-1])
    # Every third one, and the worst of each part.
    assert 61 < counted <= 64


def test_weight_and_a_load_at_rest_are_in_equilibrium_too() -> None:
    """At rest no speed raises them, and no search begins."""
    push = Load("push", AttachmentPoint("coupler", 0.1397), ((0.0, -60.0),))
    mechanism = replace(aluminium(), loads=(push,))
    found = strength(mechanism, 0.0).dataset
    rigid = strength(mechanism, StrengthRequest(crank_speed=0.0, source="rigid")).dataset
    assert "searched_speed_factor" not in found
    assert np.isnan(found["margin_speed_factor"]).all()
    factors = (float(one["margin_load_factor"][0]) for one in (found, rigid))
    assert next(factors) != pytest.approx(next(factors), rel=1e-3)


def test_a_part_that_fails_is_searched_downwards() -> None:
    mechanism = load_mechanism(MODELS / "composite_fourbar.toml")
    fast = strength(mechanism, 1300.0)
    assert float(fast.dataset["margin_load_factor"][0]) < 1
    factor = float(fast.dataset["margin_speed_factor"].min())
    assert factor < 1
    there = StrengthRequest(crank_speed=1300.0 * factor, search_speed=False)
    slower = strength(mechanism, there).dataset
    assert float(slower["margin_load_factor"][0]) == pytest.approx(1.0, rel=2e-3)
    assert "the speed to 0.9" in fast.summary().answer[0]


def test_too_fast_for_an_equilibrium_names_the_other_source() -> None:
    with pytest.raises(ComputationError, match=r"displaced by .*source rigid") as end:
        strength(aluminium(), 200.0)
    assert "{" not in str(end.value)


def test_a_load_over_time_is_refused_at_rest() -> None:
    place, values = AttachmentPoint("coupler", 0.1), ((1.0, 0.0), (2.0, 0.0))
    late = Load("late", place, values, (0.0, 0.0), over="time", at=(0.0, 1.0))
    mechanism = replace(aluminium(), loads=(late,))
    with pytest.raises(InputError, match=r"load late: .*source transient, or rigid"):
        strength(mechanism, 10.0)
    strength(mechanism, StrengthRequest(crank_speed=10.0, source="rigid"))


def test_heat_and_moisture_are_in_the_equilibrium() -> None:
    """Swollen longer links: forces of the mechanism as it is then."""
    mechanism = load_mechanism(MODELS / "moist_composite_fourbar.toml")
    state = HygrothermalState(40.0, 0.02)
    wet = mechanism_in_state(mechanism, state)
    request = StrengthRequest(crank_speed=30.0, environment=state, search_speed=False)
    cuts = {name: cuts_of(wet, name, 8) for name in wet.linkage.topology.link_names}
    asked = Equilibria.of([ReferenceEngine(mechanism, 8)], request, 30.0)
    loads = asked.loads(asked.engines[0], cuts, silent)
    plain = Equilibria.of([ReferenceEngine(wet, 8)], replace(request, environment=None), 30.0)
    again = plain.loads(plain.engines[0], cuts, silent)
    np.testing.assert_array_equal(loads.joints.force, again.joints.force)
    for name, own in loads.links.items():
        np.testing.assert_array_equal(own.loads, again.links[name].loads)


def test_batches_are_joined_in_order(monkeypatch: pytest.MonkeyPatch) -> None:
    mechanism = load_mechanism(MODELS / "slider_crank.toml")
    request = StrengthRequest(crank_speed=30.0, search_speed=False)
    cuts = {n: cuts_of(mechanism, n, 4) for n in mechanism.linkage.topology.link_names}
    asked = Equilibria.of([ReferenceEngine(mechanism, 4)], request, 30.0)
    (engine,) = asked.engines
    whole = asked.loads(engine, cuts, silent)
    monkeypatch.setattr(Engine, "batch_size", 20)
    assert len(engine.batches(73)) > 3
    told: list[int] = []
    parts = asked.loads(engine, cuts, lambda label, done, total: told.append(done))
    assert told[-1] == 73
    np.testing.assert_allclose(parts.joints.force, whole.joints.force, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(parts.joints.angle, whole.joints.angle, rtol=1e-12)
    for joint, force in whole.joints.of_blocks.items():
        np.testing.assert_allclose(parts.joints.of_blocks[joint], force, rtol=1e-9, atol=1e-9)
    for name, own in whole.links.items():
        np.testing.assert_allclose(parts.links[name].loads, own.loads, rtol=1e-9, atol=1e-9)


# --- running -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "engine", [ReferenceEngine, pytest.param(ExudynEngine, marks=pytest.mark.thorough)]
)
def test_what_runs_is_in_balance(engine: type[Engine]) -> None:
    """D'Alembert's forces against the curvature, and against the joint forces of the run itself.

    The run's go through a filter, which begins and ends a few samples late; the moments of links
    that were taken as rigid would be 9 % off.
    """
    mechanism = aluminium()
    request = StrengthRequest(crank_speed=15.0, source="periodic", search_speed=False)
    runs = Runs.of([engine(mechanism, 8)], request, 15.0)
    (own,) = runs.engines
    cuts = {name: cuts_of(mechanism, name, 8) for name in mechanism.linkage.topology.link_names}
    loads = runs.loads(own, cuts, silent)
    assert loads.moment_gap is not None
    apart, peak = loads.moment_gap.T
    assert (apart < 5e-4 * peak).all()
    trajectory = run_engine(own, runs.request, runs.plan, silent).trajectory
    inside = slice(40, -40)
    size = np.abs(trajectory.joint_force).max()
    np.testing.assert_allclose(
        loads.joints.force[inside], trajectory.joint_force[inside], atol=2e-4 * size
    )
    # At its far end, which turns on a pin, a link carries what the pin gives it.
    ends = loads.links["coupler"].loads[:, -1]
    np.testing.assert_allclose(ends[:, 1], 0.0, atol=1e-6 * peak[1])
    pin = np.linalg.norm(loads.joints.vector("B"), axis=1)
    np.testing.assert_allclose(np.hypot(ends[:, 0], ends[:, 2]), pin, rtol=1e-6)


def test_a_body_off_the_axis_runs_with_its_section() -> None:
    """Its arm turns with the link's end: Euler's force, and centripetal force by the vibration."""
    light = BeamSection.rectangle(Material(70e9, 1e-3, 0.3, yield_strength=240e6), 4e-3, 20e-3)
    body = AttachedBody("arm", 0.3, 0.05, 1e-5, (0.0, 0.02))
    arm = Mechanism(RotatingArm(0.3), {"arm": light}, bodies=(body,))
    engine, time = ReferenceEngine(arm, 2), np.linspace(0.0, 0.1, 400)
    (link,) = engine.links
    end = link.readings.slope + link.readings.per_node * (len(link.readings.nodes) - 1)
    angle, frequency = 1e-3, 60.0
    q = np.zeros((len(time), link.size))
    shake = angle * np.sin(frequency * time)
    q[:, end] = shake
    rate, gain = np.zeros_like(q), np.zeros_like(q)
    rate[:, end] = frequency * angle * np.cos(frequency * time)
    gain[:, end] = -(frequency**2) * shake
    motion = arm.linkage.motion(20.0 * time, 20.0, 0.0)
    running = RunningLinks.of_run(engine, motion, time, [q], [rate], [gain])
    # At the root: M = -(r x F) - I theta''.
    x, y = 0.3 - 0.02 * np.sin(shake), 0.02 * np.cos(shake)
    spin, change = rate[:, end], gain[:, end]
    along = -0.02 * (np.cos(shake) * change - np.sin(shake) * spin**2)
    across = -0.02 * (np.sin(shake) * change + np.cos(shake) * spin**2)
    speed = np.stack([-0.02 * np.cos(shake) * spin, -0.02 * np.sin(shake) * spin])
    force_x = -0.05 * (along - 400 * x - 40 * speed[1])
    force_y = -0.05 * (across - 400 * y + 40 * speed[0])
    moment = x * force_y - y * force_x - 1e-5 * change
    found = running.section_forces(0, np.array([1e-9]))[:, 0]
    np.testing.assert_allclose(found[:, 0], force_x, rtol=1e-4)
    np.testing.assert_allclose(found[:, 1], moment, rtol=1e-3, atol=1e-4 * np.abs(moment).max())
