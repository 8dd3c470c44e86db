"""Layered links in two-dimensional elasticity: plane stress, nine-node elements (scikit-fem).

An oracle that shares nothing with beam theory: no section, no rotation, no shear factor. Joints
hold the end faces of links plane, as a pin in a rigid fitting does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse
import scipy.sparse.linalg
from numpy.typing import NDArray
from skfem import Basis, BilinearForm, ElementQuad2, ElementVector, MeshQuad
from skfem.helpers import sym_grad

from flexmech.materials import Laminate

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class PlaneLink:
    """One link in its own axes.

    Parameters
    ----------
    place : ndarray, shape (2, n)
        Place of its coordinates, in m.
    is_along : ndarray of bool, shape (n,)
        Which of them are displacements along the link.
    stiffness_of_layers : list of sparse matrix, shape (n, n)
    mass : sparse matrix, shape (n, n)
    """

    place: FloatArray
    is_along: NDArray[np.bool_]
    stiffness_of_layers: list[Any]
    mass: Any

    @property
    def stiffness(self) -> Any:
        """Matrix of all layers, sparse."""
        return sum(self.stiffness_of_layers[1:], self.stiffness_of_layers[0])


def plane_link(laminate: Laminate, width: float, length: float, elements: int) -> PlaneLink:
    """Layers of plies along the link, thick ones in several elements; shorter ones at the ends.

    Parameters
    ----------
    laminate : Laminate
    width, length : float
        In m.
    elements : int
        Along the link.

    Returns
    -------
    PlaneLink
    """
    faces = laminate.boundaries
    parts = np.maximum(1, np.round(4 * np.diff(faces) / laminate.thickness)).astype(int)
    layers = zip(faces[:-1], faces[1:], parts, strict=True)
    heights = [np.linspace(low, high, n + 1)[1:] for low, high, n in layers]
    s = np.linspace(0, 1, elements + 1)
    s = 0.35 * (1 - np.cos(np.pi * s)) + 0.3 * s
    mesh = MeshQuad.init_tensor(length * s, np.concatenate([faces[:1], *heights]))
    basis = Basis(mesh, ElementVector(ElementQuad2()), intorder=5)
    layer = np.searchsorted(faces, mesh.p[1][mesh.t].mean(axis=0)) - 1
    stiffness = []
    density = np.zeros(len(layer))
    for number, one in enumerate(laminate.layers):
        ply, inside = one.ply, np.where(layer == number, width, 0.0)[:, None]
        along, across, nu = ply.longitudinal_modulus, ply.transverse_modulus, ply.poisson_ratio
        shear, rest = ply.longitudinal_shear_modulus, 1 - nu**2 * across / along
        stiffness.append(
            _elastic(basis, inside, along / rest, nu * across / rest, across / rest, shear)
        )
        density += np.where(layer == number, width * ply.density, 0.0)
    mass = BilinearForm(lambda u, v, w: density[:, None] * (u[0] * v[0] + u[1] * v[1]))
    is_along = np.zeros(basis.N, dtype=bool)
    is_along[basis.split_indices()[0]] = True
    return PlaneLink(basis.doflocs, is_along, stiffness, mass.assemble(basis))


def _elastic(basis: Any, inside: Any, xx: float, xy: float, yy: float, shear: float) -> Any:
    def form(u: Any, v: Any, w: Any) -> Any:
        e, f = sym_grad(u), sym_grad(v)
        mixed = e[0, 0] * f[1, 1] + e[1, 1] * f[0, 0]
        normal = xx * e[0, 0] * f[0, 0] + xy * mixed + yy * e[1, 1] * f[1, 1]
        return inside * (normal + 4 * shear * e[0, 1] * f[0, 1])

    return BilinearForm(form).assemble(basis)


def fourbar_frequencies(
    links: Sequence[PlaneLink], angles: Sequence[float], lengths: Sequence[float], count: int
) -> FloatArray:
    """Frequencies in Hz of crank (clamped), coupler and rocker at angles against the ground.

    Every end face moves as a rigid one: by the displacement of its joint, and a rotation.

    Parameters
    ----------
    links : sequence of PlaneLink
    angles, lengths : sequence of float
        Crank angles of the links in rad, and their lengths in m.
    count : int

    Returns
    -------
    ndarray, shape (count,)
    """
    # Joints O2, A, B, O4: two displacements of A and of B; rotations of the crank's end at A,
    # of both ends of coupler and rocker.
    ends = [((None, None), (0, 4)), ((0, 5), (2, 6)), ((None, 8), (2, 7))]
    size = 9
    maps = []
    for link, angle, length, degrees in zip(links, angles, lengths, ends, strict=True):
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        entries, faces = [], np.zeros(len(link.is_along), dtype=bool)
        for (joint, rotation), x in zip(degrees, (0.0, length), strict=True):
            face = np.isclose(link.place[0], x, atol=1e-9 * length)
            faces |= face
            for where in np.flatnonzero(face):
                row = turn[0 if link.is_along[where] else 1]
                if joint is not None:
                    entries += [(where, joint, row[0]), (where, joint + 1, row[1])]
                if rotation is not None and link.is_along[where]:
                    entries.append((where, rotation, -link.place[1, where]))
        inner = np.flatnonzero(~faces)
        entries += [(where, size + number, 1.0) for number, where in enumerate(inner)]
        maps.append((entries, len(faces)))
        size += len(inner)
    return _joined(links, maps, count)


def _joined(links: Sequence[PlaneLink], maps: list[Any], count: int) -> FloatArray:
    size = 1 + max(column for entries, _ in maps for _, column, _ in entries)
    stiffness = mass = scipy.sparse.csr_matrix((size, size))
    for link, (entries, rows) in zip(links, maps, strict=True):
        where, column, value = zip(*entries, strict=True)
        to_link = scipy.sparse.csr_matrix((value, (where, column)), shape=(rows, size))
        stiffness = stiffness + to_link.T @ link.stiffness @ to_link
        mass = mass + to_link.T @ link.mass @ to_link
    squares = scipy.sparse.linalg.eigsh(
        stiffness.tocsc(), count, mass.tocsc(), sigma=0.0, return_eigenvectors=False
    )
    return np.asarray(np.sqrt(np.sort(squares)) / (2 * np.pi))
