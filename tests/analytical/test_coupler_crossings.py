"""Crunodes of random linkages against the crossings of their curves' polylines.

A polyline misses loops, and adds crossings near tacnodes, that are smaller than its segments:
where the counts differ the curve is drawn again with ever smaller segments until they do not.
"""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from flexmech.errors import InputError
from flexmech.linkages import CouplerCurve, CouplerPoint, FourBar, double_points
from tests.analytical.coupler_polylines import crossings, polylines, swinging_polylines

COARSE, FINER = 120, (1200, 12_000, 120_000)
GRASHOF = ("crank-rocker", "rocker-crank", "double-crank", "double-rocker")


def random_lengths(generator, number, *, grashof):
    """Of assembled linkages that are not within 1e-3 of a change point; (number, 4)."""
    lengths = generator.uniform(0.1, 2.0, (40 * number, 4))
    ordered = np.sort(lengths, axis=1)
    excess = ordered[:, 0] + ordered[:, 3] - ordered[:, 1] - ordered[:, 2]
    closes = ordered[:, 3] < ordered[:, :3].sum(axis=1) - 1e-3
    chosen = excess < -1e-3 if grashof else excess > 1e-3
    return lengths[chosen & closes][:number]


def random_points(generator, lengths):
    size = len(lengths)
    distance = generator.uniform(0.0, 2.0, size) * lengths[:, 2]
    return np.stack([distance, generator.uniform(0.0, 2 * np.pi, size)], axis=1)


def crunodes(linkage, point, crank_angle=None):
    """Their number, after a look at what is given for them."""
    found = double_points(linkage, point, crank_angle)
    for double in found:
        numbers = np.concatenate([double.position, double.crank_angles, double.coupler_angles])
        assert np.all(np.isfinite(numbers))
        assert np.all((double.crank_angles >= 0) & (double.crank_angles < 2 * np.pi))
        if linkage.crank_turns_fully:
            passages = CouplerCurve(linkage, point).position(double.crank_angles)
            gap = np.linalg.norm(passages - double.position, axis=-1)
            assert gap.max() < 1e-10 * (linkage.crank + point.distance)
    return sum(double.kind == "crunode" for double in found)


@pytest.mark.thorough
def test_ten_thousand_grashof_linkages() -> None:
    generator = np.random.default_rng(1)
    lengths = random_lengths(generator, 10_000, grashof=True)
    assert len(lengths) == 10_000
    points = random_points(generator, lengths)
    circuit = generator.choice([1.0, -1.0], len(lengths))
    curves, paths = polylines(lengths, points, circuit, COARSE)
    exact, classes = [], Counter()
    for four, two, side, path in zip(
        lengths.tolist(), points.tolist(), circuit, paths, strict=True
    ):
        linkage = FourBar(*four, branch="open" if side > 0 else "crossed")
        classes[linkage.grashof_class] += 1
        # Without a crank angle the circuit above the ground's line is meant.
        turns = linkage.crank_turns_fully or side > 0
        crank_angle = None if turns else float(np.arctan2(path[0, 1], path[0, 0]))
        exact.append(crunodes(linkage, CouplerPoint(*two), crank_angle))
    assert set(classes) == set(GRASHOF)
    assert min(classes.values()) > 2000
    exact = np.array(exact)
    assert all(np.count_nonzero(exact == number) > 2 for number in range(4))
    agree(
        exact,
        crossings(curves),
        lambda c, n: polylines(*(v[c] for v in (lengths, points, circuit)), n)[0],
    )


def test_triple_rockers() -> None:
    """Their curve runs over both branches, and over both between one pair of limits."""
    generator = np.random.default_rng(2)
    lengths = random_lengths(generator, 500, grashof=False)
    points = random_points(generator, lengths)
    exact = [
        crunodes(FourBar(*four), CouplerPoint(*two))
        for four, two in zip(lengths.tolist(), points.tolist(), strict=True)
    ]
    assert len(exact) == 500
    assert np.bincount(exact)[:3].min() > 2
    drawn = crossings(swinging_polylines(lengths, points, COARSE))
    agree(np.array(exact), drawn, lambda c, n: swinging_polylines(lengths[c], points[c], n))


def agree(exact, drawn, draw):
    """Whether the counts differ in a few curves only, and in none of them when drawn finely."""
    differing = np.flatnonzero(exact != drawn)
    assert len(differing) <= 0.02 * len(exact), f"{len(differing)} differ at {COARSE} segments"
    for segments in FINER:
        if len(differing):
            again = crossings(draw(differing, segments))
            differing = differing[again != exact[differing]]
    assert not len(differing), f"curves {differing} differ at {FINER[-1]} segments"


def test_polylines_count_what_is_drawn() -> None:
    """A circle, a figure of eight and a trefoil have no, one and three crossings."""
    turn = 2 * np.pi * (np.arange(180) + 0.37) / 180
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    eight = np.stack([np.cos(turn), np.sin(2 * turn)], axis=-1)
    trefoil = (2 + np.cos(3 * turn))[:, None] * np.stack([np.cos(2 * turn), np.sin(2 * turn)], -1)
    assert crossings(np.stack([circle, eight, trefoil])).tolist() == [0, 1, 3]


def test_two_ranges_of_the_crank_need_an_angle_inside() -> None:
    linkage = FourBar(1.0, 0.9, 0.5, 1.1)
    assert linkage.grashof_class == "double-rocker"
    with pytest.raises(InputError, match="cannot be assembled at crank angle 180 deg"):
        double_points(linkage, CouplerPoint(0.5, 1.0), crank_angle=np.pi)
