"""A layered link in two-dimensional elasticity (plane stress), against which beams are compared.

Beams keep the thickness of a link. Soft layers do not: where they are compressed, the faces of a
sandwich move against each other, and a free end bends as two strips. Below the frequency at which
the layers of a wide plate would do so this is a correction; above it such modes stand among those
of the beam. Nine-node rectangles in plane stress know it, one row or more a layer, reduced to the
motion of the rigid end faces and the lowest modes between these (Craig & Bampton, *AIAA Journal* 6
(1968) 1313). Good for frequencies at rest, which it exists for.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from flexmech.arrays import FloatArray, IntArray
from flexmech.beams.parabolas import Parabolas, graded, rows_of_runs
from flexmech.linear_system import LinkModel, LinkReadings, RigidBody, RigidFields
from flexmech.linkages import LinkMass
from flexmech.materials import solid_stiffness
from flexmech.sections import LaminateSection

# Along the link: short elements at the ends, whose layers shear and bend by themselves. Twice as
# many change the four lowest frequencies of a sandwich arm by 1e-4 to 5e-4, even spacing by 1e-3.
ALONG, GRADED = 32, 0.7
# Rows of elements over the thickness, shared among the layers by their own: twice as many change
# frequencies of a sandwich by 1e-5.
ROWS = 4
# Of the length: nodes of the mesh that are nearer to a point mass give way to it. The shortest
# element of the mesh is ten times as long; shorter ones would only worsen its condition.
NEAR = 1e-3
# Lowest modes between the end faces for each mode that is asked for: those of a linkage are made of
# fewer modes of each link, and of a sandwich arm or four-bar more change nothing in nine digits.
INNER_MODES = 2
# Among strains x, y, z, yz, xz and xy.
IN_PLANE = np.array([0, 1, 5])
ACROSS = np.array([2, 3, 4])
# Displacements of a rigid face: along, across, rotation.
FACE = 3


def compression_frequency(section: LaminateSection) -> float:
    """Lowest thickness-stretch frequency of a wide layered plate in Hz.

    Its faces stay parallel: the layers are rods through the thickness. Beams know none of it.

    Parameters
    ----------
    section : LaminateSection

    Returns
    -------
    float
    """
    rows = _Rows.of(section)
    line = Parabolas(rows.faces)
    squares = scipy.linalg.eigh(
        line.stiffness(rows.stiffness[:, 1, 1]).toarray(),
        line.mass(rows.density).toarray(),
        eigvals_only=True,
    )
    return float(np.sqrt(squares[1]) / (2 * np.pi))


def plane_link(
    name: str,
    section: LaminateSection,
    mass: LinkMass,
    joined: Sequence[bool],
    modes: int,
    sprung: Sequence[float] = (),
) -> LinkModel:
    """Mass and stiffness of a link in plane stress.

    Parameters
    ----------
    name : str
    section : LaminateSection
    mass : LinkMass
        Distributed mass spreads over the layers as their densities do. A point mass moves with
        the mean of its cross-section, weighted by the layers' stiffness, and a body turns with it
        too.
    joined : sequence of bool, length 2
        Whether start and end are at joints, whose fittings keep the end faces plane.
    modes : int
        How many of the linkage's lowest modes count.
    sprung : sequence of float
        Places in m from the start at which springs act: on the section as a whole.

    Returns
    -------
    LinkModel
        With readings at the ends and those places; without what frequencies at rest do not
        depend on.
    """
    places = [x for x, rigid in zip((0.0, mass.length), joined, strict=True) if rigid]
    attached = [(x, value * np.diag([1.0, 1.0, 0.0])) for x, value in _points(mass)]
    attached += [
        (body.position, RigidBody.fixed(body).matrices(np.zeros(()))[0]) for body in mass.bodies
    ]
    solid = _PlaneSolid.of(
        section, mass, [each for each in attached if each[0] not in places], sprung
    )
    basis, stiffness, inertia = solid.reduced(places, INNER_MODES * modes)
    read = np.unique([0.0, mass.length, *sprung])
    sections = np.concatenate([solid.section_at(x) @ basis for x in read])
    size = len(stiffness)
    for x, own in attached:
        if x in places:
            face = FACE * places.index(x) + np.arange(FACE)
            inertia[np.ix_(face, face)] += own
    nothing, still = np.zeros((size, size)), np.zeros(size)
    none = np.zeros(0, dtype=np.intp)
    faces = np.arange(FACE * len(places)).reshape(-1, FACE)
    at_start, at_end = (faces[places.index(x)] if x in places else none for x in (0.0, mass.length))
    return LinkModel(
        name=name,
        mass=inertia,
        gyroscopic=nothing,
        centrifugal_mass=inertia,
        first_moment=np.zeros((2, size)),
        stiffness=stiffness,
        damping=nothing,
        is_axial=np.zeros(size, dtype=bool),
        start=at_start[:2],
        end=at_end[:2],
        start_rotation=at_start[2:],
        end_rotation=at_end[2:],
        readings=LinkReadings(read, FACE, _at_nodes, slope=2, deflection=None, basis=sections),
        fields=RigidFields(still, still, still, still),
    )


def _points(mass: LinkMass) -> list[tuple[float, float]]:
    return list(zip(mass.point_positions, mass.point_masses, strict=True))


def _at_nodes(fraction: FloatArray, length: FloatArray) -> FloatArray:
    """Displacement at the nodes, (s, 2, 2 FACE)."""
    shapes = np.zeros((len(fraction), 2, 2 * FACE))
    for number, share in enumerate((1.0 - fraction, fraction)):
        for component in range(2):
            shapes[:, component, FACE * number + component] = share
    return shapes


@dataclass(frozen=True)
class _Rows:
    """Rows of elements: faces (n + 1,), stiffness by x, y and xy (n, 3, 3), density (n,)."""

    faces: FloatArray
    stiffness: FloatArray
    density: FloatArray

    @classmethod
    def of(cls, section: LaminateSection) -> _Rows:
        """Rows of elements of the layers: equal neighbours are one, a thick layer is several."""
        laminate = section.laminate
        layers = laminate.layers
        starts = [
            n
            for n, layer in enumerate(layers)
            if n == 0 or (layer.ply, layer.angle) != (layers[n - 1].ply, layers[n - 1].angle)
        ]
        bounds = laminate.boundaries[[*starts, len(layers)]]
        faces, parts = rows_of_runs(bounds, ROWS)
        along = _moduli_along(section)
        own = np.stack([_plane_stiffness(section, layers[n], along[n]) for n in starts])
        density = np.array([layers[n].ply.density for n in starts])
        return cls(faces, np.repeat(own, parts, axis=0), np.repeat(density, parts))


def _moduli_along(section: LaminateSection) -> FloatArray:
    """Axial modulus of each layer as in the beam, (N,)."""
    place = section.places(5)
    found = section.stresses(place, bending_moment=1.0)
    square = np.sum(found.strain**2, axis=1)
    return np.asarray(np.sum(found.normal_stress * found.strain, axis=1) / square)


def _plane_stiffness(section: LaminateSection, layer: Any, along: float) -> FloatArray:
    """Stiffness of one layer by strains x, y and xy, (3, 3), with the beam's axial modulus."""
    solid = solid_stiffness(layer)
    if section.reduction == "wide":
        plane = solid[np.ix_(IN_PLANE, IN_PLANE)]
    else:
        coupling = solid[np.ix_(ACROSS, IN_PLANE)]
        moved = np.linalg.solve(solid[np.ix_(ACROSS, ACROSS)], coupling)
        plane = solid[np.ix_(IN_PLANE, IN_PLANE)] - coupling.T @ moved
    scale = np.ones(FACE)
    scale[0] = np.sqrt(along * np.linalg.inv(plane)[0, 0])
    return np.asarray(scale[:, None] * plane * scale)


def _means(through: Parabolas, weight: FloatArray) -> FloatArray:
    """Mean displacements and rotation of a section, (3, 2 size).

    By displacements of its nodes along and across; weighted.
    """
    mass, y = through.mass(weight), through.places
    mean = np.asarray(mass.sum(axis=0)).ravel()
    mean = mean / mean.sum()
    axis = y - mean @ y
    turned = -(mass @ axis) / (axis @ (mass @ axis))
    nothing = np.zeros(through.size)
    # Along at the pins' line, from which the neutral axis is so far.
    along = mean + (mean @ y) * turned
    return np.stack([np.r_[along, nothing], np.r_[nothing, mean], np.r_[turned, nothing]])


@dataclass(frozen=True)
class _PlaneSolid:
    """Matrices by displacements along at all nodes, row by row from the lowest, then across."""

    along: Parabolas
    through: Parabolas
    means: FloatArray
    stiffness: Any
    mass: Any

    @classmethod
    def of(
        cls,
        section: LaminateSection,
        mass: LinkMass,
        attached: Sequence[tuple[float, FloatArray]],
        sprung: Sequence[float],
    ) -> _PlaneSolid:
        """Matrices of a link, with inertia (3, 3) added at given sections."""
        rows = _Rows.of(section)
        along, through = Parabolas(_nodes_along(mass, sprung)), Parabolas(rows.faces)
        d, width = rows.stiffness, section.width
        mass_x, stiff_x, coupled_x = along.mass(), along.stiffness(), along.coupling()

        def over(matrix: Any, x: Any) -> Any:
            return width * sp.kron(matrix, x)

        shear = d[:, 2, 2]
        uu = over(through.mass(d[:, 0, 0]), stiff_x) + over(through.stiffness(shear), mass_x)
        vv = over(through.stiffness(d[:, 1, 1]), mass_x) + over(through.mass(shear), stiff_x)
        # u' with the thickness' strain, and its slope through the thickness with v'.
        uv = over(through.coupling(d[:, 0, 1]), coupled_x.T)
        uv = uv + over(through.coupling(shear).T, coupled_x)
        stiffness = sp.bmat([[uu, uv], [uv.T, vv]], format="csc")
        inertia = over(through.mass(rows.density), mass_x)
        inertia = inertia * (mass.mass_per_length / section.mass_per_length)
        both = sp.block_diag([inertia, inertia], format="csc")
        solid = cls(along, through, _means(through, d[:, 0, 0]), stiffness, both)
        for x, own in attached:
            moved = solid.section_at(x)
            both = both + moved.T @ sp.csr_matrix(own) @ moved
        return replace(solid, mass=both.tocsc())

    def section_at(self, x: float) -> Any:
        """Mean displacements and rotation of a section, (3, n), sparse."""
        row = np.zeros(self.along.size)
        row[np.argmin(np.abs(self.along.places - x))] = 1.0
        return sp.csr_matrix(np.kron(self.means, row))

    def reduced(
        self, places: Sequence[float], count: int
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Basis (n, s) of rigid faces at k places and modes between, s = 3 k + count.

        And stiffness and mass in it, (s, s).
        """
        by_faces, fixed = self._by_faces(places)
        inner = np.setdiff1d(np.arange(self.mass.shape[0]), fixed)
        own, inertia = (matrix[inner][:, inner] for matrix in (self.stiffness, self.mass))
        factors = spla.splu(own.tocsc())
        moved = factors.solve(-(self.stiffness[inner] @ by_faces))
        count = min(count, len(inner) - 2)
        inverse = spla.LinearOperator(own.shape, matvec=factors.solve, dtype=float)
        # Started alike, so that the same link always gives the same numbers.
        _, vectors = spla.eigsh(
            own, count, inertia, sigma=0.0, OPinv=inverse, v0=np.ones(len(inner))
        )
        basis = np.zeros((self.mass.shape[0], by_faces.shape[1] + count))
        basis[:, : by_faces.shape[1]] = by_faces
        basis[inner, : by_faces.shape[1]] = moved
        basis[inner, by_faces.shape[1] :] = vectors
        both = (basis.T @ (matrix @ basis) for matrix in (self.stiffness, self.mass))
        stiffness, mass = ((matrix + matrix.T) / 2 for matrix in both)
        return basis, stiffness, mass

    def _by_faces(self, places: Sequence[float]) -> tuple[FloatArray, IntArray]:
        """Displacements (n, 3 k) of rigid faces at places, and their coordinates."""
        count = self.along.size * self.through.size
        y, up = self.through.places, np.arange(self.through.size) * self.along.size
        moved, fixed = np.zeros((2 * count, FACE * len(places))), []
        for number, x in enumerate(places):
            own = up + int(np.argmin(np.abs(self.along.places - x)))
            moved[own, FACE * number] = 1.0
            moved[count + own, FACE * number + 1] = 1.0
            moved[own, FACE * number + 2] = -y
            fixed += [own, count + own]
        return moved, np.concatenate(fixed)


def _nodes_along(mass: LinkMass, sprung: Sequence[float]) -> FloatArray:
    """Nodes in m, close at the ends and one at each point mass, body and spring."""
    nodes = mass.length * graded(ALONG, GRADED)
    fixed = [*mass.point_positions, *(body.position for body in mass.bodies), *sprung]
    inside = np.unique([x for x in fixed if NEAR < x / mass.length < 1 - NEAR])
    if not len(inside):
        return nodes
    apart = np.abs(nodes[:, None] - inside).min(axis=1)
    kept = apart > NEAR * mass.length
    kept[[0, -1]] = True
    return np.sort(np.concatenate([nodes[kept], inside]))
