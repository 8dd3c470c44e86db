"""Links of off-axis plies between joints, in the reference engine against three dimensions.

First frequencies of pinned links are those of scikit-fem's 27-node hexahedra between rigid end
faces, computed for these tests; second ones are of the elements of
:mod:`flexmech.beams.solid_link`, which are held against these in ``test_off_axis_beams.py``.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
from numpy.typing import NDArray

from flexmech.analyses.beam_theory import theory_attributes
from flexmech.analyses.frequencies.compute import moving_frequencies
from flexmech.analyses.frequencies.positions import natural_frequencies
from flexmech.beams import BEAM_SHAPES, build_chain
from flexmech.beams.link_matrices import Chain
from flexmech.beams.restrained_ends import restrained_beam, restrained_ends
from flexmech.beams.solid_link import SolidLink, bending_between_pins
from flexmech.linear_system import whole
from flexmech.linkages import FourBar, LinkMass, RotatingArm
from flexmech.materials import Laminate, Layer, Ply
from flexmech.mechanism import Mechanism
from flexmech.multibody import ExudynEngine
from flexmech.reference import ReferenceEngine
from flexmech.sections import BeamSection, LaminateSection

FloatArray = NDArray[np.float64]
CARBON = Ply(172.7e9, 7.20e9, 3.76e9, 3.76e9, 2.57e9, 0.29, 1566.7, name="C")
THICKNESS, LENGTH = 4e-3, 0.12
ANGLE_PLY = (30, -30, -30, 30)


def layers_of(angles: tuple[float, ...], width: float) -> LaminateSection:
    """Of plies at angles in degrees, its width over the thickness."""
    layers = tuple(Layer(CARBON, THICKNESS / len(angles), np.radians(a)) for a in angles)
    return LaminateSection(Laminate(layers), width * THICKNESS)


def chain_of(layers: LaminateSection, theory: str, length: float, elements: int = 8) -> Chain:
    section = BeamSection.of_laminate(replace(layers, twist="free")).with_damping_time(1e-5)
    mass = LinkMass(length, section.mass_per_length)
    chain = build_chain("link", section, mass, elements, BEAM_SHAPES[theory])
    held = restrained_ends(layers, length)
    assert held is not None
    return held.restrain(chain, section.mass_per_length)


def pinned(chain: Chain) -> FloatArray:
    """Frequencies in Hz of a link between pins."""
    model = chain.model
    kept = np.setdiff1d(np.arange(model.size), [*model.start, model.end[1]])
    grid = np.ix_(kept, kept)
    squares = scipy.linalg.eigh(
        whole(model.stiffness)[grid], whole(model.mass)[grid], eigvals_only=True
    )
    return np.asarray(np.sqrt(squares) / (2 * np.pi))


@pytest.mark.parametrize(
    "theory",
    [
        "timoshenko",
        *(pytest.param(theory, marks=pytest.mark.thorough) for theory in ("reddy", "zigzag")),
    ],
)
def test_both_modes_of_wide_strips_are_those_of_three_dimensions(theory: str) -> None:
    """Free twist is 36 % low in the first mode, and its half sine 41 % high in the second."""
    layers = layers_of((30,), 8)
    found = pinned(chain_of(layers, theory, LENGTH))
    assert found[0] == pytest.approx(628.0, rel=5e-3)
    assert found[1] == pytest.approx(bending_between_pins(layers, LENGTH)[1], rel=5e-3)


@pytest.mark.parametrize(
    ("angles", "width", "first"),
    [
        pytest.param((30,), 1, 446.5, marks=pytest.mark.thorough),
        ((30,), 4, 554.1),
        (ANGLE_PLY, 4, 622.5),
        pytest.param(ANGLE_PLY, 8, 684.5, marks=pytest.mark.thorough),
    ],
)
def test_strips_of_any_width_are_those_of_another_code(
    angles: tuple[float, ...], width: float, first: float
) -> None:
    found = pinned(chain_of(layers_of(angles, width), "timoshenko", LENGTH))
    assert found[0] == pytest.approx(first, rel=7e-3)


@pytest.mark.thorough
@pytest.mark.parametrize("angles", [(30,), (45,), (15,), (30, 0), (30, -30), ANGLE_PLY])
@pytest.mark.parametrize(("width", "length"), [(1, 20), (4, 30), (8, 60), (16, 30), (16, 100)])
def test_both_modes_of_strips_are_within_a_percent(
    angles: tuple[float, ...], width: float, length: float
) -> None:
    layers = layers_of(angles, width)
    exact = bending_between_pins(layers, length * THICKNESS)
    found = pinned(chain_of(layers, "timoshenko", length * THICKNESS, 16))[:2]
    assert found == pytest.approx(exact, rel=0.01)


def test_couples_at_the_ends_turn_them_as_in_three_dimensions() -> None:
    """Of an unsymmetric stack, whose neutral axis is off the pins."""
    layers = layers_of((30, 0), 8)
    solid = SolidLink.of(layers, LENGTH)
    couples = solid.couples()
    model = chain_of(layers, "timoshenko", LENGTH, 16).model
    kept = np.setdiff1d(np.arange(model.size), [*model.start, model.end[1]])
    loads = np.zeros((model.size, 2))
    turned = [model.start_rotation[0], model.end_rotation[0]]
    loads[turned, 0], loads[turned, 1] = (-1.0, 1.0), (1.0, 1.0)
    answer = np.linalg.solve(whole(model.stiffness)[np.ix_(kept, kept)], loads[kept])
    exact = couples.T @ solid.solve(couples)
    assert loads[kept].T @ answer == pytest.approx(exact, rel=1e-4, abs=1e-6 * exact.max())


def test_long_links_hold_their_twist_alone() -> None:
    """A torque along the link adds c^2 GJ (turn of the ends)^2 / (2 L)."""
    layers = layers_of((30,), 4)
    length = 41 * layers.width
    held = restrained_ends(layers, length)
    assert held is not None
    assert not held.solid
    free, whole = (replace(layers, twist=twist).bending_stiffness for twist in ("free", "held"))  # type: ignore[arg-type]
    torsion = (whole - free) * np.pi**2 / 8
    chain = chain_of(layers, "euler", length)
    turned = np.zeros(chain.model.size)
    turned[chain.model.start_rotation], turned[chain.model.end_rotation] = -1.0, 1.0
    assert chain.coupling is not None
    expected = torsion / length * np.outer(turned, turned)
    assert chain.coupling.stiffness == pytest.approx(expected, rel=1e-8, abs=1e-9 * torsion)
    assert restrained_ends(layers_of((0, 90, 90, 0), 4), length) is None


@pytest.mark.thorough
@pytest.mark.parametrize("elements", [1, 4])
def test_short_links_keep_their_energies_positive(elements: int) -> None:
    """A difference in shear is no bending: it would take stiffness and mass away."""
    short = layers_of((65, -21, -35, 0, 74), 3.9)
    held = restrained_ends(short, 4 * THICKNESS)
    assert held is not None
    assert not held.solid
    for layers in (short, layers_of((30, 0), 1)):
        length = (4 if layers is short else 20) * THICKNESS
        model = chain_of(layers, "timoshenko", length, elements).model
        mass = whole(model.mass)
        scale = np.sqrt(np.diag(mass))
        assert np.linalg.eigvalsh(mass / np.outer(scale, scale))[0] > 0
        stiffness = np.linalg.eigvalsh(whole(model.stiffness))
        assert stiffness[0] > -1e-9 * stiffness[-1]


def linkage_of(section: BeamSection) -> Mechanism:
    names = ("crank", "coupler", "rocker")
    return Mechanism(FourBar(0.18, 0.06, 0.18, 0.15), dict.fromkeys(names, section))


@pytest.mark.thorough
def test_links_between_joints_are_held_in_the_reference_engine() -> None:
    section = BeamSection.of_laminate(layers_of((30,), 4)).with_damping_time(1e-5)
    engine = ReferenceEngine(linkage_of(section), 4, "timoshenko")
    for chain in engine.chains.values():
        assert chain.coupling is not None
        bending = ~chain.model.is_axial
        grid = np.ix_(bending, bending)
        # Kelvin-Voigt damping of one time is that times the stiffness, what the ends hold too.
        damping = whole(chain.model.damping)[grid] / 1e-5
        stiffness = whole(chain.model.stiffness)[grid]
        assert damping == pytest.approx(stiffness, abs=1e-12 * np.abs(stiffness).max())
    free = BeamSection.of_laminate(replace(layers_of((30,), 4), twist="free"))
    stated = replace(section, bending_stiffness=2 * section.bending_stiffness)
    for other in (free, stated):
        assert restrained_beam(linkage_of(other), "coupler")[1] is None
    assert restrained_beam(Mechanism(RotatingArm(0.3), {"arm": section}), "arm")[1] is None


def test_the_equilibrium_has_what_the_ends_hold() -> None:
    """Its forces balance the loads, its tangents are their derivatives."""
    section = BeamSection.of_laminate(layers_of((30,), 4))
    engine = ReferenceEngine(linkage_of(section), 4, "timoshenko")
    motion = engine.mechanism.linkage.motion(np.radians([20.0, 140.0]), 100.0)
    stressed = engine.stressed_links(motion, "equilibrium")
    assert stressed.displacement is not None
    assert stressed.internal_force is not None
    balance = engine.frames.gather(motion, stressed.internal_force)
    loads = engine.frames.gather(motion, stressed.loads)
    coupled = [
        q @ engine.chains[n].coupling.stiffness  # type: ignore[union-attr]
        for n, q in enumerate(stressed.displacement)
    ]
    left = np.abs(balance - loads).max()
    assert left < 1e-6 * np.abs(engine.frames.gather(motion, coupled)).max()
    rng = np.random.default_rng(5)
    step = [1e-7 * rng.standard_normal(q.shape) for q in stressed.displacement]
    varying = engine._varying(motion)
    forces = [
        engine.equilibrium.response(
            [q + sign * s for q, s in zip(stressed.displacement, step, strict=True)], varying
        )[0]
        for sign in (1.0, -1.0)
    ]
    for number, tangent in engine.equilibrium.response(stressed.displacement, varying)[1].items():
        change = (forces[0][number] - forces[1][number]) / 2
        linear = np.einsum("bij,bj->bi", tangent, step[number])
        assert change == pytest.approx(linear, abs=1e-5 * np.abs(linear).max())


def test_links_that_swelling_bends_have_no_forces_at_rest() -> None:
    """What the ends hold is held about the curvature that the link swells to between them."""
    section = BeamSection.of_laminate(replace(layers_of((30,), 4), twist="held"))
    mechanism = linkage_of(replace(section, free_curvature=0.1))
    engine = ReferenceEngine(mechanism, 4, "timoshenko")
    stressed = engine.stressed_links(mechanism.linkage.motion(np.ones(1), 0.0), "equilibrium")
    assert stressed.internal_force is not None
    assert stressed.displacement is not None
    moment = 0.1 * section.bending_stiffness
    for force in stressed.internal_force:
        assert np.abs(force).max() < 1e-6 * moment
    per_node = engine.chains[1].elements.shapes.per_node
    across = stressed.displacement[1][0, 1::per_node]
    arc = abs(across[2] - across[[0, -1]].mean())
    assert arc == pytest.approx(0.1 * 0.18**2 / 8, rel=2e-3)


@pytest.mark.parametrize("elements", [4, 18])
def test_the_equilibrium_of_a_slow_linkage_is_that_of_straight_links(
    elements: int,
) -> None:
    section = BeamSection.of_laminate(layers_of((30,), 4))
    engine = ReferenceEngine(linkage_of(section), elements, "timoshenko")
    angles = np.radians([20.0, 140.0])
    slow, still = (
        moving_frequencies(engine, angles, [speed], modes=4, rotation_terms=False)
        .dataset["frequency"]
        .values
        for speed in (1.0, 0.0)
    )
    assert slow == pytest.approx(still, rel=1e-5)


@pytest.mark.thorough
def test_what_is_taken_is_told_and_why_engines_differ() -> None:
    mechanism = linkage_of(BeamSection.of_laminate(layers_of((30,), 8)))
    reference = ReferenceEngine(mechanism, 2, "timoshenko")
    exudyn = ExudynEngine(mechanism, 2, "geometrically-exact")
    said = theory_attributes([reference, exudyn], 2)
    of_reference = [x for x in said["beam_theory_warnings"].splitlines() if "(reference)" in x]
    assert "coupler: its off-axis plies bend and twist in three dimensions" in of_reference[1]
    assert "flat over the whole width" in of_reference[1]
    assert "its second 4" in said["beam_theory_warnings"]
    reason = said["beam_theory_difference"]
    assert "off-axis plies bend and twist by one stiffness in exudyn" in reason
    assert reason.endswith("trust reference")
    # Of a clamped crank, whose first mode is not that between pins, more than any link is off.
    turn = np.radians(np.arange(0.0, 360.0, 60.0))
    apart = natural_frequencies(exudyn.with_(elements=8), turn, modes=2) / natural_frequencies(
        reference.with_(elements=8), turn, modes=2
    )
    told = float(reason.split("at rest by up to ")[1].split(" %")[0]) / 100
    assert told == pytest.approx(np.abs(apart - 1).max(), rel=0.1)
    assert f"may be off by {100 * told:.3g} % (mode" in said["beam_theory_warnings"]
    alone = theory_attributes([reference], 2)
    assert "too high" not in alone["beam_theory_warnings"]
