"""Measured records beside computed ones: what is aligned, fitted, refused and said."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import flexmech
from flexmech.analyses import Comparison
from flexmech.analyses.comparison.over_frequency import points_of
from flexmech.analyses.comparison.parameters import (
    damping_times,
    fitted_engine,
    fitted_names,
    stiffness_factors,
)
from flexmech.dynamical_systems import direct_receptance
from flexmech.errors import ComputationError, InputError
from flexmech.linear_system import point_rows
from tests.support.comparison_data import (
    RATIO,
    SPEED,
    damped,
    damping_time,
    history,
    strain_record,
    undamped,
)

LINKS = ("crank", "coupler", "rocker")
ANGLE = np.radians(60.0)
TIMES = {"damping:crank": 2e-5, "damping:coupler": 4e-5, "damping:rocker": 2e-5}
# In standard errors: what white noise hardly ever reaches. How many intervals hold is tested in
# tests/analytical/test_damping_found_back.py.
FAR = 3.5


@pytest.fixture(scope="module")
def with_angle() -> Comparison:
    request = flexmech.ComparisonRequest(SPEED * 30 / np.pi, speed_unit="rpm")
    return flexmech.compare_with_record(undamped(), strain_record(), request)


def test_the_damping_of_a_record_is_found(with_angle):
    found = with_angle.fitted("damping")
    assert abs(found.value - damping_time()) < FAR * found.standard_error
    assert found.value == pytest.approx(damping_time(), rel=0.05)
    assert (found.unit, with_angle.unexplained < 1e-3) == ("s", True)
    data = with_angle.dataset
    assert np.array_equal(data["residual"], data["measured"] - data["computed"])
    assert data.attrs["aligned_by"] == "crank angle column"
    # The free vibration has died down at the end, and the periodic motion is left.
    strain = history()[2]
    last = np.abs(data["periodic"].values - strain)[-40:].max()
    assert last < 0.2 * np.abs(strain).max() < np.abs(data["periodic"].values - strain).max()


def test_the_crank_angle_of_a_record_without_it_is_found():
    record = strain_record(2, first=77, with_angle=False)
    request = flexmech.ComparisonRequest(SPEED, fit=("damping", "offset"))
    result = flexmech.compare_with_record(undamped(), record, request)
    start = result.fitted("start_angle")
    assert start.lower < np.degrees(history()[1][77]) < start.upper
    assert start.upper - start.lower < 2.0
    found, offset = result.fitted("damping"), result.fitted("offset")
    assert abs(found.value - damping_time()) < FAR * found.standard_error
    assert abs(offset.value) < FAR * offset.standard_error
    assert "found from the record itself" in str(result.summary())


def test_a_zero_that_has_drifted_is_found():
    record = strain_record(3)
    shifted = replace(record.quantities[0], values=record.quantities[0].values + 3e-5)
    moved = replace(record, quantities=(shifted, record.quantities[1]))
    request = flexmech.ComparisonRequest(SPEED, fit=("damping", "offset"))
    offset = flexmech.compare_with_record(undamped(), moved, request).fitted("offset")
    assert offset.value == pytest.approx(3e-5, rel=0.01)


def test_a_gauge_on_the_other_face_is_told():
    record = strain_record(1)
    turned = replace(record.quantities[0], values=-record.quantities[0].values)
    result = flexmech.compare_with_record(
        undamped(),
        replace(record, quantities=(turned, record.quantities[1])),
        flexmech.ComparisonRequest(SPEED, fit=("none",)),
    )
    assert result.unexplained > 0.5
    assert "turn the sign of the column" in " ".join(result.summary().warnings)


def test_what_is_said_and_written(with_angle, tmp_path):
    said = str(with_angle.summary())
    assert "fitted to strain.csv, aluminium four-bar" in said
    assert "turns at 190.986 rpm" in said
    assert "first natural frequency: 1" in said or "first natural frequency: 0.9" in said
    assert "the residual looks like white noise" in said
    time = f"{with_angle.fitted('damping').value:.4g}"
    assert f'applied: nothing; to use it, write into the model file: damping_time = "{time} s"' in (
        said
    )
    with_angle.save(tmp_path, figures=True)
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == ["comparison.csv", "comparison.nc", "comparison.png", "fit.csv"]
    head = (tmp_path / "comparison.csv").read_text().splitlines()[0]
    assert head == "time_s,measured,computed,residual"
    lines = (tmp_path / "fit.csv").read_text().splitlines()
    assert lines[0] == "parameter,value,unit,standard_error,p2_5,p97_5"
    assert lines[1].startswith("damping,")
    assert ",s," in lines[1]
    again = Comparison.load(tmp_path / "comparison.nc")
    assert again.dataset.identical(with_angle.dataset)
    assert again.fitted("damping") == with_angle.fitted("damping")
    with pytest.raises(InputError, match="'stiffness' was not fitted"):
        again.fitted("stiffness")


def test_the_own_damping_of_a_model_stays_where_it_is_not_fitted():
    result = flexmech.compare_with_record(
        damped(), strain_record(), flexmech.ComparisonRequest(SPEED, fit=("none",))
    )
    assert result.unexplained < 1e-3
    assert "nothing was fitted" in result.summary().trust
    worse = flexmech.compare_with_record(
        undamped(), strain_record(), flexmech.ComparisonRequest(SPEED, fit=("none",))
    )
    assert worse.unexplained > 20 * result.unexplained


@pytest.mark.parametrize(
    "engine",
    [
        flexmech.ReferenceEngine,
        pytest.param(flexmech.ExudynEngine, marks=pytest.mark.thorough),
    ],
)
def test_stiffness_is_found_back_from_frequencies(engine):
    own = engine(undamped().mechanism, 2)
    true = {"coupler": 0.9, "rocker": 1.05}
    angle = np.radians(np.arange(0.0, 360.0, 45.0))
    stiffened = fitted_engine(own, {f"stiffness:{link}": factor for link, factor in true.items()})
    found = flexmech.natural_frequencies(stiffened, angle, SPEED, modes=2)
    record = flexmech.MeasuredRecord(
        "crank_angle",
        np.tile(angle, 2),
        (
            flexmech.MeasuredQuantity("frequency", "Hz", found.T.ravel()),
            flexmech.MeasuredQuantity("mode", "", np.repeat([1.0, 2.0], len(angle))),
        ),
    )
    request = flexmech.ComparisonRequest(SPEED, fit=("stiffness:rocker", "stiffness:coupler"))
    result = flexmech.compare_with_record(own, record, request)
    for link, factor in true.items():
        assert result.fitted(f"stiffness:{link}").value == pytest.approx(factor, rel=1e-6)
    assert list(result.tables()["comparison"].columns)[:3] == [
        "crank_angle_deg",
        "mode",
        "measured_Hz",
    ]
    assert "on all moduli of coupler" in str(result.summary())


def test_a_record_without_modes_is_laid_beside_the_nearest():
    angle = np.radians([0.0, 120.0, 240.0])
    second = flexmech.natural_frequencies(undamped(), angle, modes=2)[:, 1]
    record = flexmech.MeasuredRecord(
        "crank_angle", angle, (flexmech.MeasuredQuantity("frequency", "Hz", 1.002 * second),)
    )
    result = flexmech.compare_with_record(undamped(), record, flexmech.ComparisonRequest(speed=0.0))
    assert result.dataset["mode"].values.tolist() == [2, 2, 2]
    assert result.dataset["residual"].values == pytest.approx(0.002 * second, rel=1e-6)
    said = str(result.summary())
    assert "mode 2 (by its frequencies)" in said
    assert "0.2 % of the frequencies" in said
    assert not result.summary().warnings


def mobility(unit: str = "m/(N s)", noise: float = 0.0) -> flexmech.MeasuredRecord:
    """A mobility of the damped linkage at a locked crank, by the unreduced equations."""
    engine = fitted_engine(undamped(), TIMES).unreduced()
    system = engine.linear_system(ANGLE)
    force, read = (
        point_rows(system, flexmech.LinkPoint(link, 0.5), "transverse")
        for link in ("coupler", "rocker")
    )
    frequency = np.arange(20.0, 120.0, 0.25)
    matrices = (system.mass[0], system.damping[0], system.stiffness[0])
    values = direct_receptance(*matrices, read, force, frequency)[:, 0, 0]
    values = 2j * np.pi * frequency * values
    random = np.random.default_rng(1)
    white = random.standard_normal((2, len(frequency)))
    values = values + noise * np.abs(values).max() * (white[0] + 1j * white[1])
    return flexmech.MeasuredRecord(
        "frequency", frequency, (flexmech.MeasuredQuantity("mobility", unit, values),), "m.uff"
    )


def test_damping_times_are_found_back_from_a_mobility():
    request = flexmech.ComparisonRequest(
        angle=ANGLE, quantity="coupler:0.5,rocker:0.5", fit=("damping", "damping:coupler")
    )
    exact = flexmech.compare_with_record(undamped(), mobility(), request)
    assert exact.fitted("damping").value == pytest.approx(2e-5, rel=5e-3)
    assert exact.fitted("damping:coupler").value == pytest.approx(4e-5, rel=5e-3)
    noisy = flexmech.compare_with_record(undamped(), mobility(noise=0.01), request)
    for name, true in (("damping", 2e-5), ("damping:coupler", 4e-5)):
        found = noisy.fitted(name)
        assert abs(found.value - true) < FAR * found.standard_error
    assert list(noisy.tables()["comparison"].columns) == [
        "frequency_Hz",
        *(
            f"{c}_{part}_m_Ns"
            for c in ("measured", "computed", "residual")
            for part in ("real", "imag")
        ),
    ]
    assert "correlation of damping and damping:coupler" in str(noisy.summary())


def test_a_calibration_that_is_off_is_found_and_is_no_damping():
    record = mobility()
    off = replace(record.quantities[0], values=1.03 * record.quantities[0].values)
    request = flexmech.ComparisonRequest(angle=ANGLE, quantity="coupler:0.5,rocker:0.5")
    result = flexmech.compare_with_record(undamped(), replace(record, quantities=(off,)), request)
    plain = flexmech.compare_with_record(undamped(), record, request)
    assert result.fitted("gain").value == pytest.approx(1.03 * plain.fitted("gain").value, rel=1e-5)
    assert result.fitted("damping").value == pytest.approx(plain.fitted("damping").value, rel=1e-5)
    assert 2e-5 < plain.fitted("damping").value < 4e-5


def test_names_that_can_be_fitted():
    names = fitted_names(("stiffness:rocker", "damping:coupler", "damping"), LINKS)
    assert names == ("damping", "damping:coupler", "stiffness:rocker")
    values = {"damping": 1.0, "damping:coupler": 2.0, "stiffness:rocker": 0.9}
    assert damping_times(LINKS, values) == {"crank": 1.0, "coupler": 2.0, "rocker": 1.0}
    assert stiffness_factors(values) == {"rocker": 0.9}
    assert fitted_names(("none",), LINKS) == ()
    with pytest.raises(InputError, match="'dampling' cannot be fitted; did you mean 'damping'"):
        fitted_names(("dampling",), LINKS)
    with pytest.raises(InputError, match=r"'stiffness:arm' cannot be fitted.*stiffness:rocker"):
        fitted_names(("stiffness:arm",), LINKS)
    with pytest.raises(InputError, match="stands twice"):
        fitted_names(("damping", "damping"), LINKS)
    with pytest.raises(InputError, match="'none' stands beside others"):
        fitted_names(("none", "damping"), LINKS)
    with pytest.raises(InputError, match="none is left for 'damping'"):
        fitted_names(("damping", *(f"damping:{link}" for link in LINKS)), LINKS)


def test_points_of_a_frequency_response():
    assert points_of(None, LINKS)[0] == flexmech.LinkPoint("coupler", 0.5)
    assert points_of("coupler:0.25, rocker:1", LINKS)[1] == flexmech.LinkPoint("rocker", 1.0)
    with pytest.raises(InputError, match="has 3 points"):
        points_of("a:0,b:0,c:0", LINKS)
    with pytest.raises(InputError, match="quantity: got 'coupler'"):
        points_of("coupler", LINKS)


def test_one_of_speed_and_angle():
    for wrong in ({}, {"speed": 20.0, "angle": 0.0}):
        with pytest.raises(InputError, match="give one of speed and angle"):
            flexmech.ComparisonRequest(**wrong)
    with pytest.raises(InputError, match="must be a tuple of names"):
        flexmech.ComparisonRequest(20.0, fit="damping")


def over_time(**changes: object) -> flexmech.MeasuredRecord:
    return replace(strain_record(), **changes)


def strains(factor: float, name: str = "strain", unit: str = "") -> tuple[object, ...]:
    own = strain_record().quantities
    return (flexmech.MeasuredQuantity(name, unit, factor * own[0].values), own[1])


# What is changed of the record, by a function where the record itself is needed for it.
REFUSED: dict[str, Any] = {
    "locked crank": ({}, {"angle": 0.1}, "give the crank speed with --speed in place of the angle"),
    "no speed": ({}, {"speed": 0.0}, "give the crank speed at which it was taken, not 0"),
    "another speed": ({}, {"speed": 21.0}, "its crank turns at 20 rad/s .190.99 rpm. by"),
    "too short": (
        lambda: {
            "position": np.arange(20) * 1e-3,
            "quantities": tuple(
                replace(q, values=q.values[:20]) for q in strain_record().quantities[:1]
            ),
        },
        {},
        "is too short: 0.019 s and 20 samples; give at least",
    ),
    "sampled slowly": (
        lambda: {"position": np.arange(541) * 0.05, "quantities": (strain_record().quantities[0],)},
        {},
        "20 samples a second cannot show vibrations of 4.*, the first natural frequency",
    ),
    "a gap": (
        {"position": np.delete(np.arange(544) * 1e-3, [9, 10, 11])},
        {},
        "has a gap: 3 samples of every 0.001 s",
    ),
    "micrometres": (
        lambda: {"quantities": strains(1e6)},
        {},
        "which no link survives; name its unit",
    ),
    "another kind": (
        lambda: {"quantities": strains(1.0, "strain", "N")},
        {},
        "'strain' is in N, and what is computed",
    ),
    "still": (
        lambda: {"quantities": strains(0.0)},
        {},
        "is the same at all samples; give a record in which",
    ),
    "unknown quantity": (
        {},
        {"quantity": "coupler_strain"},
        "quantity: 'coupler_strain' cannot be laid beside a record over time; did you mean",
    ),
    "not of that unit": (
        {},
        {"quantity": "coupler_mid_deflection_m"},
        "'strain' is in 1, and coupler_mid_deflection_m in m",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_records_over_time_that_cannot_be_compared(name):
    changes, asked, message = REFUSED[name]
    changes = changes() if callable(changes) else changes
    request = flexmech.ComparisonRequest(**({} if "angle" in asked else {"speed": SPEED}) | asked)
    with pytest.raises(InputError, match=message):
        flexmech.compare_with_record(undamped(), over_time(**changes), request)


def frequencies(**more: list[float]) -> flexmech.MeasuredRecord:
    units = {"mode": "", "crank_speed": "rad/s", "frequency": "Hz"}
    values = {"frequency": [45.0, 44.0, 43.0], **more}
    return flexmech.MeasuredRecord(
        "crank_angle",
        np.radians([0.0, 90.0, 180.0]),
        tuple(
            flexmech.MeasuredQuantity(name, units[name], np.array(column))
            for name, column in values.items()
        ),
        "f.csv",
    )


@pytest.mark.parametrize(
    ("record", "fit", "message"),
    [
        (frequencies(), ("damping",), "natural frequencies hardly change with damping"),
        (frequencies(), ("offset",), "frequencies have no offset and no gain"),
        (frequencies(mode=[1.0, 1.5, 2.0]), None, "must number modes from 1"),
        (frequencies(crank_speed=[10.0, 10.0, 20.0]), None, "crank speeds of 10, 20 rad/s, not 0"),
        (frequencies(frequency=[45.0, 0.0, 44.0]), None, "natural frequencies are positive"),
    ],
)
def test_frequencies_that_cannot_be_compared(record, fit, message):
    request = flexmech.ComparisonRequest(speed=0.0, fit=fit)
    with pytest.raises(InputError, match=message):
        flexmech.compare_with_record(undamped(), record, request)


@pytest.mark.parametrize(
    ("quantity", "points"),
    [("mobility", None), ("mobility@coupler:0.5,rocker:0.5", "coupler:0.5,rocker:0.5")],
)
def test_one_of_several_functions_is_chosen_by_name(quantity, points):
    alone = mobility()
    other = replace(alone.quantities[0], name="other", values=7 * alone.quantities[0].values)
    both = replace(alone, quantities=(other, *alone.quantities))
    damped = fitted_engine(undamped(), TIMES)
    found, expected = (
        flexmech.compare_with_record(
            damped, record, flexmech.ComparisonRequest(angle=ANGLE, quantity=name, fit=("gain",))
        )
        for record, name in ((both, quantity), (alone, points))
    )
    assert found.fitted("gain").value == expected.fitted("gain").value


def test_functions_that_cannot_be_compared():
    request = flexmech.ComparisonRequest(angle=ANGLE)
    with pytest.raises(InputError, match="give the crank angle with --angle"):
        flexmech.compare_with_record(undamped(), mobility(), flexmech.ComparisonRequest(SPEED))
    with pytest.raises(InputError, match="is in N; give a displacement, velocity or acceleration"):
        flexmech.compare_with_record(undamped(), mobility("N"), request)
    two = mobility()
    other = replace(two.quantities[0], name="other")
    with pytest.raises(InputError, match="holds 2 frequency-response functions: mobility, other"):
        flexmech.compare_with_record(
            undamped(), replace(two, quantities=(*two.quantities, other)), request
        )
    with pytest.raises(InputError, match="has no column 'third'"):
        flexmech.compare_with_record(
            undamped(),
            replace(two, quantities=(*two.quantities, other)),
            flexmech.ComparisonRequest(angle=ANGLE, quantity="third@coupler:0.5"),
        )
    locked = flexmech.MeasuredQuantity("crank_angle", "rad", np.full(len(two.position), 1.0))
    with pytest.raises(InputError, match=r"crank angles of 57\.2958 deg, not 60"):
        flexmech.compare_with_record(
            undamped(), replace(two, quantities=(*two.quantities, locked)), request
        )


def test_what_a_record_does_not_tell_is_refused():
    """Three factors on three equal frequencies: one equation."""
    angle = np.radians([10.0, 10.0, 10.0])
    found = flexmech.natural_frequencies(undamped(), angle, modes=1)[:, 0]
    quantities = (
        flexmech.MeasuredQuantity("frequency", "Hz", found),
        flexmech.MeasuredQuantity("mode", "", np.ones(3)),
    )
    record = flexmech.MeasuredRecord("crank_angle", angle, quantities)
    names = tuple(f"stiffness:{link}" for link in LINKS)
    request = flexmech.ComparisonRequest(speed=0.0, fit=names)
    with pytest.raises(ComputationError, match=r"does not tell .* apart.*fit fewer of them"):
        flexmech.compare_with_record(undamped(), record, request)


def test_ratio(with_angle):
    attrs = with_angle.dataset.attrs
    ratio = np.pi * attrs["first_frequency"] * with_angle.fitted("damping").value
    assert ratio == pytest.approx(RATIO, rel=0.05)
