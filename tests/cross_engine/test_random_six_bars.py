"""Slider-cranks and six-bars at random, damped and at speed: both engines' complex eigenvalues."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from flexmech import ExudynEngine, ReferenceEngine
from flexmech.analyses import solve_modes
from flexmech.arrays import FloatArray
from flexmech.threads import one_thread
from tests.support.random_planar_mechanisms import KINDS, Kind, planar_case

MODES = 3
ELEMENTS = 8
# Of the fastest link's angular velocity over the slowest vibration's: rotation terms and stress
# move frequencies by up to a tenth, and damping ratios by more than themselves.
SHARE = (0.05, 0.2)
# Measured at most 5.5e-5 over 144 linkages of 8 elements a link, and a fourth of it with 16.
FREQUENCIES_AGREE = 1e-4
# Of the ratio itself, and of the largest one at the same crank angle: a ratio that rotation terms
# bring near zero keeps the error of its parts.
RATIOS_AGREE, NEAR_ZERO = 5e-4, 5e-5
DRAWS = [(kind, seed) for kind in KINDS for seed in range(10)]


@cache
def solved(kind: Kind, seed: int, elements: int = ELEMENTS) -> tuple[FloatArray, FloatArray]:
    """Frequencies in Hz and damping ratios, each (engine, at rest and at speed, angle, mode)."""
    case = planar_case(seed, kind, share=SHARE)
    frequency, ratio = np.empty((2, 2, 2, len(case.crank_angles), MODES))
    engines = (
        ReferenceEngine(case.mechanism, elements, "euler"),
        ExudynEngine(case.mechanism, elements, "ancf"),
    )
    with one_thread():
        for number, engine in enumerate(engines):
            for row, speed in enumerate((0.0, case.crank_speed)):
                modes = solve_modes(
                    engine.linear_system(case.crank_angles, speed, modes=MODES), MODES
                )
                frequency[number, row], ratio[number, row] = modes.frequency, modes.damping_ratio
    return frequency, ratio


def gaps(kind: Kind, seed: int, elements: int = ELEMENTS) -> tuple[float, float]:
    """Greatest difference of the engines at speed: of frequencies, relative, and of ratios.

    That of a ratio is relative to what it may differ by.
    """
    frequency, ratio = solved(kind, seed, elements)
    allowed = np.abs(ratio[0, 1]) + NEAR_ZERO / RATIOS_AGREE * ratio[0, 1].max(-1, keepdims=True)
    return (
        float(np.abs(frequency[1, 1] / frequency[0, 1] - 1).max()),
        float((np.abs(ratio[1, 1] - ratio[0, 1]) / allowed).max()),
    )


@pytest.mark.parametrize(
    ("kind", "seed"),
    [
        ("slider-crank", 35),
        *(pytest.param(kind, seed, marks=pytest.mark.thorough) for kind, seed in DRAWS),
    ],
)
def test_engines_agree_and_the_speed_matters_more(kind: Kind, seed: int) -> None:
    frequency, _ = solved(kind, seed)
    apart, ratios_apart = gaps(kind, seed)
    assert apart < FREQUENCIES_AGREE
    assert ratios_apart < RATIOS_AGREE
    assert np.abs(frequency[0, 1] / frequency[0, 0] - 1).max() > 50 * apart


@pytest.mark.thorough
@pytest.mark.parametrize(("kind", "seed"), [("watt", 9), ("slider-crank", 44), ("watt", 15)])
def test_the_farthest_draws_converge_to_each_other(kind: Kind, seed: int) -> None:
    """In second order, as the mean tension of an element does."""
    coarse, fine = (gaps(kind, seed, elements) for elements in (ELEMENTS, 2 * ELEMENTS))
    for before, after in zip(coarse, fine, strict=True):
        assert after < 0.35 * before


@pytest.mark.thorough
def test_what_is_drawn_has_welds_sliders_and_every_sort_of_dyad() -> None:
    drawn = [planar_case(seed, kind).mechanism.linkage.topology for kind, seed in DRAWS]
    slides = np.mean([bool(topology.sliders) for topology in drawn])
    welds = np.mean([bool(topology.welds) for topology in drawn])
    rigid = sum(any(link.rigid for link in topology.links) for topology in drawn)
    assert 0.35 < slides < 0.9
    assert 0.6 < welds < 1
    assert rigid > 0
    assert max(len(topology.links) for topology in drawn) >= 6
