"""Matrices of one link in its frame, for small displacements about the rigid motion.

A link is a chain of consecutive elements; its matrices are summed node by node, in many positions
at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, IntArray
from flexmech.linkages import LinkBody, LinkMass, RigidMotion
from flexmech.mechanics.links.link_readings import LinkReadings
from flexmech.mechanics.links.rigid_body import RigidBody, body_nodes


def chain_matrix(elements: FloatArray) -> FloatArray:
    """Sum of the matrices of consecutive elements, as a full matrix.

    Parameters
    ----------
    elements : ndarray, shape (..., e, 2 p, 2 p)
        Elements of p coordinates a node.

    Returns
    -------
    ndarray, shape (..., n, n)
        n = p (e + 1).
    """
    *batch, count, both, _ = elements.shape
    size = both // 2
    first, second = slice(0, size), slice(size, None)
    total = np.zeros((*batch, count + 1, size, count + 1, size))
    of_nodes = _along_diagonal(total)
    of_nodes[..., :-1, :, :] = elements[..., first, first]
    of_nodes[..., 1:, :, :] += elements[..., second, second]
    _along_diagonal(total[..., :-1, :, 1:, :])[:] = elements[..., first, second]
    _along_diagonal(total[..., 1:, :, :-1, :])[:] = elements[..., second, first]
    return total.reshape(*batch, size * (count + 1), size * (count + 1))


def _along_diagonal(blocks: FloatArray) -> FloatArray:
    """View of the blocks (..., i, p, i, p) of a matrix by blocks; (..., i, p, p)."""
    return np.asarray(np.einsum("...iaib->...iab", blocks))


def in_positions(matrix: FloatArray, which: slice | IntArray) -> FloatArray:
    """A link matrix in some positions; a constant one stays."""
    return matrix[which] if matrix.ndim == 3 else matrix


def with_entries(
    matrix: FloatArray, rows: IntArray, columns: IntArray, values: FloatArray
) -> FloatArray:
    """Matrix of a link with values added to some of its entries.

    Parameters
    ----------
    matrix : ndarray, shape (n, n) or (B, n, n)
    rows, columns : ndarray of int, shape (k,)
        Each pair once.
    values : ndarray, shape (k,) or (B, k)

    Returns
    -------
    ndarray
        Matrix of shape (n, n); of a batch, where the values are one.
    """
    batch = np.broadcast_shapes(matrix.shape[:-2], values.shape[:-1])
    total = np.array(np.broadcast_to(matrix, (*batch, *matrix.shape[-2:])))
    total[..., rows, columns] += values
    return total


NONE = np.zeros(0, dtype=np.intp)
NO_VECTORS = np.zeros((2, 0), dtype=np.intp)


@dataclass(frozen=True)
class RigidFields:
    """Rigid-body acceleration fields in a link's coordinates, each of shape (n,).

    Parameters
    ----------
    along, across : ndarray
        Unit acceleration along the link frame's x and y.
    centripetal : ndarray
        Field ``x`` along the link (multiplied by ``-omega**2``).
    tangential : ndarray
        Field ``x`` across the link with its rotation (multiplied by ``alpha``).
    """

    along: FloatArray
    across: FloatArray
    centripetal: FloatArray
    tangential: FloatArray


@dataclass(frozen=True)
class EndMatrices:
    """Forces ``X E`` by displacements of a link's joined ends alone; each (n, n).

    Only the columns of the ends are used. In nodal coordinates these are the link's own
    matrices. In component modes an end's coordinate carries a static shape with it, but
    the leader's rotating frame is that of the end alone: the reduction must not change the
    frame, because frozen eigenvalues depend on it.

    Parameters
    ----------
    mass, gyroscopic, damping : ndarray, shape (n, n)
    readings : LinkReadings
        Displacements by the ends alone.
    """

    mass: FloatArray
    gyroscopic: FloatArray
    damping: FloatArray
    readings: LinkReadings


class VectorMap(Protocol):
    """Map from the coordinates q of a link to those x by which its inertia is linear; (B, n) each.

    Displacements and slope vectors: coordinates of an element without rotations, some of which q
    replaces by the length and the angle of a slope.
    """

    def to_nodes(self, axis: FloatArray) -> FloatArray:
        """Coordinates x.

        Parameters
        ----------
        axis : ndarray, shape (B, n)
        """

    def rate_to_nodes(self, axis: FloatArray, rate: FloatArray) -> FloatArray:
        """Time derivative ``x'`` by that of q.

        Parameters
        ----------
        axis, rate : ndarray, shape (B, n)
        """

    def acceleration_to_nodes(
        self, axis: FloatArray, rate: FloatArray, acceleration: FloatArray
    ) -> FloatArray:
        """Second time derivative ``x''`` by those of q.

        Parameters
        ----------
        axis, rate, acceleration : ndarray, shape (B, n)
        """

    def force(self, axis: FloatArray, force: FloatArray) -> FloatArray:
        """Forces on x as those on q.

        Parameters
        ----------
        axis, force : ndarray, shape (B, n)
        """

    def geometric_stiffness(self, axis: FloatArray, force: FloatArray) -> FloatArray:
        """Second derivative by q of the work of constant forces on x, (B, n, n).

        Parameters
        ----------
        axis, force : ndarray, shape (B, n)
        """


@dataclass(frozen=True, eq=False)
class LinkModel:
    """Matrices of one link in the coordinates q of its link frame.

    The displacement in the frame is ``u(x) = N(x) q``; ``J`` turns by a quarter.

    Parameters
    ----------
    name : str
    mass : ndarray, shape (n, n)
        Consistent mass, rotary inertia included where the element has it.
    gyroscopic : ndarray, shape (n, n)
        ``S``, the integral of ``rho N^T J N`` (skew); the Coriolis matrix is ``2 omega S``
        and the tangential one ``alpha S``.
    centrifugal_mass : ndarray, shape (n, n)
        ``M_t``, the integral of ``rho N^T N``; the centripetal matrix is ``-omega^2 M_t``.
        Without rotary inertia: what turns about its centre keeps its centrifugal potential.
    first_moment : ndarray, shape (2, n)
        ``-rho N^T J e`` and ``rho N^T e``, integrated, with e the place of matter against that
        which the field ``centripetal`` gives it: mostly its distance from the pins' axis.
    stiffness : ndarray, shape (n, n)
        Elastic stiffness of the unloaded, straight link.
    damping : ndarray, shape (n, n)
        Kelvin-Voigt damping, ``tau`` times the elastic stiffness.
    is_axial : ndarray of bool, shape (n,)
        Whether a coordinate moves the link along its axis.
    start, end : ndarray of int, shape (2,) or (0,)
        Coordinates that are the displacement of the two ends; empty where a reduction has
        removed an end that is not joined, and of a rigid link's end.
    start_rotation, end_rotation : ndarray of int, shape (k,)
        Coordinates that a clamp at that end fixes besides the displacement.
    readings : LinkReadings
        From which :attr:`shape` and :attr:`curvature` are computed.
    fields : RigidFields
        Rigid accelerations in these coordinates (of the unreduced link only).
    reduced_ends : EndMatrices, optional
        Ends of a reduced link; see :attr:`ends`.
    start_warping, end_warping : ndarray of int, shape (k,)
        Coordinates that a joint of any kind at that end fixes: its pin is in a fitting that keeps
        the cross-section plane.
    vectors : ndarray of int, shape (2, k)
        Coordinates along and across of all vectors in the link frame: displacements of nodes, and
        slope vectors. A reduced link has none.
    receding : ndarray of int, shape (1,) or (0,)
        Coordinate ``cos(phi) - 1`` of the free shaft that the link is clamped to, where its
        coordinates are natural ones.
    rigid : bool
        Whether the link is rigid; see :func:`flexmech.mechanics.rigid_link`.
    bodies : tuple of RigidBody
        Part of the straight link's matrices. A rigid link is one, mass off the axis one a node.
    uncounted_rotary_inertia : float
        Rotary inertia of sections, kg m, that ``mass`` leaves out; see ``rigid_inertia``
        in ``link_inertia``.
    vector_map : VectorMap, optional
        Map of an unreduced link whose matrices are those of small displacements, to
        coordinates by which its inertia is linear at finite ones, where these are others.
    """

    name: str
    mass: FloatArray
    gyroscopic: FloatArray
    centrifugal_mass: FloatArray
    first_moment: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    is_axial: NDArray[np.bool_]
    start: IntArray
    end: IntArray
    start_rotation: IntArray
    end_rotation: IntArray
    readings: LinkReadings
    fields: RigidFields
    reduced_ends: EndMatrices | None = None
    start_warping: IntArray = field(default_factory=NONE.copy)
    end_warping: IntArray = field(default_factory=NONE.copy)
    vectors: IntArray = field(default_factory=NO_VECTORS.copy)
    receding: IntArray = field(default_factory=NONE.copy)
    rigid: bool = False
    bodies: tuple[RigidBody, ...] = ()
    uncounted_rotary_inertia: float | FloatArray = 0.0
    vector_map: VectorMap | None = None

    def carrying(self, mass: LinkMass) -> LinkModel:
        """The unreduced link with attached bodies, and with its mass off the axis as bodies.

        Distributed mass is in the matrices of the straight link. Where it is off the axis, each
        node's share of it is a body whose arm rotates with the section there.

        Parameters
        ----------
        mass : LinkMass
            With a node at the position of each body.

        Returns
        -------
        LinkModel
        """
        matrices = [self.mass, self.gyroscopic, self.centrifugal_mass]
        moment, fixed = self.first_moment.copy(), []
        places = body_nodes(self.readings.nodes, mass.bodies).tolist()
        for body, node in zip(mass.bodies, places, strict=True):
            at_node, section = self._section(node)
            fixed.append(RigidBody.fixed(body, section))
            (a, c), entries = fixed[-1].first_moment, np.ix_(at_node, at_node)
            rows, columns = (entry.ravel() for entry in np.broadcast_arrays(*entries))
            added = fixed[-1].matrices(np.zeros(())).reshape(3, -1)
            matrices = [
                with_entries(matrix, rows, columns, more)
                for matrix, more in zip(matrices, added, strict=True)
            ]
            by_rotation = fixed[-1].translational_inertia
            moment[:, at_node] += [[c, -a, -by_rotation], [a, c, 0.0]]
        if mass.offset:
            nodes = self.readings.nodes
            shares = mass.mass_per_length * np.convolve(np.diff(nodes), [0.5, 0.5])
            for node, (x, share) in enumerate(zip(nodes.tolist(), shares.tolist(), strict=True)):
                matter = LinkBody(x, share, offset=(0.0, mass.offset))
                own_part = RigidBody.fixed(matter, self._section(node)[1])
                fixed.append(replace(own_part, of_section=True))
            turning = self.readings.per_node * np.arange(len(nodes)) + self.readings.slope
            arms = shares * mass.offset**2
            matrices[2] = with_entries(matrices[2], turning, turning, arms)
            moment[0, turning] -= arms
        inertia, gyroscopic, translational = matrices
        return replace(
            self,
            mass=inertia,
            gyroscopic=gyroscopic,
            centrifugal_mass=translational,
            first_moment=moment,
            bodies=tuple(fixed),
        )

    def _section(self, node: int) -> tuple[IntArray, FloatArray]:
        """Coordinates (3,) of displacement and rotation at a node, and their rows (3, n)."""
        columns = self.readings.per_node * node + np.array([0, 1, self.readings.slope])
        rows = np.zeros((3, self.size))
        rows[np.arange(3), columns] = 1.0
        return columns, rows

    def inertia_change(self, turns: Sequence[FloatArray]) -> FloatArray | None:
        """Change of :attr:`inertia` of the straight link by rotated bodies.

        Parameters
        ----------
        turns : sequence of ndarray, shape (B,)
            Angle of each body in the link's frame in rad.

        Returns
        -------
        ndarray, shape (5, B, n, n), or None
            None where no body is off the axis, and of a rigid link.
        """
        pairs = zip(self.bodies, turns, strict=True)
        turned = [(body, angle) for body, angle in pairs if body.is_off_axis]
        if self.rigid or not turned:
            return None
        change = np.stack([body.inertia_change(angle) for body, angle in turned], axis=-3)
        rows = np.stack([body.rows for body, _ in turned])
        ends = np.stack([b.rows if b.end_rows is None else b.end_rows for b, _ in turned])
        forces = np.concatenate([change @ rows, change[:2] @ ends])
        across = rows.reshape(-1, self.size).T
        return np.asarray(across @ forces.reshape(*forces.shape[:-3], -1, self.size))

    @property
    def attached_off_axis(self) -> list[RigidBody]:
        """Bodies off the axis besides distributed mass."""
        return [body for body in self.bodies if body.is_off_axis and not body.of_section]

    @cached_property
    def inertia(self) -> FloatArray:
        """Mass, gyroscopic and centrifugal mass, and the first two by the ends, (5, ..., n, n)."""
        ends = self.ends
        every = self.mass, self.gyroscopic, self.centrifugal_mass, ends.mass, ends.gyroscopic
        return np.stack(every)

    @property
    def ends(self) -> EndMatrices:
        """Forces by displacements of the joined ends alone."""
        return self.reduced_ends or EndMatrices(
            self.mass, self.gyroscopic, self.damping, self.readings
        )

    @property
    def shape(self) -> FloatArray:
        """Displacement at evenly spaced stations from start to end, (n_stations, 2, n)."""
        return self.readings.shape

    @property
    def curvature(self) -> FloatArray:
        """Bending curvature in the middle of the link, (n,)."""
        return self.readings.curvature

    @property
    def size(self) -> int:
        """Number of coordinates n."""
        return len(self.mass)

    @cached_property
    def mass_root(self) -> FloatArray:
        """``L`` with ``L L^T`` the mass matrix, which may be singular, (n, n)."""
        values, vectors = np.linalg.eigh(self.mass)
        return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)), dtype=float)

    def end_displacement(self, end: str) -> IntArray:
        """Coordinates of the displacement at ``"start"`` or ``"end"``."""
        return self.start if end == "start" else self.end

    def end_rotation_of(self, end: str) -> IntArray:
        """Coordinate of the rotation at ``"start"`` or ``"end"``."""
        return self.start_rotation if end == "start" else self.end_rotation

    def end_warping_of(self, end: str) -> IntArray:
        """Coordinate of the warping at ``"start"`` or ``"end"``; none in most elements."""
        return self.start_warping if end == "start" else self.end_warping

    @property
    def kept_ends(self) -> dict[str, IntArray]:
        """Coordinates of displacements and rotations of the ends, as :meth:`projected` has them."""
        names = ("start", "end", "start_rotation", "end_rotation")
        return {name: getattr(self, name) for name in names}

    def end_basis(self, size: int, kept: dict[str, IntArray]) -> FloatArray:
        """Displacements of the ends alone, (n, size), from ``size`` reduced coordinates.

        Parameters
        ----------
        size : int
        kept : dict
            Which of them move ``start`` and ``end``, and may turn the ends' rotations.

        Returns
        -------
        ndarray, shape (n, size)
        """
        unit = np.zeros((self.size, size))
        for end, place in kept.items():
            if len(place):
                unit[getattr(self, end), place] = 1.0
        return unit

    def projected(self, basis: FloatArray, kept: dict[str, IntArray]) -> LinkModel:
        """The link in reduced coordinates p, with ``q = basis @ p``.

        Parameters
        ----------
        basis : ndarray, shape (n, m)
        kept : dict
            New positions of ``start`` and ``end``, and of ``start_rotation`` and
            ``end_rotation`` where they are kept.
        """
        across = basis.T

        def project(matrix: FloatArray) -> FloatArray:
            return across @ matrix @ basis

        unit = self.end_basis(basis.shape[-1], kept)
        ends = EndMatrices(
            mass=across @ self.mass @ unit,
            gyroscopic=across @ self.gyroscopic @ unit,
            damping=across @ self.damping @ unit,
            readings=self.readings.projected(unit),
        )
        size = np.abs(basis)
        axial = size[self.is_axial].sum(axis=0) > size[~self.is_axial].sum(axis=0)
        return replace(
            self,
            start=kept["start"],
            end=kept["end"],
            start_rotation=kept.get("start_rotation", NONE),
            end_rotation=kept.get("end_rotation", NONE),
            start_warping=NONE,
            end_warping=NONE,
            mass=project(self.mass),
            gyroscopic=project(self.gyroscopic),
            centrifugal_mass=project(self.centrifugal_mass),
            first_moment=self.first_moment @ basis,
            stiffness=project(self.stiffness),
            damping=project(self.damping),
            readings=self.readings.projected(basis),
            is_axial=axial,
            vectors=NO_VECTORS,
            receding=np.flatnonzero(size[self.receding].any(axis=0)),
            reduced_ends=ends,
            bodies=tuple(body.projected(basis, unit) for body in self.bodies),
            vector_map=None,
        )


def rigid_link(name: str, mass: LinkMass) -> LinkModel:
    """Model of a rigid link in the displacement of its start and its rotation.

    With the place r of its matter from the start, the displacement is ``u + phi J r``.

    Parameters
    ----------
    name : str
    mass : LinkMass
        Distributed, in points and in bodies.

    Returns
    -------
    LinkModel
        Without coordinates of its end, which depends on the three.
    """
    body = RigidBody.of_link(mass)
    inertia, gyroscopic, translational = body.matrices(np.zeros(()))
    along, across = body.first_moment
    nothing = np.zeros((3, 3))
    ends = np.array([0.0, mass.length])
    # Both ends of a rigid bar with the rotation of each.
    bar = np.zeros((6, 3))
    bar[:3] = bar[3:] = np.eye(3)
    bar[4, 2] = mass.length
    start, rotation = np.array([0, 1]), np.array([2])
    along_it, across_it, turning = np.eye(3)
    return LinkModel(
        name=name,
        mass=inertia,
        gyroscopic=gyroscopic,
        centrifugal_mass=translational,
        first_moment=np.array(
            [[across, -along, -body.translational_inertia], [along, across, 0.0]]
        ),
        stiffness=nothing,
        damping=nothing,
        is_axial=np.zeros(3, dtype=bool),
        start=start,
        end=NONE.copy(),
        start_rotation=rotation,
        end_rotation=rotation,
        readings=LinkReadings(ends, 3, _straight, slope=2, deflection=None, basis=bar),
        fields=RigidFields(along_it, across_it, np.zeros(3), turning),
        vectors=start[:, None],
        rigid=True,
        bodies=(body,),
    )


def _straight(fraction: FloatArray, length: FloatArray) -> FloatArray:
    """Displacement of a bar whose ends are (u, v, phi) each, (s, 2, 6)."""
    shapes = np.zeros((len(fraction), 2, 6))
    for component in (0, 1):
        shapes[:, component, component] = 1 - fraction
        shapes[:, component, 3 + component] = fraction
    return shapes


@dataclass(frozen=True)
class StressedLinks:
    """Tangent stiffness, damping and forces of each link in a state of stress.

    The internal force of a link near that state is
    ``internal_force + tangent @ (q - displacement)``, all in its link frame.

    Parameters
    ----------
    tangent : list of ndarray, shape (n, n) or (B, n, n)
    displacement : list of ndarray, shape (B, n), or None
        Displacement of the state; None for links taken as straight.
    internal_force : list of ndarray, shape (B, n), or None
        Internal force of the state; None for straight links, where there is none.
    damping : list of ndarray, shape (B, n, n), or None
        Damping matrix in the state; None for that of the straight links. A bowed link that
        bends further is not stretched along its axis, and must not be damped as if it were.
    damping_stiffness : list of ndarray, shape (B, n, n), or None
        Derivative of the damping forces by the displacement, not symmetric; None where no link is
        damped, and for a state at rest.
    guide_stiffness : ndarray, shape (B, n_sliders), or None
        Geometric stiffness between the rotation of a slider's guide and its slide in N/rad.
    unstressed : bool
        Whether the tangents are the links' own stiffness, those of designs as they are.
    motion : RigidMotion, or None
        Motion of the linkage in these positions, a batch of shape (B,); None where it is not kept.
    """

    tangent: Sequence[FloatArray]
    displacement: list[FloatArray] | None = None
    internal_force: list[FloatArray] | None = None
    damping: Sequence[FloatArray] | None = None
    damping_stiffness: Sequence[FloatArray] | None = None
    guide_stiffness: FloatArray | None = None
    unstressed: bool = False
    motion: RigidMotion | None = None

    @classmethod
    def unloaded(cls, links: Sequence[LinkModel]) -> Self:
        """Straight links without stress."""
        return cls([link.stiffness for link in links], unstressed=True)

    def at(self, which: slice | IntArray) -> Self:
        """Links in chosen positions of the batch, which may be repeated.

        Parameters
        ----------
        which : slice or ndarray of int
        """
        motion = self.motion and self.motion.at(which)
        if self.unstressed:
            return replace(self, motion=motion)

        def chosen(values: Sequence[FloatArray] | None) -> list[FloatArray] | None:
            return None if values is None else [v[which] for v in values]

        return replace(
            self,
            tangent=[in_positions(t, which) for t in self.tangent],
            displacement=chosen(self.displacement),
            internal_force=chosen(self.internal_force),
            damping=self.damping and [d[which] for d in self.damping],
            damping_stiffness=chosen(self.damping_stiffness),
            guide_stiffness=None if self.guide_stiffness is None else self.guide_stiffness[which],
            motion=motion,
        )
