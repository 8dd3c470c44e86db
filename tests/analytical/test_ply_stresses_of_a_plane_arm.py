"""Ply stresses of an unsymmetric arm against elasticity in two dimensions.

An arm of unlike layers, clamped at its root, pulled and pushed at its tip, in plane stress
(scikit-fem, quadrilaterals of second order). Away from the ends a beam's stresses are the plane's.
"""

from __future__ import annotations

from collections.abc import Sequence
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
from flexmech.sections import LaminateSection, unit_ply_stresses

HEIGHT, WIDTH, ROWS = 8e-3, 10e-3, 16
LENGTH = 20 * HEIGHT
CARBON = Ply(172.7e9, 7.2e9, 3.76e9, 3.76e9, 2.57e9, 0.29, 1566.7)
GLASS = Ply(37.78e9, 10.9e9, 4.91e9, 4.91e9, 3.89e9, 0.29, 1813.9)
METAL = Ply.isotropic(Material(70e9, 2700.0, 0.33))
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
    faces = np.linspace(-HEIGHT / 2, HEIGHT / 2, len(plies) + 1)
    rows = np.linspace(-HEIGHT / 2, HEIGHT / 2, ROWS + 1)
    mesh = MeshQuad.init_tensor(np.linspace(0.0, LENGTH, 201), rows)
    basis = Basis(mesh, ElementVector(ElementQuad2()), intorder=4)
    middle = mesh.p[:, mesh.t].mean(axis=1)
    layer = np.searchsorted(faces, middle[1]) - 1
    moduli = np.stack([plane_stiffness(ply) for ply in plies])[layer]

    def energy(u: Any, v: Any, _: Any) -> Any:
        one, other = strains(u), strains(v)
        return sum(moduli[:, i, j, None] * one[i] * other[j] for i in range(3) for j in range(3))

    tip = basis.boundary(mesh.facets_satisfying(lambda p: np.isclose(p[0], LENGTH)))
    area = WIDTH * HEIGHT
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
    [(CARBON, GLASS), (METAL, CARBON), (GLASS, CARBON, METAL, GLASS)],
    ids=["carbon on glass", "metal on carbon", "four layers"],
)
def test_elasticity_of_the_plane(plies: tuple[Ply, ...]) -> None:
    """Stress along the layers and shear between them within 2 % of their greatest value."""
    place = LENGTH / 2
    laminate = Laminate(tuple(Layer(ply, HEIGHT / len(plies)) for ply in plies))
    loads = np.array([AXIAL, ACROSS * (LENGTH - place), ACROSS])
    stress = np.tensordot(loads, unit_ply_stresses(LaminateSection(laminate, WIDTH)), axes=1)
    along, between = plane_stresses(plies, place)
    assert np.abs(stress[..., 0] - along).max() < 0.02 * np.abs(along).max()
    assert np.abs(stress[..., 3] - between).max() < 0.02 * np.abs(between).max()
