"""Both engines on the same mechanisms and meshes: frequencies, damping, stability, strength.

Cables and exact beams interpolate the stretch and the bending of a link otherwise than the
reference's elements do, so that frequencies differ by what falls with the square of the mesh. What
extrapolation leaves of the difference is a hundredth of it, and would show a fault of 1e-5.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
import xarray as xr

from flexmech import (
    ConstantSpeed,
    PlanarLinkage,
    campbell,
    moving_frequencies,
    natural_frequencies,
    stability,
    strength,
)
from flexmech.analyses import StrengthRequest, deflections
from flexmech.linkages import RigidMotion, Topology
from flexmech.mechanics.running import DrivenLinkage
from flexmech.solvers import periodic_turn
from tests.support.mechanisms import NAMES, case
from tests.support.stations import at_common_places

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
# Largest difference of frequencies at equilibrium on the finer mesh.
SLENDER = {
    "aluminium four-bar": 8.7e-6,
    "steel four-bar": 1.1e-6,
    "Turcic's four-bar": 1.6e-6,
    "arm": 2.0e-7,
    "slender arm": 3.5e-5,
    "L-beam": 2.9e-6,
    "slider-crank": 8.1e-7,
    "slider-crank with free shaft": 1.5e-4,
    "Watt six-bar": 4.0e-7,
    "Stephenson six-bar": 1.2e-6,
    "carton pusher": 4.4e-7,
    "carton pusher with free shaft": 4.0e-6,
    "of all kinds": 2.8e-6,
    "ternary coupler": 1.9e-6,
    "rigid coupler": 2.0e-7,
    "rigid ternary coupler": 2.0e-7,
    "slider-crank uphill": 1.7e-6,
    "rigid crank": 2.0e-7,
    "rigid rod": 2.0e-7,
    "moving guide": 7.6e-7,
    "bowed on a moving guide": 2.0e-7,
    "L-arm with bodies": 6.9e-7,
    "rigid leg": 1.7e-7,
    "three links on a pin": 2.8e-6,
    "portal frame": 3.7e-7,
    "dead loads": 5.6e-6,
    "follower load": 7.9e-6,
    "spring and damper": 1.8e-6,
    "springs in pins": 1.4e-5,
    "sprung joints": 4.1e-6,
    "sprung joints of a rigid rocker": 7.3e-6,
    "sprung pin and a body": 7.0e-6,
    "loaded rigid rocker": 1.1e-5,
    "sprung L-arm": 3.6e-5,
    "loaded rigid leg": 4.3e-6,
    "flywheel": 8.9e-6,
    "arm on a hub with free shaft": 5.4e-7,
    "four-bar on a frame": 3.9e-7,
    "slider-crank on a frame": 2.0e-7,
    "crank-rocker 0": 1.5e-6,
    "crank-rocker 17": 9.8e-6,
    "slider-crank 35": 1.2e-6,
    "Watt 9": 1.3e-5,
    "Stephenson 3": 5.9e-6,
}
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


@pytest.mark.parametrize("name", HARDLY_STRETCHED[::2])
def test_frequencies_at_rest_differ_by_half_a_millionth(name: str) -> None:
    coarse, fine = (apart(name, n, 0.0, prestress="none") for n in (6, 12))
    assert np.abs(fine).max() < 2e-6
    assert np.abs(extrapolated(coarse, fine)).max() < 4e-7


@pytest.mark.parametrize("name", HARDLY_STRETCHED[1::2])
def test_frequencies_of_straight_links_under_axial_forces_tend_to_each_other(name: str) -> None:
    speed = case(name).speed
    coarse, fine = (apart(name, n, speed, prestress="axial") for n in (6, 12))
    left = np.abs(extrapolated(coarse, fine)).max()
    assert left < max(2e-6, 0.1 * np.abs(fine).max())


@pytest.mark.parametrize("name", SLENDER)
def test_frequencies_at_equilibrium_differ_by_what_elements_make(name: str) -> None:
    """With all rotation terms, in all coordinates: component modes differ by 1e-5 of their own."""
    one = case(name)
    gap = apart(name, 2 * one.elements, one.speed, modes=False)
    assert np.abs(gap).max() < SLENDER[name]


@pytest.mark.thorough
@pytest.mark.parametrize("name", SLENDER)
def test_frequencies_at_equilibrium_tend_to_each_other(name: str) -> None:
    one = case(name)
    meshes = (one.elements, 2 * one.elements)
    coarse, fine = (apart(name, n, one.speed, modes=False) for n in meshes)
    left = np.abs(extrapolated(coarse, fine)).max()
    assert left < max(4e-6, 0.3 * np.abs(fine).max())


def test_every_mechanism_is_of_slender_or_of_thick_links() -> None:
    assert {*SLENDER, *THICK} == set(NAMES)


@pytest.mark.parametrize(
    "name",
    [
        *THICK[3:5],
        *(pytest.param(n, marks=pytest.mark.thorough) for n in (*THICK[:3], *THICK[5:])),
    ],
)
def test_frequencies_of_beams_that_shear_tend_to_each_other(name: str) -> None:
    """Exact beams are linear, of second order in the mesh: two extrapolations."""
    one = case(name)
    meshes = [one.elements * 2**n for n in range(3)]
    gaps = [apart(name, n, one.speed, modes=False) for n in meshes]
    once = [extrapolated(*pair) for pair in pairwise(gaps)]
    # Links bent by water keep a difference of 9e-5, which does not fall with the mesh.
    assert np.abs(extrapolated(*once, order=4)).max() < 1.2e-4


DAMPED = (
    "aluminium four-bar",
    "composite four-bar",
    "of all kinds",
    "rigid rod",
    "spring and damper",
    "sprung joints",
    "four-bar on a frame",
)


@pytest.mark.thorough
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
        ("slider-crank", 2e-5),
        pytest.param("aluminium four-bar", 2e-4, marks=pytest.mark.thorough),
        pytest.param("rigid crank", 2e-5, marks=pytest.mark.thorough),
        pytest.param("crank-rocker 0", 2e-5, marks=pytest.mark.thorough),
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


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["steel four-bar", "slider-crank uphill", "crank-rocker 0"])
def test_periodic_motions_of_both_engines_peak_alike(name: str) -> None:
    one = case(name)
    for speed in (one.speed / 2, one.speed):
        drive, peaks = ConstantSpeed(speed), []
        for engine in one.engines(4):
            linkage = DrivenLinkage(engine, drive, "equilibrium", modes=1)
            peaks.append(np.abs(deflections(engine, periodic_turn(linkage, 720))).max(axis=0))
        np.testing.assert_allclose(peaks[1], peaks[0], atol=2e-4 * peaks[0].max())


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
    request = StrengthRequest(one.speed, crank_angles=one.angles[1:2], search_speed=False)
    first, second = both(strength, name, request, elements=12)
    for of in ("axial_force", "bending_moment", "shear_force"):
        size = first[of].pipe(np.abs).max(["crank_angle", "station"])
        gap = xr.apply_ufunc(np.abs, second[of] - first[of]).max(["crank_angle", "station"])
        assert float((gap / size).max()) < 1e-3, of


@pytest.mark.parametrize("name", ["of all kinds", "ternary coupler", "dead loads", "rigid crank"])
def test_stiff_links_bear_what_rigid_ones_do(name: str) -> None:
    """Statics of displaced links by both engines, and inverse dynamics of the rigid linkage."""
    one = case(name)
    kinds = ("axial_stiffness", "bending_stiffness", "shear_stiffness")
    sections = {
        link: replace(section, **{kind: 1e3 * getattr(section, kind) for kind in kinds})
        for link, section in one.mechanism.sections.items()
    }
    stiff = replace(one, mechanism=replace(one.mechanism, sections=sections))
    found = [
        strength(
            engine, one.speed, crank_angles=one.angles[1:2], source=source, search_speed=False
        ).dataset.isel(engine=0, drop=True)
        for source in ("rigid", "quasi-static")
        for engine in stiff.engines(8)
    ]
    for other in found[2:]:
        for of in ("axial_force", "bending_moment", "shear_force"):
            size = float(np.abs(found[0][of]).max())
            for bent, straight in at_common_places(other, found[0], of):
                np.testing.assert_allclose(bent, straight, rtol=0, atol=1e-3 * size)


class OfOnesOwn:
    """A linkage that only says its topology and motion, as one that a user writes does."""

    kind = "of one's own"

    def __init__(self, drawn: PlanarLinkage) -> None:
        self.drawn = drawn

    @property
    def topology(self) -> Topology:
        return self.drawn.topology

    def motion(self, angle: Any, speed: Any = 0.0, acceleration: Any = 0.0) -> RigidMotion:
        return self.drawn.motion(angle, speed, acceleration)

    def resized(self, lengths: Any, ground_growth: float) -> Any:
        raise NotImplementedError

    def described(self) -> list[str]:
        return []

    def to_table(self) -> dict[str, object]:
        return {}


def test_a_linkage_of_ones_own_comes_without_touching_the_engines() -> None:
    one = case("three links on a pin")
    own = replace(one.mechanism, linkage=OfOnesOwn(one.mechanism.linkage))
    pairs = zip(one.engines(4), replace(one, mechanism=own).engines(4), strict=True)
    for engine, other in pairs:
        found, wanted = (natural_frequencies(e, one.angles, one.speed) for e in (other, engine))
        np.testing.assert_array_equal(found, wanted)
