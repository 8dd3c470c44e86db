"""A triangular plate by one word of the model file is the body that its long form states."""

from __future__ import annotations

import itertools
import re

import numpy as np
import pytest

import flexmech
from flexmech.modelfile import json_schema, mechanism_from_toml, template
from tests.support.command import MODELS

FOURBAR = (MODELS.parent / "tests" / "data" / "packer.toml").read_text(encoding="utf-8")
PLATE = """
[[links.coupler.bodies]]
shape = "triangle"
{mass}
"""
LONG = """
[[links.coupler.bodies]]
position = "{foot!r} m"
offset = ["{along!r} m", "{across!r} m"]
mass = "{mass!r} kg"
inertia = "{inertia!r} kg m^2"
"""
THICK, DENSITY = 6e-3, 2700.0
TERNARY = ("A", "B", "C")


def lamina(corners: np.ndarray) -> tuple[float, np.ndarray, float]:
    """Area, centre and polar moment of area about it, by the midpoints of the sides.

    With a third of the area as their weights they are exact for polynomials of second degree.
    """
    sides = corners[1:] - corners[0]
    area = abs(np.linalg.det(sides)) / 2
    middles = np.array([(a + b) / 2 for a, b in itertools.combinations(corners, 2)])
    centre = middles.mean(axis=0)
    return area, centre, area / 3 * float(((middles - centre) ** 2).sum())


def long_form(corners: np.ndarray, foot: float | None = None) -> str:
    """The body of a plate of aluminium, at a foot or opposite to its centre, as a file has it."""
    area, centre, moment = lamina(corners)
    foot = float(centre[0]) if foot is None else foot
    weight = DENSITY * THICK
    along, across = (float(part) for part in centre - [foot, 0.0])
    numbers = {"mass": float(weight * area), "inertia": float(weight * moment)}
    return LONG.format(foot=foot, along=along, across=across, **numbers)


def of_four_bar(body: str) -> flexmech.Mechanism:
    without = re.sub(r"\[\[links\.coupler\.bodies\]\]\n(?:\w.*\n)+", "", FOURBAR)
    return mechanism_from_toml(without + body, "plate.toml")


def of_six_bar(body: str) -> flexmech.Mechanism:
    """The template's linkage, whose coupler is a rigid triangle."""
    text = re.sub(
        r'(points = \["A", "B", "C"\]).*\n(?:\w.*\n)+', r"\1\nrigid = true\n", template("planar")
    )
    return mechanism_from_toml(text + body, "plate.toml")


def assert_same(plate: flexmech.Mechanism, long: flexmech.Mechanism) -> None:
    """Frequencies of elastic links, and the driving torque of rigid ones."""
    angles = np.radians([0.0, 100.0, 250.0])
    frequency, torque = [], []
    for one in (plate, long):
        engine = flexmech.ReferenceEngine(one, 2)
        found = flexmech.moving_frequencies(engine, angles, [30.0], modes=3)
        frequency.append(found.dataset["frequency"].values)
        torque.append(flexmech.kinematics(one, 30.0).dataset["driving_torque"].values)
    np.testing.assert_allclose(*frequency, rtol=1e-9)
    np.testing.assert_allclose(*torque, rtol=1e-9, atol=1e-9 * np.abs(torque[0]).max())


@pytest.mark.parametrize("foot", [None, 0.06])
def test_a_plate_on_the_coupler_is_the_body_of_its_long_form(foot: float | None) -> None:
    """From A and B to the coupler point, fixed opposite to its centre or at a place."""
    place = "" if foot is None else f'position = "{foot} m"\n'
    stated = f'material = "aluminium"\nthickness = "{THICK} m"\n{place}'
    plate = of_four_bar(PLATE.format(mass=stated))
    point = 0.085 * np.array([np.cos(np.radians(28)), np.sin(np.radians(28))])
    corners = np.array([[0.0, 0.0], [0.15, 0.0], point])
    assert_same(plate, of_four_bar(long_form(corners, foot)))
    bare = of_four_bar("")
    assert plate.total_mass - bare.total_mass == pytest.approx(
        DENSITY * THICK * lamina(corners)[0], rel=1e-9
    )


def test_a_rigid_ternary_link_has_the_mass_of_its_triangle() -> None:
    """Its corners are the points that the link joins, in the axes of its first two."""
    plate = of_six_bar(PLATE.format(mass=f'material = "aluminium"\nthickness = "{THICK} m"'))
    places = plate.linkage.points
    first, second, third = (complex(*places[name]) for name in TERNARY)
    turned = (third - first) * abs(second - first) / (second - first)
    corners = np.array([[0.0, 0.0], [abs(second - first), 0.0], [turned.real, turned.imag]])
    centre = lamina(corners)[1]
    assert 0 < centre[0] < corners[1, 0], "the foot is on the first beam"
    assert_same(plate, of_six_bar(long_form(corners)))


def test_a_mass_and_own_corners_stand_in_for_material_and_coupler_point() -> None:
    corners = '[["150 mm", "0 mm"], ["210 mm", "0 mm"], ["180 mm", "60 mm"]]'
    stated = f'mass = "0.3 kg"\ncorners = {corners}'
    (body,) = of_four_bar(PLATE.format(mass=stated)).bodies
    assert (body.link, body.position, body.mass) == ("coupler", 0.15, 0.3)
    assert body.offset == pytest.approx((0.03, 0.02))
    area, _, moment = lamina(np.array([[0.0, 0.0], [0.06, 0.0], [0.03, 0.06]]))
    assert body.inertia == pytest.approx(0.3 * moment / area, rel=1e-12)


@pytest.mark.parametrize(
    ("stated", "told"),
    [
        ("", r"bodies\[0\]: give either mass, or material and thickness"),
        ('mass = "1 kg"\nmaterial = "aluminium"', "give either mass, or material and thickness"),
        ('mass = "1 kg"\noffset = ["1 mm", "0 mm"]', r"bodies\[0\]\.offset: unknown key"),
        ('mass = "1 kg"\nposition = "2 m"', r"bodies\[0\]\.position: got 2 m"),
        ('material = "alu"\nthickness = "6 mm"', r"bodies\[0\]\.material: .*aluminium"),
        (
            'mass = "1 kg"\ncorners = [["0 mm", "0 mm"], ["9 mm", "0 mm"], ["3 mm", "0 mm"]]',
            r"bodies\[0\]\.corners: they stand on one line",
        ),
    ],
)
def test_a_plate_that_is_none_is_refused_by_its_key(stated: str, told: str) -> None:
    with pytest.raises(flexmech.InputError, match=told) as refused:
        of_four_bar(PLATE.format(mass=stated))
    assert "\n" not in str(refused.value)


def test_corners_are_asked_for_where_the_link_has_no_third_point() -> None:
    with pytest.raises(flexmech.InputError, match=r"links\.rocker\.bodies\[0\]\.corners: is miss"):
        of_four_bar('[[links.rocker.bodies]]\nshape = "triangle"\nmass = "1 kg"\n')


def test_a_plate_is_in_the_schema_and_in_the_picture() -> None:
    assert "PlateTable" in json_schema()["$defs"]
    mechanism = of_four_bar(PLATE.format(mass='mass = "0.3 kg"'))
    figure = flexmech.check_mechanism(flexmech.ReferenceEngine(mechanism, 2)).plot()
    assert any(len(patch.get_xy()) == 4 and patch.get_alpha() for patch in figure.axes[0].patches)
