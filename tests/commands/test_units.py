"""Units: what is typed with a unit is the nearest SI float, and comes back as it was typed."""

from __future__ import annotations

import contextlib
import math
import re

import pint
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flexmech import InputError, units
from flexmech.modelfile import mechanism_from_toml, template
from flexmech.units import Dimension, from_si, parse_quantity


@pytest.fixture(scope="module")
def registry():
    return pint.UnitRegistry()


ALL = [value for value in vars(units).values() if isinstance(value, Dimension)]


@pytest.mark.parametrize(
    ("text", "dimension", "expected"),
    [
        ("279.4 mm", units.LENGTH, 0.2794),
        ("279.4mm", units.LENGTH, 0.2794),
        ("11 inch", units.LENGTH, 0.2794),
        ("20 µm", units.LENGTH, 2e-5),
        ("68.9 GPa", units.STRESS, 68.9e9),
        ("2.698e-9 t/mm^3", units.DENSITY, 2698.0),
        ("2.7 g/cm³", units.DENSITY, 2700.0),
        ("-9.81 m s^-2", units.ACCELERATION, -9.81),
        ("300 rpm", units.ANGULAR_SPEED, 10 * math.pi),
        ("5 rev/s", units.ANGULAR_SPEED, 10 * math.pi),
        ("90 deg/s", units.ANGULAR_SPEED, math.pi / 2),
        ("1.2 kHz", units.FREQUENCY, 1200.0),
        ("2e6 N mm^2", units.BENDING_STIFFNESS, 2.0),
        ("0.3 g mm", units.ROTARY_INERTIA, 3e-7),
        ("20 degC", units.TEMPERATURE, 293.15),
        ("0.00302 1/percent", units.MOISTURE_EXPANSION, 0.302),
        ("45 kJ/mol", units.ACTIVATION_ENERGY, 45e3),
        ("0.5%", units.RATIO, 0.005),
        (0.3, units.RATIO, 0.3),
    ],
)
def test_text_is_the_nearest_si_float(text, dimension, expected):
    """Equal to the last bit: nothing is lost before rounding."""
    assert parse_quantity(text, dimension) == expected


UNITS = (
    *("m", "cm", "mm", "µm", "nm", "km", "inch", "ft", "1/m", "kg", "g", "lb", "s", "ms", "min"),
    *("h", "day", "Hz", "kHz", "rad", "deg", "rad/s", "deg/s", "rad/s^2", "m/s^2", "Pa", "kPa"),
    *("MPa", "GPa", "psi", "kg/m^3", "g/cm^3", "t/mm^3", "kg/m", "g/m", "kg m", "kg m^2"),
    *("kg mm^2", "N", "kN", "lbf", "N m", "N mm", "N m^2", "N mm^2", "N m/rad", "N m s/rad"),
    *("N/m", "N/mm", "N s/m", "N s/mm", "1/K", "m^2/s", "mm^2/s", "J/mol", "kJ/mol", "ohm"),
    *("V", "H", "mH", "N m/A", "MPa m/s"),
)


@pytest.mark.parametrize("unit", UNITS)
def test_a_unit_is_as_large_as_another_library_has_it(unit, registry):
    """At least one dimension takes it, and all that do take it for the same."""
    exact = registry.Quantity(unit.replace(" ", "*")).to_base_units().magnitude
    found = set()
    for dimension in ALL:
        with contextlib.suppress(InputError):
            found.add(parse_quantity(f"1 {unit}", dimension))
    assert len(found) == 1
    assert found.pop() == pytest.approx(exact, rel=1e-14)


@pytest.mark.parametrize("dimension", ALL, ids=lambda dimension: dimension.name)
def test_the_examples_of_messages_are_understood(dimension):
    for example in dimension.examples:
        assert math.isfinite(parse_quantity(example, dimension))


@pytest.mark.parametrize(
    ("value", "dimension"),
    [
        *((value, units.LENGTH) for value in ("100", 100, True, None, ["1 mm"], "", "mm")),
        *((value, units.LENGTH) for value in ("nan mm", "-inf mm", "1e400 mm", "1e308 km")),
        # A library for units reads these as 15 mm, 3 m and 6 mm.
        *((value, units.LENGTH) for value in ("1,5 mm", "1_000 mm", "3 m$", "3 m;", "2*3 mm")),
        *((value, units.LENGTH) for value in ("3 foo", "3 mm mm", "3 (mm", "3 m/0", "10 mil")),
        *((value, units.ANGULAR_SPEED) for value in ("5 Hz", "5 1/s", "5 m/s", "300 RPM")),
        *((value, units.FREQUENCY) for value in ("50 rad/s", "50 cps")),
        *((value, units.RATIO) for value in (True, math.nan, "5 deg", "5 %%")),
        ("20 °C", units.LENGTH),
        ("5 GPa", units.FORCE),
    ],
)
def test_what_is_no_such_quantity_is_refused(value, dimension):
    with pytest.raises(InputError):
        parse_quantity(value, dimension)


@pytest.mark.parametrize(
    ("text", "dimension", "meant"),
    [
        ("68.9 gpa", units.STRESS, "'GPa'"),
        ("300 RPM", units.ANGULAR_SPEED, "'rpm'"),
        ("1500 rmp", units.ANGULAR_SPEED, "'rpm'"),
        ("20 rda/s", units.ANGULAR_SPEED, "'rad/s'"),
        ("5 mn", units.FORCE, "'MN'"),
    ],
)
def test_the_unit_that_was_meant_is_named(text, dimension, meant):
    with pytest.raises(InputError, match=meant):
        parse_quantity(text, dimension)


@given(
    st.floats(-1e30, 1e30).filter(lambda x: x == 0 or abs(x) > 1e-30),
    st.sampled_from([("mm", 1e-3), ("km", 1e3), ("µm", 1e-6), ("inch", 0.0254), ("m", 1.0)]),
)
def test_a_number_survives_the_way_through_text(number, unit):
    name, factor = unit
    found = parse_quantity(f"{number!r} {name}", units.LENGTH)
    assert found == pytest.approx(number * factor, rel=4e-16, abs=0)
    assert from_si(found, name) == pytest.approx(number, rel=1e-15, abs=0)
    assert parse_quantity(f"{number!r} rad/s", units.ANGULAR_SPEED) == number


@given(
    st.text(max_size=12) | st.text(alphabet="mskgNHPa%/^*() -23radpo²µ", max_size=10),
    st.sampled_from(ALL),
)
def test_any_text_behind_a_number_is_a_quantity_or_refused(text, dimension):
    with contextlib.suppress(InputError):
        assert math.isfinite(parse_quantity(f"1.5 {text}", dimension))


@given(st.floats(1.0, 1e4), st.sampled_from([("mm", 1e-3), ("cm", 1e-2), ("inch", 0.0254)]))
def test_a_length_of_a_model_file_survives_in_any_unit(length, unit):
    name, factor = unit
    text = template("rotating-arm").replace('length = "300 mm"', f'length = "{length!r} {name}"')
    linkage = mechanism_from_toml(text).linkage
    assert linkage.length == pytest.approx(length * factor, rel=4e-16)


@pytest.mark.parametrize("unit", ["rad/s", "rpm", "rps", "deg/s"])
def test_speeds_of_a_model_file_are_written_in_their_unit(unit):
    """Results speak of speeds in the unit of the last one."""
    text = re.sub(
        r"crank_speeds = .*", f'crank_speeds = ["7 rad/s", "12.3 {unit}"]', template("four-bar")
    )
    mechanism = mechanism_from_toml(text)
    assert mechanism.speed_unit == unit
    written = mechanism.to_toml()
    assert f'"12.3 {unit}"' in written
    again = mechanism_from_toml(written)
    assert (again, again.speed_unit) == (mechanism, unit)
