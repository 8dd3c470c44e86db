"""Fixed-interface modes and constraint modes of a link (Craig & Bampton, *AIAA Journal* 6, 1968).

Of few elements all modes are found at once. Of many the lowest are found alone, by Lanczos' method
on the inverse of the stiffness (shift-invert, ARPACK), so that nothing grows with the square of the
number of elements.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse.linalg import LinearOperator, eigsh, splu

from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system.links.chains import ChainMatrix, LinkMatrix, couples, whole
from flexmech.linear_system.links.link_model import LinkModel
from flexmech.linear_system.reduction.link_boundary import JoinedEnds, LinkBoundary, link_boundary
from flexmech.linkages import Topology


@dataclass(frozen=True)
class FixedInterfaceLink:
    """Constraint modes and fixed-interface modes of a link.

    Parameters
    ----------
    link : LinkModel
        Of n coordinates.
    boundary : LinkBoundary
    constraint_modes : ndarray, shape (n, b)
        Static displacement by a unit of each boundary coordinate.
    bending, axial : FixedInterfaceModes
        Fixed-interface modes, normalized by the mass.
    bending_relief, axial_relief : ndarray, shape (n, r)
        Inertia-relief modes, static responses to the inertia of the constraint modes, and
        attachment modes of couples at free ends.
    floating_relief : ndarray, shape (n, r)
        Inertia-relief mode of a rigid motion along the link.
    interior_shapes : ndarray, shape (n, k)
        Constraint modes of dependent ends without the ends: they vanish at the joints.
    flexibility : Flexibility
        Of the coordinates that no joint fixes or moves.
    """

    link: LinkModel
    boundary: LinkBoundary
    constraint_modes: FloatArray
    bending: FixedInterfaceModes
    axial: FixedInterfaceModes
    bending_relief: FloatArray
    axial_relief: FloatArray
    floating_relief: FloatArray
    interior_shapes: FloatArray
    flexibility: Flexibility

    @property
    def inner(self) -> IntArray:
        """Coordinates that no joint fixes or moves, (i,)."""
        return self.flexibility.free


def fix_interfaces(
    topology: Topology, links: Sequence[LinkModel], couples: Sequence[FloatArray] | None = None
) -> tuple[FixedInterfaceLink, ...]:
    """Constraint modes and fixed-interface modes of the flexible links of a linkage.

    Parameters
    ----------
    topology : Topology
    links : sequence of LinkModel
        Unreduced, rigid ones among them.
    couples : sequence of ndarray, shape (n_link, k), optional
        Couples of springs on the links' ends, whose attachment modes are kept.

    Returns
    -------
    tuple of FixedInterfaceLink
    """
    ends = JoinedEnds.of(topology)
    if couples is None:
        couples = [np.zeros((link.size, 0)) for link in links]
    pairs = zip(links, couples, strict=True)
    return tuple(_fix_interface(ends, *pair) for pair in pairs if not pair[0].rigid)


def _fix_interface(ends: JoinedEnds, link: LinkModel, couples: FloatArray) -> FixedInterfaceLink:
    """Constraint modes and fixed-interface modes of a flexible link.

    Parameters
    ----------
    ends : JoinedEnds
        Of the linkage.
    link : LinkModel
        Unreduced.
    couples : ndarray, shape (n, k)
        Forces of springs in joints that turn the link's ends.

    Returns
    -------
    FixedInterfaceLink
    """
    boundary = link_boundary(ends, link)
    flexibility, constraint_modes = static_modes(boundary, link.stiffness)
    inner = flexibility.free
    interior_shapes = (constraint_modes - boundary.unit)[:, boundary.dependent]
    relief = np.zeros_like(constraint_modes)
    inertia = link.mass @ constraint_modes
    relief[inner] = flexibility.displacements(inertia[inner])
    axial_boundary = boundary.unit[link.is_axial].any(axis=0)
    # A link that no end ties to the ground moves along itself as a whole: one axial shape.
    # One with fixed ends only stretches: of a slender one far too little for inertia to matter.
    floats = bool(axial_boundary.any()) and not boundary.fixed.any()
    axial_relief = relief[:, axial_boundary]
    floating_relief = axial_relief.sum(axis=1, keepdims=True)
    stretching, turning = inner[link.is_axial[inner]], inner[~link.is_axial[inner]]
    responses = [relief[:, ~axial_boundary], _attachment_modes(link, flexibility)]
    # Modes of a link whose ends turn freely converge slowly to a spring against that.
    turned = np.zeros_like(couples)
    turned[inner] = flexibility.displacements(couples[inner])
    return FixedInterfaceLink(
        link=link,
        boundary=boundary,
        constraint_modes=constraint_modes,
        # Where an axis off the pins couples both, bending goes along without axial force.
        bending=FixedInterfaceModes(link, turning, stretching),
        axial=FixedInterfaceModes(link, stretching),
        bending_relief=np.concatenate([*responses, turned], axis=1),
        axial_relief=axial_relief,
        floating_relief=floating_relief if floats else relief[:, :0],
        interior_shapes=interior_shapes,
        flexibility=flexibility,
    )


def static_modes(boundary: LinkBoundary, stiffness: LinkMatrix) -> tuple[Flexibility, FloatArray]:
    """Flexibility of a link with its ends held, and its constraint modes.

    Parameters
    ----------
    boundary : LinkBoundary
    stiffness : ndarray, shape (..., n, n), or ChainMatrix, shape (n, n)

    Returns
    -------
    Flexibility
    ndarray, shape (..., n, b)
    """
    flexibility, unit = Flexibility(stiffness, boundary.inner), boundary.unit
    forces = (stiffness @ unit)[..., flexibility.free, :]
    modes = np.array(np.broadcast_to(unit, (*forces.shape[:-2], *unit.shape)))
    modes[..., flexibility.free, :] = -flexibility.displacements(forces)
    return flexibility, modes


def _attachment_modes(link: LinkModel, flexibility: Flexibility) -> FloatArray:
    """Attachment modes (n, m) of an eccentric link: response to couples at its free ends.

    The force of a pin on an arm is a spring against the end's rotation, to which modes of the link
    with free rotations at its ends converge slowly.
    """
    off_axis = any(body.of_section for body in link.bodies)
    if not (off_axis or couples(link.stiffness, link.is_axial, ~link.is_axial)):
        return np.zeros((link.size, 0))
    ends, inner = np.concatenate([link.start_rotation[:1], link.end_rotation[:1]]), flexibility.free
    turned = ends[np.isin(ends, inner)]
    unit = np.zeros((link.size, len(turned)))
    unit[turned, np.arange(len(turned))] = 1.0
    shapes = np.zeros_like(unit)
    shapes[inner] = flexibility.displacements(unit[inner])
    return shapes


# Of many elements so many modes are found first, twice as many where these are too few. Speed and
# memory alone: a map of four frequencies asks for some twenty modes of a link.
FIRST_MODES = 24
# All modes are found at once where the lowest are more than this part of them: it takes no longer.
LARGE_PART = 1 / 4


class FixedInterfaceModes:
    """Mass-normalized vibration modes of a link with its interface fixed, found as needed.

    Parameters
    ----------
    link : LinkModel
        Unreduced.
    which : ndarray of int, shape (m,)
        Coordinates that move, one in each shape.
    condensed : ndarray of int, shape (k,), optional
        Coordinates that are condensed statically.
    """

    def __init__(self, link: LinkModel, which: IntArray, condensed: IntArray | None = None) -> None:
        self._link, self._which = link, which
        self._condensed = which[:0] if condensed is None else condensed
        moves, condenses = np.zeros((2, link.size), dtype=bool)
        moves[which], condenses[self._condensed] = True, True
        self._couples = couples(link.stiffness, moves, condenses)
        self._frequency, self._shapes = np.zeros(0), np.zeros((link.size, 0))

    def lowest(self, count: int) -> FloatArray:
        """Lowest angular frequencies in rad/s, (count,), or all if there are fewer."""
        self._find(count)
        return self._frequency[:count]

    def below(self, frequency: float) -> int:
        """Number of modes up to an angular frequency in rad/s."""
        self._find(1)
        while self._known < len(self._which) and self._frequency[-1] <= frequency:
            self._find(2 * self._known)
        return int((self._frequency <= frequency).sum())

    def shapes(self, first: int, last: int) -> FloatArray:
        """Modes from one number up to another, (n, last - first), or up to the last one."""
        self._find(last)
        return self._shapes[:, first:last]

    @property
    def _known(self) -> int:
        """Number of modes that are found."""
        return len(self._frequency)

    def _find(self, count: int) -> None:
        """Find at least ``count`` modes, if there are so many."""
        size = len(self._which)
        if min(count, size) <= self._known:
            return
        many = isinstance(self._link.stiffness, ChainMatrix)
        count = max(count, FIRST_MODES)
        if many and count < LARGE_PART * size:
            self._frequency, self._shapes = self._lowest(count)
        else:
            self._frequency, self._shapes = self._all()

    def _all(self) -> tuple[FloatArray, FloatArray]:
        link = self._link
        shapes = self._moved(np.eye(len(self._which)))
        root = np.linalg.cholesky(shapes.T @ (link.mass @ shapes))
        unit_mass = np.linalg.inv(root) @ shapes.T
        values, vectors = np.linalg.eigh(unit_mass @ (link.stiffness @ unit_mass.T))
        return np.sqrt(np.abs(values)), unit_mass.T @ vectors

    def _lowest(self, count: int) -> tuple[FloatArray, FloatArray]:
        link, which, size = self._link, self._which, len(self._which)
        free = np.union1d(which, self._condensed) if self._couples else which
        place, flexibility = np.searchsorted(free, which), Flexibility(link.stiffness, free)

        def inverse(load: FloatArray) -> FloatArray:
            forces = np.zeros((len(free), 1))
            forces[place, 0] = load.ravel()
            return np.asarray(flexibility.displacements(forces)[place, 0])

        def inertia(amplitude: FloatArray) -> FloatArray:
            return self._load(link.mass @ self._moved(amplitude.reshape(size, -1)))[:, 0]

        def elastic(amplitude: FloatArray) -> FloatArray:
            return self._load(link.stiffness @ self._moved(amplitude.reshape(size, -1)))[:, 0]

        stiffness, mass, response = (
            LinearOperator((size, size), matvec=product, dtype=float)
            for product in (elastic, inertia, inverse)
        )
        # A start that has a part of every mode, and is the same in each run.
        start = np.random.default_rng(0).standard_normal(size)
        squares, vectors = eigsh(stiffness, count, mass, sigma=0.0, OPinv=response, v0=start)
        order = np.argsort(squares)
        return np.sqrt(np.abs(squares[order])), self._moved(vectors[:, order])

    def _moved(self, amplitudes: FloatArray) -> FloatArray:
        """Coordinates (n, k) of the link at amplitudes (m, k) of the shapes."""
        moved = _scattered(self._link.size, self._which, amplitudes)
        if self._couples:
            force = (self._link.stiffness @ moved)[self._condensed]
            moved[self._condensed] = -self._condensing.displacements(force)
        return moved

    def _load(self, forces: FloatArray) -> FloatArray:
        """Generalized forces (m, k) on the shapes by forces (n, k) on the coordinates."""
        load = forces[self._which]
        if self._couples:
            response = _scattered(
                self._link.size,
                self._condensed,
                self._condensing.displacements(forces[self._condensed]),
            )
            load = load - (self._link.stiffness @ response)[self._which]
        return load

    @cached_property
    def _condensing(self) -> Flexibility:
        """Of the condensed coordinates."""
        return Flexibility(self._link.stiffness, self._condensed)


def _scattered(size: int, rows: IntArray, values: FloatArray) -> FloatArray:
    """Vectors (size, k) with values (r, k) in some rows."""
    whole = np.zeros((size, values.shape[1]))
    whole[rows] = values
    return whole


# Columns that are solved at a time, where all would fill a full matrix: memory alone.
AT_A_TIME = 64


class Flexibility:
    """Flexibility matrix: inverse of a stiffness matrix with some coordinates fixed.

    Of a chain of elements only its sparse factors are computed.

    Parameters
    ----------
    stiffness : ndarray, shape (..., n, n), or ChainMatrix, shape (n, n)
    free : ndarray of int, shape (i,)
        Ascending coordinates that are not fixed.
    """

    def __init__(self, stiffness: LinkMatrix, free: IntArray) -> None:
        self.free = free
        self._factors = self._inverse = None
        if isinstance(stiffness, ChainMatrix) and len(free):
            self._factors = splu(stiffness.sparse()[free][:, free].tocsc())
        else:
            self._inverse = np.linalg.inv(whole(stiffness)[..., free[:, None], free])

    def displacements(self, forces: FloatArray) -> FloatArray:
        """Displacements (..., i, k) by forces (..., i, k) on the free coordinates."""
        if self._factors is not None:
            return np.asarray(self._factors.solve(np.ascontiguousarray(forces)))
        return np.asarray(self.matrix @ forces, dtype=float)

    @property
    def matrix(self) -> FloatArray:
        """The matrix itself, (..., i, i); not of a chain of elements."""
        return np.asarray(self._inverse, dtype=float)

    def trace_with(self, matrix: LinkMatrix) -> float:
        """Trace of the product with a symmetric matrix (n, n) in the same coordinates."""
        free, total = self.free, 0.0
        for first in range(0, len(free), AT_A_TIME):
            unit = np.zeros((matrix.shape[-1], len(free[first : first + AT_A_TIME])))
            unit[free[first : first + AT_A_TIME], np.arange(unit.shape[1])] = 1.0
            moved = self.displacements((matrix @ unit)[free])
            total += float(np.trace(moved[first : first + AT_A_TIME]))
        return total
