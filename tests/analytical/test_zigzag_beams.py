"""Zigzag beams against two-dimensional elasticity: sandwiches, soft cores, several cores."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse.linalg
from numpy.typing import NDArray

from flexmech import example_model, load_mechanism
from flexmech.analyses import natural_frequencies, strain_energy_damping
from flexmech.analyses.beam_theory import theory_attributes
from flexmech.beams import BEAM_SHAPES, build_chain, compare_theories
from flexmech.beams.zigzag_shapes import SMALL, BoundaryLayers
from flexmech.linkages import FourBar, LinkMass, RotatingArm
from flexmech.materials import Laminate, Layer, Material, Ply, PlyDamping
from flexmech.mechanism import Mechanism
from flexmech.multibody import ExudynEngine
from flexmech.reference import ReferenceEngine
from flexmech.sections import BeamSection, LaminateSection
from flexmech.verification import verification_case
from flexmech.verification.methods.plane_elasticity import (
    PlaneLink,
    fourbar_frequencies,
    plane_link,
)

FloatArray = NDArray[np.float64]
WIDTH = 0.02
CARBON = Ply(172.7e9, 7.20e9, 3.76e9, 3.76e9, 2.57e9, 0.29, 1566.7)
STEEL = Ply.isotropic(Material(210e9, 7850.0, 0.3))
ALUMINIUM = Ply.isotropic(Material(70e9, 2700.0, 0.33))
FOAM = Ply.isotropic(Material(80e6, 80.0, 0.3))
SOFT_FOAM = Ply.isotropic(Material(20e6, 80.0, 0.3))
STIFF_FOAM = Ply.isotropic(Material(200e6, 80.0, 0.3))
RUBBER = Ply.isotropic(Material(3e6, 1100.0, 0.49))


def stack(*layers: tuple[Ply, float]) -> Laminate:
    """Of plies and their thicknesses in mm."""
    return Laminate(tuple(Layer(ply, 1e-3 * thickness) for ply, thickness in layers))


SANDWICH = stack((CARBON, 1), (FOAM, 14), (CARBON, 1))
STACKS = {
    "sandwich": SANDWICH,
    "unlike faces": stack((CARBON, 1), (FOAM, 14), (ALUMINIUM, 2)),
    "steel and rubber": stack((STEEL, 1), (RUBBER, 6), (STEEL, 1)),
    "steel and rubber, thick": stack((STEEL, 4), (RUBBER, 8), (STEEL, 4)),
    "steel and rubber, thin": stack((STEEL, 2), (RUBBER, 1), (STEEL, 2)),
    "two unlike cores": stack(
        (CARBON, 1), (SOFT_FOAM, 5), (CARBON, 1), (STIFF_FOAM, 5), (CARBON, 1)
    ),
    "solid": stack((STEEL, 8)),
}


def section_of(laminate: Laminate) -> BeamSection:
    return BeamSection.of_laminate(LaminateSection(laminate, WIDTH))


def free_frequencies(laminate: Laminate, theory: str, length: float, count: int) -> FloatArray:
    section = section_of(laminate)
    mass = LinkMass(length, section.mass_per_length)
    model = build_chain("beam", section, mass, 10, BEAM_SHAPES[theory]).model
    squares = scipy.linalg.eigh(model.stiffness, model.mass, eigvals_only=True)
    return np.sqrt(np.sort(squares)[3 : 3 + count]) / (2 * np.pi)


def fourbar_of(laminate: Laminate, unit: float) -> Mechanism:
    section = section_of(laminate)
    sections = dict.fromkeys(("crank", "coupler", "rocker"), section)
    return Mechanism(FourBar(3 * unit, unit, 3 * unit, 2.5 * unit), sections)


def elastic_frequencies(mechanism: Mechanism, laminate: Laminate, angle: float) -> FloatArray:
    lengths = [link.length for link in mechanism.linkage.topology.links]
    links = [plane_link(laminate, WIDTH, length, 36) for length in lengths]
    motion = mechanism.linkage.motion(angle)
    return fourbar_frequencies(links, motion.angle.tolist(), lengths, 4)


def free_modes(link: PlaneLink, count: int) -> FloatArray:
    """Frequencies in Hz of a free link in plane elasticity, without its rigid motions."""
    # A little below the squares of zero that those have.
    squares = scipy.sparse.linalg.eigsh(
        link.stiffness, count + 3, link.mass, sigma=-1e3, return_eigenvectors=False
    )
    return np.sqrt(np.sort(squares)[3:]) / (2 * np.pi)


@pytest.mark.parametrize("name", STACKS)
def test_free_beams_of_thirty_thicknesses(name: str) -> None:
    laminate = STACKS[name]
    length = 30 * laminate.thickness
    exact = free_modes(plane_link(laminate, WIDTH, length, 40), 3)
    assert free_frequencies(laminate, "zigzag", length, 3) == pytest.approx(exact, rel=5e-3)


def test_soft_cores_are_beyond_the_other_theories() -> None:
    """Timoshenko far below, Reddy far above: what a finer theory is for."""
    laminate = STACKS["steel and rubber, thick"]
    length = 30 * laminate.thickness
    zigzag, low, high = (
        free_frequencies(laminate, theory, length, 3)
        for theory in ("zigzag", "timoshenko", "reddy")
    )
    assert np.all(low < 0.5 * zigzag)
    assert np.all(high > 2 * zigzag)


@pytest.mark.parametrize(
    "name",
    [
        "sandwich",
        *(
            pytest.param(name, marks=pytest.mark.thorough)
            for name in ("steel and rubber", "two unlike cores")
        ),
    ],
)
def test_default_linkage_against_elasticity(name: str) -> None:
    """The element that is chosen is right, and what Exudyn's leaves out is within its bound."""
    laminate = STACKS[name]
    mechanism, angle = fourbar_of(laminate, 10 * laminate.thickness), 0.7
    exact = elastic_frequencies(mechanism, laminate, angle)
    reference, exudyn = ReferenceEngine(mechanism), ExudynEngine(mechanism, 24)
    assert reference.element == "zigzag"
    assert natural_frequencies(reference, angle) == pytest.approx(exact, rel=3e-3)
    off = np.abs(natural_frequencies(exudyn, angle) / exact - 1).max()
    text = theory_attributes([reference, exudyn], 4)["beam_theory_warnings"]
    bound = float(text.split("may be off by ")[1].split(" %")[0])
    assert 0.6 * bound < 100 * off < bound


@pytest.mark.thorough
def test_sandwich_of_the_verification_is_this_one() -> None:
    """Its frequencies by others, on two meshes, and by the elasticity of these tests."""
    mechanism = load_mechanism(example_model("sandwich_fourbar"))
    layers = mechanism.sections["coupler"].layers
    assert layers is not None
    assert layers.laminate.thickness == pytest.approx(SANDWICH.thickness)
    stored = verification_case("Sandwich four-bar at rest: zigzag beams, reference")
    exact = elastic_frequencies(mechanism, SANDWICH, 0.0)
    assert exact == pytest.approx(stored.expected_values(), rel=5e-4)
    assert ReferenceEngine(mechanism).element == "zigzag"


def test_the_first_warping_of_a_solid_rectangle() -> None:
    """Bending held by ``G = -y / 4 + 5 y^3 / (3 h^2)`` is 1/84 of EI (Levinson 1981)."""
    rectangle = BeamSection.rectangle(Material(70e9, 2700.0, 0.3), 0.01, WIDTH)
    stated = replace(rectangle, layers=None)
    for section in (rectangle, stated, section_of(stack((STEEL, 8)))):
        zigzag = section.zigzag
        held = section.shear_stiffness * np.sum(zigzag.flexibility * zigzag.fall_off**2)
        assert held / section.bending_stiffness == pytest.approx(1 / 84, rel=1e-9)
        # The inertia of the same warping, whose parts have their shares of the shear angle.
        square = zigzag.flexibility @ zigzag.square @ zigzag.flexibility
        radius = section.rotary_inertia / section.mass_per_length
        assert square / radius == pytest.approx(1 / 84, rel=1e-9)


def test_thin_faces_bend_about_their_own_axes() -> None:
    """Allen's sandwich: kGA of the core alone, and the faces' own EI against its change."""
    face, core = 0.2, 10.0
    section = section_of(stack((STEEL, face), (SOFT_FOAM, core), (STEEL, face)))
    shear = WIDTH * (20e6 / 2.6) * (core + face) ** 2 / core * 1e-3
    assert section.shear_stiffness == pytest.approx(shear, rel=2e-3)
    zigzag = section.zigzag
    held = section.shear_stiffness * np.sum(zigzag.flexibility * zigzag.fall_off**2)
    assert held == pytest.approx(2 * 210e9 * WIDTH * (1e-3 * face) ** 3 / 12, rel=2e-2)


def test_zigzag_elements_converge_in_fourth_order() -> None:
    mechanism = fourbar_of(SANDWICH, 0.16)
    two, four, fine = (
        natural_frequencies(ReferenceEngine(mechanism, n, component_modes=False), 0.0)
        for n in (4, 8, 32)
    )
    rate = np.log2((two - fine) / (four - fine))
    # The higher modes, whose error is not that of the joints' axial compliance.
    assert np.all(rate[2:] > 3.9)
    assert np.abs(four / fine - 1).max() < 2e-4


def test_series_and_exponentials_of_boundary_layers_meet() -> None:
    t = np.linspace(-1, 1, 9)
    below, above = (
        BoundaryLayers.of(t, np.full(9, SMALL * factor)) for factor in (1 - 1e-9, 1 + 1e-9)
    )
    for name, value in vars(below).items():
        assert value == pytest.approx(getattr(above, name), abs=1e-8), name
    far = BoundaryLayers.of(t, np.full(9, 1e4))
    assert all(np.isfinite(value).all() for value in vars(far).values())


def test_damping_of_a_sandwich_by_its_strain_energy() -> None:
    """Each layer loses its part of the energy that it stores in two-dimensional elasticity."""
    faces = replace(STEEL, specific_damping=PlyDamping(0.002, 0.002, 0.002))
    core = replace(RUBBER, specific_damping=PlyDamping(0.8, 0.8, 0.8))
    laminate = stack((faces, 2), (core, 4), (faces, 2))
    length = 0.3
    link = plane_link(laminate, WIDTH, length, 40)
    mechanism = Mechanism(RotatingArm(length), {"arm": section_of(laminate)})
    engine = ReferenceEngine(mechanism)
    assert engine.element == "zigzag"
    computed = strain_energy_damping(engine, 0.0, modes=3)
    fixed = np.isclose(link.place[0], 0.0)
    free = np.flatnonzero(~fixed)
    parts = [k[free][:, free] for k in link.stiffness_of_layers]
    total, mass = sum(parts[1:], parts[0]), link.mass[free][:, free]
    squares, shapes = scipy.sparse.linalg.eigsh(total, 3, mass, sigma=0.0)
    shapes = shapes[:, np.argsort(squares)]
    loss = sum(
        psi * np.sum(shapes * (part @ shapes), axis=0)
        for psi, part in zip((0.002, 0.8, 0.002), parts, strict=True)
    )
    exact = loss / np.sum(shapes * (total @ shapes), axis=0) / (4 * np.pi)
    # The core holds a twentieth of the third mode's energy, part of it in compression.
    assert computed[:2] == pytest.approx(exact[:2], rel=1e-2)
    assert computed[2] == pytest.approx(exact[2], rel=3e-2)
    # Timoshenko's beam puts nearly all energy into the core.
    crude = strain_energy_damping(ReferenceEngine(mechanism, element="timoshenko"), 0.0, modes=3)
    assert np.all(crude > 1.5 * exact)


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(24))
def test_random_sandwiches(seed: int) -> None:
    random = np.random.default_rng(seed)
    skins, cores = (CARBON, STEEL, ALUMINIUM), (RUBBER, SOFT_FOAM, FOAM, STIFF_FOAM)
    skin, core = skins[random.integers(3)], cores[random.integers(4)]
    face = random.uniform(0.5, 3.0)
    layers = [(skin, face), (core, random.uniform(2, 12)), (skin, face)]
    if random.random() < 0.3:
        layers += [(cores[random.integers(4)], random.uniform(2, 6)), (skin, face)]
    laminate = stack(*layers)
    mechanism, angle = fourbar_of(laminate, random.uniform(6, 12) * laminate.thickness), 0.7
    exact = elastic_frequencies(mechanism, laminate, angle)
    found = natural_frequencies(ReferenceEngine(mechanism), angle)
    assert found[:3] == pytest.approx(exact[:3], rel=0.01)
    # Of 24 stacks, one has a fourth mode that is 1.1 % off.
    assert found[3] == pytest.approx(exact[3], rel=0.015)
    comparison = compare_theories(mechanism)
    apart = comparison.difference("timoshenko", "zigzag").value
    crude = natural_frequencies(ReferenceEngine(mechanism, element="timoshenko"), angle)
    assert np.abs(crude / exact - 1).max() < apart + 0.01
