"""Coupler curves as polylines and the crossings of their segments, without flexmech.

Curves are drawn by turning the shortest link of a Grashof linkage, which makes full turns
against all others, and by letting two circles meet; crossings are counted segment by segment.
Stacks of curves at once.
"""

from __future__ import annotations

import numpy as np

# Segments a block: pairs of blocks are left out by their bounding boxes.
BLOCK = 10
MOST_BLOCKS = 360
CHUNK = 200_000  # pairs of segments at once


def polylines(lengths, points, circuit, segments):
    """Closed curves and the paths of A; (n, segments, 2) each.

    ``lengths`` (n, 4) of ground, crank, coupler and rocker; ``points`` (n, 2) distance and
    angle; ``circuit`` (n,) +1 or -1: of linkages whose crank turns, B to the left or right of
    the way from A to O4; of others, A above or below the ground's line.
    """
    turn = 2 * np.pi * (np.arange(segments) + 0.37) / segments
    along = np.exp(1j * turn)
    pin_a = np.empty((len(lengths), segments), dtype=complex)
    pin_b = np.empty_like(pin_a)
    shortest = np.argmin(lengths, axis=1)
    for link in range(4):
        chosen = shortest == link
        d, a, b, c = (lengths[chosen, k, None] for k in range(4))
        side = circuit[chosen, None]
        if link in (0, 1):
            pin_a[chosen] = a * along
            pin_b[chosen] = _meeting(pin_a[chosen], b, d, c, side)
            continue
        if link == 3:
            pin_b[chosen] = d + c * along
            ways = [_meeting(0, a, pin_b[chosen], b, s) for s in (1, -1)]
        else:
            ways = [_meeting(0, a, d - b * along, c, s) for s in (1, -1)]
        above = np.sign(ways[0].imag[:, :1])
        pin_a[chosen] = np.where(above == side, *ways)
        assert np.all(np.sign(pin_a[chosen].imag) == side)
        if link == 2:
            pin_b[chosen] = pin_a[chosen] + b * along
    arm = points[:, :1] * np.exp(1j * points[:, 1:])
    curve = pin_a + arm * (pin_b - pin_a) / lengths[:, 2, None]
    return tuple(np.stack([z.real, z.imag], axis=-1) for z in (curve, pin_a))


def swinging_polylines(lengths, points, segments):
    """Closed curves of triple-rockers, whose crank swings over both branches; (n, segments, 2)."""
    d, a, b, c = (lengths[:, k, None] for k in range(4))
    reach = np.stack([np.abs(b - c), b + c])
    cosines = (a**2 + d**2 - reach**2) / (2 * a * d)
    folded = cosines[0] < 1  # else the limit is where coupler and rocker are stretched
    limit = np.where(folded, np.pi - np.arccos(np.minimum(cosines[0], 1)), 0)
    limit = np.where(folded, limit, np.arccos(np.clip(cosines[1], -1, 1)))
    turn = 2 * np.pi * (np.arange(segments) + 0.37) / segments
    crank = np.where(folded, np.pi, 0) + limit * np.cos(turn)
    pin_a = a * np.exp(1j * crank)
    pin_b = _meeting(pin_a, b, d, c, np.sign(np.sin(turn)))
    curve = pin_a + points[:, :1] * np.exp(1j * points[:, 1:]) * (pin_b - pin_a) / b
    return np.stack([curve.real, curve.imag], axis=-1)


def _meeting(first, radius, second, other, side):
    """Where circles about two places meet, to the left (+1) of the way between them."""
    way = second - first
    distance = np.abs(way)
    along = (radius**2 + distance**2 - other**2) / (2 * distance)
    across = np.sqrt(radius**2 - along**2)
    return first + (along + 1j * side * across) * way / distance


def crossings(curves):
    """Number of crossings of each closed polyline; (n, segments, 2) -> (n,)."""
    n, segments = curves.shape[:2]
    size = max(BLOCK, segments // MOST_BLOCKS)
    blocks = segments // size
    assert blocks * size == segments
    corners = np.concatenate([curves, curves[:, :1]], axis=1)
    inside = np.arange(blocks)[:, None] * size + np.arange(size + 1)
    boxes = corners[:, inside]
    low, high = boxes.min(axis=2), boxes.max(axis=2)
    counts = np.zeros(n, dtype=int)
    for i, j in _overlapping(corners, low, high, size):
        counts += _crossings_of_blocks(corners, i, j, size, segments)
    return counts


def _overlapping(corners, low, high, size):
    """Arrays of (curve, block), (curve, block) whose boxes meet, in chunks."""
    n, blocks = low.shape[:2]
    first, second = np.triu_indices(blocks)
    steps = np.diff(corners, axis=1).reshape(n, blocks, size, 2)
    neighbours = ((second - first) <= 1) | ((first == 0) & (second == blocks - 1))
    each = max(1, 4_000_000 // len(first))
    for start in range(0, n, each):
        part = slice(start, start + each)
        meet = np.ones((len(low[part]), len(first)), dtype=bool)
        for axis in range(2):
            meet &= low[part, first, axis] <= high[part, second, axis]
            meet &= low[part, second, axis] <= high[part, first, axis]
        curve, pair = np.nonzero(meet)
        curve = curve + start
        # Neighbours that go one way throughout do not cross.
        near = neighbours[pair]
        chord = steps[curve[near], first[pair[near]]].sum(axis=1)
        chord = chord + steps[curve[near], second[pair[near]]].sum(axis=1)
        forward = np.ones(len(chord), dtype=bool)
        for block in (first, second):
            ahead = np.einsum("nsk,nk->ns", steps[curve[near], block[pair[near]]], chord)
            forward &= np.all(ahead > 0, axis=1)
        keep = np.ones(len(curve), dtype=bool)
        keep[np.flatnonzero(near)[forward]] = False
        curve, pair = curve[keep], pair[keep]
        many = max(1, CHUNK // size**2)
        for at in range(0, len(curve), many):
            some = slice(at, at + many)
            yield (curve[some], first[pair[some]]), (curve[some], second[pair[some]])


def _crossings_of_blocks(corners, i, j, size, segments):
    curve, places = i[0], np.arange(size)
    one = i[1][:, None] * size + places
    two = j[1][:, None] * size + places
    p, q = corners[curve[:, None], one], corners[curve[:, None], one + 1]
    r, s = corners[curve[:, None], two], corners[curve[:, None], two + 1]
    p, q, r, s = p[:, :, None], q[:, :, None], r[:, None], s[:, None]
    apart = two[:, None, :] - one[:, :, None]
    allowed = (apart > 1) & (apart < segments - 1)
    cross = (_side(p, q, r) * _side(p, q, s) < 0) & (_side(r, s, p) * _side(r, s, q) < 0)
    found = np.sum(cross & allowed, axis=(1, 2))
    return np.bincount(curve, weights=found, minlength=len(corners)).astype(int)


def _side(p, q, r):
    way, other = q - p, r - p
    return way[..., 0] * other[..., 1] - way[..., 1] * other[..., 0]
