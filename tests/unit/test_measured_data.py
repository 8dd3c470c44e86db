"""Records from files: units are read, and bad records are refused with the remedy."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexmech.errors import InputError
from flexmech.measured_data import MeasuredRecord, read_csv_record, sampling_interval
from flexmech.measured_data.headers import read_header

TIMES = (0.0, 0.5, 1.0, 1.5)


def record(tmp_path: Path, text: str) -> MeasuredRecord:
    path = tmp_path / "record.csv"
    path.write_text(text, encoding="utf-8")
    return read_csv_record(path)


@pytest.mark.parametrize(
    ("header", "name", "unit", "factor"),
    [
        ("time_s", "time", "s", 1.0),
        ("time [ms]", "time", "s", 1e-3),
        ("time_us", "time", "s", 1e-6),
        ("time [us]", "time", "s", 1e-6),
        ("t / s", "t", "s", 1.0),
        ("frequency [kHz]", "frequency", "Hz", 1e3),
        ("crank angle (degrees)", "crank_angle", "rad", np.pi / 180),
        ("speed_rad_s", "speed", "rad/s", 1.0),
        ("velocity_m_s", "velocity", "m/s", 1.0),
        ("deflection_mm", "deflection", "m", 1e-3),
        ("deflection [um]", "deflection", "m", 1e-6),
        ("torque_Nm", "torque", "N m", 1.0),
        ("damping [%]", "damping", "", 1e-2),
        ("crank_angle_deg", "crank_angle", "rad", np.pi / 180),
        ("coupler_mid_deflection_m", "coupler_mid_deflection", "m", 1.0),
        ("coupler_mid_strain", "coupler_mid_strain", "", 1.0),
        ("strain", "strain", "", 1.0),
        ("strain (um/m)", "strain", "", 1e-6),
        ("strain [µm/m]", "strain", "", 1e-6),
        ("Strain [με]", "Strain", "", 1e-6),
        ("tip deflection [inch]", "tip_deflection", "m", 0.0254),
        ("receptance_real_m_N", "receptance_real", "m/N", 1.0),
        ("acceleration (m/s²)", "acceleration", "m/s^2", 1.0),
        ("pin_A_x_N", "pin_A_x", "N", 1.0),
        ("displacement", "displacement", None, 1.0),
    ],
)
def test_headers_as_flexmech_and_laboratories_write_them(header, name, unit, factor):
    found = read_header(header)
    assert (found.name, found.unit) == (name, unit)
    assert found.factor == pytest.approx(factor, rel=1e-12)


def test_a_unit_that_is_none_is_refused():
    with pytest.raises(InputError, match=r"'furlongz'.* is unknown; write one such as"):
        read_header("deflection [furlongz]")


@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_a_record_over_time_in_si_units(tmp_path, separator):
    rows = [("time [ms]", "strain (um/m)", "gauge"), *((1e3 * t, 10.0 * t, "left") for t in TIMES)]
    text = "# of the rig\n" + "\n".join(separator.join(map(str, row)) for row in rows)
    found = record(tmp_path, text)
    assert found.abscissa == "time"
    assert found.position == pytest.approx(TIMES, rel=1e-15)
    assert found.quantity("strain").values == pytest.approx(1e-5 * np.array(TIMES))
    assert found.quantity("strain (um/m)").unit == ""
    with pytest.raises(InputError, match="'gauge' has no unit; name the unit of every column"):
        found.quantity("gauge")
    with pytest.raises(InputError, match="has no column 'strein'; did you mean 'strain'"):
        found.quantity("strein")


def test_a_frequency_response_is_complex(tmp_path):
    found = record(
        tmp_path,
        "crank_angle_deg,frequency_Hz,receptance_real_m_N,receptance_imag_m_N,coherence\n"
        "0,1,2,3,1\n0,2,4,-5,1\n0,3,1,1,0.5\n",
    )
    assert found.abscissa == "frequency"
    assert found.quantity("receptance").values.tolist() == [2 + 3j, 4 - 5j, 1 + 1j]
    assert found.names == ("crank_angle", "receptance", "coherence")


def test_frequencies_over_the_crank_angle(tmp_path):
    found = record(tmp_path, "crank_angle_deg,frequency_Hz\n0,30\n90,31\n180,32\n")
    assert found.abscissa == "crank_angle"
    assert found.position == pytest.approx([0, np.pi / 2, np.pi])
    assert found.quantity("frequency").values.tolist() == [30, 31, 32]


BAD = {
    "without a header": ("0,1\n0.1,2\n0.2,3\n", "has no header; name the unit of every column"),
    "time without a unit": ("time,strain\n0,1\n1,2\n2,3\n", "no column of time.*'time' without"),
    "ragged": ("time_s,strain\n0,1\n0.5\n1,2\n", "line 3 has 1 fields, the header 2"),
    "decimal comma": ("time_s,strain\n0,1\n0,5,2\n1,2\n", "3 fields.*decimal point"),
    "text in the time": ("time_s,strain\n0,1\nlate,2\n1,2\n", "line 3 has 'late'.* no number"),
    "empty": ("", "holds no record"),
    "short": ("time_s,strain\n0,1\n1,2\n", "holds 2 samples, too few"),
    "twice": ("time_s,strain,strain\n0,1,1\n1,2,2\n2,3,3\n", "two columns are named 'strain'"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_files_are_refused_with_the_remedy(tmp_path, name):
    text, message = BAD[name]
    with pytest.raises(InputError, match=message):
        record(tmp_path, text)


@pytest.mark.parametrize(
    ("cell", "message"),
    [
        ("", "line 3 has no value of 'strain'; give a part of the record without gaps"),
        ("NaN", "line 3 has no value of 'strain'"),
        ("overload", "line 3 has 'overload' in the column 'strain', which is no number"),
        ("1e999", "line 3 has a number in 'strain' that is too large"),
        ("2e60", "line 3 has a number in 'strain' that is too large"),
    ],
)
def test_gaps_and_text_in_the_column_that_is_wanted(tmp_path, cell, message):
    found = record(tmp_path, f"time_s,strain\n0,1\n0.5,{cell}\n1,2\n")
    with pytest.raises(InputError, match=message):
        found.quantity("strain")


def test_numbers_are_taken_whose_squares_are_numbers(tmp_path):
    found = record(tmp_path, "time_s,strain\n0,1\n0.5,9e59\n1,2\n")
    assert found.quantity("strain").values.max() == 9e59


def test_no_file_and_no_text(tmp_path):
    with pytest.raises(InputError, match=r"nothing\.csv: cannot be read: No such file"):
        read_csv_record(tmp_path / "nothing.csv")
    binary = tmp_path / "binary.csv"
    binary.write_bytes(b"\xff\xfe\x00\x81")
    with pytest.raises(InputError, match="is no text in UTF-8"):
        read_csv_record(binary)


def test_even_samples_and_their_rounding(tmp_path):
    step = 1 / 3000
    time = np.arange(200) * step
    assert sampling_interval(time) == pytest.approx(step, rel=1e-12)
    text = "time_s,strain\n" + "".join(f"{t:.4f},0\n" for t in time)
    found = record(tmp_path, text)
    assert found.rounding == pytest.approx(1e-4)
    assert sampling_interval(found.position, rounding=found.rounding) == pytest.approx(step, 1e-3)
    with pytest.raises(InputError, match="steps are unequal"):
        sampling_interval(found.position)


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


def test_gaps_unequal_steps_and_time_that_turns_back():
    time = np.arange(20) * 0.01
    with pytest.raises(InputError, match=r"has a gap: 3 samples of every 0\.01 s are missing from"):
        sampling_interval(np.delete(time, [5, 6, 7]))
    with pytest.raises(InputError, match=r"steps are unequal: one is 0\.013 s.*resample"):
        sampling_interval(time + 0.003 * (time > 0.1))
    with pytest.raises(InputError, match="must increase; if the file holds several runs"):
        sampling_interval(np.concatenate([time, time]))


@pytest.mark.parametrize(
    ("step", "message"),
    [(1.97, "has a gap: 1 samples"), (2.05, "has a gap: 1 samples"), (2.2, "steps are unequal")],
)
def test_a_gap_is_a_whole_number_of_steps_but_for_their_jitter(step, message):
    with pytest.raises(InputError, match=message):
        sampling_interval(np.cumsum([0.0, 1.0, 1.0, step, 1.0, 1.0]))


def test_clocks_may_jitter_by_a_part_of_the_step():
    assert sampling_interval(np.cumsum([0.0, 1.0, 1.015, 0.985, 1.0])) == pytest.approx(1.0)
    with pytest.raises(InputError, match="steps are unequal"):
        sampling_interval(np.cumsum([0.0, 1.0, 1.03, 0.97, 1.0]))
