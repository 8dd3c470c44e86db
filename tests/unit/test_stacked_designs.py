"""Designs that are computed together: each has the numbers that it has alone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import flexmech
from flexmech.analyses.designs import MOST_AT_ONCE, of_designs
from flexmech.analyses.frequencies.formulation import Formulation, Systems
from flexmech.analyses.frequencies.positions import _along, _extremes, frequency_extremes
from flexmech.arrays import IntArray
from flexmech.beams import comparison
from flexmech.errors import FlexmechError
from flexmech.linear_system import (
    GREAT_DETAIL,
    Engine,
    component_modes,
    inertia_loads,
    likeness,
    stack_batches,
    stack_engines,
)
from flexmech.linkages import FourBar, LinkageStack
from flexmech.mechanism import Mechanism

ANGLES = np.linspace(0.0, 2 * np.pi, 16, endpoint=False)
LINKS = ("crank", "coupler", "rocker")


def designs(models: Path, name: str = "aluminium_fourbar", count: int = 5) -> list[Mechanism]:
    """Mechanisms that differ in the sections of links, and four-bars in their lengths."""
    mechanism, chance = flexmech.load_mechanism(models / f"{name}.toml"), np.random.default_rng(0)
    found = []
    for thicker in 1 + 0.3 * chance.random((count, len(mechanism.sections))):
        sections = {
            link: replace(
                section,
                axial_stiffness=factor * section.axial_stiffness,
                bending_stiffness=factor**3 * section.bending_stiffness,
                shear_stiffness=factor * section.shear_stiffness,
                mass_per_length=factor * section.mass_per_length,
                layers=None,
            )
            for (link, section), factor in zip(mechanism.sections.items(), thicker, strict=True)
        }
        linkage = mechanism.linkage
        if isinstance(linkage, FourBar):
            linkage = replace(linkage, coupler=linkage.coupler * (0.95 + 0.1 * chance.random()))
        found.append(replace(mechanism, sections=sections, linkage=linkage))
    return found


def engines(mechanisms: list[Mechanism], element: str = "euler") -> list[Engine]:
    return [flexmech.ReferenceEngine(mechanism, element=element) for mechanism in mechanisms]


def frequencies(own: list[Engine], prestress: str, speed: float) -> list[np.ndarray]:
    """Lowest and highest frequencies and their crank angles of each design."""
    found = frequency_extremes(own, ANGLES, np.full(len(own), speed), modes=3, prestress=prestress)
    for each in found:
        assert not isinstance(each, FlexmechError), each
    return [np.array([*vars(each).values()]) for each in found]


@pytest.mark.parametrize("element", ["euler", "timoshenko"])
@pytest.mark.parametrize(
    ("prestress", "speed"), [("none", 0.0), ("none", 20.0), ("axial", 20.0), ("equilibrium", 20.0)]
)
def test_a_stack_has_the_frequencies_of_each_design_alone(
    models: Path, prestress: str, speed: float, element: str
) -> None:
    own = engines(designs(models), element)
    assert len({likeness(engine) for engine in own}) == 1
    together = frequencies(own, prestress, speed)
    formulation = Formulation(prestress, True, 3)
    for engine, found in zip(own, together, strict=True):
        alone = _extremes(engine, ANGLES, np.array([speed]), formulation).of_speed(0)
        np.testing.assert_allclose(found[0], alone.lowest_frequency, rtol=1e-9)
        np.testing.assert_allclose(found[2], alone.highest_frequency, rtol=1e-9)


def test_how_many_are_computed_together_changes_no_bit(models: Path) -> None:
    own = engines(designs(models, count=4))
    together = frequencies(own, "equilibrium", 20.0)
    for number, engine in enumerate(own):
        np.testing.assert_array_equal(
            frequencies([engine], "equilibrium", 20.0)[0], together[number]
        )


@pytest.mark.parametrize("prestress", ["none", "axial", "equilibrium"])
def test_nor_does_it_where_positions_are_solved_in_several_batches(
    models: Path, prestress: str
) -> None:
    angles = np.linspace(0.0, 2 * np.pi, 48, endpoint=False)

    def found(own: list[Engine]) -> list[object]:
        def compute(engine: Engine, numbers: IntArray) -> list[np.ndarray]:
            angle = np.tile(angles, len(numbers))
            systems = Systems(engine, Formulation(prestress, True, 3), np.full(len(numbers), 20.0))
            assert len(systems.batch_numbers(24 * len(numbers))) == 2
            frequency, _ = _along(systems, angle, np.full(angle.shape, 20.0))
            return [*frequency.reshape(len(numbers), len(angles), 3)]

        return of_designs(own, compute)

    own = engines(designs(models, count=3))
    for number, each in enumerate(found(own)):
        np.testing.assert_array_equal(each, found([own[number]])[0])
        alone = flexmech.natural_frequencies(
            own[number], angles, 20.0, modes=3, prestress=prestress
        )
        np.testing.assert_allclose(each, alone, rtol=1e-9)


def test_a_batch_has_as_many_positions_of_every_design() -> None:
    parts = stack_batches(3 * 30, 3)
    assert len(parts) == 3
    assert all((np.bincount(part // 30) == [len(part) // 3] * 3).all() for part in parts)
    assert all((np.diff(part) > 0).all() for part in parts)
    assert np.array_equal(np.sort(np.concatenate(parts)), np.arange(90))


def test_loads_of_a_stack_are_those_of_each_design(models: Path) -> None:
    own = engines(designs(models, count=3))
    stack, angles = stack_engines(own), np.array([0.3, 2.0])
    motion = stack.mechanism.linkage.motion(np.tile(angles, 3), np.full(6, 20.0))
    together = inertia_loads(stack.links, motion, (0.0, -9.81))
    for number, engine in enumerate(own):
        there = engine.mechanism.linkage.motion(angles, 20.0)
        alone = inertia_loads(engine.links, there, (0.0, -9.81))
        for here, each in zip(together, alone, strict=True):
            some = here[2 * number : 2 * number + 2]
            np.testing.assert_allclose(some, each, rtol=1e-12, atol=1e-12 * np.abs(each).max())


def test_damped_links_are_stacked(models: Path) -> None:
    mechanisms = [
        replace(
            own,
            sections={
                k: s.with_damping_ratio(0.02, frequency=50.0) for k, s in own.sections.items()
            },
        )
        for own in designs(models, count=3)
    ]
    own = engines(mechanisms)
    together = frequencies(own, "equilibrium", 15.0)
    for number, engine in enumerate(own):
        angle = together[number][1][0]
        alone = flexmech.natural_frequencies(engine, angle, 15.0, modes=3)[0]
        assert together[number][0][0] == pytest.approx(alone, rel=1e-9)


def test_designs_that_differ_in_more_than_numbers_are_apart(models: Path) -> None:
    """Other elements, masses at more places, bodies, sliders, another kind of engine."""
    one, other = designs(models, count=2)
    assert likeness(engines([one])[0]) == likeness(engines([other])[0])
    more = replace(one, link_masses=(flexmech.PointMass("coupler", 0.1, 0.02),))
    assert likeness(engines([more])[0]) not in (None, likeness(engines([one])[0]))
    assert likeness(engines([one], "timoshenko")[0]) != likeness(engines([one])[0])
    body = flexmech.AttachedBody("coupler", 0.1, 0.02, offset=(0.0, 0.01))
    assert likeness(engines([replace(one, bodies=(body,))])[0]) is None
    assert likeness(flexmech.ExudynEngine(one)) is None
    slides = flexmech.load_mechanism(models / "slider_crank.toml")
    assert likeness(flexmech.ReferenceEngine(slides)) is None


def test_unlike_designs_and_failures_keep_their_places(models: Path) -> None:
    """One design cannot turn, one has a body, the others are computed as without these."""
    plain = designs(models, count=4)
    locks = replace(plain[0], linkage=replace(plain[0].linkage, crank=0.29))
    body = flexmech.AttachedBody("coupler", 0.1, 0.02, offset=(0.0, 0.01))
    mixed = [plain[0], locks, plain[1], replace(plain[2], bodies=(body,)), plain[3]]
    speeds = np.full(len(mixed), 10.0)
    found = frequency_extremes(engines(mixed), ANGLES, speeds, modes=3, prestress="none")
    assert isinstance(found[1], FlexmechError)
    assert "crank angle" in str(found[1])
    alone = frequencies(engines([plain[0], plain[1], plain[3]]), "none", 10.0)
    for place, expected in zip((0, 2, 4), alone, strict=True):
        np.testing.assert_array_equal(np.array([*vars(found[place]).values()]), expected)


def test_a_failure_is_found_by_halves(models: Path) -> None:
    """Whichever of them it is, and none of the others is lost."""
    own = engines(designs(models, count=7))
    for bad in (0, 3, 6):

        def compute(engine: Engine, numbers: IntArray) -> list[int]:
            del engine
            if bad in numbers:  # noqa: B023
                raise FlexmechError("this one")
            return [*numbers.tolist()]

        found = of_designs(own, compute)
        assert [n for n, each in enumerate(found) if isinstance(each, FlexmechError)] == [bad]
        assert [each for each in found if not isinstance(each, FlexmechError)] == [
            n for n in range(7) if n != bad
        ]


def test_more_designs_than_a_stack_holds(models: Path) -> None:
    own = engines(designs(models, count=2)) * MOST_AT_ONCE
    sizes: list[int] = []

    def compute(engine: Engine, numbers: IntArray) -> list[int]:
        sizes.append(engine.designs or 0)
        return [*numbers.tolist()]

    assert of_designs(own, compute) == [*range(len(own))]
    assert sizes == [MOST_AT_ONCE] * 2


def test_motion_of_a_stack_is_that_of_each_linkage(models: Path) -> None:
    linkages = tuple(own.linkage for own in designs(models, count=3))
    angle, speed = np.tile(ANGLES, 3), np.repeat([1.0, 2.0, 3.0], len(ANGLES))
    motion = LinkageStack(linkages).motion(angle, speed)
    assert motion.design is not None
    np.testing.assert_array_equal(motion.design, np.repeat(range(3), len(ANGLES)))
    for number, linkage in enumerate(linkages):
        alone, own = linkage.motion(ANGLES, number + 1.0), motion.at(motion.design == number)
        np.testing.assert_array_equal(own.angular_acceleration, alone.angular_acceleration)
        np.testing.assert_array_equal(own.origin_acceleration, alone.origin_acceleration)


def test_six_bars_are_stacked_as_well(models: Path) -> None:
    own = engines(designs(models, "watt_six_bar", 2))
    assert likeness(own[0]) is not None
    together = frequencies(own, "axial", 5.0)
    for number, engine in enumerate(own):
        np.testing.assert_allclose(frequencies([engine], "axial", 5.0)[0], together[number])


def test_of_a_stack_no_displacement_is_read(models: Path) -> None:
    stack = stack_engines(engines(designs(models, count=2)))
    with pytest.raises(TypeError, match="one design"):
        _ = stack.links[0].shape


def test_elements_are_chosen_alike_of_many_and_of_one(models: Path) -> None:
    """The comparison of beam theories that is prepared is that of a mechanism by itself."""
    mechanisms = designs(models, count=3)
    alone = [flexmech.ReferenceEngine.compare_theories(own, 4) for own in mechanisms]
    expected = [own.frequency("timoshenko") for own in alone]
    comparison._frequencies.cache_clear()
    flexmech.ReferenceEngine.prepare_comparisons(mechanisms, 4)
    assert comparison._PREPARED
    for own, frequency in zip(mechanisms, expected, strict=True):
        again = flexmech.ReferenceEngine.compare_theories(own, 4).frequency("timoshenko")
        np.testing.assert_array_equal(again, frequency)


def test_designs_whose_links_bow_deeply_are_stacked_too(models: Path) -> None:
    """At a speed that bends them far, component modes in great detail are taken of both."""
    mechanism = flexmech.load_mechanism(models / "aluminium_fourbar.toml")
    own = engines([mechanism, replace(mechanism, gravity=(0.0, 0.0))])
    together = frequencies(own, "equilibrium", 45.0)
    formulation = Formulation("equilibrium", True, 3)
    alone = _extremes(own[0], ANGLES, np.array([45.0]), formulation).of_speed(0)
    np.testing.assert_allclose(together[0][0], alone.lowest_frequency, rtol=1e-9)
    reduction = component_modes(
        own[0].topology,
        stack_engines(own).links,
        3,
        np.full(2, 100.0),
        couples_axially=True,
        detail=GREAT_DETAIL,
    )
    one = component_modes(
        own[0].topology, own[0].links, 3, 100.0, couples_axially=True, detail=GREAT_DETAIL
    )
    for stacked, link in zip(reduction.links, one.links, strict=True):
        np.testing.assert_allclose(stacked.basis[0], link.basis, rtol=0, atol=1e-9)
