"""Runs in time: the reference's equations beside Exudyn's simulation, at the same steps.

The reference's equations are linear about the equilibrium. At half the speeds of the frequencies
what they leave out is below 3e-4 of the peaks.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

from flexmech import ComputationError, ConstantSpeed, LawDrive, Load, Response, response
from flexmech.analyses import ResponseRequest
from tests.support.mechanisms import FOLLOWER, Case, at, bowed_guide, case, four_bar, model, strips
from tests.support.random_mechanisms import random_case


def run(one: Case, drive: Any, revolutions: float, elements: int = 4, **asked: Any) -> Response:
    asked = {"start": "equilibrium", "modes": 2, "samples": 1200, "shaft": one.shaft} | asked
    return response(one.engines(elements), ResponseRequest(drive, revolutions, **asked))


def gap(found: Response | xr.Dataset, name: str) -> float:
    """Greatest difference of both engines over the peak."""
    data = found if isinstance(found, xr.Dataset) else found.dataset
    first, second = data[name].values
    return float(np.nanmax(np.abs(second - first)) / np.nanmax(np.abs(first)))


STEADY = {
    "aluminium four-bar": 3e-4,
    "steel four-bar": 1e-4,
    "swollen resin": 6e-4,
    "slider-crank": 1e-4,
    "slider-crank with free shaft": 6e-4,
    "Stephenson six-bar": 1e-4,
    "of all kinds": 1e-4,
    "ternary coupler": 2e-4,
    "rigid coupler": 1e-4,
    "rigid rod": 1e-4,
    "rigid crank": 1e-4,
    "rigid leg": 2e-4,
    "slider-crank uphill": 1e-4,
    "moving guide": 2e-4,
    "bowed on a moving guide": 3e-4,
    "L-arm with bodies": 1e-4,
    "three links on a pin": 2e-4,
    "dead loads": 1e-3,
    "follower load": 6e-4,
    "spring and damper": 1e-3,
    "sprung joints of a rigid rocker": 3e-4,
    "crank-rocker 0": 3e-4,
}


RARELY = {
    "steel four-bar",
    "rigid coupler",
    "rigid crank",
    "ternary coupler",
    "follower load",
    "rigid leg",
    "bowed on a moving guide",
    "three links on a pin",
    "sprung joints of a rigid rocker",
}


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.thorough] * (name in RARELY)) for name in STEADY],
)
def test_a_fiftieth_of_a_turn_from_the_equilibrium_is_alike(name: str) -> None:
    one = case(name)
    found = run(one, ConstantSpeed(one.speed / 2), 0.02)
    data = found.dataset
    of = ["deflection", "joint_force", "driving_torque"]
    of += [extra for extra in ("shaft_rotation",) if extra in data]
    for quantity in of:
        assert gap(found, quantity) < STEADY[name], quantity
    # Cables have curvatures of third order, exact beams of first.
    assert gap(found, "strain") < 3e-2
    linear, simulated = data["energy_error"].values
    assert linear < 1e-4
    assert simulated < 1e-6


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["L-arm with bodies"])
def test_a_crank_that_speeds_up_bends_its_links_alike(name: str) -> None:
    """From rest within a tenth of a second; what stands off a link's axis is left behind."""
    one = case(name)
    drive = ConstantSpeed(4.0, run_up_time=0.1, start_angle=0.4)
    found = run(one, drive, 0.02, start="rigid", step=4e-5, samples=1500)
    assert gap(found, "deflection") < 2e-3
    assert gap(found, "driving_torque") < 1e-3
    assert float(found.dataset["energy_error"].max()) < 1e-5


def test_a_force_that_turns_with_a_bent_section_does_its_work() -> None:
    """The power of the turned force balances the energies; of the force as drawn it does not."""
    load = replace(FOLLOWER, force=((0.0, -10.0),), torque=(0.0,))
    one = Case(strips(four_bar(), 3e-3, loads=(load,), gravity=(0.0, 0.0)), 20.0)
    found = run(one, ConstantSpeed(20.0), 0.03, elements=2, step=2e-4, start="rigid")
    assert float(np.abs(found.dataset["deflection"]).max()) > 1e-3
    assert float(found.dataset["energy_error"].sel(engine="reference")) < 2e-5


@pytest.mark.thorough
def test_all_that_can_act_on_a_four_bar_is_in_the_energies_of_both_engines() -> None:
    """Loads over the crank angle and over time, a follower, a spring, a hinge, dampers."""
    push = Load(
        "push",
        at("coupler", 0.1),
        ((0.0, 0.0), (0.0, -1.0)),
        (0.0, 0.0),
        over="time",
        at=(0.005, 0.01),
    )
    own = case("spring and damper").mechanism
    table = replace(case("dead loads").mechanism.loads[1], force=((-1.0, 0.0), (2.0, 1.0), (0, 0)))
    hinge = case("sprung pin and a body").mechanism.joint_springs[0]
    acting = replace(own, loads=(push, table, FOLLOWER), joint_springs=(hinge,))
    found = run(Case(acting, 15.0), ConstantSpeed(15.0), 0.06, step=7e-5)
    data = found.dataset
    assert float(np.abs(data["prestress_work"]).max() / data["kinetic_energy"].max()) > 1e-3
    assert float(data["energy_error"].max()) < 2e-5
    assert gap(found, "deflection") < 3e-3
    assert gap(found, "driving_torque") < 1e-3


@pytest.mark.thorough
def test_a_load_over_time_that_never_changes_is_a_constant_load() -> None:
    """In the equilibrium at the start too: links do not ring."""
    constant = Load("push", at("coupler", 0.14), ((0.0, -2.0),), (0.01,), "link")
    over_time = replace(
        constant, force=constant.force * 2, torque=(0.01, 0.01), over="time", at=(0.0, 1.0)
    )
    first, second = (
        run(Case(strips(four_bar(), loads=(load,)), 5.0), 5.0, 0.01, elements=3, step=2e-4)
        for load in (constant, over_time)
    )
    for found in (first, second):
        assert gap(found, "deflection") < 1e-3
    np.testing.assert_allclose(
        second.dataset["deflection"],
        first.dataset["deflection"],
        atol=1e-6 * float(np.abs(first.dataset["deflection"]).max()),
    )


def test_a_joint_spring_keeps_its_energy_where_a_link_turns_past_half_a_turn() -> None:
    """The angle of a cable's slope jumps there; the spring's does not."""
    one = Case(strips(four_bar(), 3e-3, joint_springs=()), 20.0)
    hinge = case("sprung pin and a body").mechanism.joint_springs[0]
    mechanism = replace(
        one.mechanism, joint_springs=(replace(hinge, torsional_stiffness=0.05, free_angle=0.7),)
    )
    drive = ConstantSpeed(20.0, start_angle=3.1)
    found = run(Case(mechanism, 20.0), drive, 0.02, elements=3, step=2e-4)
    assert gap(found, "strain_energy") < 1e-3
    assert float(found.dataset["energy_error"].max()) < 1e-4


def test_a_rigid_start_rings_alike_to_twice_its_bow() -> None:
    """Linear equations about straight links were 0.5 of the joint forces off."""
    one = case("crank-rocker 0")
    found = run(one, ConstantSpeed(one.speed), 0.05, elements=6, start="rigid", samples=720)
    agreement, forces = found.agreement(), found.force_agreement()
    assert agreement is not None
    assert forces is not None
    assert float(agreement.max()) < 1e-2
    assert float(forces["peak_joint_force"].max()) < 2e-2
    assert float(forces["peak_driving_torque"]) < 2e-2
    for link in ("coupler", "rocker"):
        bent = found.dataset.isel(engine=1).sel(link=link)
        # A pinned link that is bent to +y is stretched there.
        assert np.corrcoef(bent["strain"], bent["deflection"])[0, 1] > 0.9


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("name", "speed", "near"),
    [("four-bar on a frame", 8.0, 2e-4), ("slider-crank on a frame", 20.0, 1e-3)],
)
def test_a_frame_on_springs_moves_alike(name: str, speed: float, near: float) -> None:
    """Exudyn's frame is a rigid body, the reference's coordinates of linear equations."""
    found = run(case(name), ConstantSpeed(speed), 0.25, start="periodic", samples=360)
    data = found.dataset
    for quantity in ("deflection", "frame_displacement", "joint_force"):
        assert gap(found, quantity) < near, quantity
    for peak in ("peak_frame_displacement", "peak_frame_rotation", "peak_floor_force"):
        np.testing.assert_allclose(data[peak][1], data[peak][0], rtol=near)
    assert float(data["energy_error"].max()) < 1e-6


@pytest.mark.thorough
def test_a_rod_that_bows_by_a_twentieth_takes_a_free_shaft_five_degrees_along() -> None:
    """Equations that were linear in its rotation had it off by 3.3 %, and its speed by 6.7 %."""
    one = case("slider-crank with free shaft")
    found = run(one, ConstantSpeed(6.0), 0.5, elements=8, start="rigid", step=2e-3)
    assert float(found.dataset["peak_shaft_rotation"].min()) > 0.07
    assert gap(found, "shaft_rotation") < 1e-2
    assert gap(found, "crank_speed_fluctuation") < 1.5e-2
    assert float(found.dataset["energy_error"].max()) < 3e-4


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("shaft", "of", "near"),
    [("free", "shaft_rotation", 3e-3), ("prescribed", "driving_torque", 3e-3)],
)
def test_a_lever_that_guides_a_bowed_crank_runs_alike(shaft: str, of: str, near: float) -> None:
    """Lines that turn linearly left deflections 2e-2 off, joint forces on a free shaft 0.2."""
    one = Case(bowed_guide(), 6.0, shaft=shaft)
    request = ResponseRequest(ConstantSpeed(6.0), 0.03, shaft=shaft, start="rigid")
    engines = one.engines(3, component_modes=False)
    data = response(engines, request).dataset
    assert gap(data, "deflection") < 5e-4
    assert gap(data, "joint_force") < 5e-4
    assert gap(data, of) < near


@pytest.mark.thorough
def test_forces_on_the_joints_of_a_chain_of_followers_are_alike() -> None:
    """The pusher's rocker of two beams follows its coupler; rod and ram hang on it."""
    one = case("carton pusher")
    found = run(one, ConstantSpeed(6.0), 0.02, elements=3, step=1e-4)
    first, second = found.dataset["joint_force"].values
    size = np.linalg.norm(first, axis=-1).max(axis=0)
    assert size.min() > 1.0
    assert (np.linalg.norm(second - first, axis=-1).max(axis=0) / size).max() < 1e-2


@pytest.mark.thorough
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_sections_off_the_axis_turn_alike_in_a_run(sign: float) -> None:
    """Mirror images are apart by 1.5e-2 of the peak: straight arms were 4.4e-3 off."""
    arm = case("heavy side").mechanism
    section = replace(arm.sections["arm"], mass_axis=sign * 1.9e-3)
    one = Case(replace(arm, sections={"arm": section}), 6.0, "shear")
    found = run(one, ConstantSpeed(6.0), 0.05, elements=12, start="rigid", samples=100, step=5e-4)
    assert gap(found, "deflection") < 5e-3


@pytest.mark.thorough
def test_exudyns_step_is_halved_where_newtons_method_finds_no_end() -> None:
    """The link bows by 15 %: a step of the user is refused, a chosen step is shortened."""
    drawn = random_case(6335, damped=True)
    one, drive = Case(drawn.mechanism, 0.0), ConstantSpeed(4 * drawn.crank_speed)
    exudyn = one.engines(4)[1]
    asked = ResponseRequest(drive, 0.25, 60, "equilibrium", modes=2)
    with pytest.raises(ComputationError, match="step smaller"):
        response(exudyn, replace(asked, step=1.5e-3))
    data = response(exudyn, asked).dataset
    assert float(data["step"].max()) < 3e-4


@pytest.mark.thorough
def test_a_run_is_not_begun_on_a_periodic_motion_that_is_not_there() -> None:
    """At three times its speed this linkage settles on no motion that repeats every turn."""
    drawn = random_case(6335, damped=True)
    one, drive = Case(drawn.mechanism, 0.0), ConstantSpeed(3 * drawn.crank_speed)
    with pytest.raises(ComputationError, match="no periodic motion"):
        response(one.engines(4)[0], ResponseRequest(drive, 0.06, 360, "periodic"))


@pytest.mark.thorough
def test_the_second_order_of_the_step_explains_what_is_left_of_a_law_of_motion() -> None:
    law = LawDrive("cycloid", np.radians(120), 0.15, dwell=0.05, start_angle=0.3)
    one = Case(model("aluminium_fourbar"), 0.0)
    gaps = [
        float(response(one.engines(3), ResponseRequest(law, step=step)).agreement().max())
        for step in (4e-4, 2e-4)
    ]
    assert gaps[1] < 8e-2
    assert gaps[0] / gaps[1] == pytest.approx(4.0, rel=0.3)
