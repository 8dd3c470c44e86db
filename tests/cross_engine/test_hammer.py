"""The virtual hammer test against the eigen model, and by both engines."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy import signal

import flexmech
from flexmech.analyses.damping_ratios import with_damping_ratio
from flexmech.analyses.hammer.locked_linkage import LockedLinkage
from flexmech.analyses.hammer.plan import planned_record
from flexmech.analyses.hammer.transient import taken_record, unwarped
from flexmech.dynamical_systems import HalfSinePulse
from flexmech.errors import InputError
from flexmech.linear_system import LinkPoint

COUPLER, ROCKER = LinkPoint("coupler", 0.5), LinkPoint("rocker", 0.5)
ANGLE = np.radians([96.9])
ENGINES = {"reference": flexmech.ReferenceEngine, "exudyn": flexmech.ExudynEngine}


def engine_of(
    name: str, model: str = "aluminium_fourbar", elements: int = 4
) -> flexmech.ReferenceEngine:
    mechanism = flexmech.load_mechanism(flexmech.example_model(model))
    return with_damping_ratio(ENGINES[name](mechanism, elements), 0.01)


@cache
def result_of(
    name: str, impact: LinkPoint = COUPLER, response: LinkPoint = ROCKER
) -> flexmech.HammerTest:
    request = flexmech.HammerRequest(ANGLE, impact, response, modes=3)
    return flexmech.hammer_test(engine_of(name), request)


def receptance(result: flexmech.HammerTest, name: str = "receptance") -> np.ndarray:
    data = result.dataset.isel(crank_angle=0)
    return data[f"{name}_real"].values + 1j * data[f"{name}_imag"].values


@pytest.mark.parametrize("name", ENGINES)
def test_the_measured_receptance_is_the_superposition(name):
    """Within 1 % at every line of the band, which the pulse excites."""
    measured, exact = receptance(result_of(name)), receptance(result_of(name), "exact_receptance")
    assert np.abs(measured / exact - 1).max() < 0.01
    assert np.ptp(np.abs(exact)) > 100 * np.abs(exact).min()  # peaks and antiresonances


@pytest.mark.parametrize("name", ENGINES)
def test_modes_of_the_eigen_model_are_identified(name):
    modes = result_of(name).identified().head(3)
    np.testing.assert_allclose(modes["frequency_Hz"], modes["eigen_frequency_Hz"], rtol=1e-3)
    np.testing.assert_allclose(modes["damping_ratio"], modes["eigen_damping_ratio"], rtol=0.05)


def test_the_engines_agree():
    """Of Exudyn's nonlinear transient and the exact linear one, to 1 % of the peak."""
    exudyn, reference = receptance(result_of("exudyn")), receptance(result_of("reference"))
    assert np.abs(exudyn - reference).max() < 0.01 * np.abs(reference).max()


@pytest.mark.parametrize("name", ENGINES)
def test_impact_and_response_may_change_places(name):
    there, back = receptance(result_of(name)), receptance(result_of(name, ROCKER, COUPLER))
    assert np.abs(there - back).max() < 1e-3 * np.abs(there).max()


def test_direct_solution_and_superposition_are_stated():
    data = result_of("exudyn").dataset
    assert float(data["direct_difference"].max()) < 1e-8
    assert float(data["superposition_error"].max()) < 1e-3
    assert float(np.abs(data["residual_term"]).min()) > 0


@pytest.mark.parametrize(("elements", "most"), [(8, 0.1), (16, 0.01)])
def test_exact_receptances_of_shearing_links_meet_with_the_mesh(elements, most):
    """Damped by a thousandth, a peak shifts by 5 % where frequencies differ by 5e-5."""
    mechanism = flexmech.load_mechanism(flexmech.example_model("composite_fourbar"))
    receptances = []
    lines = np.linspace(870.0, 890.0, 801)
    for kind in ENGINES.values():
        locked = LockedLinkage.at(kind(mechanism, elements), float(ANGLE[0]), "none")
        row = locked.rows([COUPLER], "transverse")
        receptances.append(locked.modes.receptance(row, row, lines)[:, 0, 0])
    one, other = receptances
    assert np.abs(one - other).max() < most * np.abs(one).max()


def test_half_the_step_changes_nothing():
    """What the trapezoidal rule does to frequencies is taken off; without that it is 20 % here."""
    engine = engine_of("exudyn", elements=2)
    locked = LockedLinkage.at(engine, float(ANGLE[0]), "none")
    request = flexmech.HammerRequest(ANGLE, COUPLER, ROCKER, modes=2)
    plan = planned_record(request, [locked])
    assert plan.oversampling == 10
    peaks = []
    for steps in (3, 6):
        coarse = type(plan)(**{**vars(plan), "oversampling": steps})
        record = taken_record(locked, coarse, COUPLER, ROCKER, "transverse")
        spectrum = np.fft.rfft(record.response) / np.fft.rfft(record.force)
        peaks.append(spectrum[: int(plan.bandwidth * plan.duration)])
    apart = np.abs(peaks[0] - peaks[1]).max() / np.abs(peaks[1]).max()
    assert apart < 2e-3


def test_the_shift_of_frequencies_is_taken_off_exactly():
    """An oscillator by the trapezoidal rule, in coarse steps, has its exact receptance again."""
    step, count, damping, stiffness = 2e-3, 4096, 8.0, (2 * np.pi * 60.0) ** 2
    force = HalfSinePulse(1.0, 0.01, start=0.05).force(step * np.arange(count))
    rule = signal.bilinear([1.0], [1.0, damping, stiffness], fs=1 / step)
    records = np.stack([force, signal.lfilter(*rule, force)])
    s = 2j * np.pi * np.fft.rfftfreq(count, step)[: count // 4]
    exact = 1 / (s**2 + damping * s + stiffness)
    for given, least, most in ((records, 0.5, 2.0), (unwarped(records, 1 / step, step), 0.0, 1e-4)):
        spectra = np.fft.rfft(given, axis=1)[:, : count // 4]
        gap = np.abs(spectra[1] / spectra[0] - exact).max() / np.abs(exact).max()
        assert least <= gap < most


def test_the_weight_of_the_links_counts_at_equilibrium():
    """Exudyn starts from the bent position of rest; straight links with weight it refuses."""
    mechanism = flexmech.load_mechanism(flexmech.example_model("aluminium_fourbar"))
    heavy = replace(mechanism, gravity=(0.0, -9.81))
    engine = with_damping_ratio(flexmech.ExudynEngine(heavy, 2), 0.03)
    found = {
        level: flexmech.hammer_test(
            engine, flexmech.HammerRequest(ANGLE, COUPLER, ROCKER, modes=2, prestress=level)
        )
        for level in ("none", "equilibrium")
    }
    for result in found.values():
        assert float(result.dataset["simulation_error"].max()) < 0.01
    light, bent = (each.identified()["frequency_Hz"].to_numpy()[:2] for each in found.values())
    assert np.abs(bent / light - 1).max() > 2e-4
    with pytest.raises(InputError, match="use prestress 'equilibrium', or the reference engine"):
        flexmech.hammer_test(engine, flexmech.HammerRequest(ANGLE, prestress="axial", modes=2))


@pytest.mark.thorough
@pytest.mark.parametrize("direction", ["transverse", "axial"])
@pytest.mark.parametrize("model", ["aluminium_fourbar", "moist_composite_fourbar"])
def test_engines_agree_in_all_positions(model, direction):
    angles = np.radians([10.0, 130.0])
    found = []
    for name in ENGINES:
        request = flexmech.HammerRequest(
            angles, LinkPoint("coupler", 0.37), ROCKER, direction, modes=3, bandwidth=250.0
        )
        found.append(flexmech.hammer_test(engine_of(name, model, 8), request).dataset)
        assert float(found[-1]["simulation_error"].max()) < 0.01
    one, other = (each["receptance_real"] + 1j * each["receptance_imag"] for each in found)
    peak = np.abs(other.values).max(axis=1)
    assert np.all(np.abs(one.values - other.values).max(axis=1) < 0.01 * peak)
