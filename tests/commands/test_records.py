"""Records of laboratories from files: units are read, and bad records are refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexmech import InputError, MeasuredRecord, read_record
from flexmech.measured_data import sampling_interval

TIMES = (0.0, 0.5, 1.0, 1.5)


def record(folder: Path, text: str) -> MeasuredRecord:
    path = folder / "record.csv"
    path.write_text(text, encoding="utf-8")
    return read_record(path)


def test_what_has_no_end_or_is_too_large_is_no_record(tmp_path):
    large = tmp_path / "record.csv"
    with large.open("wb") as file:
        file.truncate(50_000_001)
    for path, said in ((large, "larger than a record can be"), ("/dev/zero", "device or pipe")):
        with pytest.raises(InputError, match=said):
            read_record(path)


@pytest.mark.parametrize(
    ("header", "name", "unit", "factor"),
    [
        ("deflection_mm", "deflection", "m", 1e-3),
        ("tip deflection [inch]", "tip_deflection", "m", 0.0254),
        ("deflection / um", "deflection", "m", 1e-6),
        ("crank angle (degrees)", "crank_angle", "rad", np.pi / 180),
        ("speed_rad_s", "speed", "rad/s", 1.0),
        ("torque_Nm", "torque", "N m", 1.0),
        ("damping [%]", "damping", "", 1e-2),
        ("strain [µm/m]", "strain", "", 1e-6),
        ("Strain [με]", "Strain", "", 1e-6),
        ("acceleration (m/s²)", "acceleration", "m/s^2", 1.0),
        ("acceleration [g]", "acceleration", "m/s^2", 9.80665),
        ("Accelerance (g/N)", "Accelerance", "m/(N s^2)", 9.80665),
        ("pin_A_x_N", "pin_A_x", "N", 1.0),
        ("coupler_mid_strain", "coupler_mid_strain", "", 1.0),
    ],
)
def test_units_of_headers_become_si(tmp_path, header, name, unit, factor):
    """As flexmech and as laboratories write them."""
    text = f"time [ms];{header}\n" + "".join(f"{1e3 * t};{t + 1}\n" for t in TIMES)
    found = record(tmp_path, text)
    assert (found.abscissa, found.names) == ("time", (name,))
    assert found.position == pytest.approx(TIMES, rel=1e-12)
    quantity = found.quantity(name)
    assert quantity.unit == unit
    assert quantity.values == pytest.approx(factor * (1 + np.array(TIMES)), rel=1e-12)


def test_real_and_imaginary_columns_are_one_complex_function(tmp_path):
    found = record(
        tmp_path,
        "crank_angle_deg,frequency_kHz,receptance_real_m_N,receptance_imag_m_N,coherence\n"
        "0,1,2,3,1\n0,2,4,-5,1\n0,3,1,1,0.5\n",
    )
    assert found.abscissa == "frequency"
    assert found.position.tolist() == [1e3, 2e3, 3e3]
    assert found.quantity("receptance").values.tolist() == [2 + 3j, 4 - 5j, 1 + 1j]


def test_frequencies_are_read_over_the_crank_angle(tmp_path):
    found = record(tmp_path, "crank_angle_deg\tfrequency_Hz\n0\t30\n90\t31\n180\t32\n")
    assert found.abscissa == "crank_angle"
    assert found.position == pytest.approx([0, np.pi / 2, np.pi])
    assert found.quantity("frequency").values.tolist() == [30, 31, 32]


# What is wrong with a file: its text, and the words that name the place or the remedy.
BAD = {
    "no header": ("0,1\n0.1,2\n0.2,3\n", "name the unit of every column"),
    "no unit of time": ("time,strain\n0,1\n1,2\n2,3\n", "'time' without"),
    "an unknown unit": ("time_s,a [furlongz]\n0,1\n1,2\n2,3\n", "'furlongz'"),
    "a column without a unit": ("time_s,gauge\n0,1\n1,2\n2,3\n", "'gauge' has no unit"),
    "a ragged line": ("time_s,strain\n0,1\n0.5\n1,2\n", "line 3 has 1 fields"),
    "a decimal comma": ("time_s,strain\n0,1\n0,5,2\n1,2\n", "decimal point"),
    "a text in the time": ("time_s,strain\n0,1\nlate,2\n1,2\n", "line 3 has 'late'"),
    "nothing": ("", "holds no record"),
    "two samples": ("time_s,strain\n0,1\n1,2\n", "2 samples"),
    "a name twice": ("time_s,strain,strain\n0,1,1\n1,2,2\n2,3,3\n", "two columns"),
    "a gap in a column": ("time_s,strain\n0,1\n0.5,\n1,2\n", "line 3 has no value"),
    "a text in a column": ("time_s,strain\n0,1\n0.5,overload\n1,2\n", "line 3 has 'overload'"),
    "a number too large": ("time_s,strain\n0,1\n0.5,2e60\n1,2\n", "too large"),
    "another column": ("time_s,strein\n0,1\n0.5,3\n1,2\n", "did you mean 'strein'"),
}


@pytest.mark.parametrize("wrong", BAD)
def test_bad_files_are_refused_with_the_place_and_the_remedy(tmp_path, wrong):
    text, words = BAD[wrong]
    column = "gauge" if "gauge" in text else "a" if "furlongz" in text else "strain"
    with pytest.raises(InputError) as raised:
        record(tmp_path, text).quantity(column)
    assert words in str(raised.value)
    assert str(tmp_path / "record.csv") in str(raised.value)


def test_files_that_are_none_or_no_text_are_refused(tmp_path):
    with pytest.raises(InputError, match=r"nothing\.csv: cannot be read"):
        read_record(tmp_path / "nothing.csv")
    binary = tmp_path / "binary.csv"
    binary.write_bytes(b"\xff\xfe\x00\x81")
    with pytest.raises(InputError, match="UTF-8"):
        read_record(binary)


@pytest.mark.parametrize(
    ("unit", "cells", "rounding"),
    [
        ("s", ("0.0e+00", "3.3e-04", "6.7e-04"), 1e-5),
        ("ms", ("0", "0.33", "0.67"), 1e-5),
        ("s", ("0E0", "2e1", "4E1"), 1.0),
    ],
)
def test_the_last_digit_counts_by_its_power_of_ten_and_its_unit(tmp_path, unit, cells, rounding):
    text = f"time [{unit}],strain\n" + "".join(f"{cell},0\n" for cell in cells)
    assert record(tmp_path, text).rounding == pytest.approx(rounding, rel=1e-12)


def test_samples_are_evenly_spaced_but_for_the_rounding_of_the_file(tmp_path):
    """3,000 samples a second written with four decimals."""
    step = 1 / 3000
    time = np.arange(200) * step
    assert sampling_interval(time) == pytest.approx(step, rel=1e-12)
    found = record(tmp_path, "time_s,strain\n" + "".join(f"{t:.4f},0\n" for t in time))
    assert sampling_interval(found.position, rounding=found.rounding) == pytest.approx(step, 1e-3)
    with pytest.raises(InputError, match="unequal"):
        sampling_interval(found.position)
    assert sampling_interval(np.cumsum([0.0, 1.0, 1.015, 0.985, 1.0])) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("steps", "words"),
    [
        ((1.0, 1.0, 1.97, 1.0), "a gap: 1 samples"),
        ((1.0, 1.0, 2.05, 1.0), "a gap: 1 samples"),
        ((1.0, 1.0, 4.0, 1.0), "a gap: 3 samples"),
        ((1.0, 1.0, 2.2, 1.0), "unequal"),
        ((1.0, 1.03, 0.97, 1.0), "unequal"),
        ((1.0, 1.0, -2.0, 1.0), "must increase"),
    ],
)
def test_gaps_unequal_steps_and_time_that_turns_back_are_refused(steps, words):
    with pytest.raises(InputError, match=words):
        sampling_interval(np.cumsum([0.0, *steps]))
