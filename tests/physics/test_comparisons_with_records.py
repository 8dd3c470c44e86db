"""Damping, stiffness and calibration found back in records of known linkages.

Records over time are runs of the reference engine, whose links stretch by the square of their
slopes; the equations that are fitted to them are linear ones in moving modes.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from flexmech import (
    Comparison,
    ComputationError,
    ConstantSpeed,
    ExudynEngine,
    InputError,
    LinkPoint,
    MeasuredQuantity,
    MeasuredRecord,
    ReferenceEngine,
    compare_with_record,
    hammer_test,
    load_mechanism,
    natural_frequencies,
    response,
)
from flexmech.analyses import ResponseRequest
from tests.support.gauge_record import (
    ALUMINIUM,
    DAMPING_TIME,
    ENGINE,
    SPEED,
    damped,
    gauge_record,
    history,
)

DATA = Path(__file__).parents[1] / "data"
FAR = 3.5
"""In standard errors: what white noise hardly ever reaches."""
ANGLE = np.radians(60.0)


def compared(record: MeasuredRecord, engine=ENGINE, **asked: object) -> Comparison:
    asked = asked or {"speed": SPEED}
    return compare_with_record(engine, record, **asked)


@pytest.fixture(scope="module")
def with_angle() -> Comparison:
    return compared(gauge_record(1))


def test_damping_is_found_back_from_a_noisy_strain(with_angle):
    """Within 5 %, and its ratio is half the time times the first natural frequency."""
    damping = with_angle.fitted("damping")
    assert abs(damping.value - DAMPING_TIME) < FAR * damping.standard_error
    assert damping.value == pytest.approx(DAMPING_TIME, rel=0.05)
    assert damping.lower < damping.value < damping.upper
    assert damping.unit == "s"
    assert with_angle.unexplained == pytest.approx(0.02**2, rel=0.2)
    data = with_angle.dataset
    np.testing.assert_array_equal(data["residual"], data["measured"] - data["computed"])


def test_a_gauge_is_stretched_where_the_coupler_bends_towards_it():
    """Bent to half a sine its strain is t/2 (pi/L)^2 times the deflection of its middle."""
    request = ResponseRequest(ConstantSpeed(SPEED), revolutions=1.0, samples=60, start="periodic")
    data = response(ENGINE, request).dataset.isel(engine=0).sel(link="coupler")
    strain, deflection = data["strain"].values, data["deflection"].values
    slope = (strain @ deflection) / (deflection @ deflection)
    assert slope == pytest.approx(0.8e-3 * (np.pi / 0.2794) ** 2, rel=0.03)


def test_the_periodic_motion_is_what_free_vibration_leaves(with_angle):
    strain, periodic = history()[2], with_angle.dataset["periodic"].values
    apart = np.abs(periodic - strain)
    assert apart[-40:].max() < 0.2 * np.abs(strain).max() < apart.max()


@pytest.mark.thorough
def test_the_crank_angle_of_a_record_without_it_is_found():
    """Within 2 deg, beside damping and a zero that has not drifted."""
    record = gauge_record(2, first=77, angle=False)
    result = compared(record, speed=SPEED, fit=("damping", "offset"))
    start = result.fitted("start_angle")
    assert start.lower < np.degrees(history()[1][77]) < start.upper < start.lower + 2.0
    damping, offset = result.fitted("damping"), result.fitted("offset")
    assert abs(damping.value - DAMPING_TIME) < FAR * damping.standard_error
    assert abs(offset.value) < FAR * offset.standard_error


def test_a_zero_that_has_drifted_is_found_and_a_gauge_on_the_other_face_is_told():
    drifted = compared(gauge_record(3, offset=3e-5), speed=SPEED, fit=("damping", "offset"))
    assert drifted.fitted("offset").value == pytest.approx(3e-5, rel=0.01)
    turned = compared(gauge_record(1, factor=-1.0), speed=SPEED, fit=("none",))
    assert turned.unexplained > 0.5
    assert any("sign" in warning for warning in turned.summary().warnings)
    upright = compared(gauge_record(1), speed=SPEED, fit=("none",))
    assert not any("sign" in warning for warning in upright.summary().warnings)


def test_damping_of_the_model_stays_where_it_is_not_fitted():
    engine = ENGINE.with_(mechanism=damped(ALUMINIUM, every=DAMPING_TIME))
    right = compared(gauge_record(1), engine, speed=SPEED, fit=("none",))
    assert right.unexplained < 1e-3
    assert (
        compared(gauge_record(1), speed=SPEED, fit=("none",)).unexplained > 20 * right.unexplained
    )


# --- natural frequencies ------------------------------------------------------------------------


def frequency_record(angle: np.ndarray, *modes: np.ndarray, numbered: bool = True):
    quantities = [MeasuredQuantity("frequency", "Hz", np.concatenate(modes))]
    if numbered:
        number = np.repeat(np.arange(1.0, 1 + len(modes)), len(angle))
        quantities.append(MeasuredQuantity("mode", "", number))
    return MeasuredRecord("crank_angle", np.tile(angle, len(modes)), tuple(quantities))


@pytest.mark.parametrize(
    "kind", [ReferenceEngine, pytest.param(ExudynEngine, marks=pytest.mark.thorough)]
)
def test_stiffness_of_two_links_is_found_back_from_frequencies_at_speed(kind):
    """To 1e-6: moduli times 0.9 in the coupler and 1.05 in the rocker."""
    true = {"coupler": 0.9, "rocker": 1.05}
    rigidities = ("bending_stiffness", "axial_stiffness", "shear_stiffness")
    sections = {
        name: replace(
            section, **{each: true.get(name, 1.0) * getattr(section, each) for each in rigidities}
        )
        for name, section in ALUMINIUM.sections.items()
    }
    angle = np.radians(np.arange(0.0, 360.0, 45.0))
    stiffened = kind(replace(ALUMINIUM, sections=sections), 2)
    record = frequency_record(angle, *natural_frequencies(stiffened, angle, SPEED, modes=2).T)
    names = tuple(f"stiffness:{link}" for link in true)
    result = compared(record, kind(ALUMINIUM, 2), speed=SPEED, fit=names)
    for link, factor in true.items():
        assert result.fitted(f"stiffness:{link}").value == pytest.approx(factor, rel=1e-6)


def test_frequencies_without_a_mode_are_laid_beside_the_only_mode_near_them():
    """At 0.2 % of mode 2 they are its own, and that is said; at 5 % they may be anything's."""
    angle = np.radians([0.0, 120.0, 240.0])
    second = natural_frequencies(ENGINE, angle, modes=2)[:, 1]
    result = compared(frequency_record(angle, 1.002 * second, numbered=False), speed=0.0)
    assert result.dataset["mode"].values.tolist() == [2, 2, 2]
    assert result.dataset["residual"].values == pytest.approx(0.002 * second, rel=1e-6)
    assert any("mode 2" in warning for warning in result.summary().warnings)
    numbered = compared(frequency_record(angle, second / 1.05, second), speed=0.0)
    assert not any("mode 2" in warning for warning in numbered.summary().warnings)
    with pytest.raises(InputError, match=r"from mode 2 by 5 %.*column 'mode'"):
        compared(frequency_record(angle, second / 1.05, numbered=False), speed=0.0)


def test_three_stiffnesses_cannot_be_told_from_one_frequency():
    angle = np.radians([10.0, 10.0, 10.0])
    record = frequency_record(angle, natural_frequencies(ENGINE, angle, modes=1)[:, 0])
    names = tuple(f"stiffness:{link}" for link in ("crank", "coupler", "rocker"))
    with pytest.raises(ComputationError, match="apart"):
        compared(record, speed=0.0, fit=names)


# --- frequency responses ------------------------------------------------------------------------

TWO = "coupler:0.5,rocker:0.5"
TIMES = {"crank": 2e-5, "coupler": 4e-5, "rocker": 2e-5}


@cache
def receptance() -> tuple[np.ndarray, np.ndarray]:
    """Exact receptance of a locked crank from 20 to 120 Hz."""
    engine = ENGINE.with_(mechanism=damped(ALUMINIUM, **TIMES))
    points = {"impact": LinkPoint("coupler", 0.5), "response": LinkPoint("rocker", 0.5)}
    asked = {"bandwidth": 130.0, "modes": 2, "method": "circle-fit"}
    data = hammer_test(engine, [ANGLE], **points, **asked).dataset.isel(crank_angle=0)
    assert data.attrs["window_decay_rate"] == 0.0
    exact = data["exact_receptance_real"] + 1j * data["exact_receptance_imag"]
    kept = (data["frequency"] > 20.0) & (data["frequency"] < 120.0)
    return data["frequency"].values[kept][::4], exact.values[kept][::4]


def mobility_record(noise: float = 0.0, factor: float = 1.0) -> MeasuredRecord:
    frequency, values = receptance()
    values = factor * 2j * np.pi * frequency * values
    white = np.random.default_rng(1).standard_normal((2, len(frequency)))
    values = values + noise * np.abs(values).max() * (white[0] + 1j * white[1])
    return MeasuredRecord(
        "frequency", frequency, (MeasuredQuantity("mobility", "m/(N s)", values),)
    )


@pytest.mark.thorough
def test_damping_times_of_links_are_found_back_from_a_mobility():
    """To 0.5 % from exact values, and within their errors from noisy ones."""
    asked = {"angle": ANGLE, "quantity": TWO, "fit": ("damping", "damping:coupler")}
    exact, noisy = (compared(mobility_record(noise), **asked) for noise in (0.0, 0.01))
    for name, true in (("damping", 2e-5), ("damping:coupler", 4e-5)):
        assert exact.fitted(name).value == pytest.approx(true, rel=5e-3)
        assert abs(noisy.fitted(name).value - true) < FAR * noisy.fitted(name).standard_error


@pytest.mark.thorough
def test_a_calibration_3_percent_off_is_a_gain_and_no_damping():
    plain, off = (
        compared(mobility_record(factor=factor), angle=ANGLE, quantity=TWO) for factor in (1, 1.03)
    )
    for name, factor in (("gain", 1.03), ("damping", 1.0)):
        expected = factor * plain.fitted(name).value
        assert off.fitted(name).value == pytest.approx(expected, rel=1e-5)
    assert 2e-5 < plain.fitted("damping").value < 4e-5


@pytest.mark.parametrize("factor", [-1e-3, 1000.0])
def test_a_gain_of_any_size_and_sign_changes_no_damping(factor):
    """The gain is linear: that of noise of 1 % and 4e-5 s in the coupler comes back to 1e-6."""
    engine = ENGINE.with_(mechanism=damped(ALUMINIUM, **(TIMES | {"coupler": 0.0})))
    asked = {"angle": ANGLE, "quantity": TWO, "fit": ("damping:coupler", "gain")}
    record = mobility_record(0.01)
    scaled = replace(record.quantities[0], values=factor * record.quantities[0].values)
    plain = compared(record, engine, **asked)
    off = compared(replace(record, quantities=(scaled,)), engine, **asked)
    damping = off.fitted("damping:coupler")
    assert damping.lower < 4e-5 < damping.upper
    for name, expected in (("gain", factor), ("damping:coupler", 1.0)):
        one, other = plain.fitted(name), off.fitted(name)
        assert other.value == pytest.approx(expected * one.value, rel=1e-6)
        assert other.standard_error == pytest.approx(abs(expected) * one.standard_error, rel=1e-3)
    assert any("gain" in warning for warning in off.summary().warnings)


def test_a_record_that_grows_shows_no_damping():
    """Every damping time negative, a receptance is conjugate and a mobility that times -1."""
    record = mobility_record()
    turned = replace(record.quantities[0], values=-np.conj(record.quantities[0].values))
    engine = ENGINE.with_(mechanism=damped(ALUMINIUM, crank=0.0))
    asked = {"angle": ANGLE, "quantity": TWO, "fit": ("damping",)}
    decays = compared(record, engine, **asked)
    grows = compared(replace(record, quantities=(turned,)), engine, **asked)
    assert grows.fitted("damping").value == pytest.approx(-decays.fitted("damping").value)
    answers = [" ".join(found.summary().answer) for found in (decays, grows)]
    assert ["shows no damping" in answer for answer in answers] == [False, True]


def test_gain_and_zero_of_a_gauge_are_found_at_any_size():
    """A gauge on the other face that counts a hundred times too much, its zero 1 mm/m off."""
    record = gauge_record(3, factor=-100.0, offset=1e-3)
    result = compared(record, speed=SPEED, fit=("damping", "offset", "gain"))
    for name, true in (("damping", DAMPING_TIME), ("offset", 1e-3), ("gain", -100.0)):
        assert result.fitted(name).value == pytest.approx(true, rel=0.05)


def test_one_of_several_functions_is_chosen_by_its_name():
    alone = mobility_record()
    other = replace(alone.quantities[0], name="other", values=7 * alone.quantities[0].values)
    both = replace(alone, quantities=(other, *alone.quantities))
    engine = ENGINE.with_(mechanism=damped(ALUMINIUM, **TIMES))
    result = compared(both, engine, angle=ANGLE, quantity=f"mobility@{TWO}", fit=("gain",))
    assert result.fitted("gain").value == pytest.approx(1.0, abs=1e-3)
    with pytest.raises(InputError, match="other, mobility"):
        compared(both, engine, angle=ANGLE)


# --- intervals ----------------------------------------------------------------------------------


def held(results: list[Comparison]) -> int:
    """How many intervals hold the true damping time."""
    fitted = [result.fitted("damping") for result in results]
    return sum(one.lower <= DAMPING_TIME <= one.upper for one in fitted)


@pytest.mark.thorough
@pytest.mark.parametrize("memory", [0.0, 0.8])
def test_of_30_records_26_give_their_damping_back(memory):
    """Fewer than 26 of 30 intervals of 95 % hold with a probability of 0.016."""
    records = (gauge_record(seed, noise=0.03, memory=memory) for seed in range(30))
    assert held([compared(record) for record in records]) >= 26


@pytest.mark.thorough
def test_of_12_records_without_crank_angle_10_give_their_damping_back():
    """Fewer than 10 of 12 intervals of 95 % hold with a probability of 0.02."""
    first = np.random.default_rng(0).integers(180, size=12)
    records = (
        gauge_record(1000 + seed, int(begin), angle=False, noise=0.03)
        for seed, begin in enumerate(first)
    )
    assert held([compared(record) for record in records]) >= 10


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["pushed_slider_crank", "heavy_slider_crank"])
def test_nothing_but_the_noise_of_a_loaded_linkage_is_unexplained(name):
    """Weight, springs and loads; damping of 1.3e-5 s within 3 %."""
    engine = ReferenceEngine(load_mechanism(DATA / f"{name}.toml"), 3)
    run = response(
        engine, ResponseRequest(ConstantSpeed(12.0), revolutions=2.0, start="rigid")
    ).dataset
    deflection = run["deflection"].sel(link="rod").values[0]
    white = np.random.default_rng(0).standard_normal(len(deflection))
    values = deflection + 0.01 * deflection.std() * white
    quantities = (
        MeasuredQuantity("rod_mid_deflection", "m", values),
        MeasuredQuantity("crank_angle", "rad", np.mod(run["crank_angle"].values, 2 * np.pi)),
    )
    record = MeasuredRecord("time", run["time"].values, quantities)
    result = compared(record, engine, speed=12.0)
    damping = result.fitted("damping")
    assert result.unexplained == pytest.approx(1e-4, rel=0.1)
    assert damping.lower <= 1.3e-5 <= damping.upper < damping.lower + 0.03 * 1.3e-5
