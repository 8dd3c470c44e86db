"""``flexmech compare``: a measured record beside the model, its files and its refusals."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from flexmech import Comparison, InputError, MeasuredQuantity, MeasuredRecord, compare_with_record
from tests.support.gauge_record import DAMPING_TIME, ENGINE, SPEED, gauge_record
from tests.support.journeys import Journey

MODEL = "models/aluminium_fourbar.toml"


@cache
def record() -> MeasuredRecord:
    return gauge_record(4)


@pytest.fixture(scope="module")
def strain(tmp_path_factory) -> Path:
    """A record of a gauge at the coupler's middle in the units of a laboratory."""
    path = tmp_path_factory.mktemp("measured") / "strain.csv"
    strain, angle = (quantity.values for quantity in record().quantities)
    rows = (
        f"{1e3 * t:.5f};{np.degrees(a) % 360:.4f};{1e6 * e:.4f}"
        for t, a, e in zip(record().position, angle, strain, strict=True)
    )
    header = "# gauge 3\ntime [ms];crank_angle [deg];strain (um/m)"
    path.write_text("\n".join([header, *rows]), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def journey(strain, tmp_path_factory):
    folder = tmp_path_factory.mktemp("compare") / "out"
    return Journey(folder, "compare", MODEL, strain, "--speed", "190.98593171 rpm", "--no-plots")


@pytest.mark.thorough
def test_the_damping_of_a_strain_gauge_is_found_in_the_models_own_mesh(journey):
    """The record is that of a coarser mesh, 0.4 % off: the interval is widened until it holds."""
    fit = journey.table("fit")
    assert list(fit) == ["parameter", "value", "unit", "standard_error", "p2_5", "p97_5"]
    assert (fit["parameter"].tolist(), fit["unit"].tolist()) == (["damping"], ["s"])
    assert fit["value"][0] == pytest.approx(DAMPING_TIME, rel=0.1)
    assert fit["p2_5"][0] < DAMPING_TIME < fit["p97_5"][0]
    assert fit["standard_error"][0] > 0.05 * fit["value"][0]


def test_curves_stand_side_by_side_and_the_result_loads_back(journey):
    table = journey.table("comparison")
    assert list(table) == ["time_s", "measured", "computed", "residual"]
    np.testing.assert_allclose(
        table["residual"], table["measured"] - table["computed"], atol=2e-8 * 1e-4
    )
    np.testing.assert_allclose(table["time_s"], record().position, atol=1e-8)
    np.testing.assert_allclose(table["measured"], record().quantities[0].values, atol=1e-10)
    result = journey.result()
    assert isinstance(result, Comparison)
    assert result.dataset.attrs["quantity"] == "coupler_mid_strain"
    assert result.fitted("damping").value == pytest.approx(journey.table("fit")["value"][0])
    with pytest.raises(InputError, match="'stiffness' was not fitted"):
        result.fitted("stiffness")


def test_a_record_over_time_is_taken_at_the_greatest_speed_of_the_model(command, strain):
    ended = command("compare", MODEL, strain, "--fit", "none", "--no-plots")
    assert ended.exit_code == 0, ended.stderr
    assert "speed of the model file: 20 rad/s" in ended.stdout


WRONG = {
    "speed and angle": (("--speed", "20", "--angle", "3"), "--speed, --angle"),
    "an angle beyond the turn": (("--angle", "400"), "--angle: got '400'"),
    "a speed is not fitted": (("--speed", "20", "--fit", "speed"), "--fit: 'speed'"),
    "no gauge": (("--speed", "20", "--quantity", "torque"), "--quantity: 'torque'"),
    "another speed": (("--speed", "300 rpm"), "20 rad/s"),
    "a length for a speed": (("--speed", "20 m"), "--speed: got '20 m'"),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_wrong_options_are_refused_in_one_line(command, strain, wrong):
    options, words = WRONG[wrong]
    ended = command("compare", MODEL, strain, *options)
    assert (ended.exit_code, ended.stdout) == (2, "")
    assert words in ended.stderr
    assert ended.stderr.count("\n") == 1
    assert not ended.files


def test_frequencies_need_a_speed_or_an_angle_and_a_record_must_exist(command, tmp_path):
    path = tmp_path / "frequencies.csv"
    path.write_text("crank_angle [deg],frequency [Hz]\n0,44\n90,45\n180,46\n", encoding="utf-8")
    for file, words in ((path, "--speed, --angle"), (tmp_path / "none.csv", "none.csv")):
        ended = command("compare", MODEL, file)
        assert (ended.exit_code, ended.stdout) == (2, "")
        assert words in ended.stderr


# --- records that cannot be compared ------------------------------------------------------------


def gauge(factor: float = 1.0, unit: str = "", samples: int | None = None, angle: bool = True):
    """Quantities of the record of a strain gauge, changed, once they are asked for."""

    def changed():
        strain, turned = record().quantities
        values = MeasuredQuantity("strain", unit, factor * strain.values[:samples])
        return (values, replace(turned, values=turned.values[:samples]))[: 1 + angle]

    return changed


OVER_TIME = {
    "a locked crank": ({}, {"angle": 0.1}, "--speed"),
    "no speed": ({}, {"speed": 0.0}, "not 0"),
    "another speed": ({}, {"speed": 21.0}, "20 rad/s"),
    "too short": (
        {"position": np.arange(20) * 1e-3, "quantities": gauge(samples=20, angle=False)},
        {},
        "too short",
    ),
    "sampled slowly": (
        {"position": np.arange(541) * 0.05, "quantities": gauge(angle=False)},
        {},
        "20 samples a second",
    ),
    "a gap": ({"position": np.delete(np.arange(544) * 1e-3, [9, 10, 11])}, {}, "a gap: 3 samples"),
    "micrometres": ({"quantities": gauge(1e6)}, {}, "name its unit"),
    "a force": ({"quantities": gauge(unit="N")}, {}, "'strain' is in N"),
    "a still machine": ({"quantities": gauge(0.0)}, {}, "the same at all samples"),
    "another unit": ({}, {"quantity": "coupler_mid_deflection_m"}, "coupler_mid_deflection_m in m"),
    "an unknown fit": ({}, {"fit": ("dampling",)}, "did you mean 'damping'"),
    "a fit of no link": ({}, {"fit": ("stiffness:arm",)}, "stiffness:rocker"),
    "nothing and something": ({}, {"fit": ("none", "damping")}, "'none'"),
    "damping of all links and of each": (
        {},
        {"fit": ("damping", *(f"damping:{link}" for link in ("crank", "coupler", "rocker")))},
        "none is left",
    ),
}


@pytest.mark.parametrize("wrong", OVER_TIME)
def test_records_over_time_that_cannot_be_compared_are_refused(wrong):
    changed, asked, words = OVER_TIME[wrong]
    asked = asked if "angle" in asked else {"speed": SPEED} | asked
    changed = {name: value() if callable(value) else value for name, value in changed.items()}
    with pytest.raises(InputError) as raised:
        compare_with_record(ENGINE, replace(record(), **changed), **asked)
    assert words in str(raised.value)


def frequencies(**columns: list[float]) -> MeasuredRecord:
    units = {"mode": "", "crank_speed": "rad/s", "frequency": "Hz"}
    values = {"frequency": [45.0, 44.0, 43.0], **columns}
    quantities = (MeasuredQuantity(name, units[name], np.array(v)) for name, v in values.items())
    return MeasuredRecord("crank_angle", np.radians([0.0, 90.0, 180.0]), tuple(quantities))


def functions(unit: str = "m/N", lines: int = 40, **more: np.ndarray) -> MeasuredRecord:
    columns = {"receptance": (unit, np.ones(lines, dtype=complex))}
    columns |= {n: ("rad" if n == "crank_angle" else unit, values) for n, values in more.items()}
    quantities = tuple(MeasuredQuantity(n, u, v) for n, (u, v) in columns.items())
    return MeasuredRecord("frequency", np.arange(20.0, 20 + lines), quantities)


LOCKED, REST = {"angle": np.radians(60.0)}, {"speed": 0.0}
OTHERS = {
    "damping by frequencies": (frequencies(), REST | {"fit": ("damping",)}, "damping"),
    "a drifted zero of frequencies": (frequencies(), REST | {"fit": ("offset",)}, "no offset"),
    "another crank speed": (frequencies(crank_speed=[10.0, 10.0, 20.0]), REST, "10, 20 rad/s"),
    "no frequency": (frequencies(frequency=[45.0, 0.0, 44.0]), REST, "positive"),
    "a function of a running crank": (functions(), {"speed": 20.0}, "--angle"),
    "a function in newtons": (functions("N"), LOCKED, "in N"),
    "too few lines": (functions(lines=15), LOCKED, "too few"),
    "one of two functions": (functions(other=2j * np.ones(40)), LOCKED, "receptance, other"),
    "no such function": (functions(), LOCKED | {"quantity": "third@coupler:0.5"}, "'third'"),
    "three points": (functions(), LOCKED | {"quantity": "a:0,b:0,c:0"}, "3 points"),
    "another crank angle": (functions(crank_angle=np.ones(40)), LOCKED, "57.2958 deg, not 60"),
}


@pytest.mark.parametrize("wrong", OTHERS)
def test_frequencies_and_functions_that_cannot_be_compared_are_refused(wrong):
    other, asked, words = OTHERS[wrong]
    with pytest.raises(InputError) as raised:
        compare_with_record(ENGINE, other, **asked)
    assert words in str(raised.value)


def test_a_comparison_needs_one_of_speed_and_angle():
    for wrong in ({}, {"speed": 20.0, "angle": 0.0}, {"speed": 20.0, "fit": "damping"}):
        with pytest.raises(InputError):
            compare_with_record(ENGINE, frequencies(), **wrong)
