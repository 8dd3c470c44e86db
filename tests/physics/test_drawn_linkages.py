"""Drawn linkages: motions by formula, strokes between dead centres, lengths that place points."""

from __future__ import annotations

import cmath
import math
from dataclasses import replace

import numpy as np
import pytest

from flexmech import (
    AttachedBody,
    CouplerCurve,
    CouplerPoint,
    FourBar,
    InputError,
    Mechanism,
    PlanarJoint,
    PlanarLinkage,
    check_mechanism,
    example_model,
    kinematics,
    load_mechanism,
)
from flexmech.modelfile import mechanism_from_toml, mechanism_with
from tests.support.mechanisms import drawn, slider_crank
from tests.support.strategies import fourbar

TURN = np.radians(np.arange(0.0, 360.0, 3.0))
CRANK, ROD, SPEED = 0.04, 0.16, 157.0
# In steps of 50 degrees no angle is near an extreme.
COARSE = np.radians([0.0, 50, 100, 150, 200, 250, 300, 350, 360])
# Differences of fourth order for first and second derivatives.
FIRST = np.array([1, -8, 0, 8, -1]) / 12
SECOND = np.array([-1, 16, -30, 16, -1]) / 12


def bodied(linkage: PlanarLinkage) -> Mechanism:
    """Its rigid links have no sections; each carries a body."""
    links = tuple(replace(link, rigid=True) for link in linkage.links)
    bodies = tuple(AttachedBody(link.name, 0.02, 0.3, 2e-4) for link in links)
    return Mechanism(replace(linkage, links=links), {}, bodies=bodies)


def crank_shaper() -> PlanarLinkage:
    """The crank's pin slides along a lever through the lever's pivot."""
    points = {"O2": (0, 0), "A": (0.04, 0.0), "O4": (0, -0.1), "C": (0.08, 0.1)}
    links = {"crank": ("O2", "A"), "lever": ("O4", "C")}
    joints = {"O2": "clamp", "A": PlanarJoint("A", "slider", (), 0.0, "lever")}
    return drawn(points, links, joints, ("O4",), ("lever",))


def number(mechanism: Mechanism, angles: np.ndarray, name: str, of: str) -> float:
    found = kinematics(mechanism, SPEED, crank_angles=angles).summary().numbers
    (value,) = (one.value for one in found if (one.name, one.of) == (name, of))
    return float(value)


@pytest.mark.parametrize("offset", [0.0, 0.03])
def test_a_slider_crank_moves_by_its_formula(offset: float) -> None:
    linkage = slider_crank(crank=0.15, rod=0.3, offset=offset)
    motion = linkage.motion(TURN, 2.0)
    swing = (offset - 0.15 * np.sin(TURN)) / 0.3
    along = np.sqrt(1 - swing**2)
    place = np.stack([0.15 * np.cos(TURN) + 0.3 * along, np.full_like(TURN, offset)], axis=1)
    np.testing.assert_allclose(motion.position(1, 0.3), place, atol=1e-14)
    rate = -0.15 * np.cos(TURN) * 2.0 / (0.3 * along)
    np.testing.assert_allclose(motion.angular_velocity[:, 1], rate, atol=1e-13)


def test_the_lever_of_a_crank_shaper_swings_by_its_formula() -> None:
    """Its angle is that of the crank's pin as seen from its pivot."""
    linkage = crank_shaper()
    motion = linkage.motion(TURN, 3.0, -7.0)
    pin = 0.04 * np.exp(1j * TURN) + 0.1j
    seen = pin * np.exp(-1j * (np.angle(0.04 + 0.1j) - np.angle(0.08 + 0.2j)))
    np.testing.assert_allclose(np.exp(1j * motion.angle[:, 1]), seen / abs(pin), atol=1e-14)
    first = 0.04j * np.exp(1j * TURN) / pin
    np.testing.assert_allclose(motion.angular_velocity[:, 1], 3.0 * first.imag, atol=1e-13)
    second = (-0.04 * np.exp(1j * TURN) / pin - first**2).imag
    expected = 9.0 * second - 7.0 * first.imag
    np.testing.assert_allclose(motion.angular_acceleration[:, 1], expected, atol=1e-12)


def test_a_scotch_yoke_moves_as_the_cosine() -> None:
    """A body that two bushings guide has no turning joint: Newton's method follows it."""
    points = {"O2": (0, 0), "A": (0.06, 0.08), "P": (0.3, 0), "Q": (0.5, 0)}
    joints = {
        "O2": "clamp",
        "A": PlanarJoint("A", "slider", (), np.pi / 2, "yoke"),
        "P": PlanarJoint("P", "slider", (), 0.0),
        "Q": PlanarJoint("Q", "slider", (), 0.0),
    }
    links = {"crank": ("O2", "A"), "yoke": ("P", "Q")}
    motion = drawn(points, links, joints, (), ("yoke",)).motion(TURN, 3.0, 5.0)
    moved = motion.position(1, 0.0)[:, 0] - 0.24
    np.testing.assert_allclose(moved, 0.1 * np.cos(TURN), atol=1e-13)
    expected = -0.9 * np.cos(TURN) - 0.5 * np.sin(TURN)
    np.testing.assert_allclose(motion.acceleration(1, 0.0)[:, 0], expected, atol=1e-12)
    np.testing.assert_allclose(motion.angle[:, 1], 0.0, atol=1e-13)


def test_a_ram_on_lines_of_the_ground_and_of_the_crank_turns() -> None:
    """The lines are parallel in the drawing alone, unlike those of two bushings."""
    points = {"O2": 0j, "A": 0.1, "P": 0.35 + 0.1j, "R": 0.4 - 0.02j, "Q": 0.25 - 0.1j}
    joints = {
        "O2": "clamp",
        "P": PlanarJoint("P", "slider", (), 0.0),
        "Q": PlanarJoint("Q", "slider", (), 0.0, "crank"),
    }
    links = {"crank": ("O2", "A"), "ram": ("P", "R", "Q"), "rod": ("A", "R")}
    places = {name: (complex(at).real, complex(at).imag) for name, at in points.items()}
    linkage = drawn(places, links, joints, (), ("crank", "ram"))
    angle = np.linspace(-0.05, 0.1, 9)
    motion, topology = linkage.motion(angle), linkage.topology
    ends = [motion.position(n, link.length) for n, link in enumerate(topology.links)]
    np.testing.assert_allclose(motion.origin[:, 1, 1], 0.1, atol=1e-13)
    np.testing.assert_allclose(ends[3], ends[1], atol=1e-13)
    on_crank = (ends[2] @ [1, 1j]) * np.exp(-1j * angle)
    np.testing.assert_allclose(on_crank.imag, -0.1, atol=1e-13)
    assert np.ptp(motion.angle[:, 1]) > 0.1


def test_a_six_bar_driven_at_its_output_stands_as_when_its_crank_drives_it() -> None:
    """Beyond its dead point, which is named, it does not go."""
    first = load_mechanism(example_model("stephenson_six_bar")).linkage
    second = replace(first, joints=(PlanarJoint("O6", "clamp"),))
    motion = first.motion(np.radians(np.linspace(50.0, 75.0, 26)), 1.0)
    output = first.topology.index("output")
    turned = motion.angle[:, output] - first.motion(np.radians(60.0)).angle[output]
    angles = np.radians(60.0) + (turned + np.pi) % (2 * np.pi) - np.pi
    rates = motion.angular_velocity[:, output], motion.angular_acceleration[:, output]
    other = second.motion(angles, *rates)
    np.testing.assert_allclose(other.origin, motion.origin, atol=1e-13)
    np.testing.assert_allclose(other.angular_velocity, motion.angular_velocity, atol=1e-11)
    np.testing.assert_allclose(other.angular_acceleration, motion.angular_acceleration, atol=1e-9)
    with pytest.raises(InputError, match=r"locks at crank angle ([\d.]+) deg, .* joint") as refused:
        second.motion(np.pi)
    locked = np.radians(float(str(refused.value).split("locks at crank angle ")[1].split()[0]))
    back = 1e-4 * np.sign(second.drawn_angle - locked)
    second.motion(locked + back)
    with pytest.raises(InputError, match="locks"):
        second.motion(locked - back)


def test_resized_linkages_have_the_lengths_asked_for() -> None:
    """Welds keep their angles, lines of the ground and of guides grow with these."""
    six_bar = load_mechanism(example_model("stephenson_six_bar")).linkage
    lengths = {link.name: link.length for link in six_bar.topology.links}
    longer = {
        name: length * (1.01 if "coupler" in name else 1.002) for name, length in lengths.items()
    }
    grown = six_bar.resized(longer, 1.001)
    for link in grown.topology.links:
        assert link.length == pytest.approx(longer[link.name], rel=1e-14)
    assert grown.points["O6"] == pytest.approx((0.3003, 0.5005), rel=1e-15)
    corner = [np.diff(one.motion(1.0).angle)[1] for one in (six_bar, grown)]
    assert corner[0] == pytest.approx(corner[1], abs=1e-14)
    back = grown.resized(lengths, 1 / 1.001)
    for name, place in six_bar.points.items():
        assert back.points[name] == pytest.approx(place, abs=1e-15)
    line = slider_crank(crank=0.15, offset=0.03).resized({"crank": 0.16, "rod": 0.31}, 1.01)
    np.testing.assert_allclose(line.motion(TURN).position(1, 0.31)[:, 1], 0.0303, rtol=1e-12)


@pytest.mark.parametrize("angles", [COARSE, np.radians(np.arange(361.0))])
@pytest.mark.parametrize("offset", [0.0, 0.03, -0.05])
def test_the_stroke_of_a_slider_is_from_stretched_to_folded(
    angles: np.ndarray, offset: float
) -> None:
    """Whatever angles are asked for; without an offset twice the crank."""
    mechanism = bodied(slider_crank(crank=CRANK, rod=ROD, offset=offset))
    reach = [np.sqrt((ROD + sign * CRANK) ** 2 - offset**2) for sign in (1, -1)]
    stroke = number(mechanism, angles, "stroke", "B")
    assert stroke == pytest.approx(1e3 * (reach[0] - reach[1]), rel=1e-12)


def test_peaks_of_a_sliders_velocity_and_acceleration_lie_between_the_angles() -> None:
    """The acceleration at the dead centre is r omega^2 (1 + r / l)."""
    mechanism = bodied(slider_crank(crank=CRANK, rod=ROD, offset=0.0))
    acceleration = number(mechanism, COARSE, "peak_acceleration", "B")
    assert acceleration == pytest.approx(CRANK * SPEED**2 * (1 + CRANK / ROD), rel=1e-12)
    theta = np.linspace(0.0, np.pi, 400001)
    sine = np.sqrt(ROD**2 - (CRANK * np.sin(theta)) ** 2)
    velocity = CRANK * SPEED * np.sin(theta) * (1 + CRANK * np.cos(theta) / sine)
    found = number(mechanism, COARSE, "peak_velocity", "B")
    assert found == pytest.approx(velocity.max(), rel=1e-10)


def test_an_accelerated_crank_moves_the_slider_by_its_lever() -> None:
    mechanism = bodied(slider_crank(crank=CRANK, rod=ROD, offset=0.0))
    alpha, theta = 3000.0, np.radians([0.0, 40.0, 90.0, 200.0])
    steady, found = (
        kinematics(mechanism, SPEED, crank_angles=theta, crank_acceleration=change)
        for change in (0.0, alpha)
    )
    root = np.sqrt(ROD**2 - (CRANK * np.sin(theta)) ** 2)
    lever = -CRANK * np.sin(theta) * (1 + CRANK * np.cos(theta) / root)
    more = (found.dataset - steady.dataset)["slider_acceleration"].values[:, 0]
    assert more == pytest.approx(lever * alpha, abs=1e-9 * CRANK * alpha)
    table = found.tables()["motion"].query("point == 'B'")
    assert table["crank_acceleration_rad_s2"].unique() == pytest.approx([alpha])
    assert table["a_along_m_s2"].to_numpy() == pytest.approx(
        found.dataset["slider_acceleration"].values[:, 0]
    )


def test_a_slider_on_a_lever_moves_along_it() -> None:
    """From the lever's pivot to the crank's pin: once nearest, once farthest."""
    mechanism, step = bodied(crank_shaper()), 1e-4
    assert number(mechanism, COARSE, "stroke", "A") == pytest.approx(80.0, rel=1e-12)
    angles = 0.7 + step * np.arange(-2, 3)
    data = kinematics(mechanism, SPEED, crank_angles=angles).dataset
    place = data["slider_position"].values[:, 0]
    assert place == pytest.approx(abs(0.04 * np.exp(1j * angles) + 0.1j), rel=1e-13)
    for name, weights, rel in (("velocity", FIRST, 1e-9), ("acceleration", SECOND, 1e-5)):
        power = 1 if name == "velocity" else 2
        rate = weights @ place * (SPEED / step) ** power
        assert data[f"slider_{name}"].values[2, 0] == pytest.approx(rate, rel=rel)


def test_the_coupler_point_of_a_model_moves_on_its_curve() -> None:
    point, step = CouplerPoint(0.16, np.radians(35.0)), 1e-4
    mechanism = replace(fourbar(), coupler_point=point)
    angles = 0.7 + step * np.arange(-2, 3)
    data = kinematics(mechanism, SPEED, crank_angles=angles).dataset
    of_point = data.sel(point="coupler point").transpose("crank_angle", ...)
    assert isinstance(mechanism.linkage, FourBar)
    places = CouplerCurve(mechanism.linkage, point).position(angles)
    assert of_point["point_position"].values == pytest.approx(places, rel=1e-12)
    first, second = FIRST @ places * SPEED / step, SECOND @ places * (SPEED / step) ** 2
    assert of_point["point_velocity"].values[2] == pytest.approx(first, rel=1e-9)
    assert of_point["point_acceleration"].values[2] == pytest.approx(second, rel=1e-5)


def model(
    crank: str = 'length = "40 mm"',
    rod: str = 'length = "160 mm"',
    slider: str = "",
    *,
    points: str = "",
    near: str = "",
    drawn_at: str = "90 deg",
) -> str:
    """Model file of a slider-crank by what is stated of it."""
    body = 'rigid = true\nmass = "0.1 kg"\ninertia = "1e-4 kg m^2"\n'
    return (
        f'name = "m"\nsource = "s"\n[linkage]\nkind = "planar"\ndrawn_at = "{drawn_at}"\n'
        f'ground = ["O2"]\n[linkage.points]\nO2 = ["0 mm", "0 mm"]\n{points}\n'
        f'{near and "[linkage.near]"}\n{near}\n[links.crank]\npoints = ["O2", "A"]\n{crank}\n'
        f'{body}[links.rod]\npoints = ["A", "B"]\n{rod}\n{body}[joints.O2]\nkind = "clamp"\n'
        f'[joints.B]\nkind = "slider"\ndirection = "0 deg"\n{slider}\n'
    )


REACH = math.sqrt(160**2 - 40**2)
TILT = math.degrees(-math.asin(40 / 160))


@pytest.mark.parametrize(
    ("text", "place"),
    [
        (model(), (REACH, 0)),
        (model(slider='offset = "10 mm"'), (math.sqrt(160**2 - 30**2), 10)),
        (model(rod=f'length = "160 mm"\nangle = "{TILT!r} deg"'), (REACH, 0)),
        (model(near='B = ["-100 mm", "3 mm"]'), (-REACH, 0)),
        # A drawing of six digits agrees with its lengths.
        (model(points='A = ["0 mm", "40 mm"]\nB = ["154.919 mm", "0 mm"]'), (154.919, 0)),
    ],
    ids=["stretched out", "offset", "by its angle", "near another place", "drawn in six digits"],
)
def test_lengths_place_pin_and_slider(text: str, place: tuple[float, float]) -> None:
    """In mm; the offset is to the left of the line's direction."""
    points = mechanism_from_toml(text).linkage.points
    assert 1e3 * np.array(points["A"]) == pytest.approx([0, 40], abs=1e-9)
    assert 1e3 * np.array(points["B"]) == pytest.approx(place, abs=1e-9)


def test_a_length_and_the_drawing_that_it_comes_from_are_one_mechanism() -> None:
    for crank, rod, aside, angle in ((40.0, 160.0, 10.0, 90.0), (30.0, 220.5, -25.0, -130.7)):
        pin = cmath.rect(crank, math.radians(angle))
        slider = pin.real + math.sqrt(rod**2 - (aside - pin.imag) ** 2)
        stated = mechanism_from_toml(
            model(
                f'length = "{crank!r} mm"',
                f'length = "{rod!r} mm"',
                f'offset = "{aside!r} mm"',
                drawn_at=f"{angle} deg",
            )
        )
        points = f'A = ["{pin.real!r} mm", "{pin.imag!r} mm"]\nB = ["{slider!r} mm", "{aside} mm"]'
        other = mechanism_from_toml(model("", "", points=points, drawn_at=f"{angle} deg"))
        for name, place in stated.linkage.points.items():
            assert place == pytest.approx(other.linkage.points[name], abs=1e-12 * rod)
        # Written with all its points, it reads back equal.
        assert mechanism_from_toml(stated.to_toml()) == stated
    longer = mechanism_with(stated, "links.rod.length", 0.3)
    assert longer.linkage.topology.links[1].length == pytest.approx(0.3, rel=1e-14)


def test_check_tells_of_the_other_place_and_how_to_choose_it() -> None:
    told = check_mechanism(mechanism_from_toml(model())).dataset.attrs["linkage"]
    assert 'B = ["-154.919 mm", "0 mm"] in [linkage.near]' in told
    other = mechanism_from_toml(model(near='B = ["-154.919 mm", "0 mm"]'))
    assert other.linkage.points["B"][0] < 0


@pytest.mark.parametrize(("drawn_at", "remarks"), [("90.05 deg", 0), ("60 deg", 1)])
def test_a_crank_that_does_not_stand_at_drawn_at_gets_a_remark(drawn_at: str, remarks: int) -> None:
    points = 'A = ["0 mm", "40 mm"]\nB = ["150 mm", "0 mm"]'
    mechanism = mechanism_from_toml(model("", "", points=points, drawn_at=drawn_at))
    told = check_mechanism(mechanism).remarks
    assert sum("the crank is drawn at 90 deg" in remark for remark in told) == remarks


@pytest.mark.parametrize(
    ("lengths", "angle", "said"),
    [
        ((0.3, 0.35, 0.1), np.radians(270.0), r"angle 270 deg: rod .* do not meet in joint B"),
        ((0.2, 0.2, 0.05), np.arcsin(-0.75) + 1e-14, r"locks at crank angle .* joint B"),
    ],
)
def test_where_a_slider_crank_cannot_stand_angle_and_joint_are_named(
    lengths: tuple[float, ...], angle: float, said: str
) -> None:
    crank, rod, offset = lengths
    with pytest.raises(InputError, match=said):
        slider_crank(crank=crank, rod=rod, offset=offset).motion([np.pi / 2, angle])


def test_a_third_parallel_crank_is_refused_as_redundant() -> None:
    points = {f"G{n}": (x, 0.0) for n, x in enumerate((0.1, 0.35, 0.6))}
    points |= {f"A{n}": (x + 0.05, 0.15) for n, x in enumerate((0.1, 0.35, 0.6))}
    links = {f"crank{n}": (f"G{n}", f"A{n}") for n in range(3)}
    links["beam"] = ("A0", "A1", "A2")
    with pytest.raises(InputError, match=r"redundant at joint A\d, at crank angle"):
        drawn(points, links, {"G0": "clamp"}, ("G1", "G2"))


def test_a_drawn_parallelogram_stays_one_past_its_change_points() -> None:
    """Its coupler moves without turning, and its rocker as the crank."""
    points = {"O2": (0, 0), "A": (0, 0.1), "B": (0.3, 0.1), "O4": (0.3, 0)}
    links = {"crank": ("O2", "A"), "coupler": ("A", "B"), "rocker": ("O4", "B")}
    linkage = drawn(points, links, {"O2": "clamp"}, ("O4",))
    turned = linkage.motion(TURN[TURN % np.pi > 1e-3], 1.0).angular_velocity
    assert turned == pytest.approx(np.tile([1, 0, 1], (len(turned), 1)), abs=1e-9)
    with pytest.raises(InputError, match=r"change point at crank angle 0 deg.*leave out 0 and 180"):
        linkage.motion(TURN)
