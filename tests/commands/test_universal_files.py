"""Universal files: what is written is read back to the digits of the format, in its columns."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexmech import InputError
from flexmech.measured_data import (
    UffDegreeOfFreedom,
    UffFile,
    UffFrame,
    UffFunction,
    UffMode,
    UffNodes,
    read_uff,
    read_uff_record,
    write_uff,
)

DIGITS = {"rtol": 5e-12, "atol": 0}  # %20.11e
FEW_DIGITS = {"rtol": 5e-6, "atol": 0}  # %13.5e
HIT, SEEN = UffDegreeOfFreedom(3, 2, "coupler"), UffDegreeOfFreedom(7, -1, "rocker")


def random(seed, *shape):
    generator = np.random.default_rng(seed)
    return generator.standard_normal(shape) * 10.0 ** generator.integers(-12, 3, shape)


def function(kind, name, values, quantity, over="none", place=SEEN, remark=""):
    abscissa = "time" if kind == "time response" else "frequency"
    step = np.arange(len(values))
    position = step / 2048.0 if abscissa == "time" else 0.3 + step / 3.0
    return UffFunction(kind, abscissa, position, values, quantity, over, place, HIT, name, remark)


FORCE = function("time response", "force", random(3, 1001), "force", place=HIT)
VELOCITY = function("time response", "seen", random(4, 1001), "velocity")
RECEPTANCE = function(
    *("frequency response", "receptance", random(1, 77) + 1j * random(2, 77)),
    *("displacement", "force", SEEN, "H1 of 3 averages"),
)
COHERENCE = function("coherence", "gamma2", random(5, 77), "none")
UNITS = ["N", "m/s", "m/N", ""]


def contents() -> UffFile:
    nodes = UffNodes(np.array([3, 7, 12]), random(6, 3, 3), np.array([1, 2, 2]))
    modes = tuple(
        UffMode(
            number,
            complex(*random(10 + number, 2)),
            nodes.label,
            random(20 + number, 3, 3) + 1j * random(30 + number, 3, 3),
            complex(*random(40 + number, 2)),
            f"mode {number}",
        )
        for number in (1, 2)
    )
    frames = UffFrame(1, "coupler", (0.1, -0.2), 0.7), UffFrame(2, "rocker", (0.3, 0.0), -2.1)
    functions = FORCE, VELOCITY, RECEPTANCE, COHERENCE
    return UffFile("four-bar", "at 96.9 deg", "flexmech", nodes, frames, functions, modes)


@pytest.fixture
def file(tmp_path):
    return write_uff(tmp_path / "test.uff", contents())


def test_all_data_sets_are_read_back_to_the_digits_of_the_format(file):
    wrote, read = contents(), read_uff(file)
    assert (read.model, read.description, read.program) == (
        *("four-bar", "at 96.9 deg", "flexmech"),
    )
    np.testing.assert_array_equal(read.nodes.label, wrote.nodes.label)
    np.testing.assert_array_equal(read.nodes.frame, wrote.nodes.frame)
    np.testing.assert_allclose(read.nodes.position, wrote.nodes.position, **FEW_DIGITS)
    for one, same in zip(wrote.frames, read.frames, strict=True):
        assert (one.label, one.name) == (same.label, same.name)
        assert (*same.origin, same.angle) == pytest.approx((*one.origin, one.angle), abs=2e-5)
    for one, same in zip(wrote.functions, read.functions, strict=True):
        for field in ("kind", "abscissa", "quantity", "over", "response", "reference", "name"):
            assert getattr(same, field) == getattr(one, field)
        assert same.remark == one.remark
        np.testing.assert_allclose(same.position, one.position, **FEW_DIGITS)
        np.testing.assert_allclose(same.values.real, one.values.real, **DIGITS)
        np.testing.assert_allclose(same.values.imag, one.values.imag, **DIGITS)
    assert [each.unit for each in read.functions] == UNITS
    for one, same in zip(wrote.modes, read.modes, strict=True):
        assert (same.number, same.name) == (one.number, one.name)
        np.testing.assert_array_equal(same.nodes, one.nodes)
        for field in ("pole", "modal_a", "shape"):
            expected, got = (np.asarray(getattr(of, field)) for of in (one, same))
            np.testing.assert_allclose(got.real, expected.real, **FEW_DIGITS)
            np.testing.assert_allclose(got.imag, expected.imag, **FEW_DIGITS)


def test_what_was_read_is_written_the_same_again(file, tmp_path):
    again = write_uff(tmp_path / "again.uff", read_uff(file))
    # The header before data set 164 holds the time of writing.
    written, rewritten = (path.read_text().split("   164", 1)[1] for path in (file, again))
    assert rewritten == written


def test_fields_stand_in_the_columns_of_the_format(file):
    """Fields of data sets 58, 15 and 164, which other programs read by position."""
    blocks = {}
    for block in file.read_text().split("    -1\n")[1::2]:
        lines = block.splitlines()
        blocks.setdefault(int(lines[0]), []).append(lines[1:])
    assert list(blocks) == [151, 164, 18, 15, 58, 55]
    receptance = blocks[58][2]
    sixth, seventh = receptance[5], receptance[6]
    columns = [(0, 5), (15, 20), (31, 41), (41, 51), (51, 55), (56, 66), (66, 76), (76, 80)]
    fields = [sixth[begin:end].strip() for begin, end in columns]
    assert fields == ["4", "0", "rocker", "7", "-1", "coupler", "3", "2"]
    assert [int(seventh[10 * n : 10 * n + 10]) for n in range(3)] == [6, 77, 1]
    assert [float(seventh[30 + 13 * n : 43 + 13 * n]) for n in range(2)] == [0.3, 0.333333]
    assert [int(receptance[n][:10]) for n in (7, 8, 9)] == [18, 8, 13]
    numbers = [float(receptance[11][20 * n : 20 * n + 20]) for n in range(2)]
    assert complex(*numbers) == pytest.approx(RECEPTANCE.values[0], rel=5e-12)
    assert int(blocks[164][0][0][:10]) == 1
    assert int(blocks[15][0][1][20:30]) == 2


def test_millimetres_and_millinewtons_of_data_set_164_become_si(file, tmp_path):
    text = file.read_text()
    metres, millimetres = (
        f"{f:25.16e}{f:25.16e}{1.0:25.16e}".replace("e+", "D+") for f in (1.0, 1000.0)
    )
    assert metres in text
    other = tmp_path / "mm.uff"
    for axis, label in (("Force", "N"), ("Velocity", "m/s"), ("Displacement", "m")):
        text = text.replace(f"{axis:21}{label} ", f"{axis:21}m{label}")
    other.write_text(text.replace(metres, millimetres))
    si, mm = read_uff(file), read_uff(other)
    np.testing.assert_allclose(mm.nodes.position, si.nodes.position / 1000.0)
    for got, one, factor in zip(mm.functions, si.functions, (1e-3, 1e-3, 1.0, 1.0), strict=True):
        np.testing.assert_allclose(got.values, one.values * factor)
    assert [each.unit for each in mm.functions] == UNITS


def test_without_data_set_164_the_labels_of_the_axes_tell_the_unit(tmp_path):
    file = write_uff(tmp_path / "two.uff", UffFile(functions=(FORCE, VELOCITY)))
    text = file.read_text()
    start = text.index("    -1\n   164")
    bare = text[:start] + text[text.index("    -1\n", start + 8) + len("    -1\n") :]
    file.write_text(bare.replace("Velocity             m/s ", "Velocity             mm/s"))
    read = read_uff(file)
    np.testing.assert_allclose(read.functions[1].values, VELOCITY.values * 1e-3)
    assert [each.unit for each in read.functions] == ["N", "m/s"]
    file.write_text(bare.replace("Velocity             m/s ", "Velocity             NONE"))
    assert read_uff(file).functions[1].unit is None
    with pytest.raises(InputError, match="data set 164"):
        read_uff_record(file).quantity("seen")


ACCELERANCE = replace(RECEPTANCE, quantity="acceleration", name="H")
AXIS = {"acceleration": "Acceleration         m/s^2", "force": "Force                N    "}


def relabelled(folder, units: bool = True, **labels: str):
    """A file of an accelerance with other labels of its axes, with data set 164 or without."""
    file = write_uff(folder / "labels.uff", UffFile(functions=(ACCELERANCE,)))
    text = file.read_text()
    for axis, label in labels.items():
        assert AXIS[axis] in text
        text = text.replace(AXIS[axis], f"{AXIS[axis][:21]}{label:5}")
    if not units:
        start = text.index("    -1\n   164")
        text = text[:start] + text[text.index("    -1\n", start + 8) + len("    -1\n") :]
    file.write_text(text)
    return file


@pytest.mark.parametrize(
    ("labels", "factor"),
    [
        ({"acceleration": "g"}, 9.80665),
        ({"acceleration": "mg"}, 9.80665e-3),
        ({"acceleration": "g/N", "force": "NONE"}, 9.80665),
        ({"acceleration": "g", "force": "lbf"}, 9.80665 / 4.4482216152605),
        ({"acceleration": "in/s2", "force": "lb"}, 0.0254 / 4.4482216152605),
    ],
)
def test_labels_without_data_set_164_count_and_those_against_it_are_refused(
    tmp_path, labels, factor
):
    """A g of an acceleration is standard gravity, and a pound of a force is a pound of force."""
    read = read_uff(relabelled(tmp_path, False, **labels)).functions[0]
    assert read.unit == "m/(N s^2)"
    np.testing.assert_allclose(read.values, factor * ACCELERANCE.values)
    ratio = {"g": "9.80665", "mg": "101.972"}.get(labels["acceleration"], "a factor of")
    with pytest.raises(InputError, match=f"'H' is labelled in .*data set 164 says .*{ratio}"):
        read_uff_record(relabelled(tmp_path, **labels)).quantity("H")


@pytest.mark.parametrize(
    ("labels", "words"),
    [
        ({"acceleration": "mm"}, "labelled in mm, and by its data type it is in m/s.2"),
        ({"acceleration": "m/s2", "force": "V"}, "labelled in V"),
    ],
)
def test_labels_of_another_kind_than_the_data_type_are_refused(tmp_path, labels, words):
    for units in (True, False):
        with pytest.raises(InputError, match=words):
            read_uff_record(relabelled(tmp_path, units, **labels)).quantity("H")
    plain = read_uff(relabelled(tmp_path, acceleration="EU")).functions[0]
    assert plain.unit == "m/(N s^2)"


def test_an_axis_in_kilohertz_is_refused(tmp_path):
    file = relabelled(tmp_path)
    file.write_text(
        file.read_text().replace("Frequency            Hz ", "Frequency            kHz")
    )
    with pytest.raises(InputError, match="axis in kHz, and universal files count in Hz"):
        read_uff_record(file).quantity("H")


def test_a_function_without_any_unit_is_named_by_compare(tmp_path, command):
    file = relabelled(tmp_path, False, acceleration="NONE", force="NONE")
    ended = command("compare", "models/aluminium_fourbar.toml", file, "--angle", "60")
    assert (ended.exit_code, ended.stdout) == (2, "")
    assert "'H' has no unit; export it with data set 164" in ended.stderr


def test_numbers_are_read_as_fortran_writes_them_and_as_many_as_announced(tmp_path):
    """D for the exponent of double precision, in text in small letters too; zeros fill a line."""
    file = write_uff(tmp_path / "x.uff", UffFile(functions=(RECEPTANCE, COHERENCE)))
    wrote, text = read_uff(file), file.read_text()
    lines = [
        line.replace("e-", "D-").replace("e+", "d+") if line[:1] in " -" and "e" in line else line
        for line in text.splitlines()
    ]
    odd = next(n for n, line in enumerate(lines) if "        77         1" in line)
    last = next(n for n in range(odd, len(lines)) if lines[n] == "    -1") - 1
    lines[last] = f"{lines[last]:40}" + 2 * f"{0.0:20.11e}"
    file.write_text("\n".join(lines) + "\n")
    read = read_uff(file)
    for one, same in zip(wrote.functions, read.functions, strict=True):
        np.testing.assert_array_equal(same.values, one.values)
        np.testing.assert_array_equal(same.position, one.position)
    file.write_text(text.replace("        77         1", "        97         1"))
    with pytest.raises(InputError, match="77 of the 97 values"):
        read_uff(file)


def test_a_record_is_made_of_the_functions_over_one_abscissa(file, tmp_path):
    record = read_uff_record(file)
    assert (record.abscissa, record.names) == ("frequency", ("receptance", "gamma2"))
    assert record.quantity("receptance").unit == "m/N"
    np.testing.assert_allclose(record.quantity("receptance").values, RECEPTANCE.values)
    same_names = UffFile(functions=(FORCE, replace(VELOCITY, name="force"), VELOCITY))
    record = read_uff_record(write_uff(tmp_path / "time.uff", same_names))
    assert record.names == ("force_3_+2_3_+2", "velocity_7_-1_3_+2", "seen")


@pytest.mark.parametrize("moved", [True, False])
def test_a_function_over_another_time_than_the_first_is_refused(tmp_path, moved):
    shift = 0.3 * FORCE.position[1] * moved
    count = len(FORCE.position) if moved else 9
    other = replace(VELOCITY, position=FORCE.position[:count] + shift, values=FORCE.values[:count])
    path = write_uff(tmp_path / "two.uff", UffFile(functions=(FORCE, other)))
    with pytest.raises(InputError, match="another time"):
        read_uff_record(path).quantity("seen")


def test_a_file_is_replaced_whole_or_not_at_all(file):
    before = file.read_bytes()
    with pytest.raises(InputError, match="not finite"):
        write_uff(file, UffFile(functions=(replace(FORCE, values=np.full(1001, np.nan)),)))
    assert file.read_bytes() == before
    assert [path.name for path in file.parent.iterdir()] == [file.name]
    write_uff(file, UffFile(model="new"))
    assert read_uff(file).functions == ()


@pytest.mark.parametrize(
    "text",
    [
        "time [s], force [N]\n0, 1\n",
        "    -1\n    58\nNONE\nNONE\n    -1\n",
        "    -1\n   164\n         1       SI units         1\n",
    ],
)
def test_what_is_no_universal_file_is_refused_with_its_name(tmp_path, text):
    path = tmp_path / "bad.uff"
    path.write_text(text)
    with pytest.raises(InputError) as raised:
        read_uff(path)
    assert str(path) in str(raised.value)
    with pytest.raises(InputError, match="no such file"):
        read_uff(tmp_path / "nowhere.uff")


def written(folder, **changed):
    return write_uff(folder / "x.uff", UffFile(functions=(replace(FORCE, **changed),)))


def test_contents_that_the_format_cannot_hold_are_refused(tmp_path):
    """Steps are equal to a thousandth of a step: what six digits can tell."""
    step = FORCE.position[1]
    one_late = step * (np.arange(1001) == 500)
    assert written(tmp_path, position=FORCE.position + 5e-4 * one_late).exists()
    for changed, remedy in (
        ({"position": FORCE.position[:5]}, "one for each"),
        ({"position": FORCE.position[:1], "values": FORCE.values[:1]}, "2 or more"),
        ({"position": FORCE.position + 2e-3 * one_late}, "equal steps"),
        ({"over": "strain"}, "no data type"),
    ):
        with pytest.raises(InputError, match=remedy):
            written(tmp_path, **changed)
    with pytest.raises(InputError, match="make it first"):
        write_uff(tmp_path / "nowhere" / "x.uff", UffFile())
