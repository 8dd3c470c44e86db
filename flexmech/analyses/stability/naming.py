"""Names of unstable bands: which frequencies add up to a multiple of the crank's."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.analyses.stability.band import Kind
from flexmech.types import FloatArray

__all__ = ["BandName", "band_name"]

# A branch that is a smaller part of the mode that grows has no part in the band.
LEAST_PART = 0.15
# Farther from a whole multiple, relative to the crank's frequency, there is no name.
FARTHEST = 0.25
# In a band frequencies are pulled to its order: by no more than its width tells, or by this.
PULLED = 0.01


@dataclass(frozen=True)
class BandName:
    """What meets in a band.

    Parameters
    ----------
    kind : Kind
    branches : tuple of int
        From 1; empty without a name.
    order : int
        0 without a name.
    mismatch : float
        How far ``(f_a + f_b) / f_crank`` or ``(f_a - f_b) / f_crank`` is from the order.
    """

    kind: Kind
    branches: tuple[int, ...]
    order: int
    mismatch: float


def band_name(
    frequency: FloatArray,
    part: FloatArray,
    usual: FloatArray,
    crank_frequency: float,
    width: float,
    *,
    differences: bool,
) -> BandName:
    """Name of a band.

    Parameters
    ----------
    frequency : ndarray, shape (m,)
        Floquet frequencies of the branches in Hz where none of them grows, at the band's speed.
    part : ndarray, shape (m,)
        How alike the mode that grows is to the shape of each branch.
    usual : ndarray, shape (m,)
        Median of each branch's frequency over the speeds. Modes that were mixtures may have
        changed their branches; a name goes by the nearest frequency.
    crank_frequency : float
        In Hz.
    width : float
        Of the band, relative to its speed.
    differences : bool
        Whether differences of frequencies can be unstable.

    Returns
    -------
    BandName
    """
    found: list[tuple[float, BandName]] = []
    label = np.abs(np.log(frequency[:, None] / usual)).argmin(axis=1) + 1
    count = len(frequency)
    for a in range(count):
        for b in range(a, count):
            common = min(part[a], part[b])
            if common < LEAST_PART:
                continue
            kinds: list[tuple[Kind, float]] = [("sum", frequency[a] + frequency[b])]
            if label[a] == label[b]:
                kinds = [("principal", frequency[a] + frequency[b])]
            elif differences:
                kinds.append(("difference", abs(frequency[b] - frequency[a])))
            for kind, meeting in kinds:
                ratio = float(meeting) / crank_frequency
                order = round(ratio)
                if order == 0 or abs(ratio - order) > FARTHEST:
                    continue
                branches = tuple(sorted((int(label[a]), int(label[b]))))
                name = BandName(kind, branches, order, abs(ratio - order))
                pulled = max(PULLED, order * width / 2)
                found.append((common / (1 + ((ratio - order) / pulled) ** 2), name))
    if not found:
        return BandName("unnamed", (), 0, float("nan"))
    return max(found, key=lambda scored: scored[0])[1]
