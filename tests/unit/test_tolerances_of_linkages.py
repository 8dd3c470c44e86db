"""Tolerances of rigid linkages: each test fails if its constant is taken away or is another one."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech.arrays import ROUND_OFF, SAME_PLACE
from flexmech.errors import InputError
from flexmech.linkages import (
    CouplerCurve,
    CouplerPoint,
    FourBar,
    PlanarJoint,
    PlanarLink,
    PlanarLinkage,
    RotatingArm,
    finite_double_points,
    focal_cubic,
)
from flexmech.linkages.applied_forces import SpringLine
from flexmech.linkages.attachments import GROUND, AttachmentPoint, Spring
from flexmech.linkages.link_mass import LinkMass
from flexmech.linkages.linkage import continuous_angles
from flexmech.linkages.motion import LOCKING_SINE
from flexmech.linkages.planar.dyads import TwoLoci
from flexmech.linkages.planar.newton import LARGEST_STEP, NewtonGroup
from flexmech.mesh import STATIONS, pieces
from flexmech.modelfile.link_places import LinkPlaces

NEARER, FARTHER = 0.1 * SAME_PLACE, 10 * SAME_PLACE


def drawn(points, links, ground, *joints, clamp="O2") -> PlanarLinkage:
    """A linkage whose links are ``name: points``; rigid ones end with an exclamation mark."""
    return PlanarLinkage(
        {name: (complex(place).real, complex(place).imag) for name, place in points.items()},
        tuple(
            PlanarLink(name.rstrip("!"), tuple(chain.split()), name.endswith("!"))
            for name, chain in links.items()
        ),
        tuple(ground.split()),
        (PlanarJoint(clamp, "clamp"), *joints),
    )


def drawn_four_bar(crank=0.1, coupler=0.28, rocker=0.27, ground=0.25, **further) -> PlanarLinkage:
    pin = 1j * crank
    motion = FourBar(ground, crank, coupler, rocker).motion(np.pi / 2)
    joint = complex(*motion.position(1, coupler))
    points = {"O2": 0, "A": pin, "B": joint, "O4": ground, **further}
    return drawn(points, {"crank": "O2 A", "coupler": "A B", "rocker": "O4 B"}, "O2 O4")


def newton_group(linkage: PlanarLinkage) -> NewtonGroup:
    """Coupler and rocker of a drawn four-bar as Newton's method finds them together."""
    assembly = linkage._assembly
    bodies = assembly.bodies
    joints = tuple(own for own in bodies.coincidences if own.point != "O2")
    return NewtonGroup(linkage.drawing, bodies, joints, (2, 3), linkage.drawn_angle)


def followed(linkage: PlanarLinkage):
    return newton_group(linkage).trace_path(linkage._assembly._driven)


# --- places that are one ------------------------------------------------------------------------


def test_points_of_a_drawing_that_are_one():
    def chain(apart):
        points = {"O2": 0, "A": 1, "B": 1 + apart}
        return drawn(points, {"crank": "O2 A", "tip": "A B"}, "O2", PlanarJoint("A", "weld"))

    assert chain(FARTHER).topology.links[1].length == pytest.approx(FARTHER)
    with pytest.raises(InputError, match="points A and B coincide"):
        chain(NEARER)


def test_lengths_that_make_a_change_point():
    assert FourBar(3 * 0.1, 0.1, 0.2, 0.2).grashof_class == "change-point"
    assert FourBar(0.3 + 0.8 * NEARER, 0.1, 0.2, 0.2).grashof_class == "change-point"
    assert FourBar(0.3 - FARTHER, 0.1, 0.2, 0.2).grashof_class != "change-point"


def test_ends_of_a_spring_that_meet():
    arm = RotatingArm(1.0)
    motion = arm.motion(np.zeros(1))

    def line(apart):
        ends = AttachmentPoint("arm", 1.0 - apart), AttachmentPoint(GROUND, 1.0)
        return SpringLine.of(Spring("s", *ends, 1.0, 0.5), arm.topology, motion)

    assert line(FARTHER).along[0, 0] == 1.0
    with pytest.raises(InputError, match="its ends meet"):
        line(NEARER)


def test_places_at_the_end_of_a_drawn_link():
    places, end = LinkPlaces(drawn_four_bar()), drawn_four_bar().topology.links[1].length
    assert places.place("coupler", end * (1 + NEARER)).x == end
    with pytest.raises(InputError, match="beyond the end"):
        places.place("coupler", end * (1 + FARTHER))


def test_point_masses_at_the_ends_make_no_element():
    assert len(pieces(2.0, [2 * NEARER, 2 - 2 * NEARER])) == 1
    assert len(pieces(2.0, [2 * FARTHER, 1.0, 1.0 + 2 * NEARER])) == 3


def test_welded_frames_fit_after_they_have_grown():
    points = {"O2": 0, "A": 0.1, "B": 0.05 + 0.08j, "C": 0.031 + 0.17j}
    links = {"crank": "O2 A", "side": "A B", "back": "O2 B", "tip": "B C"}
    welds = [PlanarJoint(name, "weld") for name in "AB"]
    frame = PlanarLinkage(
        {name: (complex(p).real, complex(p).imag) for name, p in points.items()},
        tuple(PlanarLink(name, tuple(chain.split())) for name, chain in links.items()),
        ("O2",),
        (PlanarJoint("O2", "clamp", ("crank", "back")), *welds),
    )
    own = {link.name: link.length for link in frame.topology.links}
    grown = frame.resized({name: 1.0173 * length for name, length in own.items()}, 1.0)
    assert grown.topology.links[2].length == pytest.approx(1.0173 * own["back"], rel=1e-14)
    almost = {**own, "side": own["side"] * (1 + NEARER)}
    assert frame.resized(almost, 1.0) is not frame
    with pytest.raises(InputError, match="do not fit"):
        frame.resized({**own, "side": own["side"] * (1 + 100 * FARTHER)}, 1.0)


# --- round-off ----------------------------------------------------------------------------------


def limit_angles() -> list[tuple[FourBar, float]]:
    """Four-bars whose cranks swing, at the angles at which coupler and rocker are stretched."""
    found = []
    for number in range(60):
        coupler, rocker = 0.1 + 0.001 * number, 0.15
        cosine = (0.25**2 + 0.2**2 - (coupler + rocker) ** 2) / (2 * 0.25 * 0.2)
        found.append((FourBar(0.25, 0.2, coupler, rocker), float(np.arccos(cosine))))
    return found


def test_limit_positions_lock_and_are_not_apart():
    for linkage, angle in limit_angles():
        assert linkage.transmission_angle(angle) > np.pi - 1e-6
        with pytest.raises(InputError, match="in one line"):
            linkage.motion(angle)


def test_loci_that_touch_lock_and_are_not_apart():
    linkage = drawn_four_bar(0.2, 0.2, 0.15, 0.25)
    four_bar = FourBar(0.25, 0.2, 0.2, 0.15)
    for scale in 1 + 1e-3 * np.arange(20):
        crank, rocker = 0.2 * scale, 0.15 * scale
        cosine = (0.25**2 + crank**2 - (0.2 + rocker) ** 2) / (2 * 0.25 * crank)
        lengths = {"crank": crank, "coupler": four_bar.coupler, "rocker": rocker}
        with pytest.raises(InputError, match="locks"):
            linkage.resized(lengths, 1.0).motion(np.arccos(cosine))


def test_links_too_short_to_meet_are_told_when_they_are_resized():
    lengths = {"crank": 0.1, "coupler": 0.05, "rocker": 0.05}
    with pytest.raises(InputError, match="cannot be put together"):
        drawn_four_bar().resized(lengths, 1.0)


def test_slotted_links_that_are_touched_lock_and_are_not_apart():
    """A pin on a slotted link whose slot passes a pivot at a distance that the pin just has."""
    for number in range(40):
        beside = 0.15 + 1e-3 * number
        pin = 0.1j
        from_pivot = pin - 0.2
        ahead = np.sqrt(abs(from_pivot) ** 2 - beside**2)
        along = from_pivot / (ahead + 1j * beside)
        points = {"O2": 0, "A": pin, "O4": 0.2, "C": 0.2 + 0.4 * along / abs(along)}
        links = {"crank": "O2 A", "slotted!": "O4 C"}
        slider = PlanarJoint("A", "slider", direction=0.0, guide="slotted")
        linkage = drawn(points, links, "O2 O4", slider)
        limit = np.arccos((0.1**2 + 0.2**2 - beside**2) / (2 * 0.1 * 0.2))
        with pytest.raises(InputError, match="locks"):
            linkage.motion(limit)


def test_circles_about_one_centre_do_not_meet():
    """A crank as long as the ground leads its pin through the other pivot."""
    for rocker in (0.15, 0.21):
        linkage = drawn_four_bar(0.2, 0.21, rocker, 0.2)
        with np.errstate(all="raise"), pytest.raises(InputError, match="cannot be assembled"):
            linkage.motion(0.0)


def test_a_point_in_a_pin_has_no_double_points():
    linkage = FourBar(0.25, 0.1, 0.28, 0.27)
    for part in (0.0, 1e-16, 0.1 * ROUND_OFF):
        assert finite_double_points(linkage, CouplerPoint(part * 0.28, 0.7)) == ()
    assert finite_double_points(linkage, CouplerPoint(10 * ROUND_OFF * 0.28, 0.7))


# --- locked positions, cusps --------------------------------------------------------------------


def at_transmission_sine(linkage: FourBar, sine: float) -> float:
    """Crank angle at which coupler and rocker are in line but for a sine."""
    sides = linkage.coupler**2 + linkage.rocker**2 - linkage.ground**2 - linkage.crank**2
    cosine = -np.sqrt(1 - sine**2) * 2 * linkage.coupler * linkage.rocker
    return float(np.arccos((cosine - sides) / (2 * linkage.ground * linkage.crank)))


@pytest.mark.parametrize("as_drawn", [False, True])
def test_positions_near_a_dead_point_lock(as_drawn):
    four_bar = FourBar(0.25, 0.2, 0.21, 0.15)
    linkage = drawn_four_bar(0.2, 0.21, 0.15, 0.25) if as_drawn else four_bar
    linkage.motion(at_transmission_sine(four_bar, 10 * LOCKING_SINE))
    with pytest.raises(InputError, match="locks"):
        linkage.motion(at_transmission_sine(four_bar, 0.1 * LOCKING_SINE))


def test_a_drawing_in_a_dead_point_is_refused_by_newtons_method():
    four_bar = FourBar(0.25, 0.2, 0.2, 0.15)

    def refuse(sine):
        motion = four_bar.motion(at_transmission_sine(four_bar, sine))
        pin, joint = (complex(*motion.position(0, 0.2)), complex(*motion.position(1, 0.2)))
        points = {"O2": 0, "A": pin, "B": joint, "O4": 0.25}
        linkage = drawn(points, {"crank": "O2 A", "coupler": "A B", "rocker": "O4 B"}, "O2 O4")
        newton_group(linkage).refuse_locking(linkage._assembly._driven(np.zeros(1)))

    refuse(100 * LOCKING_SINE)
    with pytest.raises(InputError, match="locks"):
        refuse(1.5 * LOCKING_SINE)


def test_a_cusp_is_told_within_round_off():
    """The instant centre of the coupler traces a cusp."""
    linkage = FourBar(0.25, 0.1, 0.28, 0.27)
    motion = linkage.motion(1.1, crank_speed=1.0)
    pin, speed = motion.origin[1], motion.origin_velocity[1]
    turning = motion.angular_velocity[1]
    arm = np.array([-speed[1], speed[0]]) / turning
    place = complex(*arm) * np.exp(-1j * motion.angle[1])
    point = CouplerPoint(abs(place), float(np.angle(place)))
    kinds = [node.kind for node in finite_double_points(linkage, point)]
    assert kinds.count("cusp") == 1
    assert np.hypot(*pin) == pytest.approx(0.1)
    beside = CouplerPoint(abs(place) * (1 + 1e-8), float(np.angle(place)))
    assert all(node.kind != "cusp" for node in finite_double_points(linkage, beside))
    curve = CouplerCurve(linkage, point)
    with pytest.raises(InputError, match="cusp"):
        curve.curvature(1.1)
    assert np.isfinite(curve.curvature(1.1 + 1e-6))


def test_roots_of_the_focal_cubic_are_as_exact_as_the_cubic():
    random = np.random.default_rng(1)
    worst = 0.0
    for _ in range(300):
        lengths = random.uniform(0.1, 0.3, 4)
        try:
            linkage = FourBar(*lengths)
        except InputError:
            continue
        point = CouplerPoint(random.uniform(0.01, 0.5), random.uniform(0, 2 * np.pi))
        cubic = focal_cubic(linkage, point)
        size = max(abs(cubic.value(np.cos(a), np.sin(a))) for a in np.linspace(0, np.pi, 9))
        residuals = [abs(cubic.value(np.cos(a), np.sin(a))) / size for a in cubic.roots()]
        worst = max(worst, *residuals)
    assert worst < 1e-14


# --- the way around a turn ----------------------------------------------------------------------


def test_newtons_method_takes_steps_of_use():
    path = followed(drawn_four_bar())
    assert path.locks == ("", "")
    assert np.diff(path.angle).max() <= LARGEST_STEP + 1e-12
    assert len(path.angle) < 80
    four_bar = FourBar(0.25, 0.1, 0.28, 0.27)
    between = (path.angle[1:] + path.angle[:-1]) / 2
    turned = four_bar.motion(between + np.pi / 2).angle[:, 1] - four_bar.motion(np.pi / 2).angle[1]
    missed = np.angle(np.exp(1j * (path.guess(between)[:, 2] - turned)))
    assert np.abs(missed).max() < 1e-4


def test_the_angle_at_which_a_group_locks_is_told_to_six_digits():
    path = followed(drawn_four_bar(0.2, 0.2, 0.15, 0.25))
    cosine = (0.25**2 + 0.2**2 - 0.35**2) / (2 * 0.25 * 0.2)
    limit = np.arccos(cosine)
    assert path.locks[1]
    assert path.angle[-1] + np.pi / 2 == pytest.approx(limit, abs=2e-7)


def test_a_posture_that_comes_back_is_the_same():
    group = newton_group(drawn_four_bar())
    start = np.zeros(6)
    for apart, refused in ((1e-9, False), (1e-7, True)):
        unknowns = np.stack([start, start + apart])
        if refused:
            with pytest.raises(InputError, match="do not come back"):
                group._check_period(unknowns)
        else:
            group._check_period(unknowns)


def test_lines_that_are_parallel_guide_without_turning():
    points = {"O2": 0, "A": 0.1j, "B": 0.3, "C": 0.4}
    links = {"crank": "O2 A", "rod": "A B", "piston!": "B C"}
    sliders = [
        PlanarJoint("B", "slider", direction=0.0),
        PlanarJoint("C", "slider", direction=np.pi),
    ]
    steps = drawn(points, links, "O2", *sliders)._assembly.steps
    assert all(isinstance(step, TwoLoci) for step in steps)


def test_a_linkage_that_is_resized_back_is_the_same():
    linkage = drawn_four_bar()
    own = {link.name: link.length for link in linkage.topology.links}
    longer = {"crank": own["crank"], "coupler": 1.2 * own["coupler"], "rocker": own["rocker"]}
    back = linkage.resized(longer, 1.1).resized(own, 1 / 1.1)
    for name, place in linkage.points.items():
        np.testing.assert_allclose(back.points[name], place, atol=2e-16)


def test_angles_are_followed_through_a_fast_part_of_the_turn():
    linkage = FourBar(0.1, 0.2, 0.21, 0.195)
    angles = np.linspace(0.0, 2 * np.pi, 3601)
    followed_here = np.unwrap(linkage.motion(angles).angle, axis=0)
    found = continuous_angles(linkage, linkage.motion(angles[::100]))
    np.testing.assert_allclose(found, followed_here[::100], atol=1e-9)


# --- numbers of a linkage -----------------------------------------------------------------------


def test_speeds_beyond_all_shafts_are_refused():
    linkage = FourBar(0.25, 0.1, 0.28, 0.27)
    linkage.motion(0.0, 5e8)
    with pytest.raises(InputError, match="which no shaft"):
        linkage.motion(0.0, 2e9)


def test_points_too_near_for_a_beam_element_become_one():
    mass = LinkMass.of_points(1.0, 1.0, [(0.5, 0.1), (0.5 + 1 / 600, 0.1)])
    assert len(mass.point_masses) == 1
    mass = LinkMass.of_points(1.0, 1.0, [(0.5, 0.1), (0.5 + 1 / 400, 0.1)])
    assert len(mass.point_masses) == 2


def test_stations_are_at_the_quarters_of_a_link():
    places = np.linspace(0.0, 1.0, STATIONS)
    assert {0.25, 0.5, 0.75} <= set(places.round(12).tolist())
    assert 16 <= STATIONS <= 40
