"""Ply stresses of sections: by hand, by classical lamination theory, and by plane elasticity."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from skfem import (
    Basis,
    BilinearForm,
    ElementQuad2,
    ElementVector,
    LinearForm,
    MeshQuad,
    condense,
    solve,
)

from flexmech.materials import Laminate, Layer, Material, Ply
from flexmech.sections import (
    LaminateSection,
    SheetSection,
    residual_ply_stresses,
    unit_ply_stresses,
)

CARBON = Ply(
    181e9,
    10.3e9,
    7.17e9,
    7.17e9,
    3.8e9,
    0.28,
    1600.0,
    thermal_expansion=(0.02e-6, 22.5e-6),
    moisture_expansion=(0.0, 0.6),
)
METAL = Ply.isotropic(Material(70e9, 2700.0, 0.33))
WIDTH, HEIGHT = 12e-3, 4e-3


def test_bent_strip_by_hand() -> None:
    """N / A and 6 M / (b h^2); no shear stress at the surfaces."""
    section = LaminateSection(Laminate((Layer(METAL, HEIGHT),)), WIDTH)
    axial, bent, sheared = unit_ply_stresses(section)
    np.testing.assert_allclose(axial[0, :, 0], 1 / (WIDTH * HEIGHT), rtol=1e-12)
    np.testing.assert_allclose(bent[0, :, 0], [6 / (WIDTH * HEIGHT**2), -6 / (WIDTH * HEIGHT**2)])
    assert np.abs(axial[..., 1:]).max() < 1e-9 * axial.max()
    assert np.abs(sheared).max() < 1e-9 / (WIDTH * HEIGHT)


def test_shear_between_two_layers_by_hand() -> None:
    """1.5 V / A in the middle of a strip, seen at the interface of its two halves."""
    half = Layer(METAL, HEIGHT / 2)
    sheared = unit_ply_stresses(LaminateSection(Laminate((half, half)), WIDTH))[2]
    middle = 1.5 / (WIDTH * HEIGHT)
    np.testing.assert_allclose(sheared[:, :, 3], [[0, middle], [middle, 0]], atol=1e-9 * middle)


def test_classical_plies_of_a_balanced_stack() -> None:
    """A stretched cross-ply: strains of the plate's stiffness, turned and multiplied by hand."""
    laminate = Laminate.stacked([CARBON] * 4, 1e-3, np.radians([0, 90, 90, 0]).tolist())
    axial = unit_ply_stresses(LaminateSection(laminate, WIDTH))[0]
    strain = np.linalg.solve(laminate.plate_stiffness, [1 / WIDTH, 0, 0, 0, 0, 0])[:3]
    zero = CARBON.reduced_stiffness @ strain
    ninety = CARBON.reduced_stiffness @ np.array([strain[1], strain[0], 0.0])
    np.testing.assert_allclose(axial[0, 0, :3], zero, rtol=1e-9, atol=1e-6 * abs(zero[0]))
    np.testing.assert_allclose(axial[1, 1, :3], ninety, rtol=1e-9, atol=1e-6 * abs(zero[0]))


def test_stresses_of_cure_by_hand() -> None:
    """A symmetric cross-ply: one common strain by which both plies' forces vanish."""
    laminate = Laminate.stacked([CARBON] * 4, 1e-3, np.radians([0, 90, 90, 0]).tolist())
    rise, moisture = -100.0, np.full(4, 0.004)
    stress = residual_ply_stresses(LaminateSection(laminate, WIDTH), rise, moisture)
    free = np.array([0.02e-6 * rise, 22.5e-6 * rise + 0.6 * 0.004])
    q = CARBON.reduced_stiffness[:2, :2]
    common = np.sum(q @ free) / np.sum(q)
    expected = q @ (common - free)
    for layer in stress:
        np.testing.assert_allclose(layer[:, :2], [expected, expected], rtol=1e-9)
    assert expected[0] == pytest.approx(-expected[1], rel=1e-9)
    sheet = residual_ply_stresses(SheetSection(laminate, 20e-3), rise, moisture)
    np.testing.assert_allclose(sheet[..., :2], stress[..., :2], rtol=1e-9)


def test_unsymmetric_cure_carries_no_load() -> None:
    """Free strains and curvature leave neither a force nor a moment."""
    stack = [CARBON, replace(METAL, thermal_expansion=(23e-6, 23e-6))]
    laminate = Laminate.stacked(stack, 1e-3, [0.0, 0.0])
    stress = residual_ply_stresses(LaminateSection(laminate, WIDTH), -80.0, np.zeros(2))
    low, high = stress[:, 0, 0], stress[:, 1, 0]
    faces, size = laminate.boundaries, np.abs(stress).max()
    assert np.sum(low + high) == pytest.approx(0.0, abs=1e-9 * size)
    first = low * (2 * faces[:-1] + faces[1:]) + high * (faces[:-1] + 2 * faces[1:])
    assert np.sum(first) == pytest.approx(0.0, abs=1e-9 * size * laminate.thickness)
    assert size > 1e6


TALL, BROAD, ROWS = 8e-3, 10e-3, 16
LENGTH = 20 * TALL
STIFF = Ply(172.7e9, 7.2e9, 3.76e9, 3.76e9, 2.57e9, 0.29, 1566.7)
GLASS = Ply(37.78e9, 10.9e9, 4.91e9, 4.91e9, 3.89e9, 0.29, 1813.9)
AXIAL, ACROSS = 400.0, 30.0


def plane_stiffness(ply: Ply) -> np.ndarray:
    """By strains x, y and xy: along the fibres and through the thickness of the layers."""
    along, through = ply.longitudinal_modulus, ply.transverse_modulus
    compliance = np.diag([1 / along, 1 / through, 1 / ply.longitudinal_shear_modulus])
    compliance[0, 1] = compliance[1, 0] = -ply.poisson_ratio / along
    return np.asarray(np.linalg.inv(compliance))


def strains(field: Any) -> list[Any]:
    gradient = field.grad
    return [gradient[0, 0], gradient[1, 1], gradient[0, 1] + gradient[1, 0]]


def plane_stresses(plies: Sequence[Ply], place: float) -> tuple[np.ndarray, np.ndarray]:
    """Stresses x and xy at both surfaces of each layer of equal thickness, (N, 2) each."""
    faces = np.linspace(-TALL / 2, TALL / 2, len(plies) + 1)
    rows = np.linspace(-TALL / 2, TALL / 2, ROWS + 1)
    mesh = MeshQuad.init_tensor(np.linspace(0.0, LENGTH, 201), rows)
    basis = Basis(mesh, ElementVector(ElementQuad2()), intorder=4)
    middle = mesh.p[:, mesh.t].mean(axis=1)
    layer = np.searchsorted(faces, middle[1]) - 1
    moduli = np.stack([plane_stiffness(ply) for ply in plies])[layer]

    def energy(u: Any, v: Any, _: Any) -> Any:
        one, other = strains(u), strains(v)
        return sum(moduli[:, i, j, None] * one[i] * other[j] for i in range(3) for j in range(3))

    tip = basis.boundary(mesh.facets_satisfying(lambda p: np.isclose(p[0], LENGTH)))
    area = BROAD * TALL
    force = LinearForm(lambda v, _: (AXIAL * v[0] + ACROSS * v[1]) / area).assemble(tip)
    held = basis.get_dofs(lambda p: np.isclose(p[0], 0.0)).all()
    moved = basis.interpolate(solve(*condense(BilinearForm(energy).assemble(basis), force, D=held)))
    stress = np.einsum("eij,jeq->ieq", moduli, np.stack(strains(moved)))
    at = basis.global_coordinates()
    found = np.zeros((2, len(plies), 2))
    near = np.abs(middle[0] - place) < LENGTH / 100
    for number in range(len(plies)):
        own = near & (layer == number)
        x, y = at[0, own].ravel() - place, at[1, own].ravel()
        # Bending changes along the arm; stress is linear and shear a parabola through a layer.
        terms = np.stack([np.ones_like(x), y, y**2, x, x * y], axis=1)
        for row, component in enumerate((0, 2)):
            fit = np.linalg.lstsq(terms, stress[component, own].ravel(), rcond=None)[0]
            ends = faces[number : number + 2]
            found[row, number] = fit[0] + fit[1] * ends + fit[2] * ends**2
    return found[0], found[1]


@pytest.mark.parametrize(
    "plies",
    [(STIFF, GLASS), (GLASS, STIFF, METAL, GLASS)],
    ids=["carbon on glass", "four layers"],
)
def test_elasticity_of_the_plane(plies: tuple[Ply, ...]) -> None:
    """Stress along the layers and shear between them within 2 % of their greatest value."""
    place = LENGTH / 2
    laminate = Laminate(tuple(Layer(ply, TALL / len(plies)) for ply in plies))
    loads = np.array([AXIAL, ACROSS * (LENGTH - place), ACROSS])
    stress = np.tensordot(loads, unit_ply_stresses(LaminateSection(laminate, BROAD)), axes=1)
    along, between = plane_stresses(plies, place)
    assert np.abs(stress[..., 0] - along).max() < 0.02 * np.abs(along).max()
    assert np.abs(stress[..., 3] - between).max() < 0.02 * np.abs(between).max()
