"""Hammer tests by both engines against the eigen model: locked linkages and running ones."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from flexmech import (
    ExudynEngine,
    HammerTest,
    InputError,
    JointSpring,
    LinkPoint,
    Load,
    Mechanism,
    ReferenceEngine,
    Spring,
    example_model,
    hammer_test,
    load_mechanism,
    running_hammer_test,
)
from flexmech.analyses import HammerRequest, RunningHammerRequest
from flexmech.linkages import AttachmentPoint

COUPLER, ROCKER = LinkPoint("coupler", 0.5), LinkPoint("rocker", 0.5)
CRANK = LinkPoint("crank", 0.6)
ANGLE = np.radians([96.9])
ENGINES = {"reference": ReferenceEngine, "exudyn": ExudynEngine}
BOTH = pytest.mark.parametrize("engine", ENGINES)


def damped(model: str, time: float) -> Mechanism:
    """Links with a Kelvin-Voigt damping time in s."""
    mechanism = load_mechanism(example_model(model))
    sections = {n: s.with_damping_time(time) for n, s in mechanism.sections.items()}
    return replace(mechanism, sections=sections)


@cache
def result_of(
    engine: str,
    impact: LinkPoint = COUPLER,
    response: LinkPoint = ROCKER,
    model: str = "aluminium_fourbar",
    time: float = 7e-5,
) -> HammerTest:
    built = ENGINES[engine](damped(model, time), 4)
    return hammer_test(built, ANGLE, impact=impact, response=response, modes=3)


def receptance(result: HammerTest, name: str = "receptance") -> np.ndarray:
    data = result.dataset.isel(crank_angle=0)
    return data[f"{name}_real"].values + 1j * data[f"{name}_imag"].values


@BOTH
@pytest.mark.parametrize(
    ("model", "time", "impact"),
    [
        ("aluminium_fourbar", 7e-5, COUPLER),
        # Unsymmetric laminates: the impact acts on the line of the pins, off the neutral axis.
        ("composite_fourbar", 8e-6, CRANK),
    ],
)
def test_the_measured_receptance_is_that_of_the_eigen_model(engine, model, time, impact):
    """At every line of the band, in peaks and antiresonances: within 2e-4, and within 1 % where
    Exudyn's nonlinear links vibrate in steps of time.
    """
    result = result_of(engine, impact, ROCKER, model, time)
    measured, exact = receptance(result), receptance(result, "exact_receptance")
    assert np.abs(measured / exact - 1).max() < {"reference": 2e-4, "exudyn": 0.01}[engine]
    assert np.ptp(np.abs(exact)) > 30 * np.abs(exact).min()


@BOTH
def test_three_modes_of_the_eigen_model_are_identified(engine):
    """Frequencies within 0.1 %, damping ratios within 5 %."""
    modes = result_of(engine).identified().head(3)
    np.testing.assert_allclose(modes["frequency_Hz"], modes["eigen_frequency_Hz"], rtol=1e-3)
    np.testing.assert_allclose(modes["damping_ratio"], modes["eigen_damping_ratio"], rtol=0.05)


def test_engines_measure_one_receptance_within_1_percent_of_its_peak():
    exudyn, reference = receptance(result_of("exudyn")), receptance(result_of("reference"))
    assert np.abs(exudyn - reference).max() < 0.01 * np.abs(reference).max()


@BOTH
def test_impact_and_response_may_change_places(engine):
    """Maxwell and Betti's reciprocity."""
    there, back = receptance(result_of(engine)), receptance(result_of(engine, ROCKER, COUPLER))
    assert np.abs(there - back).max() < 1e-3 * np.abs(there).max()


@BOTH
def test_superposition_of_modes_is_the_direct_solution_to_1e_8(engine):
    """Modes of the band with their residual term are within 1e-3 of all modes."""
    data = result_of(engine).dataset
    assert float(data["direct_difference"].max()) < 1e-8
    assert 1e-6 < float(data["superposition_error"].max()) < 1e-3
    assert float(np.abs(data["residual_term"]).min()) > 0


def test_the_weight_of_links_counts_at_equilibrium_and_not_about_straight_links():
    """Exudyn starts from the bent position of rest; axial forces of weight it refuses."""
    heavy = replace(damped("aluminium_fourbar", 2e-4), gravity=(0.0, -9.81))
    engine = ExudynEngine(heavy, 2)
    tests = [
        hammer_test(engine, ANGLE, impact=COUPLER, response=ROCKER, modes=2, prestress=level)
        for level in ("none", "equilibrium")
    ]
    for result in tests:
        assert float(result.dataset["simulation_error"].max()) < 0.01
    straight, bent = (each.identified()["frequency_Hz"].to_numpy()[:2] for each in tests)
    assert np.abs(bent / straight - 1).max() > 2e-4
    with pytest.raises(InputError, match="'equilibrium', or the reference engine"):
        hammer_test(engine, ANGLE, prestress="axial", modes=2)


@pytest.mark.thorough
@pytest.mark.parametrize("method", ["lscf", "circle-fit"])
@pytest.mark.parametrize("name", ["aluminium_fourbar", "steel_fourbar", "composite_fourbar"])
def test_three_modes_are_identified_all_over_the_turn(name, method):
    """At 300 deg of the aluminium four-bar a fifth mode overlaps the band's end."""
    mechanism = load_mechanism(example_model(name))
    if name != "composite_fourbar":
        mechanism = damped(name, 3.5e-5)
    request = HammerRequest(
        np.radians([0.0, 45.0, 96.9, 150.0, 210.0, 300.0]),
        impact=LinkPoint("coupler", 0.4),
        response=LinkPoint("rocker", 0.3),
        modes=3,
        method=method,
    )
    data = hammer_test(ReferenceEngine(mechanism, 4), request).dataset.isel(mode=slice(0, 3))
    np.testing.assert_allclose(data["identified_frequency"], data["eigen_frequency"], rtol=1e-3)
    np.testing.assert_allclose(
        data["identified_damping_ratio"], data["eigen_damping_ratio"], rtol=0.05
    )


# --- running linkages ---------------------------------------------------------------------------

RUNNING = RunningHammerRequest(
    20.0, impact=COUPLER, response=ROCKER, damping_ratio=0.1, bandwidth=60.0, orders=1
)


def test_sidebands_are_those_of_the_harmonic_balance():
    """At 20 rad/s; frozen linkages answer up to 24 % otherwise."""
    test = running_hammer_test(
        ReferenceEngine(load_mechanism(example_model("aluminium_fourbar")), 2), RUNNING
    )
    peaks, data = test.peaks(), test.dataset
    assert peaks["order"].tolist() == [-1, 0, 1]
    assert float(data["balance_error"].max()) < 1e-6
    assert float(data["reduction_error"].max()) < 1e-2
    frozen = np.hypot(data["frozen_real"], data["frozen_imag"]).max("frequency").values
    assert np.abs(frozen / peaks["peak_m_N"] - 1).max() > 0.15


def test_a_rotating_arm_has_no_sidebands():
    """Its equations are constant: one receptance, of the order 0."""
    arm = ReferenceEngine(load_mechanism(example_model("rotating_arm")), 2)
    tip = LinkPoint("arm", 1.0)
    found = running_hammer_test(arm, 60.0, impact=tip, damping_ratio=0.3, orders=1)
    peaks = found.peaks().set_index("order")
    assert peaks.loc[[-1, 1], "peak_m_N"].tolist() == [0.0, 0.0]
    assert peaks.loc[0, "peak_m_N"] > 0


def test_loads_and_springs_count_in_the_answer_of_a_running_linkage():
    """Springs to the ground and in a joint, and a load over the turn, change the peaks by 20 %."""
    place = AttachmentPoint("rocker", 0.13)
    bare = load_mechanism(example_model("aluminium_fourbar"))
    spring = Spring("hold", AttachmentPoint("ground", 0.2, 0.5), place, 400.0, 0.3, 0.5)
    load = Load(
        *("press", place, ((0.0, 0.0), (2.0, 0.0)), (0.0, 0.0), "ground", "crank_angle", (0.5, 1.0))
    )
    hinge = JointSpring("B", 0.0, 0.002)
    held = replace(bare, springs=(spring,), joint_springs=(hinge,), loads=(load,))
    request = replace(RUNNING, impact=ROCKER, prestress="axial", bandwidth=40.0)
    peaks, alone = (
        running_hammer_test(ReferenceEngine(each, 2), request).peaks() for each in (held, bare)
    )
    assert np.abs(peaks["peak_m_N"] / alone["peak_m_N"] - 1).max() > 0.2


def test_exudyn_is_referred_to_the_reference_engine():
    engine = ExudynEngine(load_mechanism(example_model("rotating_arm")), 2)
    with pytest.raises(InputError, match="--engine reference"):
        running_hammer_test(engine, 20.0)
