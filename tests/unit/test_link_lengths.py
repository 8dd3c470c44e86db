"""Lengths of links in place of coordinates: what they place, and what they cannot."""

from __future__ import annotations

import cmath
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from flexmech import check_mechanism
from flexmech.errors import InputError
from flexmech.linkages import PlanarLinkage
from flexmech.mechanism import Mechanism
from flexmech.modelfile import mechanism_from_toml, mechanism_with, template, twofold_points
from flexmech.modelfile.placing import AS_DRAWN

KEYS = 'rigid = true\nmass = "0.1 kg"\ninertia = "1e-4 kg m^2"\n'
SECTION = (
    'material = "steel"\nsection = "rectangle"\nin_plane_thickness = "5 mm"\n'
    'out_of_plane_width = "10 mm"\n'
)
STEEL = (
    '[materials.steel]\nyoungs_modulus = "200 GPa"\ndensity = "7800 kg/m^3"\npoisson_ratio = 0.3\n'
)
O2 = 'O2 = ["0 mm", "0 mm"]\n'


def model(
    points: str = O2,
    crank: str = 'length = "40 mm"',
    rod: str = 'length = "160 mm"',
    slider: str = "",
    near: str = "",
    drawn_at: str = "90 deg",
) -> str:
    """Model file of a slider-crank by what is stated of it."""
    return (
        f'name = "m"\nsource = "s"\n[linkage]\nkind = "planar"\ndrawn_at = "{drawn_at}"\n'
        f'ground = ["O2"]\n[linkage.points]\n{points}{near and "[linkage.near]"}\n{near}\n{STEEL}'
        f'[links.crank]\npoints = ["O2", "A"]\n{crank}\n{KEYS}'
        f'[links.rod]\npoints = ["A", "B"]\n{rod}\n{SECTION}'
        f'[joints.O2]\nkind = "clamp"\n[joints.B]\nkind = "slider"\ndirection = "0 deg"\n{slider}\n'
    )


def places(text: str) -> dict[str, tuple[float, float]]:
    """Points in mm."""
    linkage = mechanism_from_toml(text).linkage
    assert isinstance(linkage, PlanarLinkage)
    return {name: (1e3 * x, 1e3 * y) for name, (x, y) in linkage.points.items()}


def refusal(text: str) -> str:
    with pytest.raises(InputError) as refused:
        mechanism_from_toml(text)
    message = str(refused.value)
    assert message.startswith("model.toml: ")
    assert "\n" not in message
    return message


# --- what lengths place -------------------------------------------------------------------------


def test_crank_and_rod_place_pin_and_slider():
    found = places(model())
    assert found["A"] == pytest.approx((0, 40), abs=1e-9)
    assert found["B"] == pytest.approx((math.sqrt(160**2 - 40**2), 0), abs=1e-9)


def test_an_offset_moves_the_line_to_the_left_of_its_direction():
    found = places(model(slider='offset = "10 mm"'))
    assert found["B"] == pytest.approx((math.sqrt(160**2 - 30**2), 10), abs=1e-9)


def test_an_angle_places_the_other_end():
    angle = math.degrees(-math.asin(40 / 160))
    found = places(model(rod=f'length = "160 mm"\nangle = "{angle!r} deg"'))
    assert found["B"] == pytest.approx((math.sqrt(160**2 - 40**2), 0), abs=1e-9)
    # And backwards, from a second point that is drawn.
    drawn = 'A = ["0 mm", "40 mm"]\n'
    turned = model(O2 + drawn, crank="").replace('["A", "B"]', '["B", "A"]')
    angle = math.degrees(math.pi - math.asin(40 / 160))
    found = places(turned.replace('length = "160', f'angle = "{angle!r} deg"\nlength = "160'))
    assert found["B"] == pytest.approx((math.sqrt(160**2 - 40**2), 0), abs=1e-9)


FOUR_BAR = (
    model(O2 + 'O4 = ["254 mm", "0 mm"]\n', 'length = "100 mm"', 'length = "280 mm"')
    .replace('ground = ["O2"]', 'ground = ["O2", "O4"]')
    .partition("[joints.B]")[0]
    + f'[links.rocker]\npoints = ["O4", "B"]\nlength = "265 mm"\n{SECTION}'
)


def test_two_links_that_meet_place_their_joint():
    mechanism = mechanism_from_toml(FOUR_BAR)
    lengths = [link.length for link in mechanism.linkage.topology.links]
    assert lengths == pytest.approx([0.1, 0.28, 0.265], rel=1e-14)
    found = places(FOUR_BAR)
    assert found["B"][1] > found["A"][1]  # the upper one of both


def test_a_rough_place_chooses_the_other_one():
    x = math.sqrt(160**2 - 40**2)
    other = model(near='B = ["-100 mm", "3 mm"]')
    assert places(other)["B"] == pytest.approx((-x, 0), abs=1e-9)
    below = FOUR_BAR.replace(
        "[materials", '[linkage.near]\nB = ["100 mm", "-200 mm"]\n[materials', 1
    )
    assert places(below)["B"][1] < 0 < places(FOUR_BAR)["B"][1]


def test_check_says_which_place_is_taken_and_how_to_choose_the_other():
    mechanism = mechanism_from_toml(model())
    (two,) = twofold_points(mechanism)
    assert str(two) == (
        "B is at (154.919 mm, 0 mm), where the rod places it; for the other place write "
        'B = ["-154.919 mm", "0 mm"] in [linkage.near]'
    )
    assert str(two) in check_mechanism(mechanism).dataset.attrs["linkage"]
    # What it says works.
    assert places(model(near='B = ["-154.919 mm", "0 mm"]'))["B"][0] < 0
    # Nothing is said of a drawing, or of a mechanism that was changed since.
    drawn = model(O2 + 'A = ["0 mm", "40 mm"]\nB = ["150 mm", "0 mm"]\n', "", "")
    assert twofold_points(mechanism_from_toml(drawn)) == ()


def test_a_line_on_a_guide_counts_from_the_guide():
    """The slider of an inverted slider-crank, on a rigid link that is drawn."""
    text = (
        'name = "m"\nsource = "s"\n[linkage]\nkind = "planar"\ndrawn_at = "90 deg"\n'
        'ground = ["O2", "O4"]\n[linkage.points]\nO2 = ["0 mm", "0 mm"]\n'
        'O4 = ["-100 mm", "0 mm"]\nC = ["200 mm", "120 mm"]\nA = ["0 mm", "40 mm"]\n'
        f'{STEEL}[links.crank]\npoints = ["O2", "A"]\n{KEYS}[links.guide]\npoints = ["O4", "C"]\n'
        f'{KEYS}[links.arm]\npoints = ["A", "B"]\nlength = "60 mm"\n{SECTION}'
        '[joints.O2]\nkind = "clamp"\n[joints.A]\nkind = "weld"\n'
        '[joints.B]\nkind = "slider"\nguide = "guide"\ndirection = "0 deg"\noffset = "5 mm"\n'
    )
    b, along = complex(*places(text)["B"]), cmath.rect(1.0, math.atan2(120, 300))
    assert ((b + 100) / along).imag == pytest.approx(5, abs=1e-9)
    assert abs(b - 40j) == pytest.approx(60, abs=1e-9)


def test_a_length_can_be_varied():
    longer = mechanism_with(mechanism_from_toml(model()), "links.rod.length", 0.2)
    assert longer.linkage.topology.links[1].length == pytest.approx(0.2, rel=1e-14)


# --- what cannot be -----------------------------------------------------------------------------

DRAWN = O2 + 'A = ["0 mm", "40 mm"]\nB = ["150 mm", "0 mm"]\n'
REFUSED = {
    "links.rod.length: got 160 mm, but A and B are 155.242 mm apart; leave B out of": model(
        DRAWN, ""
    ),
    "links.crank.length: got 41 mm, but O2 and A are 40 mm apart; leave A out of": model(
        DRAWN, 'length = "41 mm"', ""
    ),
    "links.rod.angle: got 10 deg, but from A to B it is -14.9314 deg; leave B out": model(
        DRAWN, "", 'length = "155.2417 mm"\nangle = "10 deg"'
    ),
    "joints.B.offset: got 10 mm, but B is drawn 0 mm from there; leave B out of": model(
        DRAWN, "", "", 'offset = "10 mm"'
    ),
    "links.rod.length: got 30 mm, but the line of slider B is 40 mm from A; lengthen": model(
        rod='length = "30 mm"'
    ),
    "links.coupler.length: got 280 mm, which does not meet the rocker of 5 mm: A and O4": (
        FOUR_BAR.replace("265", "5").replace("links.rod", "links.coupler")
    ),
    "linkage.points.A: it is not drawn, and no lengths place it; draw it, or give": model(crank=""),
    "linkage.points.B: it is not drawn, and no lengths place it; draw it, or give": model(rod=""),
    "links.rod: angle is given without length; add it, or leave the angle out": model(
        rod='angle = "3 deg"'
    ),
    "links.rod: length and angle are of a link with two points; draw the points": model(
        DRAWN + 'C = ["9 mm", "80 mm"]\n', ""
    ).replace('["A", "B"]', '["A", "B", "C"]'),
    "linkage.near.A: no lengths place this point in two ways; leave it out": model(
        near='A = ["0 mm", "1 mm"]'
    ),
    "joints.O2: offset belongs to a slider; leave it out": model().replace(
        'kind = "clamp"', 'kind = "clamp"\noffset = "1 mm"'
    ),
}


@pytest.mark.parametrize("words", REFUSED)
def test_lengths_that_disagree_or_cannot_meet_are_refused_in_one_line(words: str):
    assert words in refusal(REFUSED[words])


def test_lengths_of_a_four_bar_stand_in_its_own_table():
    text = template("four-bar").replace("[links.crank]", '[links.crank]\nlength = "1 m"')
    assert "links.crank.length: leave it out, or draw the linkage" in refusal(text)


def test_a_drawing_of_six_digits_agrees_with_its_lengths():
    text = model(O2 + 'A = ["0 mm", "40 mm"]\nB = ["154.919 mm", "0 mm"]\n')
    assert places(text)["B"] == pytest.approx((154.919, 0))
    for part, agrees in ((0.5, True), (2.0, False)):
        length = 40 * (1 + part * AS_DRAWN)
        text = model(DRAWN, f'length = "{length!r} mm"', "")
        if agrees:
            assert places(text)["A"] == (0, 40)
        else:
            assert "links.crank.length" in refusal(text)
    assert 1e-6 < AS_DRAWN < 1e-4


# --- a length and the drawing that it comes from ------------------------------------------------

millimetres = st.floats(20.0, 300.0)


@given(
    crank=millimetres,
    longer=st.floats(1.2, 5.0),
    offset=st.floats(-0.9, 0.9),
    angle=st.floats(-170.0, 170.0),
)
def test_a_length_and_the_drawing_that_it_comes_from_give_the_same_mechanism(
    crank: float, longer: float, offset: float, angle: float
):
    rod = crank * longer
    aside = offset * (rod - crank)
    lengths = model(
        O2,
        f'length = "{crank!r} mm"',
        f'length = "{rod!r} mm"',
        f'offset = "{aside:f} mm"',
        drawn_at=f"{angle!r} deg",
    )
    stated = mechanism_from_toml(lengths)
    pin = cmath.rect(crank, math.radians(angle))
    height = float(f"{aside:f}")
    slider = pin.real + math.sqrt(rod**2 - (height - pin.imag) ** 2)
    drawing = (
        f'{O2}A = ["{pin.real!r} mm", "{pin.imag!r} mm"]\nB = ["{slider!r} mm", "{height!r} mm"]\n'
    )
    drawn = mechanism_from_toml(model(drawing, "", "", drawn_at=f"{angle!r} deg"))
    same(stated, drawn, rod)


def same(first: Mechanism, second: Mechanism, size: float) -> None:
    """Whether two mechanisms differ by round-off of coordinates alone."""
    own, other = first.linkage, second.linkage
    assert isinstance(own, PlanarLinkage)
    assert isinstance(other, PlanarLinkage)
    assert own.points.keys() == other.points.keys()
    for name, place in own.points.items():
        assert place == pytest.approx(other.points[name], abs=1e-12 * size)
    assert first.sections.keys() == second.sections.keys()
    assert own.drawn_at == other.drawn_at
    assert first.joint_masses == second.joint_masses
    lengths = [link.length for link in own.topology.links]
    assert lengths == pytest.approx([link.length for link in other.topology.links], rel=1e-11)
    # Written resolved, it reads back equal.
    assert mechanism_from_toml(first.to_toml()) == first


# --- a drawing whose crank stands elsewhere -----------------------------------------------------


@pytest.mark.parametrize(("drawn_at", "said"), [("90.05 deg", 0), ("90.2 deg", 1), ("60 deg", 1)])
def test_a_crank_that_does_not_stand_at_drawn_at_gets_a_remark(drawn_at: str, said: int):
    mechanism = mechanism_from_toml(model(DRAWN, "", "", drawn_at=drawn_at))
    remarks = check_mechanism(mechanism).remarks
    own = [line for line in remarks if line.startswith("the crank is drawn at 90 deg")]
    assert len(own) == said
    if said:
        shown = drawn_at.removesuffix(" deg")
        assert f"drawn at 90 deg, from O2 to A, and drawn_at says {shown} deg" in own[0]
