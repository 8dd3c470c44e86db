"""Parallel cranks: two turn a beam, and a third one is one joint too many, which is refused."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech import InputError, PlanarJoint, PlanarLink, PlanarLinkage


def parallel_cranks(seed: int, count: int) -> PlanarLinkage:
    """Cranks of one length and one angle on a straight ground, joined by one beam."""
    random = np.random.default_rng([seed, 61])
    places = np.cumsum(random.uniform(0.1, 0.4, count))
    length, angle = random.uniform(0.05, 0.3), random.uniform(0.3, 2.8)
    points = {f"G{n}": (float(x), 0.0) for n, x in enumerate(places)}
    tip = length * np.array([np.cos(angle), np.sin(angle)])
    points |= {f"A{n}": (float(x + tip[0]), float(tip[1])) for n, x in enumerate(places)}
    links = [PlanarLink(f"crank{n}", (f"G{n}", f"A{n}")) for n in range(count)]
    links.append(PlanarLink("beam", tuple(f"A{n}" for n in range(count))))
    ground = tuple(f"G{n}" for n in range(count))
    return PlanarLinkage(points, tuple(links), ground, (PlanarJoint("G0", "clamp"),))


@pytest.mark.parametrize("seed", range(10))
def test_a_third_parallel_crank_is_refused_with_the_reason(seed: int) -> None:
    assert len(parallel_cranks(seed, 2).topology.links) == 3
    with pytest.raises(InputError, match=r"the chain is redundant at joint A\d, at crank angle"):
        parallel_cranks(seed, 3)
