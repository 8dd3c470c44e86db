"""Constraint modes and fixed-interface modes of a link (Craig & Bampton 1968).

*AIAA Journal* 6, 1313-1319. The boundary of a link are the coordinates that its joints move.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system.joints.joint_coordinates import joint_points
from flexmech.linear_system.links.chains import same_of_all
from flexmech.linear_system.links.link_model import LinkModel
from flexmech.linkages import LinkEnd, Topology
from flexmech.linkages.topology import End

ENDS: tuple[End, ...] = ("start", "end")


@dataclass(frozen=True)
class LinkBoundary:
    """Fixed and boundary coordinates of a link at its joints.

    Parameters
    ----------
    fixed : ndarray of bool, shape (n,)
        Fixed by the ground, the shaft or the fitting of a joint.
    unit : ndarray, shape (n, b)
        Unit displacement of each boundary coordinate: of one coordinate of the link, or of all
        that rotate with a welded end.
    kept : dict of str to ndarray of int
        Which of them are displacements of ``start`` and ``end``, and ``start_rotation`` and
        ``end_rotation``.
    dependent : ndarray of int, shape (k,)
        Which of them are displacements that depend on another link, or on a line.
    """

    fixed: NDArray[np.bool_]
    unit: FloatArray
    kept: dict[str, IntArray]
    dependent: IntArray

    @property
    def inner(self) -> IntArray:
        """Coordinates that no joint fixes or moves, (i,)."""
        return np.flatnonzero(~(self.fixed | self.unit.any(axis=1)))


def link_boundary(topology: Topology, link: LinkModel) -> LinkBoundary:
    """Coordinates of a flexible link at its joints.

    Parameters
    ----------
    topology : Topology
        Of its linkage.
    link : LinkModel
        Unreduced.

    Returns
    -------
    LinkBoundary
    """
    fixed = np.zeros(link.size, dtype=bool)
    for rows in _fixed_by_joints(topology, link):
        fixed[rows] = True
    tied, welded = _tied_ends(topology), _welded_ends(topology)
    columns: list[IntArray] = []
    kept: dict[str, IntArray] = {}
    for end in ENDS:
        rows = link.end_displacement(end)
        keeps = LinkEnd(link.name, end) in tied and not fixed[rows].any()
        kept[end] = len(columns) + np.arange(2 if keeps else 0)
        columns += [rows[n : n + 1] for n in range(2 if keeps else 0)]
    for end in ENDS:
        rows = link.end_rotation_of(end)
        keeps = bool(len(rows)) and LinkEnd(link.name, end) in welded and not fixed[rows].any()
        # Both ends of a bar have one rotation.
        before = [n for n, own in enumerate(columns) if np.array_equal(own, rows)]
        numbers = (before or [len(columns)]) if keeps else []
        kept[f"{end}_rotation"] = np.array(numbers, dtype=np.intp)
        columns += [rows] if len(columns) in numbers else []
    # The section of a body off the axis is a joint too: a rigid link is welded to it.
    arms = [body.rows.any(axis=0) for body in link.attached_off_axis]
    taken = fixed.copy()
    taken[np.concatenate([*columns, np.zeros(0, dtype=np.intp)])] = True
    columns += list(np.flatnonzero(np.any(arms, axis=0) & ~taken)[:, None]) if arms else []
    unit = np.zeros((link.size, len(columns)))
    for number, rows in enumerate(columns):
        unit[rows, number] = 1.0
    ends = [kept[place.end] for place in _dependent_ends(topology) if place.link == link.name]
    dependent = np.concatenate([np.zeros(0, dtype=np.intp), *ends])
    return LinkBoundary(fixed, unit, kept, dependent)


def _fixed_by_joints(topology: Topology, link: LinkModel) -> Iterator[IntArray]:
    """Coordinates that the ground, the shaft or a fitting fixes, end by end."""
    for clamp in topology.clamps:
        if clamp.link_end.link == link.name:
            if not (clamp.free and clamp.hub):
                yield link.end_displacement(clamp.link_end.end)
            if not clamp.free:
                yield link.end_rotation_of(clamp.link_end.end)
    for pivot in topology.pivots:
        if pivot.link_end.link == link.name and not pivot.sprung:
            yield link.end_displacement(pivot.link_end.end)
    for place in topology.joined_ends:
        if place.link == link.name:
            yield link.end_warping_of(place.end)


def _tied_ends(topology: Topology) -> set[LinkEnd]:
    """Ends joined to other links, on a line, or on springs."""
    tied = {place for tie in topology.ties for place in (tie.leader, tie.follower)}
    tied |= {slider.link_end for slider in topology.sliders}
    tied |= {clamp.link_end for clamp in topology.clamps if clamp.free and clamp.hub}
    return tied | {pivot.link_end for pivot in topology.pivots if pivot.sprung}


def _welded_ends(topology: Topology) -> set[LinkEnd]:
    """Ends tied by welds, or clamped to a free shaft."""
    welded = {place for weld in topology.welds for place in (weld.leader, weld.follower)}
    return welded | {clamp.link_end for clamp in topology.clamps if clamp.free}


def _dependent_ends(topology: Topology) -> list[LinkEnd]:
    """Ends of flexible links that depend on another link's end, a rigid link or a line."""
    rigid = {link.name for link in topology.links if link.rigid}
    welded, dependent = _welded_ends(topology), []
    for point in joint_points(topology):
        elastic = [end for end in point.ends if end.link not in rigid]
        # What is welded to a rigid link does not turn against its frame.
        leaders = elastic[:1]
        if point.slider is not None:
            leaders = []
        elif len(elastic) < len(point.ends):
            leaders = [end for end in elastic if end in welded][:1]
        dependent += [end for end in elastic if end not in leaders]
    return dependent


@dataclass(frozen=True)
class FixedInterfaceModes:
    """All vibration modes of a link with its interface fixed, normalized by the mass.

    Parameters
    ----------
    frequency : ndarray, shape (..., m)
        Angular, in rad/s; ascending.
    shapes : ndarray, shape (..., n, m)
    """

    frequency: FloatArray
    shapes: FloatArray

    @classmethod
    def of(
        cls, link: LinkModel, moving: IntArray, condensed: IntArray | None = None
    ) -> FixedInterfaceModes:
        """Modes in which some coordinates move, and others follow statically.

        Parameters
        ----------
        link : LinkModel
            Unreduced.
        moving : ndarray of int, shape (m,)
        condensed : ndarray of int, shape (k,), optional

        Returns
        -------
        FixedInterfaceModes
        """
        amplitudes = np.eye(link.size)[:, moving]
        if condensed is not None:
            amplitudes = constraint_modes(link.stiffness, amplitudes, condensed)[0]
        across = np.swapaxes(amplitudes, -1, -2)
        unit_mass = np.linalg.inv(np.linalg.cholesky(across @ (link.mass @ amplitudes))) @ across
        turned = np.swapaxes(unit_mass, -1, -2)
        values, vectors = np.linalg.eigh(unit_mass @ (link.stiffness @ turned))
        return cls(np.sqrt(np.abs(values)), turned @ vectors)

    def below(self, frequency: FloatArray) -> int:
        """Number of modes up to an angular frequency (...) in rad/s, the same of all designs."""
        return same_of_all((self.frequency <= np.asarray(frequency)[..., None]).sum(axis=-1))


@dataclass(frozen=True)
class FixedInterfaceLink:
    """Constraint modes and fixed-interface modes of a link.

    Parameters
    ----------
    link : LinkModel
        Of n coordinates.
    boundary : LinkBoundary
    constraint_modes : ndarray, shape (n, b)
        Static displacement by a unit of each boundary coordinate. These and all that follow have
        a leading dimension where the link is of several designs.
    flexibility : ndarray, shape (n, n)
        Displacements by forces with the interface fixed.
    bending, axial : FixedInterfaceModes
    bending_relief, axial_relief : ndarray, shape (n, r)
        Inertia-relief modes, static responses to the inertia of the constraint modes, and
        attachment modes of couples at free ends.
    floating_relief : ndarray, shape (n, r)
        Inertia-relief mode of a rigid motion along the link.
    """

    link: LinkModel
    boundary: LinkBoundary
    constraint_modes: FloatArray
    flexibility: FloatArray
    bending: FixedInterfaceModes
    axial: FixedInterfaceModes
    bending_relief: FloatArray
    axial_relief: FloatArray
    floating_relief: FloatArray

    @property
    def inner(self) -> IntArray:
        """Coordinates that no joint fixes or moves, (i,)."""
        return self.boundary.inner


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
    if couples is None:
        couples = [np.zeros((link.size, 0)) for link in links]
    pairs = zip(links, couples, strict=True)
    return tuple(_fix_interface(topology, *pair) for pair in pairs if not pair[0].rigid)


def _fix_interface(topology: Topology, link: LinkModel, couples: FloatArray) -> FixedInterfaceLink:
    """Modes of a flexible link, on whose ends springs in joints exert couples (n, k)."""
    boundary = link_boundary(topology, link)
    static, flexibility = constraint_modes(link.stiffness, boundary.unit, boundary.inner)
    relief = flexibility @ (link.mass @ static)
    axial_boundary = boundary.unit[link.is_axial].any(axis=0)
    # A link that no end ties to the ground moves along itself as a whole: one axial shape.
    # One with fixed ends only stretches: of a slender one far too little for inertia to matter.
    floats = bool(axial_boundary.any()) and not boundary.fixed.any()
    axial_relief = relief[..., axial_boundary]
    inner = boundary.inner
    stretching, turning = inner[link.is_axial[inner]], inner[~link.is_axial[inner]]
    responses = [
        relief[..., ~axial_boundary],
        flexibility[..., _free_ends_of_eccentric_link(link, inner)],
        # Modes of a link whose ends turn freely converge slowly to a spring against that.
        flexibility @ couples,
    ]
    return FixedInterfaceLink(
        link=link,
        boundary=boundary,
        constraint_modes=static,
        flexibility=flexibility,
        # Where an axis off the pins couples both, bending goes along without axial force.
        bending=FixedInterfaceModes.of(link, turning, stretching),
        axial=FixedInterfaceModes.of(link, stretching),
        bending_relief=np.concatenate(responses, axis=-1),
        axial_relief=axial_relief,
        floating_relief=axial_relief.sum(axis=-1, keepdims=True) if floats else relief[..., :0],
    )


def constraint_modes(
    stiffness: FloatArray, unit: FloatArray, inner: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Constraint modes of a link, and its flexibility with the interface fixed.

    Parameters
    ----------
    stiffness : ndarray, shape (..., n, n)
    unit : ndarray, shape (n, b)
        Unit displacements of the boundary.
    inner : ndarray of int, shape (i,)
        Coordinates that answer to them statically.

    Returns
    -------
    ndarray, shape (..., n, b)
    ndarray, shape (..., n, n)
        Zero in what is fixed.
    """
    flexibility = np.zeros_like(stiffness)
    grid = (..., inner[:, None], inner)
    flexibility[grid] = np.linalg.inv(stiffness[grid])
    return unit - flexibility @ (stiffness @ unit), flexibility


def _free_ends_of_eccentric_link(link: LinkModel, inner: IntArray) -> IntArray:
    """Rotations of free ends of an eccentric link, whose attachment modes are kept.

    The force of a pin on an arm is a spring against the end's rotation, to which modes of the link
    with free rotations at its ends converge slowly.
    """
    coupled = link.stiffness[..., link.is_axial, :][..., ~link.is_axial].any()
    if not (coupled or any(body.of_section for body in link.bodies)):
        return inner[:0]
    ends = np.concatenate([link.start_rotation[:1], link.end_rotation[:1]])
    return ends[np.isin(ends, inner)]
