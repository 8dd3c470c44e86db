"""Universal files: what is written is read back to the digits of the format, and its fields stand
where the format has them.
"""

from __future__ import annotations

import importlib.util
from dataclasses import replace

import numpy as np
import pytest

from flexmech.errors import InputError
from flexmech.measured_data import (
    UffDegreeOfFreedom,
    UffFile,
    UffFrame,
    UffFunction,
    UffMode,
    UffNodes,
    UffTrace,
    read_uff,
    read_uff_record,
    write_uff,
)
from flexmech.measured_data.uff_datasets import datasets_of
from flexmech.measured_data.uff_units import quantity_of

DIGITS = {"rtol": 5e-12, "atol": 0}  # %20.11e
FEW_DIGITS = {"rtol": 5e-6, "atol": 0}  # %13.5e
HIT, SEEN = UffDegreeOfFreedom(3, 2, "coupler"), UffDegreeOfFreedom(7, -1, "rocker")


def random(seed, *shape):
    generator = np.random.default_rng(seed)
    return generator.standard_normal(shape) * 10.0 ** generator.integers(-12, 3, shape)


def functions():
    time, frequency = np.arange(1001) / 2048.0, 0.3 + np.arange(77) / 3.0
    receptance = random(1, 77) + 1j * random(2, 77)
    return (
        UffFunction(
            "time response", "time", time, random(3, 1001), "force", "none", HIT, HIT, "force"
        ),
        UffFunction(
            "time response", "time", time, random(4, 1001), "velocity", "none", SEEN, HIT, "seen"
        ),
        UffFunction(
            "frequency response",
            "frequency",
            frequency,
            receptance,
            "displacement",
            "force",
            SEEN,
            HIT,
            "receptance",
            "H1 of 3 averages",
        ),
        UffFunction(
            "coherence", "frequency", frequency, random(5, 77), "none", "none", SEEN, HIT, "gamma2"
        ),
    )


def contents():
    nodes = UffNodes(np.array([3, 7, 12]), random(6, 3, 3), np.array([1, 2, 2]))
    modes = tuple(
        UffMode(
            number,
            complex(*random(10 + number, 2)),
            np.array([3, 7, 12]),
            random(20 + number, 3, 3) + 1j * random(30 + number, 3, 3),
            complex(*random(40 + number, 2)),
            f"mode {number}",
        )
        for number in (1, 2)
    )
    return UffFile(
        "Aluminium four-bar",
        "crank at 96.9 deg",
        "flexmech",
        nodes,
        (UffFrame(1, "coupler", (0.1, -0.2), 0.7), UffFrame(2, "rocker", (0.3, 0.0), -2.1)),
        (UffTrace("coupler", (3, 7)), UffTrace("rocker", (7, 12, 0, 3))),
        functions(),
        modes,
    )


@pytest.fixture
def file(tmp_path):
    return write_uff(tmp_path / "test.uff", contents())


def test_all_data_sets_are_read_back_to_the_digits_of_the_format(file):
    wrote, read = contents(), read_uff(file)
    assert (read.model, read.description, read.program) == (
        wrote.model,
        wrote.description,
        wrote.program,
    )
    assert read.traces == wrote.traces
    assert read.others == ()
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
        # First value and step of the abscissa have six digits.
        np.testing.assert_allclose(same.position, one.position, **FEW_DIGITS)
        np.testing.assert_allclose(same.values.real, one.values.real, **DIGITS)
        np.testing.assert_allclose(same.values.imag, one.values.imag, **DIGITS)
    assert [each.unit for each in read.functions] == ["N", "m/s", "m/N", ""]
    for one, same in zip(wrote.modes, read.modes, strict=True):
        assert (same.number, same.name) == (one.number, one.name)
        np.testing.assert_array_equal(same.nodes, one.nodes)
        for field in ("pole", "modal_a", "shape"):
            expected, got = (np.asarray(getattr(of, field)) for of in (one, same))
            np.testing.assert_allclose(got.real, expected.real, **FEW_DIGITS)
            np.testing.assert_allclose(got.imag, expected.imag, **FEW_DIGITS)


def test_what_was_read_is_written_the_same_again(file, tmp_path):
    again = write_uff(tmp_path / "again.uff", read_uff(file))

    def lines(path):  # without the header, which holds the time of writing
        return path.read_text().split("   164", 1)[1]

    assert lines(again) == lines(file)


def test_fields_stand_where_the_format_has_them(file):
    """Columns of the formats that other programs read by position: data sets 58, 15, 164."""
    blocks = {}
    for block in file.read_text().split("    -1\n")[1::2]:
        lines = block.splitlines()
        blocks.setdefault(int(lines[0]), []).append(lines[1:])
    assert list(blocks) == [151, 164, 18, 15, 82, 58, 55]
    receptance = blocks[58][2]
    sixth = receptance[5]
    fields = [sixth[:5], sixth[15:20], sixth[31:41], sixth[41:51], sixth[51:55]]
    assert [field.strip() for field in fields] == ["4", "0", "rocker", "7", "-1"]
    assert [sixth[56:66].strip(), sixth[66:76].strip(), sixth[76:80].strip()] == [
        "coupler",
        "3",
        "2",
    ]
    seventh = receptance[6]
    assert [int(seventh[10 * n : 10 * n + 10]) for n in range(3)] == [6, 77, 1]
    assert [float(seventh[30 + 13 * n : 43 + 13 * n]) for n in range(2)] == [0.3, 0.333333]
    assert [int(receptance[n][:10]) for n in (7, 8, 9)] == [18, 8, 13]
    numbers = [float(receptance[11][20 * n : 20 * n + 20]) for n in range(2)]
    assert complex(*numbers) == pytest.approx(functions()[2].values[0], rel=5e-12)
    assert int(blocks[164][0][0][:10]) == 1
    assert int(blocks[15][0][1][20:30]) == 2


def test_units_of_the_file_become_si(file, tmp_path):
    """Millimetres and millinewtons, as data set 164 of such a file has them."""
    text = file.read_text()
    old = f"{1.0:25.16e}{1.0:25.16e}{1.0:25.16e}".replace("e+", "D+")
    assert old in text
    new = f"{1000.0:25.16e}{1000.0:25.16e}{1.0:25.16e}".replace("e+", "D+")
    other = tmp_path / "mm.uff"
    other.write_text(text.replace(old, new))
    si, mm = read_uff(file), read_uff(other)
    np.testing.assert_allclose(mm.nodes.position, si.nodes.position / 1000.0)
    for number, factor in enumerate((1e-3, 1e-3, 1.0, 1.0)):
        np.testing.assert_allclose(
            mm.functions[number].values, si.functions[number].values * factor
        )
    assert mm.functions[1].unit == "m/s"


def test_without_data_set_164_the_labels_of_the_axes_tell_the_unit(file, tmp_path):
    text = file.read_text()
    start = text.index("    -1\n   164")
    end = text.index("    -1\n", start + 8) + len("    -1\n")
    bare = text[:start] + text[end:]
    other = tmp_path / "bare.uff"
    other.write_text(bare.replace("Velocity             m/s ", "Velocity             mm/s"))
    read = read_uff(other)
    np.testing.assert_allclose(read.functions[1].values, functions()[1].values * 1e-3)
    assert [each.unit for each in read.functions] == ["N", "m/s", "m/N", ""]
    other.write_text(bare.replace("Velocity             m/s ", "Velocity             NONE"))
    assert read_uff(other).functions[1].unit is None


def test_a_record_is_made_of_the_functions_over_one_abscissa(file, tmp_path):
    record = read_uff_record(file)
    assert (record.abscissa, record.names) == ("frequency", ("receptance", "gamma2"))
    assert record.quantity("receptance").unit == "m/N"
    np.testing.assert_allclose(record.quantity("receptance").values, functions()[2].values)
    first, second, *_ = functions()
    same_names = UffFile(functions=(first, replace(second, name="force"), second))
    record = read_uff_record(write_uff(tmp_path / "time.uff", same_names))
    assert record.abscissa == "time"
    assert record.names == ("force_3_+2_3_+2", "velocity_7_-1_3_+2", "seen")


def test_functions_that_cannot_be_used_say_why(file, tmp_path):
    first, second, *_ = functions()
    short = replace(second, name="short", position=first.position[:9], values=first.values[:9])
    path = write_uff(tmp_path / "two.uff", UffFile(functions=(first, short)))
    with pytest.raises(InputError, match="another time than the first"):
        read_uff_record(path).quantity("short")
    late = replace(second, name="late", position=first.position + 0.3 * first.position[1])
    moved = write_uff(tmp_path / "late.uff", UffFile(functions=(first, late)))
    with pytest.raises(InputError, match="another time than the first"):
        read_uff_record(moved).quantity("late")
    text = path.read_text().replace(
        "        13    0    0    0 Force", "         0    0    0    0 Force"
    )
    path.write_text(text.replace("N                   ", "NONE                "))
    with pytest.raises(InputError, match=r"has no unit.*data set 164"):
        read_uff_record(path).quantity("force")


def test_writing_replaces_a_file_whole_or_not_at_all(file):
    before = file.read_bytes()
    bad = replace(functions()[0], values=np.full(1001, np.nan))
    with pytest.raises(InputError, match="not finite"):
        write_uff(file, UffFile(functions=(bad,)))
    assert file.read_bytes() == before
    assert [path.name for path in file.parent.iterdir()] == [file.name]
    write_uff(file, UffFile(model="new"))
    assert read_uff(file).functions == ()


@pytest.mark.parametrize(
    ("text", "remedy"),
    [
        ("time [s], force [N]\n0, 1\n", "holds no data set"),
        ("    -1\n    58\nNONE\nNONE\n    -1\n", "export it anew"),
        ("    -1\n   164\n         1       SI units         1\n", "holds no data set"),
    ],
)
def test_what_is_no_universal_file_is_refused_in_one_line(tmp_path, text, remedy):
    path = tmp_path / "bad.uff"
    path.write_text(text)
    with pytest.raises(InputError) as raised:
        read_uff(path)
    assert remedy in str(raised.value)
    assert str(path) in str(raised.value)


def test_bad_contents_are_refused(tmp_path):
    first = functions()[0]
    with pytest.raises(InputError, match="one for each"):
        replace(first, position=first.position[:5])
    with pytest.raises(InputError, match="2 or more"):
        replace(first, position=first.position[:1], values=first.values[:1])
    uneven = replace(first, position=first.position**2)
    with pytest.raises(InputError, match="equal steps"):
        write_uff(tmp_path / "x.uff", UffFile(functions=(uneven,)))
    odd = replace(first, over="strain")
    with pytest.raises(InputError, match="no data type"):
        write_uff(tmp_path / "x.uff", UffFile(functions=(odd,)))
    with pytest.raises(InputError, match="make it first"):
        write_uff(tmp_path / "nowhere" / "x.uff", UffFile())
    with pytest.raises(InputError, match="no such file"):
        read_uff(tmp_path / "nowhere.uff")


def test_texts_are_cut_to_the_room_that_the_format_has():
    header = datasets_of(UffFile(description=200 * "x"))[0]
    assert len(header["description"]) == 80
    where = replace(HIT, entity="coupler of the machine")
    function = replace(functions()[0], reference=where)
    [written] = [each for each in datasets_of(UffFile(functions=(function,))) if each["type"] == 58]
    assert written["ref_ent_name"] == "coupler of"


@pytest.mark.parametrize(("jitter", "refused"), [(5e-4, False), (2e-3, True)])
def test_an_abscissa_is_even_to_what_the_format_can_tell(jitter, refused):
    function = functions()[0]
    step = function.position[1]
    moved = function.position + jitter * step * (np.arange(function.position.size) == 500)
    uneven = UffFile(functions=(replace(function, position=moved),))
    if refused:
        with pytest.raises(InputError, match="is unevenly spaced; interpolate"):
            datasets_of(uneven)
    else:
        assert len(datasets_of(uneven)) == 3


def test_reaction_forces_are_forces():
    assert quantity_of(9) == quantity_of(13) == "force"


def test_units_are_told_with_the_zero_of_celsius():
    assert datasets_of(UffFile())[1]["temp_offset"] == 273.15


def test_without_the_extra_the_message_names_it(monkeypatch, tmp_path):
    find = importlib.util.find_spec
    monkeypatch.setattr(
        "flexmech.measured_data.uff_files.find_spec",
        lambda name: None if name == "pyuff" else find(name),
    )
    with pytest.raises(InputError, match=r"pyuff.*flexmech\[modal-test\]"):
        write_uff(tmp_path / "x.uff", UffFile())
