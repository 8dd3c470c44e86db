"""Planar linkages with known motions, and how they are put together, resized and refused."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech import load_mechanism
from flexmech.errors import InputError
from flexmech.linkages import PlanarJoint, PlanarLink, PlanarLinkage
from flexmech.linkages.planar.dyads import SlidingBody, TwoLoci
from flexmech.linkages.planar.newton import NewtonGroup
from flexmech.linkages.topology import Clamp, LinkEnd, Pin, Pivot, Slider, Weld
from tests.unit.test_modelfile import MODELS
from tests.unit.test_planar_motion import angle_difference, check_rates, drawn_as_planar

TURN = np.radians(np.arange(0.0, 360.0, 3.0))


def linkage(points, links, ground, joints=(), drawn_at=None, clamped=()) -> PlanarLinkage:
    """A linkage whose links are ``name: points``; rigid ones end with an exclamation mark."""
    return PlanarLinkage(
        {name: (place.real, place.imag) for name, place in points.items()},
        tuple(
            PlanarLink(name.rstrip("!"), tuple(chain.split()), name.endswith("!"))
            for name, chain in links.items()
        ),
        tuple(ground.split()),
        (PlanarJoint("O2", "clamp", clamped), *joints),
        drawn_at,
    )


def slider_crank(crank=0.15, rod=0.3, offset=0.0) -> PlanarLinkage:
    end = np.sqrt(rod**2 - (crank - offset) ** 2)
    return linkage(
        {"O2": 0j, "A": 1j * crank, "B": end + 1j * offset},
        {"crank": "O2 A", "rod": "A B"},
        "O2",
        [PlanarJoint("B", "slider", direction=0.0)],
    )


def quick_return(pivot=-0.3j) -> PlanarLinkage:
    """A crank's pin in the slot of a swinging arm (RPR)."""
    return linkage(
        {"O2": 0j, "A": 0.1 + 0j, "O4": pivot, "C": pivot + 0.6 * (0.1 - pivot) / abs(0.1 - pivot)},
        {"crank": "O2 A", "arm!": "O4 C"},
        "O2 O4",
        [PlanarJoint("A", "slider", direction=0.0, guide="arm")],
    )


def scotch_yoke() -> PlanarLinkage:
    """A crank's pin in the cross slot of a yoke that two bushings guide."""
    return linkage(
        {"O2": 0j, "A": 0.06 + 0.08j, "P": 0.3 + 0j, "Q": 0.5 + 0j},
        {"crank": "O2 A", "yoke!": "P Q"},
        "O2",
        [
            PlanarJoint("A", "slider", direction=np.pi / 2, guide="yoke"),
            PlanarJoint("P", "slider", direction=0.0),
            PlanarJoint("Q", "slider", direction=0.0),
        ],
    )


def steps(of: PlanarLinkage) -> list[type]:
    return [type(step) for step in of._assembly.steps]


# --- known motions ------------------------------------------------------------------------------


@pytest.mark.parametrize("offset", [0.0, 0.03])
def test_a_slider_crank_moves_as_its_formula(offset):
    crank, rod = 0.15, 0.3
    drawn = slider_crank(crank, rod, offset)
    assert steps(drawn) == [TwoLoci]
    motion = drawn.motion(TURN, 2.0)
    place = motion.position(1, rod)
    swing = (offset - crank * np.sin(TURN)) / rod
    np.testing.assert_allclose(
        place[:, 0], crank * np.cos(TURN) + rod * np.sqrt(1 - swing**2), atol=1e-15
    )
    np.testing.assert_allclose(place[:, 1], offset, atol=1e-16)
    rate = -crank * np.cos(TURN) * 2.0 / (rod * np.sqrt(1 - swing**2))
    np.testing.assert_allclose(motion.angular_velocity[:, 1], rate, atol=1e-14)


def test_a_quick_return_swings_as_its_formula():
    """arctan of the crank's pin seen from the arm's pivot; sliding along the arm's own line."""
    drawn = quick_return()
    assert steps(drawn) == [SlidingBody]
    motion = drawn.motion(TURN, 1.0)
    pin = 0.1 * np.exp(1j * TURN) + 0.3j
    assert np.abs(angle_difference(motion.angle[:, 1], np.angle(pin))).max() < 1e-15
    rate = (np.conj(pin) * 0.1j * np.exp(1j * TURN)).imag / np.abs(pin) ** 2
    np.testing.assert_allclose(motion.angular_velocity[:, 1], rate, atol=1e-14)
    check_rates(drawn, drawn.drawn_angle + 0.2)


def test_a_yoke_moves_as_the_cosine():
    """A body without a turning joint has no dyad here: Newton's method follows it."""
    drawn = scotch_yoke()
    assert steps(drawn) == [NewtonGroup]
    motion = drawn.motion(TURN, 3.0)
    moved = motion.position(1, 0.0)[:, 0] - (0.3 - 0.06)
    np.testing.assert_allclose(moved, 0.1 * np.cos(TURN), atol=1e-14)
    velocity = motion.velocity(1, 0.0)[:, 0]
    np.testing.assert_allclose(velocity, -0.3 * np.sin(TURN), atol=1e-13)
    np.testing.assert_allclose(motion.angle[:, 1], 0.0, atol=1e-14)


def test_a_slider_on_a_rocker_moves_with_it():
    """Its line turns, and is accelerated, with the rocker."""
    drawn = linkage(
        {
            "O2": 0j,
            "A": 0.05 + 0.0866j,
            "B": 0.2638 + 0.2665j,
            "O4": 0.254 + 0j,
            "C": 0.35 + 0.15j,
            "D": 0.27 + 0.21j,
        },
        {"crank": "O2 A", "coupler": "A B C", "rocker!": "O4 B", "rod": "C D"},
        "O2 O4",
        [PlanarJoint("D", "slider", direction=0.3, guide="rocker")],
    )
    assert steps(drawn) == [TwoLoci, TwoLoci]
    check_rates(drawn, drawn.drawn_angle + 0.2)


def test_a_ram_that_two_bushings_guide_does_not_turn():
    drawn = linkage(
        {"O2": 0j, "A": 0.1j, "B": 0.3 + 0.05j, "C": 0.5 + 0.15j},
        {"crank": "O2 A", "rod": "A B", "ram": "B C"},
        "O2",
        [
            PlanarJoint("B", "slider", direction=np.arctan2(0.1, 0.2)),
            PlanarJoint("C", "slider", direction=np.arctan2(0.1, 0.2)),
        ],
    )
    motion = drawn.motion(np.linspace(1.3, 1.8, 11), 1.0)
    assert np.abs(motion.angle[:, 2] - np.arctan2(0.1, 0.2)).max() < 1e-14
    check_rates(drawn, drawn.drawn_angle + 0.2)


def test_parallel_lines_of_ground_and_crank_turn_what_slides_on_both():
    """They are parallel in the drawing alone: the ram does not translate as between bushings."""
    drawn = linkage(
        {"O2": 0j, "A": 0.1 + 0j, "P": 0.35 + 0.1j, "R": 0.4 - 0.02j, "Q": 0.25 - 0.1j},
        {"crank!": "O2 A", "ram!": "P R Q", "rod": "A R"},
        "O2",
        [
            PlanarJoint("P", "slider", direction=0.0),
            PlanarJoint("Q", "slider", direction=0.0, guide="crank"),
        ],
    )
    angle = np.linspace(-0.05, 0.1, 9)
    motion = drawn.motion(angle)
    _, r, q, end = (
        motion.position(link, own.length) for link, own in enumerate(drawn.topology.links)
    )
    assert np.abs(motion.origin[:, 1, 1] - 0.1).max() < 1e-13
    assert np.abs(end - r).max() < 1e-13
    on_crank = (q[:, 0] + 1j * q[:, 1]) * np.exp(-1j * angle)
    assert np.abs(on_crank.imag + 0.1).max() < 1e-13
    assert np.ptp(motion.angle[:, 1]) > 0.1
    check_rates(drawn, 0.05)


def test_a_six_bar_driven_at_its_output_stands_as_when_its_crank_drives_it():
    """Four links have to be found together: no dyad hangs on the driven one alone."""
    crank_driven = load_mechanism(MODELS / "stephenson_six_bar.toml").linkage
    output_driven = PlanarLinkage(
        crank_driven.points,
        crank_driven.links,
        crank_driven.ground,
        (PlanarJoint("O6", "clamp"),),
        crank_driven.drawn_at,
    )
    assert steps(output_driven) == [NewtonGroup]
    angles = np.radians(np.linspace(50.0, 75.0, 26))
    first = crank_driven.motion(angles, 1.0)
    output = crank_driven.topology.index("output")
    turned = angle_difference(
        first.angle[:, output], crank_driven.motion(np.radians(60)).angle[output]
    )
    speed = first.angular_velocity[:, output]
    second = output_driven.motion(
        np.radians(60) + turned, speed, first.angular_acceleration[:, output]
    )
    np.testing.assert_allclose(second.origin, first.origin, atol=1e-13)
    np.testing.assert_allclose(second.angular_velocity, first.angular_velocity, atol=1e-11)
    np.testing.assert_allclose(second.angular_acceleration, first.angular_acceleration, atol=1e-9)


# --- topology -----------------------------------------------------------------------------------


def test_rigid_ends_lead_and_further_joints_of_a_point_are_named_by_their_beams():
    drawn = linkage(
        {"O2": 0j, "A": 0.1j, "B": 0.3 + 0.2j, "O4": 0.25 + 0j, "C": 0.4 + 0.25j, "O6": 0.5 + 0j},
        {"crank": "O2 A", "coupler": "A B", "rocker!": "O4 B", "rod": "B C", "output": "O6 C"},
        "O2 O4 O6",
    )
    topology = drawn.topology
    assert topology.clamps == (Clamp("O2", LinkEnd("crank", "start")),)
    assert topology.pins == (
        Pin("A", LinkEnd("crank", "end"), LinkEnd("coupler", "start")),
        Pin("B", LinkEnd("rocker", "end"), LinkEnd("coupler", "end")),
        Pin("B-rod", LinkEnd("rocker", "end"), LinkEnd("rod", "start")),
        Pin("C", LinkEnd("rod", "end"), LinkEnd("output", "end")),
    )
    assert topology.pivots == (
        Pivot("O4", LinkEnd("rocker", "start")),
        Pivot("O6", LinkEnd("output", "start")),
    )
    assert [link.rigid for link in topology.links] == [False, False, True, False, False]


def test_chains_are_welded_and_pivoted_once():
    topology = load_mechanism(MODELS / "watt_six_bar.toml").linkage.topology
    assert topology.welds == (
        Weld("O4-rocker-2", LinkEnd("rocker-1", "end"), LinkEnd("rocker-2", "start")),
    )
    assert Pivot("O4", LinkEnd("rocker-1", "end")) in topology.pivots
    topology = load_mechanism(MODELS / "stephenson_six_bar.toml").linkage.topology
    assert topology.link_names == (
        "crank", "coupler-1", "coupler-2", "rocker", "connector", "output",
    )  # fmt: skip
    assert Weld("B-coupler-2", LinkEnd("coupler-1", "end"), LinkEnd("coupler-2", "start")) in (
        topology.welds
    )


def test_sliders_have_their_lines_in_the_axes_of_what_guides_them():
    (slider,) = slider_crank(offset=0.03).topology.sliders
    assert slider == Slider("B", LinkEnd("rod", "end"), 0.0, 0.03)
    guided = linkage(
        {"O2": 0j, "A": 0.1 + 0j, "O4": 0.05 - 0.3j, "C": 0.05 + 0.3j},
        {"crank": "O2 A", "arm!": "O4 C"},
        "O2 O4",
        [PlanarJoint("A", "slider", direction=0.0, guide="arm")],
    )
    (slider,) = guided.topology.sliders
    assert slider == Slider("A", LinkEnd("crank", "end"), 0.0, pytest.approx(-0.05), "arm")


def test_several_links_may_be_on_the_shaft():
    points = {"O2": 0j, "A": 0.1j, "B": 0.3 + 0.2j, "O4": 0.25 + 0j, "W": -0.05j}
    links = {"crank": "O2 A", "coupler": "A B", "rocker": "O4 B", "weight": "O2 W"}
    with pytest.raises(InputError, match="crank, weight meet at the clamp O2; say which are on"):
        linkage(points, links, "O2 O4")
    topology = linkage(points, links, "O2 O4", clamped=("crank", "weight")).topology
    assert topology.clamps == (Clamp("O2", LinkEnd("crank", "start")),)
    assert topology.welds == (
        Weld("O2-weight", LinkEnd("crank", "start"), LinkEnd("weight", "start")),
    )
    for first, angle in (("crank", np.pi / 2), ("weight", -np.pi / 2)):
        shaft = (first, "weight" if first == "crank" else "crank")
        assert linkage(points, links, "O2 O4", clamped=shaft).drawn_angle == pytest.approx(angle)


@pytest.mark.parametrize("idler", ["idler", "idler!"])
def test_a_link_may_turn_about_the_shaft(idler):
    """A rocker on the crank's own axis is pivoted there, and does not turn with the shaft."""
    drawn = linkage(
        {"O2": 0j, "A": 0.1j, "B": 0.26 + 0.26j, "O4": 0.25 + 0j, "C": 0.1 + 0.35j},
        {"crank": "O2 A", "coupler": "A B", "rocker": "O4 B", "rod": "B C", idler: "O2 C"},
        "O2 O4",
        clamped=("crank",),
    )
    assert drawn.topology.clamps == (Clamp("O2", LinkEnd("crank", "start")),)
    assert Pivot("O2-idler", LinkEnd("idler", "start")) in drawn.topology.pivots
    motion = drawn.motion(np.pi / 2, 1.0)
    assert motion.angular_velocity[0] == 1.0
    assert 0 < abs(motion.angular_velocity[4]) < 0.9
    assert np.all(motion.origin[4] == 0)


# --- lengths ------------------------------------------------------------------------------------


def test_a_resized_linkage_keeps_the_angles_of_its_welds():
    drawn = load_mechanism(MODELS / "stephenson_six_bar.toml").linkage
    lengths = {link.name: link.length for link in drawn.topology.links}
    longer = {
        name: length * (1.01 if "coupler" in name else 1.002) for name, length in lengths.items()
    }
    grown = drawn.resized(longer, 1.001)
    for link in grown.topology.links:
        assert link.length == pytest.approx(longer[link.name], rel=1e-14)
    assert grown.points["O6"] == pytest.approx((0.3003, 0.5005), rel=1e-15)
    corner = [m.angle[2] - m.angle[1] for m in (drawn.motion(1.0), grown.motion(1.0))]
    assert corner[0] == pytest.approx(corner[1], abs=1e-14)
    assert drawn.resized(lengths, 1.0) is drawn


def test_a_resized_four_bar_is_the_four_bar_of_its_lengths():
    own = load_mechanism(MODELS / "steel_fourbar.toml").linkage
    drawn = drawn_as_planar(own, 0.7)
    lengths = {"crank": 0.101, "coupler": 0.281, "rocker": 0.268}
    first, second = (each.resized(lengths, 1.003).motion(TURN) for each in (own, drawn))
    np.testing.assert_allclose(second.origin, first.origin, atol=1e-14)
    assert np.abs(angle_difference(second.angle, first.angle)).max() < 1e-13


def test_lines_on_guides_grow_with_them():
    drawn = linkage(
        {"O2": 0j, "A": 0.1 + 0j, "O4": 0.05 - 0.3j, "C": 0.05 + 0.3j},
        {"crank": "O2 A", "arm!": "O4 C"},
        "O2 O4",
        [PlanarJoint("A", "slider", direction=0.0, guide="arm")],
    )
    grown = drawn.resized({"crank": 0.1, "arm": 0.66}, 1.0)
    assert grown.topology.sliders[0].offset == pytest.approx(-0.055, rel=1e-13)


# --- where it cannot stand ----------------------------------------------------------------------


def test_a_line_of_the_ground_grows_with_it():
    grown = slider_crank(offset=0.03).resized({"crank": 0.16, "rod": 0.31}, 1.01)
    motion = grown.motion(TURN)
    end = motion.position(1, 0.31)
    np.testing.assert_allclose(end[:, 1], 0.0303, rtol=1e-12)
    np.testing.assert_allclose(np.abs(motion.origin[:, 1]).max(), 0.16, rtol=1e-12)


def test_a_gap_names_the_crank_angle_and_the_joint():
    short = slider_crank(crank=0.3, rod=0.35, offset=0.1)
    with pytest.raises(
        InputError, match=r"at crank angle 270 deg: rod and its line do not meet in joint B"
    ):
        short.motion(np.radians([90.0, 270.0]))


def test_a_dead_point_names_the_crank_angle_and_the_joint():
    equal = slider_crank(crank=0.2, rod=0.2, offset=0.05)
    with pytest.raises(InputError, match=r"locks at crank angle .* at joint B rod and its line"):
        equal.motion(np.arcsin(-0.75) + 1e-14)


def test_beyond_a_dead_point_newtons_method_does_not_go():
    model = load_mechanism(MODELS / "stephenson_six_bar.toml").linkage
    driven = PlanarLinkage(
        model.points, model.links, model.ground, (PlanarJoint("O6", "clamp"),), model.drawn_at
    )
    with pytest.raises(
        InputError,
        match=r"at crank angle 180 deg: from the drawing on it locks at "
        r"crank angle [\d.]+ deg, where .* dead point at joint [A-E]",
    ) as refused:
        driven.motion(np.pi)
    locked = np.radians(float(str(refused.value).split("locks at crank angle ")[1].split()[0]))
    back = np.sign(driven.drawn_angle - locked)
    driven.motion(locked + 1e-4 * back)
    with pytest.raises(InputError, match="from the drawing on it locks"):
        driven.motion(locked - 1e-4 * back)
    assert driven.described()[-1] == "the crank does not turn fully"


def test_a_drawing_in_a_dead_point_is_refused():
    with pytest.raises(InputError, match=r"locks at crank angle 90 deg: at joint B"):
        linkage(
            {"O2": 0j, "A": 0.1j, "B": 0.4j},
            {"crank": "O2 A", "rod": "A B"},
            "O2",
            [PlanarJoint("B", "slider", direction=0.0)],
        )


def test_a_linkage_that_takes_two_turns_is_refused():
    """An antiparallelogram with equal opposite sides changes its branch where all are in line."""
    with pytest.raises(InputError, match=r"locks|come back"):
        linkage(
            {"O2": 0j, "A": 0.1j, "B": 0.3 + 0.1j, "O4": 0.3 + 0j},
            {"crank": "O2 A", "coupler": "A B", "rocker": "O4 B"},
            "O2 O4",
        ).motion(TURN)
