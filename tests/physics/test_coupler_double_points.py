"""Double points of coupler curves: where geometry tells them, published curves, polylines."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from cusp_transitions import cusp_transitions
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from flexmech import (
    CouplerCurve,
    CouplerPoint,
    FourBar,
    InputError,
    double_points,
    example_model,
    load_mechanism,
    mechanism_in_state,
)
from flexmech.hygrothermal import HygrothermalState
from flexmech.linkages import coupler_sextic, finite_double_points
from flexmech.verification import verification_case
from tests.support.coupler_polylines import crossings, polylines, swinging_polylines
from tests.support.strategies import Posture, angles, numbers, postures

few = settings(max_examples=12)
points = st.builds(CouplerPoint, numbers(0.05, 2.0), angles())
COARSE, FINER = 120, (1200, 12_000, 120_000)


def crank_rocker(crank: float, coupler: float, rocker: float, branch: str) -> FourBar:
    """With the ground as unit."""
    ordered = sorted((1.0, crank, coupler, rocker))
    assume(crank == ordered[0])
    assume(ordered[0] + ordered[3] < ordered[1] + ordered[2] - 0.02)
    return FourBar(1.0, crank, coupler, rocker, branch)


crank_rockers = st.builds(
    crank_rocker,
    numbers(0.1, 0.5),
    numbers(0.7, 1.3),
    numbers(0.7, 1.3),
    st.sampled_from(["open", "crossed"]),
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
def test_both_passages_close_and_meet(posture: Posture, point: CouplerPoint, upper: bool) -> None:
    """Linkages of every class; the sextic is zero at the double point and stationary."""
    linkage = posture.linkage
    angle = abs(posture.crank_angle) * (1 if upper else -1)
    for double in double_points(linkage, point, angle):
        assert opening(linkage, point, double) < 1e-12
        assert 0 <= double.crank_angles[0] <= double.crank_angles[1] < 2 * np.pi
        position = np.array(double.position)
        step = 1e-4 * (1 + np.hypot(*position)) * np.array([[1, 0], [-1, 0], [0, 1], [0, -1]])
        around = coupler_sextic(linkage, point, position + step)
        scale = np.abs(coupler_sextic(linkage, point, position + 1e3 * step)).max()
        assert abs(coupler_sextic(linkage, point, position)) < 1e-10 * scale
        assert np.abs(around).max() < 1e-4 * scale


@few
@given(crank_rockers, points)
def test_from_a_double_point_the_ground_is_seen_as_the_coupler_from_the_point(
    linkage: FourBar, point: CouplerPoint
) -> None:
    """Under the angle A-E-B or its supplement: on the circle of singular foci; one or three."""
    place = point.distance * np.exp(1j * point.angle)
    assume(abs(place - linkage.coupler) > 0.02)
    corner = place.conjugate() * (place - linkage.coupler)
    found = finite_double_points(linkage, point)
    assert len(found) in (1, 3)
    for node in found:
        to_o2, to_o4 = -complex(*node.position), 1 - complex(*node.position)
        seen = to_o2.conjugate() * to_o4 / corner * abs(corner)
        assert abs(seen.imag) < 1e-10 * (1 + abs(seen))


@few
@given(crank_rockers, angles())
def test_the_instant_centre_traces_a_cusp(linkage: FourBar, crank_angle: float) -> None:
    centre = instant_centre(linkage, crank_angle)
    assume(abs(centre) < 10)
    point = fixed_to_coupler(linkage, crank_angle, centre)
    assume(point.distance > 0.02)
    assume(abs(point.distance * np.exp(1j * point.angle) - linkage.coupler) > 0.02)
    (cusp,) = (d for d in double_points(linkage, point) if d.kind == "cusp")
    assert cusp.position == pytest.approx([centre.real, centre.imag], abs=1e-9)
    turned = np.remainder(cusp.crank_angles - crank_angle + 1, 2 * np.pi) - 1
    assert turned == pytest.approx([0.0, 0.0], abs=1e-8)
    assert CouplerCurve(linkage, point).speed(cusp.crank_angles).max() < 1e-7


def test_on_one_side_of_the_instant_centre_is_a_loop() -> None:
    """A billionth of the linkage away it is known: beyond is a crunode, before it an acnode."""
    linkage = FourBar(0.25, 0.1, 0.28, 0.27)
    cusp = fixed_to_coupler(linkage, 1.1, instant_centre(linkage, 1.1))

    def nearest(away: float):
        point = CouplerPoint(cusp.distance * (1 + away), cusp.angle)
        return min(finite_double_points(linkage, point), key=lambda node: abs(node.margin))

    unit = nearest(1e-6).margin / 1e-6
    for margin, kind in ((4e-11, "cusp"), (-4e-11, "cusp"), (1e-9, "crunode"), (-1e-9, "acnode")):
        node = nearest(margin / unit)
        assert node.margin == pytest.approx(margin, rel=1e-3)
        assert node.kind == kind


@pytest.mark.parametrize("pivot", ["O2", "O4"])
def test_a_point_as_far_from_its_pin_as_a_pivot_crosses_itself_there(pivot: str) -> None:
    linkage = FourBar(1.0, 1.2, 1.4, 1.3)
    at_o4 = linkage.coupler + linkage.rocker * np.exp(2.2j)
    arm = 1.2 * np.exp(0.5j) if pivot == "O2" else at_o4
    point, position = CouplerPoint(abs(arm), float(np.angle(arm))), [float(pivot == "O4"), 0.0]
    nodes = finite_double_points(linkage, point)
    node = min(nodes, key=lambda node: math.dist(node.position, position))
    assert node.position == pytest.approx(position, abs=1e-12)
    assert node.kind == "crunode"
    for attitude in node.attitudes:
        passage = replace(linkage, branch=attitude.circuit)
        place = CouplerCurve(passage, point).position(attitude.crank_angle)
        assert place == pytest.approx(position, abs=1e-12)


# --- Singh & Sanyal 2022, Figures 5 to 12 -------------------------------------------------------

FIGURES = (5, 6, 7, 8, 9, 10, 11, 12)


def in_state(figure: int, moisture: float, rise: float = 80.0) -> tuple[FourBar, CouplerPoint]:
    """Links swell with temperature and moisture, R-914 wet, and the frame with temperature."""
    dry = load_mechanism(example_model(f"neat_resin_figure_{figure}"))
    link, frame = 1 + 62.6e-6 * rise + 3.02e-3 * moisture, 1 + 62.6e-6 * rise
    linkage, point = dry.linkage, dry.coupler_point
    assert isinstance(linkage, FourBar)
    assert point is not None
    moved = (link * length for length in (linkage.crank, linkage.coupler, linkage.rocker))
    return FourBar(linkage.ground * frame, *moved, linkage.branch), point.scaled(link)


@pytest.mark.parametrize("figure", FIGURES)
@pytest.mark.parametrize("wet", [False, True], ids=["dry", "wet"])
def test_crossings_are_those_of_the_papers_figures(figure: int, wet: bool) -> None:
    """Counted in the drawn curves too; a frame of the same resin would change no angle."""
    state = "wet" if wet else "dry"
    case = verification_case(f"Crossings of coupler curves, Figures 5 to 12: {state}")
    expected = int(case.expected_values()[case.labels.index(f"Figure {figure}")])
    linkage, point = in_state(figure, 7.0 if wet else 0.0, 80.0 if wet else 0.0)
    found = double_points(linkage, point)
    assert [double.kind for double in found] == ["crunode"] * expected
    lengths = np.array([list(linkage.lengths.values())])
    drawn, _ = polylines(lengths, np.array([[point.distance, point.angle]]), np.ones(1), 3600)
    assert crossings(drawn).tolist() == [expected]
    model = load_mechanism(example_model(f"neat_resin_figure_{figure}"))
    if wet:
        model = mechanism_in_state(model, HygrothermalState(80.0, 0.07))
    for name, length in model.linkage.lengths.items():
        assert length == pytest.approx(linkage.lengths[name], rel=1e-12)


@pytest.mark.parametrize(("figure", "appears"), [(5, True), (8, False), (10, True)])
def test_moisture_at_which_the_loop_is_a_cusp(figure: int, appears: bool) -> None:
    """At 80 K from dry to saturated; at a cusp the coupler point stands still."""
    moisture, crank_angle = (
        verification_case(f"Cusps on the way from dry to wet, Figures 5, 8 and 10: {quantity}")
        for quantity in ("moisture", "crank angle")
    )
    place = moisture.labels.index(f"Figure {figure}")
    (cusp,) = cusp_transitions(lambda m: in_state(figure, m), 0.0, 7.0)
    for value, case in ((cusp.parameter, moisture), (np.degrees(cusp.crank_angle), crank_angle)):
        assert value == pytest.approx(case.expected_values()[place], abs=case.tolerance)
    assert (cusp.crunodes_before, cusp.crunodes_after) == ((0, 1) if appears else (1, 0))
    curve = CouplerCurve(*in_state(figure, cusp.parameter))
    assert curve.speed(cusp.crank_angle) < 1e-11 * curve.linkage.crank


# --- random linkages against their polylines ----------------------------------------------------


def random_lengths(random: np.random.Generator, number: int, *, grashof: bool) -> np.ndarray:
    """Lengths (number, 4) of linkages that assemble, 1e-3 or more from a change point."""
    lengths = random.uniform(0.1, 2.0, (40 * number, 4))
    ordered = np.sort(lengths, axis=1)
    excess = ordered[:, 0] + ordered[:, 3] - ordered[:, 1] - ordered[:, 2]
    closes = ordered[:, 3] < ordered[:, :3].sum(axis=1) - 1e-3
    chosen = excess < -1e-3 if grashof else excess > 1e-3
    return lengths[chosen & closes][:number]


def random_points(random: np.random.Generator, lengths: np.ndarray) -> np.ndarray:
    distance = random.uniform(0.0, 2.0, len(lengths)) * lengths[:, 2]
    return np.stack([distance, random.uniform(0.0, 2 * np.pi, len(lengths))], axis=1)


def crunodes(linkage: FourBar, point: CouplerPoint, crank_angle: float | None = None) -> int:
    found = double_points(linkage, point, crank_angle)
    return sum(double.kind == "crunode" for double in found)


def assert_counts_agree(exact: np.ndarray, drawn: np.ndarray, draw: Callable) -> None:
    """A polyline misses loops smaller than its segments: those curves are drawn more finely."""
    differing = np.flatnonzero(exact != drawn)
    assert len(differing) <= 0.02 * len(exact)
    for segments in FINER:
        if len(differing):
            again = crossings(draw(differing, segments))
            differing = differing[again != exact[differing]]
    assert not len(differing)


@pytest.mark.parametrize(
    "number", [300, pytest.param(3000, marks=pytest.mark.thorough)], ids=["few", "many"]
)
def test_crunodes_of_grashof_linkages_are_the_crossings_of_their_polylines(number: int) -> None:
    random = np.random.default_rng(1)
    lengths = random_lengths(random, number, grashof=True)
    points_of = random_points(random, lengths)
    circuit = random.choice([1.0, -1.0], number)
    curves, paths = polylines(lengths, points_of, circuit, COARSE)
    exact, classes = [], set()
    for four, two, side, path in zip(
        lengths.tolist(), points_of.tolist(), circuit, paths, strict=True
    ):
        linkage = FourBar(*four, branch="open" if side > 0 else "crossed")
        classes.add(linkage.grashof_class)
        # Without a crank angle the circuit above the ground's line is meant.
        turns = linkage.crank_turns_fully or side > 0
        crank_angle = None if turns else float(np.arctan2(path[0, 1], path[0, 0]))
        exact.append(crunodes(linkage, CouplerPoint(*two), crank_angle))
    assert classes == {"crank-rocker", "rocker-crank", "double-crank", "double-rocker"}
    assert set(exact) >= {0, 1, 2}
    assert_counts_agree(
        np.array(exact),
        crossings(curves),
        lambda c, n: polylines(lengths[c], points_of[c], circuit[c], n)[0],
    )


def test_crunodes_of_triple_rockers_are_the_crossings_of_their_polylines() -> None:
    """Their curve runs over both branches, between one pair of limits."""
    random = np.random.default_rng(2)
    lengths = random_lengths(random, 300, grashof=False)
    points_of = random_points(random, lengths)
    exact = np.array(
        [
            crunodes(FourBar(*four), CouplerPoint(*two))
            for four, two in zip(lengths.tolist(), points_of.tolist(), strict=True)
        ]
    )
    drawn = crossings(swinging_polylines(lengths, points_of, COARSE))
    assert_counts_agree(exact, drawn, lambda c, n: swinging_polylines(lengths[c], points_of[c], n))


def test_what_has_no_double_points_or_no_circuit() -> None:
    """A pin traces a circle; a double-rocker has two circuits; a change point has none."""
    linkage = FourBar(1.0, 0.4, 0.9, 0.8)
    for point in (CouplerPoint(0.0, 1.0), CouplerPoint(0.9, 0.0), CouplerPoint(0.9, 2 * np.pi)):
        assert double_points(linkage, point) == ()
    with pytest.raises(InputError, match="cannot be assembled at crank angle 180 deg"):
        double_points(FourBar(1.0, 0.9, 0.5, 1.1), CouplerPoint(0.5, 1.0), crank_angle=np.pi)
    with pytest.raises(InputError, match="change point"):
        double_points(FourBar(1.0, 0.5, 0.8, 0.7), CouplerPoint(0.5, 1.0))
