"""Sections whose plies are parallel to the plane of motion: by hand and by elasticity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import permutations
from typing import Any

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse.linalg
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from skfem import (
    Basis,
    BilinearForm,
    ElementHex2,
    ElementQuad2,
    ElementVector,
    MeshHex,
    MeshQuad,
)

from flexmech.beams import BEAM_SHAPES, build_chain
from flexmech.errors import InputError
from flexmech.linkages import LinkMass
from flexmech.materials import (
    Laminate,
    Layer,
    Material,
    Ply,
    PlyDamping,
    ply_from_constituents,
    published_constituents,
    solid_stiffness,
)
from flexmech.sections import (
    BeamSection,
    HygrothermalProfile,
    LaminateSection,
    SheetSection,
    swollen_section,
)

FloatArray = NDArray[np.float64]
KNOWN = published_constituents()
CARBON, GLASS = (
    ply_from_constituents(
        KNOWN[f"{fibre} (isotropic shear)"], KNOWN["polyester (isotropic shear)"], 0.6
    )
    for fibre in ("carbon", "E-glass")
)
PLY = 0.5e-3
Stack = Sequence[tuple[Any, float]]
MIXED: Stack = [(GLASS, 0), (CARBON, 0), (GLASS, 90), (GLASS, 90), (CARBON, 0), (GLASS, 0)]
ANGLES: Stack = [(CARBON, 30), (CARBON, -30), (CARBON, -30), (CARBON, 30)]


def laminate(stack: Stack) -> Laminate:
    return Laminate(tuple(Layer(ply, PLY, np.radians(angle)) for ply, angle in stack))


def first_free(section: BeamSection, length: float, theory: str) -> float:
    """First bending frequency of a bar with free ends in Hz."""
    mass = LinkMass(length, section.mass_per_length)
    model = build_chain("bar", section, mass, 8, BEAM_SHAPES[theory]).model
    squares = scipy.linalg.eigh(model.stiffness, model.mass, eigvals_only=True)
    return float(np.sqrt(squares[3]) / (2 * np.pi))


def lowest(stiffness: Any, mass: Any, rigid: int) -> float:
    """Lowest frequency in Hz above the rigid motions."""
    shift = -1e-6 * float(stiffness.diagonal().sum() / mass.diagonal().sum())
    squares = scipy.sparse.linalg.eigsh(
        stiffness, rigid + 1, mass, sigma=shift, return_eigenvectors=False
    )
    return float(np.sqrt(np.sort(squares)[rigid]) / (2 * np.pi))


def strains(u: Any) -> list[Any]:
    """x, y, xy in a plane; x, y, z, yz, xz and xy in space: y is the third, through the sheet."""
    g = u.grad
    if len(g) == 2:
        return [g[0, 0], g[1, 1], g[0, 1] + g[1, 0]]
    # Coordinates: along, across in the plane, through the plies.
    return [g[0, 0], g[2, 2], g[1, 1], g[2, 1] + g[1, 2], g[0, 1] + g[1, 0], g[0, 2] + g[2, 0]]


def matrices(basis: Any, stiffness: FloatArray, density: FloatArray) -> tuple[Any, Any]:
    """Stiffness and mass of elements with their own stiffness (n, k, k) and density (n,)."""

    def energy(u: Any, v: Any, w: Any) -> Any:
        own, other = strains(u), strains(v)
        return sum(
            stiffness[:, i, j, None] * own[j] * other[i]
            for i in range(len(own))
            for j in range(len(own))
            if np.any(stiffness[:, i, j])
        )

    def inertia(u: Any, v: Any, w: Any) -> Any:
        return density[:, None] * sum(u[i] * v[i] for i in range(len(u)))

    return BilinearForm(energy).assemble(basis), BilinearForm(inertia).assemble(basis)


def test_stiffness_by_hand() -> None:
    stack, breadth = laminate(MIXED), 18e-3
    sheet = SheetSection(stack, breadth)
    a11, a12, a22, a66 = np.zeros(4)
    for ply, angle in MIXED:
        e1, e2, nu = ply.longitudinal_modulus, ply.transverse_modulus, ply.poisson_ratio
        rest = 1 - nu**2 * e2 / e1
        along, across = (e1, e2) if angle == 0 else (e2, e1)
        a11, a22 = a11 + PLY * along / rest, a22 + PLY * across / rest
        a12, a66 = a12 + PLY * nu * e2 / rest, a66 + PLY * ply.in_plane_shear_modulus
    membrane = a11 - a12**2 / a22
    assert sheet.axial_stiffness == pytest.approx(breadth * membrane, rel=1e-10)
    assert sheet.bending_stiffness == pytest.approx(breadth**3 / 12 * membrane, rel=1e-10)
    assert sheet.shear_stiffness == pytest.approx(5 / 6 * breadth * a66, rel=1e-10)
    mass = breadth * PLY * sum(ply.density for ply, _ in MIXED)
    assert sheet.mass_per_length == pytest.approx(mass, rel=1e-12)
    assert sheet.rotary_inertia == pytest.approx(mass * breadth**2 / 12, rel=1e-12)
    smeared = BeamSection.of_laminate(sheet.smeared)
    own = BeamSection.of_laminate(sheet)
    for name in ("axial_stiffness", "bending_stiffness", "shear_stiffness", "mass_per_length"):
        assert getattr(smeared, name) == pytest.approx(getattr(own, name), rel=1e-12)


def test_the_order_of_the_plies_does_not_matter() -> None:
    half = MIXED[:3]
    found = {
        round(SheetSection(laminate([*order, *order[::-1]]), 0.02).bending_stiffness, 9)
        for order in permutations(half)
    }
    assert len(found) == 1
    through = {
        round(LaminateSection(laminate([*o, *o[::-1]]), 0.02).bending_stiffness, 9)
        for o in permutations(half)
    }
    assert len(through) == 6


def test_one_isotropic_ply_is_a_rectangle() -> None:
    steel = Material(200e9, 7800.0, 0.3)
    sheet = SheetSection(Laminate((Layer(Ply.isotropic(steel), 3e-3),)), 12e-3)
    own = BeamSection.rectangle(steel, in_plane_thickness=12e-3, out_of_plane_width=3e-3)
    assert sheet.axial_stiffness == pytest.approx(own.axial_stiffness, rel=1e-12)
    assert sheet.bending_stiffness == pytest.approx(own.bending_stiffness, rel=1e-12)
    assert sheet.mass_per_length == pytest.approx(own.mass_per_length, rel=1e-12)


@pytest.mark.parametrize("theory", ["timoshenko", "reddy", "zigzag"])
def test_a_membrane_in_two_dimensions(theory: str) -> None:
    """Ten times as long as broad: shear and Poisson's contraction are in it."""
    stack, breadth = laminate(MIXED), 20e-3
    length, density = 10 * breadth, stack.mass_moment(0)
    mesh = MeshQuad.init_tensor(
        np.linspace(0, length, 31), np.linspace(-breadth / 2, breadth / 2, 5)
    )
    basis = Basis(mesh, ElementVector(ElementQuad2()), intorder=5)
    count = mesh.nelements
    membrane = np.repeat([stack.stiffness_moment(0)], count, axis=0)
    exact = lowest(*matrices(basis, membrane, np.full(count, density)), 3)
    section = BeamSection.of_laminate(SheetSection(stack, breadth))
    assert first_free(section, length, theory) == pytest.approx(exact, rel=2e-3)


def in_space(
    stack: Laminate, breadth: float, length: float, mesh_of: tuple[int, int, int]
) -> float:
    """First frequency of bending in the plane, of half the thickness of a symmetric laminate."""
    along, across, rows = mesh_of
    upper = stack.boundaries[len(stack.layers) // 2 :]
    through = np.interp(np.arange(rows * (len(upper) - 1) + 1) / rows, range(len(upper)), upper)
    graded = breadth / 2 * np.sin(np.pi / 2 * np.linspace(-1, 1, across + 1))
    mesh = MeshHex.init_tensor(np.linspace(0, length, along + 1), graded, through)
    basis = Basis(mesh, ElementVector(ElementHex2()), intorder=4)
    place = mesh.p[2][mesh.t[:8]].mean(axis=0)
    number = len(stack.layers) // 2 + np.searchsorted(upper, place) - 1
    own = np.stack([solid_stiffness(layer) for layer in stack.layers])[number]
    density = np.array([layer.ply.density for layer in stack.layers])[number]
    stiffness, mass = matrices(basis, own, density)
    # On the middle plane nothing moves through the plies.
    held = np.zeros(basis.N, dtype=bool)
    held[basis.split_indices()[2]] = True
    free = ~(held & (np.abs(basis.doflocs[2]) < 1e-9))
    return lowest(stiffness[free][:, free], mass[free][:, free], 3)


@pytest.mark.thorough
@pytest.mark.parametrize(("stack", "breadths"), [(MIXED, 4), (ANGLES, 2), (ANGLES, 6)])
def test_elasticity_in_three_dimensions(stack: Stack, breadths: int) -> None:
    """Within 1 %; plies of +-30 deg that held each other up to the edges are 15 % and more high."""
    own = laminate(stack)
    breadth = breadths * own.thickness
    length = 15 * breadth
    exact = in_space(own, breadth, length, (12, 4, 1 if len(stack) > 4 else 2))
    section = BeamSection.of_laminate(SheetSection(own, breadth))
    assert first_free(section, length, "timoshenko") == pytest.approx(exact, rel=0.01)


@settings(deadline=None)
@given(st.floats(-1e3, 1e3), st.floats(-10, 10), st.floats(-1e3, 1e3))
def test_stresses_balance_the_loads(force: float, moment: float, shear: float) -> None:
    for stack in (MIXED, ANGLES):
        # So broad that free edges matter little; what they let go no stress of a ply shows.
        sheet = SheetSection(laminate(stack), 30.0 if stack is ANGLES else 30e-3)
        points, weights = np.polynomial.legendre.leggauss(4)
        half = sheet.in_plane_thickness / 2
        place = np.tile(half * points, (len(stack), 1))
        found = sheet.stresses(place, force, moment, shear)
        area = PLY * half * weights
        scale = 1e-9 if stack is MIXED else 2e-3
        for own, load in (
            (np.sum(found.normal_stress * area), force),
            (-np.sum(found.normal_stress * place * area), moment),
            (np.sum(found.shear_stress * area), shear),
        ):
            assert own == pytest.approx(load, rel=scale, abs=1e-6 * max(1, half * abs(force)))


def test_damping_is_shared_by_energy() -> None:
    first = replace(CARBON, specific_damping=PlyDamping(0.01, 0.05, 0.06))
    second = replace(GLASS, specific_damping=PlyDamping(0.03, 0.05, 0.09))
    sheet = SheetSection(laminate([(first, 0), (second, 0), (first, 0)]), 0.02)
    e, g = (
        (2 * first.longitudinal_modulus, second.longitudinal_modulus),
        (
            2 * first.in_plane_shear_modulus,
            second.in_plane_shear_modulus,
        ),
    )
    loss = sheet.specific_damping
    assert loss.bending == pytest.approx((0.01 * e[0] + 0.03 * e[1]) / sum(e), rel=2e-3)
    assert loss.shear == pytest.approx((0.06 * g[0] + 0.09 * g[1]) / sum(g), rel=1e-9)
    assert sheet.smeared.specific_damping.bending == pytest.approx(loss.bending, rel=1e-9)


def test_swelling_by_hand() -> None:
    heat = (1e-6, 3e-5)
    hot = [(replace(ply, thermal_expansion=heat, origin=None), angle) for ply, angle in MIXED]
    stack, rise = laminate(hot), 40.0
    section = BeamSection.of_laminate(SheetSection(stack, 0.02))
    swollen = swollen_section(section, HygrothermalProfile(rise, 0.0, 293.15))
    force = sum(
        PLY * layer.strain_turn.T @ layer.ply.reduced_stiffness @ np.array([*heat, 0.0]) * rise
        for layer in stack.layers
    )
    strain = np.linalg.solve(stack.stiffness_moment(0), force)
    assert swollen.elongation == pytest.approx(strain[0], rel=1e-3)
    grown = swollen.section.in_plane_thickness / section.in_plane_thickness - 1
    assert grown == pytest.approx(strain[1], rel=1e-3)
    assert swollen.section.free_curvature == 0.0
    dry = section.mass_per_length
    assert swollen.section.mass_per_length * (1 + swollen.elongation) == pytest.approx(dry)


@pytest.mark.parametrize(
    ("stack", "word"),
    [
        ([(GLASS, 0), (CARBON, 0)], "not symmetric"),
        ([(CARBON, 30), (CARBON, 30)], "not balanced"),
    ],
)
def test_laminates_that_leave_the_plane_are_refused(stack: Stack, word: str) -> None:
    with pytest.raises(InputError, match=word):
        SheetSection(laminate(stack), 0.02)
