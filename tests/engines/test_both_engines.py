"""Both engines on the same mechanisms and meshes: frequencies, damping, stability, strength.

Cables and exact beams interpolate the stretch and the bending of a link otherwise than the
reference's elements do, so that frequencies differ by what falls with the square of the mesh. What
extrapolation leaves of the difference is a hundredth of it, and would show a fault of 1e-5.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import xarray as xr

from flexmech import (
    StrengthRequest,
    campbell,
    moving_frequencies,
    natural_frequencies,
    speed_sweep,
    stability,
    strength,
)
from tests.support.mechanisms import NAMES, case

THICK = (
    "composite four-bar",
    "sandwich four-bar",
    "swollen resin",
    "wet on one side",
    "heavy side",
    "eccentric arm",
    "unsymmetric laminates",
    "laminated slider-crank 20",
)
SLENDER = [name for name in NAMES if name not in THICK]
# Its soft coupler is stretched in its third mode.
HARDLY_STRETCHED = [name for name in SLENDER if name != "of all kinds"]


def apart(name: str, elements: int, speed: float, modes: bool = True, **options: Any) -> np.ndarray:
    """Relative difference of the engines' frequencies, (angle, mode)."""
    one = case(name)
    first, second = (
        natural_frequencies(engine, one.angles, speed, modes=one.modes, **options)
        for engine in one.engines(elements, component_modes=modes)
    )
    return second / first - 1


def extrapolated(coarse: np.ndarray, fine: np.ndarray, order: int = 2) -> np.ndarray:
    return (2**order * fine - coarse) / (2**order - 1)


@pytest.mark.parametrize("name", HARDLY_STRETCHED)
def test_frequencies_at_rest_differ_by_half_a_millionth(name: str) -> None:
    coarse, fine = (apart(name, n, 0.0, prestress="none") for n in (6, 12))
    assert np.abs(fine).max() < 2e-6
    assert np.abs(extrapolated(coarse, fine)).max() < 4e-7


@pytest.mark.parametrize("name", HARDLY_STRETCHED)
def test_frequencies_of_straight_links_under_axial_forces_tend_to_each_other(name: str) -> None:
    speed = case(name).speed
    coarse, fine = (apart(name, n, speed, prestress="axial") for n in (6, 12))
    left = np.abs(extrapolated(coarse, fine)).max()
    assert left < max(2e-6, 0.1 * np.abs(fine).max())


@pytest.mark.parametrize("name", SLENDER)
def test_frequencies_at_equilibrium_tend_to_each_other(name: str) -> None:
    """With all rotation terms, in all coordinates: component modes differ by 1e-5 of their own."""
    one = case(name)
    coarse, fine = (
        apart(name, n, one.speed, modes=False) for n in (one.elements, 2 * one.elements)
    )
    left = np.abs(extrapolated(coarse, fine)).max()
    assert left < max(4e-6, 0.3 * np.abs(fine).max())
    assert np.abs(fine).max() < 2e-4


@pytest.mark.parametrize("name", THICK)
def test_frequencies_of_beams_that_shear_tend_to_each_other(name: str) -> None:
    """Exact beams are linear, of second order in the mesh: two extrapolations."""
    one = case(name)
    meshes = [one.elements * 2**n for n in range(3)]
    gaps = [apart(name, n, one.speed, modes=False) for n in meshes]
    once = [extrapolated(*pair) for pair in pairwise(gaps)]
    # Of links that water bends 9e-5 are left, and do not fall with the mesh.
    assert np.abs(extrapolated(*once, order=4)).max() < 1.2e-4


DAMPED = (
    "aluminium four-bar",
    "composite four-bar",
    "Watt six-bar",
    "of all kinds",
    "rigid rod",
    "spring and damper",
    "sprung joints",
    "four-bar on a frame",
    "arm on a hub with free shaft",
    "crank-rocker 17",
)


@pytest.mark.parametrize("name", DAMPED)
def test_damping_ratios_at_equilibrium_tend_to_each_other(name: str) -> None:
    one = case(name)
    result = moving_frequencies(
        one.engines(6), one.angles[:1], [one.speed], modes=one.modes, shaft=one.shaft
    )
    first, second = result.dataset["damping_ratio"].values
    assert first.max() > 1e-4
    np.testing.assert_allclose(second, first, rtol=0, atol=5e-3 * first.max())


def both(analysis: Any, name: str, *asked: Any, elements: int = 4, **options: Any) -> list[Any]:
    return [
        analysis(engine, *asked, **options).dataset.isel(engine=0, drop=True)
        for engine in case(name).engines(elements)
    ]


@pytest.mark.parametrize(
    ("name", "near"),
    [
        ("aluminium four-bar", 2e-4),
        ("slider-crank", 2e-5),
        ("rigid crank", 2e-5),
        ("crank-rocker 0", 2e-5),
    ],
)
def test_floquet_modes_of_both_engines_are_alike(name: str, near: float) -> None:
    first, second = both(stability, name, [case(name).speed], modes=3)
    size = float(np.abs(first["frequency"]).max())
    for of, scale in (("frequency", size), ("growth_rate", 2 * np.pi * size), ("damping_ratio", 1)):
        np.testing.assert_allclose(
            np.sort(second[of]), np.sort(first[of]), rtol=0, atol=near * scale
        )


@pytest.mark.parametrize("name", ["aluminium four-bar", "rigid crank"])
def test_campbell_diagrams_of_both_engines_are_alike(name: str) -> None:
    one = case(name)
    speeds = [0.0, one.speed / 2, one.speed]
    result = campbell(one.engines(4), speeds, crank_angles=one.angles, modes=2, orders=[10])
    for band in ("lowest_frequency", "mean_frequency", "highest_frequency"):
        first, second = result.dataset[band].values
        np.testing.assert_allclose(second, first, rtol=2e-4)


@pytest.mark.parametrize(
    "name",
    [
        "steel four-bar",
        pytest.param("slider-crank uphill", marks=pytest.mark.thorough),
        pytest.param("crank-rocker 0", marks=pytest.mark.thorough),
    ],
)
def test_periodic_motions_of_both_engines_peak_alike(name: str) -> None:
    one = case(name)
    first, second = (
        speed_sweep(engine, [one.speed / 2, one.speed], modes=1).dataset["peak_deflection"]
        for engine in one.engines(4)
    )
    np.testing.assert_allclose(second, first, atol=2e-4 * float(first.max()))


JUDGED = (
    "aluminium four-bar",
    "rigid coupler",
    "rigid crank",
    "moving guide",
    "L-arm with bodies",
    "ternary coupler",
    "three links on a pin",
    "dead loads",
    "follower load",
    "spring and damper",
    "springs in pins",
    "sprung joints",
    "sprung L-arm",
)


@pytest.mark.parametrize("name", JUDGED)
def test_forces_inside_links_at_equilibrium_are_alike(name: str) -> None:
    """By statics of the displaced links: axial and shear forces and moments at all stations."""
    one = case(name)
    request = StrengthRequest(one.angles, one.speed, search_speed=False)
    first, second = both(strength, name, request, elements=12)
    for of in ("axial_force", "bending_moment", "shear_force"):
        size = first[of].pipe(np.abs).max(["crank_angle", "station"])
        gap = xr.apply_ufunc(np.abs, second[of] - first[of]).max(["crank_angle", "station"])
        assert float((gap / size).max()) < 1e-3, of
