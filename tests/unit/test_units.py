"""The door for units: what passes, what it becomes, and what is refused with which remedy."""

from __future__ import annotations

import contextlib
import math
import re
from decimal import Decimal

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from flexmech import units
from flexmech.errors import InputError
from flexmech.quantity_lists import Quantities, parse_quantities
from flexmech.unit_registry import COMMON_UNITS, base_units, base_units_by_pint
from flexmech.units import Dimension, from_si, parse_number, parse_quantity

ALL = [value for value in vars(units).values() if isinstance(value, Dimension)]


@pytest.mark.parametrize(
    ("text", "dimension", "expected"),
    [
        ("279.4 mm", units.LENGTH, 0.2794),
        ("279.4mm", units.LENGTH, 0.2794),
        ("  28 cm ", units.LENGTH, 0.28),
        ("11 inch", units.LENGTH, 0.2794),
        ("20 µm", units.LENGTH, 2e-5),
        ("68.9 GPa", units.STRESS, 68.9e9),
        ("2.698e-9 t/mm^3", units.DENSITY, 2698.0),
        ("2.7 g/cm^3", units.DENSITY, 2700.0),
        ("2.7 g/cm³", units.DENSITY, 2700.0),
        ("9.81 m/s^2", units.ACCELERATION, 9.81),
        ("-9.81 m s^-2", units.ACCELERATION, -9.81),
        ("20 rad/s", units.ANGULAR_SPEED, 20.0),
        ("300 rpm", units.ANGULAR_SPEED, 10 * math.pi),
        ("5 rev/s", units.ANGULAR_SPEED, 10 * math.pi),
        ("90 deg/s", units.ANGULAR_SPEED, math.pi / 2),
        ("-20 rad/s", units.ANGULAR_SPEED, -20.0),
        ("50 Hz", units.FREQUENCY, 50.0),
        ("1.2 kHz", units.FREQUENCY, 1200.0),
        ("2e-5 s", units.TIME, 2e-5),
        ("2e6 N mm^2", units.BENDING_STIFFNESS, 2.0),
        ("0.3 g mm", units.ROTARY_INERTIA, 3e-7),
        ("25 g", units.MASS, 0.025),
        ("0.5 %", units.RATIO, 0.005),
        ("0.5%", units.RATIO, 0.005),
        ("0.3", units.RATIO, 0.3),
        (0.3, units.RATIO, 0.3),
        (0, units.RATIO, 0.0),
    ],
)
def test_text_becomes_the_nearest_si_float(
    text: object, dimension: Dimension, expected: float
) -> None:
    # Equal to the last bit: the conversion is decimal, so nothing is lost before rounding.
    assert parse_quantity(text, dimension) == expected


def test_three_hundred_rpm_in_rad_per_second() -> None:
    assert parse_quantity("300 rpm", units.ANGULAR_SPEED) == pytest.approx(31.41592653589793)


@pytest.mark.parametrize("dimension", ALL, ids=lambda dimension: dimension.name)
def test_every_example_is_understood(dimension: Dimension) -> None:
    for example in dimension.examples:
        assert math.isfinite(parse_quantity(example, dimension))


@pytest.mark.parametrize("unit", COMMON_UNITS)
def test_common_units_are_what_pint_finds(unit: str) -> None:
    assert base_units(unit) == base_units_by_pint(unit)


def test_a_default_unit_serves_bare_numbers_alone() -> None:
    assert parse_quantity("10", units.ANGULAR_SPEED, default_unit="rad/s") == 10.0
    assert parse_quantity("60", units.ANGULAR_SPEED, default_unit="rpm") == 2 * math.pi
    assert parse_quantity("60 rpm", units.ANGULAR_SPEED, default_unit="rad/s") == 2 * math.pi


@pytest.mark.parametrize(
    ("value", "dimension", "message"),
    [
        ("100", units.LENGTH, r"'100', which has no unit; write a length .*\"279.4 mm\""),
        (100, units.LENGTH, r"the number 100, which has no unit.*as text"),
        (True, units.LENGTH, r"True, which is not a length"),
        (True, units.RATIO, r"True, which is not a ratio"),
        (None, units.MASS, r"None, which is not a mass"),
        (["1 mm"], units.LENGTH, r"which is not a length"),
        ("", units.LENGTH, r"does not begin with a number"),
        ("mm", units.LENGTH, r"does not begin with a number"),
        ("nan mm", units.LENGTH, r"does not begin with a number"),
        ("inf mm", units.LENGTH, r"does not begin with a number"),
        ("-inf mm", units.LENGTH, r"does not begin with a number"),
        (math.nan, units.RATIO, r"does not begin with a number"),
        ("1e400 mm", units.LENGTH, r"too large"),
        ("1e308 km", units.LENGTH, r"too large"),
        ("1e99999999999999999999 mm", units.LENGTH, r"too large"),
        # Pint alone reads this as 15 mm.
        ("1,5 mm", units.LENGTH, r"decimal point"),
        ("1_000 mm", units.LENGTH, r"no separators"),
        ("1.5.2 mm", units.LENGTH, r"'\.2 mm' follows the number"),
        ("3 furlong mm", units.LENGTH, r"is not that of a length"),
        ("3 mm mm", units.LENGTH, r"\(meter \*\* 2\) is not that of a length"),
        ("3 foo", units.LENGTH, r"unit 'foo' is unknown; write a length"),
        # Pint alone reads these as "3 m".
        ("3 m$", units.LENGTH, r"unit 'm\$' is unknown"),
        ("3 m;", units.LENGTH, r"unit 'm;' is unknown"),
        ("2*3 mm", units.LENGTH, r"unknown"),
        ("3 (mm", units.LENGTH, r"unknown"),
        ("3 m/0", units.LENGTH, r"unknown"),
        ("3 m//s", units.LENGTH, r"unknown"),
        ("68.9 gpa", units.STRESS, r"unit 'gpa' is unknown; did you mean 'GPa'\?"),
        ("300 RPM", units.ANGULAR_SPEED, r"did you mean 'rpm'\?"),
        ("10 mil", units.LENGTH, r"'mil' \(radian\) is not that of a length"),
        ("20 °C", units.LENGTH, r"\(kelvin\) is not that of a length"),
        ("5 Hz", units.ANGULAR_SPEED, r"is a frequency and not an angular speed.*\"5 rps\""),
        ("5 1/s", units.ANGULAR_SPEED, r"is a frequency and not an angular speed"),
        ("5 m/s", units.ANGULAR_SPEED, r"is not that of an angular speed"),
        ("50 rad/s", units.FREQUENCY, r"is an angular speed and not a frequency.*\"50 Hz\""),
        ("50 cps", units.FREQUENCY, r"is not that of a frequency"),
        ("5 deg", units.RATIO, r"is not that of a ratio"),
        ("5 %%", units.RATIO, r"unknown"),
        ("5 GPa", units.FORCE, r"is not that of a force"),
    ],
)
def test_what_is_no_such_quantity_is_refused(
    value: object, dimension: Dimension, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        parse_quantity(value, dimension)


@given(
    st.floats(min_value=-1e30, max_value=1e30).filter(lambda x: x == 0 or abs(x) > 1e-30),
    st.sampled_from([("mm", 1e-3), ("km", 1e3), ("µm", 1e-6), ("inch", 0.0254), ("m", 1.0)]),
)
def test_numbers_survive_the_way_through_text(number: float, unit: tuple[str, float]) -> None:
    name, factor = unit
    assert parse_quantity(f"{number!r} {name}", units.LENGTH) == pytest.approx(
        number * factor, rel=4e-16, abs=0
    )


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_the_si_unit_changes_no_bit(number: float) -> None:
    assert parse_quantity(f"{number!r} rad/s", units.ANGULAR_SPEED) == number


@given(st.text(max_size=12), st.sampled_from(ALL))
def test_any_text_after_a_number_is_a_quantity_or_an_input_error(
    text: str, dimension: Dimension
) -> None:
    with contextlib.suppress(InputError):
        assert math.isfinite(parse_quantity(f"1.5 {text}", dimension))


@given(st.text(alphabet="mskgNHPa%/^*() -23radpo²µ", max_size=10), st.sampled_from(ALL))
def test_any_heap_of_unit_letters_is_a_quantity_or_an_input_error(
    text: str, dimension: Dimension
) -> None:
    with contextlib.suppress(InputError):
        assert math.isfinite(parse_quantity(f"2{text}", dimension))


@given(st.text(max_size=8))
def test_plain_numbers_are_what_float_reads_but_for_its_oddities(text: str) -> None:
    assume("_" not in text)
    try:
        number = parse_number(text)
    except InputError:
        if re.fullmatch(r"[+-]?[0-9]+", text):
            raise
    else:
        assert float(number) == float(text)


RPM = math.pi / 30


@pytest.mark.parametrize(
    ("text", "values", "unit"),
    [
        ("0,50,100", [0.0, 50.0, 100.0], "rad/s"),
        ("0,50,100 rpm", [0.0, 50 * RPM, 100 * RPM], "rpm"),
        ("0, 50 rpm ,100 rpm", [0.0, 50 * RPM, 100 * RPM], "rpm"),
        ("10 rad/s,300 rpm", [10.0, 300 * RPM], "rpm"),
        ("300 rpm,10 rad/s,0", [300 * RPM, 10.0, 0.0], "rad/s"),
        ("-1", [-1.0], "rad/s"),
        ("0:100:50 rpm", [0.0, 50 * RPM, 100 * RPM], "rpm"),
        ("0:100:60 rpm", [0.0, 60 * RPM], "rpm"),
        ("0:0.3:0.1", [0.0, 0.1, 0.2, 0.3], "rad/s"),
        ("0 rpm:1 rps:30 rpm", [0.0, 30 * RPM, 60 * RPM], "rpm"),
        ("0:6:2 rad/s", [0.0, 2.0, 4.0, 6.0], "rad/s"),
    ],
)
def test_one_unit_at_the_end_covers_a_list_or_a_range(text, values, unit) -> None:
    found = parse_quantities(text, units.ANGULAR_SPEED, "rad/s")
    assert (found.values, found.unit) == (pytest.approx(values, rel=1e-15), unit)


def test_the_default_unit_is_that_of_the_option() -> None:
    found = parse_quantities("0,3", units.LENGTH, "mm")
    assert found == Quantities((0.0, 0.003), "mm", (0.0, 3.0))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("50,100 rpm,150", r'none; write the unit once, at the end: "50,100,150 rpm"'),
        ("50 rpm,100", r'write the unit once, at the end: "50,100 rpm"'),
        ("0 rpm:100:50", r'write the unit once, at the end: "0:100:50 rpm"'),
        ("10 rad/s,50,300 rpm", r"give each value its unit"),
        ("0,,1", r'a value is missing; write START:STOP:STEP, for example "0:300:50 rad/s"'),
        ("0:1", r"has 2 parts"),
        ("0:1:0 rpm", r"STEP must be positive"),
        ("0:1:-1", r"STEP must be positive"),
        ("2:1:1", r"STOP must not be less than START"),
        ("0:1:1e-4", r"choose a STEP that gives at most 100 values"),
        ("0:1e300:1e-300", r"at most 100 values"),
        ("0,5 Hz", r"is a frequency and not an angular speed"),
        ("0,nan", r"got 'nan', which does not begin with a number"),
        ("0,3 foo", r"unit 'foo' is unknown"),
        ("1e308,1e308 km/m rad/s", r"too large"),
    ],
)
def test_what_is_no_list_or_range_is_refused(text, message) -> None:
    with pytest.raises(InputError, match=message):
        parse_quantities(text, units.ANGULAR_SPEED, "rad/s", most=100)


@given(st.integers(-500, 500), st.integers(1, 40), st.sampled_from(["0.1", "7", "2.5e-3"]))
def test_a_range_is_the_list_of_its_values(start: int, steps: int, step: str) -> None:
    values = [Decimal(start) + number * Decimal(step) for number in range(steps + 1)]
    listed = ",".join(map(str, values))
    ranged = f"{start}:{values[-1]}:{step}"
    for unit in ("rad/s", "rpm", "deg/s"):
        assert parse_quantities(f"{ranged} {unit}", units.ANGULAR_SPEED, "rad/s") == (
            parse_quantities(f"{listed} {unit}", units.ANGULAR_SPEED, "rad/s")
        )


def test_an_si_value_is_told_in_any_unit() -> None:
    assert from_si(10 * math.pi, "rpm") == pytest.approx(300)
    assert from_si(0.2794, "mm") == pytest.approx(279.4)
    with pytest.raises(InputError, match="'wheels' is unknown"):
        from_si(1.0, "wheels")
