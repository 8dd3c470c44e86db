"""Double points of coupler curves where geometry tells them, and how they come and go."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from flexmech.errors import ComputationError
from flexmech.linkages import CouplerCurve, CouplerPoint, FourBar, coupler_sextic, double_points
from flexmech.linkages.coupler_curves.double_points import finite_double_points
from scenarios._cusp_transitions import cusp_transitions
from tests.support.strategies import angles, numbers, postures

few = settings(max_examples=20)
branches = st.sampled_from(["open", "crossed"])
points = st.builds(CouplerPoint, numbers(0.05, 2.0), angles())


def away_from_change_points(linkage: FourBar, least: float = 1e-3) -> bool:
    ordered = sorted(linkage.lengths.values())
    return abs(ordered[0] + ordered[3] - ordered[1] - ordered[2]) > least


def crank_rocker(
    crank: float, coupler: float, rocker: float, branch: str, least: float = 0.02
) -> FourBar:
    """With the ground as unit."""
    ordered = sorted((1.0, crank, coupler, rocker))
    assume(crank == ordered[0])
    assume(ordered[0] + ordered[3] < ordered[1] + ordered[2] - least)
    return FourBar(1.0, crank, coupler, rocker, branch)


crank_rockers = st.builds(
    crank_rocker, numbers(0.1, 0.6), numbers(0.4, 1.5), numbers(0.4, 1.5), branches
)


def instant_centre(linkage: FourBar, crank_angle: float) -> complex:
    """Where the lines of crank and rocker meet."""
    theta2, _, theta4 = linkage.motion(crank_angle).angle
    return np.exp(1j * theta2) * linkage.ground * np.sin(theta4) / np.sin(theta4 - theta2)


def fixed_to_coupler(linkage: FourBar, crank_angle: float, place: complex) -> CouplerPoint:
    """Coupler point that is at a place at a crank angle."""
    arm = place - linkage.crank * np.exp(1j * crank_angle)
    return CouplerPoint(abs(arm), float(np.angle(arm) - linkage.motion(crank_angle).angle[1]))


def opening(linkage: FourBar, point: CouplerPoint, double) -> float:
    """Largest gap of the loop and of the place in both passages over the linkage's size."""
    d, a, b, c = linkage.lengths.values()
    pin_a, coupler = a * np.exp(1j * double.crank_angles), np.exp(1j * double.coupler_angles)
    place = pin_a + point.distance * coupler * np.exp(1j * point.angle)
    gaps = [abs(pin_a + b * coupler - d) - c, abs(place - complex(*double.position))]
    return float(np.abs(gaps).max() / (d + a + b + c + point.distance))


@few
@given(postures(), points, st.booleans())
def test_both_passages_close_and_meet(posture, point: CouplerPoint, upper: bool) -> None:
    """Of linkages of every class, in the coordinates of both passages."""
    linkage = posture.linkage
    assume(away_from_change_points(linkage))
    angle = abs(posture.crank_angle) * (1 if upper else -1)
    for double in double_points(linkage, point, angle):
        assert opening(linkage, point, double) < 1e-12
        assert abs(coupler_sextic(linkage, point, double.position)) < 1e-10
        assert 0 <= double.crank_angles[0] <= double.crank_angles[1] < 2 * np.pi


@pytest.mark.parametrize(("distance", "gap"), [(1e3, 1e-11), (1e5, 1e-9)])
def test_points_far_from_the_coupler(distance: float, gap: float) -> None:
    """Their curves are nearly circles' arcs, and loops no smaller than the crank's circle."""
    generator, found = np.random.default_rng(1), []
    for angle in generator.uniform(0, 2 * np.pi, 200):
        crank, coupler, rocker = generator.uniform([0.1, 0.9, 0.9], [0.6, 1.2, 1.2])
        linkage = FourBar(1.0, crank, coupler, rocker)
        if away_from_change_points(linkage):
            point = CouplerPoint(distance, angle)
            found += [(linkage, point, double) for double in double_points(linkage, point)]
    assert len(found) > 20
    assert max(opening(*each) for each in found) < gap
    assert {double.kind for *_, double in found} == {"crunode"}


@few
@given(crank_rockers, points)
def test_sextic_is_stationary_at_every_finite_double_point(
    linkage: FourBar, point: CouplerPoint
) -> None:
    """At acnodes and crossings of two circuits too; they are one or three."""
    assume(point.triangle(linkage.coupler).far > 1e-3)
    found = finite_double_points(linkage, point)
    assert len(found) in (1, 3)
    for node in found:
        position, size = np.array(node.position), 1 + math.hypot(*node.position)
        assume(size < 10)
        step = 1e-4 * size * np.array([[1, 0], [-1, 0], [0, 1], [0, -1]])
        around = coupler_sextic(linkage, point, position + step)
        scale = np.abs(coupler_sextic(linkage, point, position + 1e3 * step)).max()
        assert abs(coupler_sextic(linkage, point, position)) < 1e-10 * scale
        assert np.abs(around).max() < 1e-4 * scale


@few
@given(crank_rockers, angles())
def test_instant_centre_traces_a_cusp(linkage: FourBar, crank_angle: float) -> None:
    centre = instant_centre(linkage, crank_angle)
    assume(abs(centre) < 10)
    point = fixed_to_coupler(linkage, crank_angle, centre)
    assume(point.distance > 0.02)
    assume(point.triangle(linkage.coupler).far > 0.02)
    cusps = [d for d in double_points(linkage, point) if d.kind == "cusp"]
    assert len(cusps) == 1
    (cusp,) = cusps
    assert cusp.position == pytest.approx([centre.real, centre.imag], abs=1e-9)
    turned = np.remainder(cusp.crank_angles - crank_angle + 1, 2 * np.pi) - 1
    assert turned == pytest.approx([0.0, 0.0], abs=1e-8)
    assert CouplerCurve(linkage, point).speed(cusp.crank_angles).max() < 1e-7


@few
@given(crank_rockers, angles(), numbers(1e-4, 1e-2))
def test_beyond_the_instant_centre_is_a_loop_and_before_it_none(
    linkage: FourBar, crank_angle: float, way: float
) -> None:
    """Points along the crank's line near its pole: one side loops and the other does not."""
    centre = instant_centre(linkage, crank_angle)
    assume(abs(centre) < 4)
    assume(abs(centre - linkage.crank * np.exp(1j * crank_angle)) > 0.1)
    assume(fixed_to_coupler(linkage, crank_angle, centre).triangle(linkage.coupler).far > 0.1)

    def family(offset: float) -> tuple[FourBar, CouplerPoint]:
        place = centre + offset * np.exp(1j * crank_angle)
        return linkage, fixed_to_coupler(linkage, crank_angle, place)

    cusp = min(cusp_transitions(family, -way, way, steps=6), key=lambda t: abs(t.parameter))
    assert cusp.kind == "cusp"
    assert abs(cusp.parameter) < 1e-9
    assert abs(np.exp(1j * (cusp.crank_angle - crank_angle)) - 1) < 1e-6
    assert abs(cusp.crunodes_after - cusp.crunodes_before) == 1


@few
@given(numbers(0.1, 0.9), numbers(0.6, 1.5), angles(), branches)
def test_symmetric_curves(crank: float, arm: float, inner: float, branch: str) -> None:
    """Coupler, rocker and E-B of one length: the axis through O4 is at half the angle A-B-E.

    Each crunode is on the axis or the image of another (Hartenberg & Denavit 1964, ch. 6).
    """
    linkage = crank_rocker(crank, arm, arm, branch)
    assume(abs(np.sin(inner / 2)) > 0.05)
    to_point = arm - arm * np.exp(1j * inner)
    point = CouplerPoint(abs(to_point), float(np.angle(to_point)))
    axis = np.exp(1j * inner / 2)
    found = double_points(linkage, point)
    local = [(complex(*d.position) - 1) / axis for d in found]
    for double, place in zip(found, local, strict=True):
        distances = [abs(place.conjugate() - other) for other in local]
        assert min(distances) < 1e-6  # pairs near a tacnode are the square root of round-off
        if abs(place.imag) < 1e-9 and double.kind == "crunode":
            # The crank passes it at mirrored angles.
            turned = np.exp(1j * np.sum(double.crank_angles))
            assert turned == pytest.approx(1.0, abs=1e-6)


@few
@given(crank_rockers, numbers(-2.0, 2.0))
def test_points_on_the_couplers_line_cross_on_the_grounds(linkage: FourBar, along: float) -> None:
    """The circle of singular foci is the ground's line there."""
    assume(min(abs(along), abs(along - linkage.coupler)) > 0.02)
    point = CouplerPoint(abs(along), 0.0 if along > 0 else math.pi)
    nodes = finite_double_points(linkage, point)
    assert [abs(node.position[1]) < 1e-9 for node in nodes] == [True] * len(nodes)


@few
@given(crank_rockers, points)
def test_double_points_see_the_ground_as_the_coupler(linkage: FourBar, point: CouplerPoint) -> None:
    """Under the angle A-E-B or its supplement: they are on the circle of singular foci."""
    _, far, cosine, sine = point.triangle(linkage.coupler)
    assume(far > 0.02)
    for node in finite_double_points(linkage, point):
        to_o2, to_o4 = -complex(*node.position), 1 - complex(*node.position)
        seen = to_o2.conjugate() * to_o4
        assert seen.imag * cosine - seen.real * sine == pytest.approx(
            0.0, abs=1e-11 * (1 + abs(seen))
        )


@pytest.mark.parametrize(
    ("linkage", "point", "position"),
    [
        # E-A as long as the crank: E passes O2, once with B on either side of the ground.
        (FourBar(1.0, 0.6, 1.1, 0.9), CouplerPoint(0.6, 0.9), [0.0, 0.0]),
        (FourBar(1.0, 1.2, 1.4, 1.3), CouplerPoint(1.2, 0.5), [0.0, 0.0]),
        # E-B as long as the rocker: E passes O4.
        (FourBar(1.0, 1.2, 1.4, 1.3), None, [1.0, 0.0]),
    ],
)
def test_crunodes_in_the_ground_pivots(linkage, point, position) -> None:
    if point is None:
        arm = linkage.coupler + linkage.rocker * np.exp(2.2j)
        point = CouplerPoint(abs(arm), float(np.angle(arm)))
    nodes = finite_double_points(linkage, point)
    node = min(nodes, key=lambda node: math.dist(node.position, position))
    assert node.position == pytest.approx(position, abs=1e-12)
    assert node.kind == "crunode"
    for attitude in node.attitudes:
        passage = FourBar(**linkage.lengths, branch=attitude.circuit)
        place = CouplerCurve(passage, point).position(attitude.crank_angle)
        assert place == pytest.approx(position, abs=1e-12)


def test_root_at_infinity_is_a_point_like_others() -> None:
    """Straight above O2 tan eta is infinite: the rocker that puts a double point there."""
    crank, coupler, point = 1.3, 0.3, CouplerPoint(0.6, 0.9)
    near, far, cosine, sine = point.triangle(coupler)
    above, across = cosine / sine, 1 / sine
    swing = (crank**2 - near**2 - above**2) / (2 * near * above)
    rocker = math.sqrt(far**2 + across**2 + 2 * far * across * swing)
    (double,) = double_points(FourBar(1.0, crank, coupler, rocker), point)
    assert double.kind == "crunode"
    assert double.position == pytest.approx([0.0, above], abs=1e-12)


def symmetric(crank: float, inner: float) -> tuple[FourBar, CouplerPoint]:
    """With a symmetric curve: coupler, rocker and E-B of unit length, E-B at an angle to A-B."""
    arm = 1.0 - np.exp(1j * inner)
    return FourBar(1.1, crank, 1.0, 1.0), CouplerPoint(abs(arm), float(np.angle(arm)))


@settings(max_examples=4)
@given(numbers(0.15, 0.8))
def test_transitions_of_symmetric_curves(crank: float) -> None:
    """E passes O4 with the crank along the ground at both limits of the transmission angle.

    It is in the instant centre then. Later two cusps appear at mirrored crank angles, and
    their crunodes meet where E-O4 is as long at crank angle 0 as at 180 deg.
    """
    least, greatest = symmetric(crank, 1.0)[0].transmission_angle_limits()
    found = cusp_transitions(lambda inner: symmetric(crank, inner), 0.05, 6.2, steps=40)
    assert [t.kind for t in found] == ["cusp"] * 4 + ["tacnode"]
    assert [(t.crunodes_before, t.crunodes_after) for t in found] == [
        (0, 1),
        (1, 0),
        (0, 2),
        (0, 2),
        (2, 0),
    ]
    exact = [
        least,
        greatest,
        found[2].parameter,
        found[2].parameter,
        np.pi + (least + greatest) / 2,
    ]
    assert [t.parameter for t in found] == pytest.approx(exact, abs=1e-10)
    # At the tacnode the paths touch: crank angles are good to the root of round-off.
    turned = np.exp(1j * np.array([t.crank_angle for t in found[:2]]))
    assert turned == pytest.approx([1.0, -1.0], abs=1e-6)
    assert np.exp(1j * (found[2].crank_angle + found[3].crank_angle)) == pytest.approx(
        1.0, abs=1e-6
    )
    assert np.sort(np.cos(found[4].crank_angles)) == pytest.approx([-1.0, 1.0], abs=1e-6)
    assert found[0].position == pytest.approx([1.1, 0.0], abs=1e-9)


def test_few_steps_do_where_double_points_move_fast() -> None:
    """They are halved; the pair that comes and goes within the last of three is met thereby."""
    many = cusp_transitions(lambda inner: symmetric(0.5, inner), 0.05, 6.2, steps=64)
    few_steps = cusp_transitions(lambda inner: symmetric(0.5, inner), 0.05, 6.2, steps=3)
    assert [t.kind for t in few_steps] == [t.kind for t in many]
    assert [t.parameter for t in few_steps] == pytest.approx([t.parameter for t in many], abs=1e-10)


def test_double_points_that_are_one_all_along_end_in_an_error(monkeypatch) -> None:
    monkeypatch.setattr("scenarios._cusp_transitions.MOST_PARAMETERS", 20)
    with pytest.raises(ComputationError, match="lie too close to be told apart near parameter"):
        cusp_transitions(lambda inner: symmetric(0.5, inner), 0.05, 6.2)


def test_backwards_is_the_same_the_other_way() -> None:
    forward = cusp_transitions(lambda inner: symmetric(0.5, inner), 0.05, 6.2)
    backward = cusp_transitions(lambda inner: symmetric(0.5, inner), 6.2, 0.05)
    assert [t.parameter for t in backward] == pytest.approx(
        [t.parameter for t in forward[::-1]], abs=1e-10
    )
    assert [t.kind for t in backward] == [t.kind for t in forward[::-1]]
    assert [(t.crunodes_after, t.crunodes_before) for t in backward] == [
        (t.crunodes_before, t.crunodes_after) for t in forward[::-1]
    ]


@pytest.mark.parametrize("transition", [0, 1, 4])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_events_within_one_step_are_found(transition: int, side: float) -> None:
    """A family that passes a cusp or tacnode by 1e-4 and comes back."""
    event = cusp_transitions(lambda inner: symmetric(0.5, inner), 0.05, 6.2)[transition]

    def family(parameter: float) -> tuple[FourBar, CouplerPoint]:
        return symmetric(0.5, event.parameter + side * (parameter**2 - 1e-4))

    found = cusp_transitions(family, -0.3, 0.3, steps=5)
    assert [t.kind for t in found] == [event.kind] * 2
    assert [t.parameter for t in found] == pytest.approx([-0.01, 0.01], abs=1e-8)
    assert found[0].crunodes_before == found[1].crunodes_after
    assert found[0].crunodes_after == found[1].crunodes_before != found[0].crunodes_before


def test_transitions_account_for_every_change_of_number() -> None:
    """Families from one random linkage to another, against counts on the way."""
    generator = np.random.default_rng(3)
    families, changes = 0, 0
    while families < 12:
        lengths = generator.uniform(0.2, 2.0, (2, 4))
        points = np.stack(
            [generator.uniform(0.1, 2.0, 2), generator.uniform(0, 2 * np.pi, 2)], axis=1
        )
        # Crank-rockers are a convex set.
        if not all(four[1] < min(four[[0, 2, 3]]) for four in lengths):
            continue
        ordered = np.sort(lengths, axis=1)
        if np.any(ordered[:, 0] + ordered[:, 3] > ordered[:, 1] + ordered[:, 2] - 0.05):
            continue
        families += 1

        def family(
            parameter: float, lengths=lengths, points=points
        ) -> tuple[FourBar, CouplerPoint]:
            four, two = ((1 - parameter) * v[0] + parameter * v[1] for v in (lengths, points))
            return FourBar(*four), CouplerPoint(*two)

        found = cusp_transitions(family, 0.0, 1.0, steps=32)
        changes += len(found)
        assert all(t.crunodes_before != t.crunodes_after for t in found)
        parameters = np.linspace(0.0, 1.0, 40)[1:-1] + 1e-4
        counted = [
            sum(double.kind == "crunode" for double in double_points(*family(p)))
            for p in parameters
        ]
        numbers_between = [t.crunodes_before for t in found[:1]]
        numbers_between += [t.crunodes_after for t in found]
        passed = np.searchsorted([t.parameter for t in found], parameters)
        assert counted == [(numbers_between or counted[:1])[n] for n in passed]
    assert changes > 5
