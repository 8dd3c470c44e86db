"""Links that bend or stretch without load: both engines, and the circle that such a link is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexmech.analyses import natural_frequencies
from flexmech.analyses.response.compute import response
from flexmech.analyses.response.request import ResponseRequest
from flexmech.errors import InputError
from flexmech.linear_system import Engine
from flexmech.linkages import ConstantSpeed, FourBar, RotatingArm
from flexmech.materials import Laminate, Layer, Material, Ply
from flexmech.mechanism import Mechanism
from flexmech.multibody import ExudynEngine
from flexmech.reference import ReferenceEngine
from flexmech.sections import BeamSection, LaminateSection

ALUMINIUM = Material(69e9, 2700.0, 0.33)
ANGLES = np.radians([10.0, 130.0, 250.0])


def four_bar(curvature: float = 0.0, strain: float = 0.0, grown: float = 1.0) -> Mechanism:
    """Thin links; coupler and rocker bent without load, all stretched."""
    section = BeamSection.rectangle(ALUMINIUM, 0.003, 0.02)
    bent = replace(section, free_curvature=curvature, free_strain=strain)
    return Mechanism(
        FourBar(0.25, 0.1 * grown, 0.28 * grown, 0.26 * grown),
        {"crank": replace(section, free_strain=strain), "coupler": bent, "rocker": bent},
    )


def arm(curvature: float) -> Mechanism:
    section = BeamSection.rectangle(ALUMINIUM, 0.003, 0.02)
    return Mechanism(RotatingArm(0.5), {"arm": replace(section, free_curvature=curvature)})


def displacement(engine: Engine, angles: np.ndarray) -> list[np.ndarray]:
    found = engine.stressed_links(engine.mechanism.linkage.motion(angles), "equilibrium")
    assert found.displacement is not None
    return found.displacement


@pytest.mark.parametrize(
    ("engine", "element", "within"),
    [
        (ReferenceEngine, "euler", 1e-3),
        (ReferenceEngine, "timoshenko", 1e-3),
        (ReferenceEngine, "reddy", 1e-3),
        (ExudynEngine, "ancf", 1e-4),
        (ExudynEngine, "geometrically-exact", 1e-3),
    ],
)
def test_free_arm_is_an_arc(engine: type[Engine], element: str, within: float) -> None:
    """Nothing loads it: its tip is where the arc of its length ends."""
    length, curvature = 0.5, 1.2
    own = engine(arm(curvature), elements=16, element=element)
    tip = displacement(own, np.zeros(1))[0][0][own.links[0].end]
    turned = curvature * length
    wanted = [np.sin(turned) / curvature - length, (1 - np.cos(turned)) / curvature]
    assert tip == pytest.approx(wanted, rel=within)


def test_the_arc_converges_in_second_order() -> None:
    """The reference's straight elements inscribe the arc."""
    length, curvature = 0.5, 1.2
    wanted = np.sin(curvature * length) / curvature - length
    errors = []
    for elements in (4, 8, 16):
        own = ReferenceEngine(arm(curvature), elements=elements, element="euler")
        tip = displacement(own, np.zeros(1))[0][0][own.links[0].end]
        errors.append(abs(tip[0] - wanted))
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(rates > 1.9)


@pytest.mark.parametrize("speed", [0.0, 30.0])
def test_engines_agree_on_bent_links(speed: float) -> None:
    """The gap falls with the square of the element length, as the reference's error."""
    gaps = []
    for elements in (8, 16):
        found = [
            natural_frequencies(engine(four_bar(0.8), elements=elements), ANGLES, speed)
            for engine in (ReferenceEngine, ExudynEngine)
        ]
        gaps.append(np.abs(found[0] / found[1] - 1).max())
    assert gaps[1] < 3e-4
    assert gaps[0] / gaps[1] > 2.8


def test_bending_matters() -> None:
    """A sagitta of three thicknesses moves a frequency by percents: it is no round-off."""
    straight, bent = (
        natural_frequencies(ReferenceEngine(four_bar(k), elements=8), ANGLES) for k in (0.0, 0.8)
    )
    assert np.abs(bent / straight - 1).max() > 0.02


def test_bent_and_eccentric_links_agree() -> None:
    """A bimetal coupler, its neutral axis off the pins, bent by heat; frequencies extrapolated."""
    strip = Laminate(
        (
            Layer(Ply.isotropic(ALUMINIUM), 0.004),
            Layer(Ply.isotropic(Material(200e9, 7800.0)), 0.003),
        )
    )
    section = replace(BeamSection.of_laminate(LaminateSection(strip, 0.02)), free_curvature=-0.3)
    plain = BeamSection.rectangle(ALUMINIUM, 0.008, 0.02)
    mechanism = Mechanism(
        FourBar(0.25, 0.1, 0.28, 0.26), {"crank": plain, "coupler": section, "rocker": plain}
    )
    coarse, fine = (
        {
            kind: natural_frequencies(kind(mechanism, elements=elements), ANGLES, 30.0, modes=3)
            for kind in (ReferenceEngine, ExudynEngine)
        }
        for elements in (8, 16)
    )
    extrapolated = [fine[k] + (fine[k] - coarse[k]) / 3 for k in (ReferenceEngine, ExudynEngine)]
    assert extrapolated[0] == pytest.approx(extrapolated[1], rel=2e-4)


@pytest.mark.parametrize("kind", [ReferenceEngine, ExudynEngine])
def test_free_strain_is_a_swollen_length(kind: type[Engine]) -> None:
    """Dry lengths with a free strain come to stand where the swollen linkage does."""
    strain = 0.01
    swollen = four_bar(grown=1 + strain).linkage.motion(ANGLES)
    engine = kind(four_bar(strain=strain), elements=4)
    motion = engine.mechanism.linkage.motion(ANGLES)
    moved = displacement(engine, ANGLES)[1][:, engine.links[1].end]
    angle = motion.angle[:, 1]
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    found = motion.position(1, 0.28) + np.einsum("ijb,bj->bi", turn, moved)
    assert found == pytest.approx(swollen.position(1, 0.28 * (1 + strain)), abs=2e-9)


@pytest.mark.parametrize("prestress", ["none", "axial"])
@pytest.mark.parametrize("kind", [ReferenceEngine, ExudynEngine])
def test_straight_links_are_asked_of_bent_ones(kind: type[Engine], prestress: str) -> None:
    with pytest.raises(InputError, match="use prestress 'equilibrium'"):
        natural_frequencies(kind(four_bar(0.5)), ANGLES, 10.0, prestress=prestress)  # type: ignore[arg-type]


def test_exact_beams_refuse_a_free_strain() -> None:
    with pytest.raises(InputError, match="swollen length"):
        ExudynEngine(four_bar(strain=0.01), element="geometrically-exact")


@pytest.mark.thorough
def test_bent_links_run_alike() -> None:
    """From the equilibrium on, with links bowed by 8 mm: ten times their thickness.

    Modes of straight links would leave a hundredth between the engines.
    """
    request = ResponseRequest(ConstantSpeed(20.0), revolutions=0.08, start="equilibrium")
    reference, exudyn = (
        response(engine(four_bar(0.8), elements=6), request).dataset
        for engine in (ReferenceEngine, ExudynEngine)
    )
    assert float(exudyn["energy_error"][0]) < 1e-6
    first, second = reference["deflection"].values[0], exudyn["deflection"].values[0]
    gap = np.abs(first - second).max(axis=0) / np.abs(second).max(axis=0)
    assert gap[0] < 2e-3
    assert np.all(gap[1:] < 2e-4)
