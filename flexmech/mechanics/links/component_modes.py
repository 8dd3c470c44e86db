"""Component-mode reduction of each link (Craig & Bampton 1968, with inertia relief).

*AIAA Journal* 6, 1313-1319. The boundary of a link are the coordinates that its joints move.
The basis of a link has the constraint modes of its joined ends, displacements and of welded ones
rotations; inertia-relief modes, which compensate the truncated modes quasi-statically (MacNeal
1971; Rubin 1975); and its lowest fixed-interface modes. Bending and stretching are reduced
separately; where the neutral axis is off the pins' axis, bending contains the stretch without axial
force. Axial modes are far above the requested frequencies, but a bowed link stretches when it
bends: some are kept in the basis and condensed statically in each position, unless the crank is so
fast that Coriolis forces excite them.

Where links are damped (Kelvin-Voigt) the basis also contains the static responses to damping
forces. Those of constraint modes and fixed-interface modes are in equilibrium only if all
deformations have one damping time. The displacement of a dependent end rotates against its link
while the rest of the link does not: in the frozen equations that is a velocity of the end alone,
and the link's static response to its damping is the end's constraint mode without the end itself.
Damping resists that response, which is ``1 + lambda tau`` times smaller than the static one: static
condensation would be wrong by that. More detail than the usual one gives the response of the
condensed coordinates, in each position, coordinates of its own. With ``lambda tau`` of one,
frequencies are then right to 1e-7 where they were off by 4e-4 with any number of modes.

A deep bow and strong damping ask for more. At a section rotated by theta, the axis tilts with
``cos(theta) w' - sin(theta) u'``, and sections that rotate with ``w'`` would be bent against
it within every element: spurious stiffness that grows with the square of the number of elements.
Where it is stretched by epsilon, its axis tilts less by that part, and sections that shear resist.
A reduction in great detail lets sections rotate without the axis, in a few smooth shapes that are
condensed like the axial modes.

A link that is bowed by w0 bends further by w without stretch if its axis has the axial displacement
``-w0' w'``, integrated. Axial modes converge slowly to that, and the remainder is resisted by EA:
of a slender link bowed by 4 % of its length frequencies are off by 2e-3, and by 5e-4 in great
detail; of one clamped and welded at a tip that bows by 2.5 %, by 70 %. Maps of frequencies measure
that error and use the unreduced links; links that rotate as one body are never reduced.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, IntArray
from flexmech.linkages import LinkEnd, Topology
from flexmech.linkages.topology import End
from flexmech.mechanics.joints.joint_coordinates import held_ends, joint_points
from flexmech.mechanics.joints.link_frames import LinkFrames
from flexmech.mechanics.links.link_model import LinkModel

ENDS: tuple[End, ...] = ("start", "end")
# Links whose modes are kept. Speed alone: a comparison of theories has found those of an engine.
KEPT_LINKS = 8


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
        Topology of its linkage.
    link : LinkModel
        Unreduced.

    Returns
    -------
    LinkBoundary
    """
    fixed, held = np.zeros(link.size, dtype=bool), held_ends(topology)
    turned = {clamp.link_end for clamp in topology.clamps if not clamp.free}
    for end in ENDS:
        place = LinkEnd(link.name, end)
        fixed[link.end_displacement(end)] |= place in held
        fixed[link.end_rotation_of(end)] |= place in turned
        fixed[link.end_warping_of(end)] |= place in topology.joined_ends
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
        before = [n for n, column in enumerate(columns) if np.array_equal(column, rows)]
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
    frequency : ndarray, shape (m,)
        Angular, in rad/s; ascending.
    shapes : ndarray, shape (n, m)
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
        mass = amplitudes.T @ (link.mass @ amplitudes)
        turned = amplitudes @ np.linalg.inv(np.linalg.cholesky(mass)).T
        values, vectors = np.linalg.eigh(turned.T @ (link.stiffness @ turned))
        return cls(np.sqrt(np.abs(values)), turned @ vectors)

    def below(self, frequency: float) -> int:
        """Number of modes up to an angular frequency in rad/s."""
        return int((self.frequency <= frequency).sum())


@dataclass(frozen=True)
class FixedInterfaceLink:
    """Constraint modes and fixed-interface modes of a link.

    Parameters
    ----------
    link : LinkModel
        Link of n coordinates.
    boundary : LinkBoundary
    constraint_modes : ndarray, shape (n, b)
        Static displacement by a unit of each boundary coordinate.
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
    flexible = [number for number, link in enumerate(links) if not link.rigid]
    fixed = [_fix_interface(topology, links[number]) for number in flexible]
    if couples is None:
        return tuple(fixed)
    # Modes of a link whose ends turn freely converge slowly to a spring against that.
    return tuple(
        replace(
            link_modes,
            bending_relief=np.hstack(
                [link_modes.bending_relief, link_modes.flexibility @ couples[number]]
            ),
        )
        if couples[number].size
        else link_modes
        for number, link_modes in zip(flexible, fixed, strict=True)
    )


@lru_cache(maxsize=KEPT_LINKS)
def _fix_interface(topology: Topology, link: LinkModel) -> FixedInterfaceLink:
    """Modes of a flexible link."""
    boundary = link_boundary(topology, link)
    static, flexibility = constraint_modes(link.stiffness, boundary.unit, boundary.inner)
    relief = flexibility @ (link.mass @ static)
    axial_boundary = boundary.unit[link.is_axial].any(axis=0)
    # A link that no end ties to the ground moves along itself as a whole: one axial shape.
    # One with fixed ends only stretches: of a slender one far too little for inertia to matter.
    floats = bool(axial_boundary.any()) and not boundary.fixed.any()
    axial_relief = relief[:, axial_boundary]
    inner = boundary.inner
    stretching, turning = inner[link.is_axial[inner]], inner[~link.is_axial[inner]]
    responses = [
        relief[:, ~axial_boundary],
        flexibility[:, _free_ends_of_eccentric_link(link, inner)],
    ]
    return FixedInterfaceLink(
        link=link,
        boundary=boundary,
        constraint_modes=static,
        flexibility=flexibility,
        # Where an axis off the pins couples both, bending goes along without axial force.
        bending=FixedInterfaceModes.of(link, turning, stretching),
        axial=FixedInterfaceModes.of(link, stretching),
        bending_relief=np.concatenate(responses, axis=1),
        axial_relief=axial_relief,
        floating_relief=axial_relief.sum(axis=1, keepdims=True) if floats else relief[:, :0],
    )


def constraint_modes(
    stiffness: FloatArray, unit: FloatArray, inner: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Constraint modes of a link, and its flexibility with the interface fixed.

    Parameters
    ----------
    stiffness : ndarray, shape (n, n)
    unit : ndarray, shape (n, b)
        Unit displacements of the boundary.
    inner : ndarray of int, shape (i,)
        Coordinates that answer to them statically.

    Returns
    -------
    ndarray, shape (n, b)
    ndarray, shape (n, n)
        Zero in what is fixed.
    """
    flexibility = np.zeros_like(stiffness)
    grid = np.ix_(inner, inner)
    flexibility[grid] = np.linalg.inv(stiffness[grid])
    return unit - flexibility @ (stiffness @ unit), flexibility


def _free_ends_of_eccentric_link(link: LinkModel, inner: IntArray) -> IntArray:
    """Rotations of free ends of an eccentric link, whose attachment modes are kept.

    The force of a pin on an arm is a spring against the end's rotation, to which modes of the link
    with free rotations at its ends converge slowly.
    """
    coupled = link.stiffness[link.is_axial][:, ~link.is_axial].any()
    if not (coupled or any(body.of_section for body in link.bodies)):
        return inner[:0]
    ends = np.concatenate([link.start_rotation[:1], link.end_rotation[:1]])
    return ends[np.isin(ends, inner)]


# Fixed-interface modes are kept up to this multiple of the frequency of the highest
# mode asked for; the frequencies asked for mostly come out within 1e-5. Maps measure their
# own error and take more modes where that is not enough (flexmech.solvers.reduction).
BENDING_CUTOFF = 1.5
# An axial mode of frequency w responds to Coriolis forces at angular velocity W with a
# relative frequency shift of about (2 W / w)^2; beyond this ratio w / W it is below 1e-5.
AXIAL_CUTOFF = 600.0
# Axial modes that are condensed in a link which may bow; with two, frequencies are off noticeably.
CONDENSED_AXIAL_MODES = 12
# A link with an axial mode up to this multiple of the usual bending cut-off is stretched by its
# own inertia: without the inertia-relief mode of that its axial modes converge slowly.
STRETCHING_BY_INERTIA = 10.0
# A shape that is independent of those before it by less than this part of itself is round-off,
# which its frequency has by the square. So is a static response to damping forces beyond one
# damping time, over the shape that it comes from.
ROUND_OFF_SHAPE = 1e-6
GREAT_DETAIL = 4.0
"""Angle from which sections rotate against the axis, for links that bow deeply."""
# They turn in so many waves, or in one for so many nodes where a mesh has few.
TURNING_WAVES = 8
NODES_A_WAVE = 2


@dataclass(frozen=True)
class ReducedLink:
    """One link reduced to component modes.

    Parameters
    ----------
    model : LinkModel
        Reduced matrices.
    basis : ndarray, shape (n_full, n_reduced)
    condensed : ndarray of bool, shape (n_reduced,)
        Coordinates that are condensed statically.
    damped_ends : ndarray, shape (n_reduced, r)
        Motions of joined ends. The response of the condensed coordinates to the damping of each
        such motion is a coordinate of its own.
    """

    model: LinkModel
    basis: FloatArray
    condensed: NDArray[np.bool_]
    damped_ends: FloatArray


@dataclass(frozen=True)
class ComponentModes:
    """All links of a linkage reduced to component modes.

    Parameters
    ----------
    topology : Topology
    links : tuple of ReducedLink
    """

    topology: Topology
    links: tuple[ReducedLink, ...]

    @property
    def models(self) -> tuple[LinkModel, ...]:
        """Reduced link models in order."""
        return tuple(link.model for link in self.links)

    @cached_property
    def frames(self) -> LinkFrames:
        """Link frames of the reduced links; condensed coordinates come last."""
        return LinkFrames(self.topology, self.models, [link.condensed for link in self.links])


def component_modes(
    topology: Topology,
    links: Sequence[LinkModel],
    modes: int,
    fastest: float,
    *,
    couples_axially: bool,
    detail: float = 1.0,
    axial_modes: int | None = None,
    turning_sections: bool = True,
    with_damping_shapes: bool = False,
    fixed: Sequence[FixedInterfaceLink] | None = None,
) -> ComponentModes:
    """Choose and build the component modes of every link.

    Parameters
    ----------
    topology : Topology
    links : sequence of LinkModel
        Unreduced.
    modes : int
        Number of natural frequencies asked for.
    fastest : float
        Greatest angular velocity of a link in rad/s (sets which axial modes stay dynamic).
    couples_axially : bool
        Whether the links may bow (prestress ``equilibrium``), so that condensed axial
        modes are needed.
    detail : float
        Multiplies the frequencies up to which modes are kept and the number condensed. Above 1
        responses to the damping of joined ends are coordinates; from :data:`GREAT_DETAIL` on
        sections rotate against the axis besides.
    axial_modes : int, optional
        Axial modes of each link besides the constraint modes, where they couple; chosen by
        ``detail`` where it is left out.
    turning_sections : bool
        False where nothing tilts the axis of a link that bows, so that its sections need not
        turn against it.
    with_damping_shapes : bool
        Keep the static responses to damping forces, which frozen damping ratios need.
    fixed : sequence of FixedInterfaceLink, optional
        What :func:`fix_interfaces` gives for the links; without springs in joints by default.

    Returns
    -------
    ComponentModes
    """
    if fixed is None:
        fixed = fix_interfaces(topology, links)
    every = np.sort(np.concatenate([h.bending.frequency[:modes] for h in fixed]))
    usual_cutoff = BENDING_CUTOFF * float(every[:modes][-1])
    if axial_modes is None:
        axial_modes = round(detail * CONDENSED_AXIAL_MODES)
    reduced = (
        _reduce(
            h,
            usual_cutoff,
            abs(fastest),
            axial_modes if couples_axially else 0,
            detail=detail,
            damped=with_damping_shapes and bool(h.link.damping.any()),
            turning_sections=turning_sections,
        )
        for h in fixed
    )
    models = (_unreduced(link) if link.rigid else next(reduced) for link in links)
    return ComponentModes(topology, tuple(models))


def _unreduced(link: LinkModel) -> ReducedLink:
    """A rigid link, which is not reduced."""
    none = np.zeros(link.size, dtype=bool)
    return ReducedLink(link, np.eye(link.size), none, np.zeros((link.size, 0)))


def _reduce(
    fixed: FixedInterfaceLink,
    usual_cutoff: float,
    fastest: float,
    condensed_modes: int,
    *,
    detail: float,
    damped: bool,
    turning_sections: bool,
) -> ReducedLink:
    """One flexible link; bending modes are kept up to ``detail`` times the usual cut-off."""
    bending_cutoff, turning = detail * usual_cutoff, fastest != 0
    # Short links stretch at frequencies like those at which they bend.
    axial_cutoff = max(bending_cutoff, detail * AXIAL_CUTOFF * fastest)
    stretches = fixed.axial.below(STRETCHING_BY_INERTIA * usual_cutoff) > 0
    bending = fixed.bending.shapes[:, : fixed.bending.below(bending_cutoff)]
    n_axial = fixed.axial.below(axial_cutoff)
    mass, axial = fixed.link.mass, fixed.axial.shapes[:, :n_axial]
    if (bending.T @ (mass @ axial)).any():
        axial = _complement(axial, bending, mass)
    dynamic = np.hstack([bending, axial])
    along = fixed.axial_relief if stretches else fixed.floating_relief
    relief = np.hstack([fixed.bending_relief, along])
    if damped:
        shapes = np.hstack([fixed.constraint_modes, dynamic])
        relief = np.hstack([relief, _damping_shapes(fixed, shapes)])
    dynamic = np.hstack([dynamic, _complement(relief, dynamic, mass)])
    candidates = fixed.axial.shapes[:, n_axial : max(n_axial, condensed_modes)]
    if condensed_modes and detail >= GREAT_DETAIL and turning_sections:
        candidates = np.hstack([candidates, _turning_sections(fixed)])
    if damped and turning:
        # Constraint modes of dependent ends without the ends: they vanish at the joints.
        shapes = (fixed.constraint_modes - fixed.boundary.unit)[:, fixed.boundary.dependent]
        candidates = np.hstack([candidates, shapes])
    condensed = _complement(candidates, dynamic, mass)
    basis = np.hstack([fixed.constraint_modes, dynamic, condensed])
    size = basis.shape[1]
    is_condensed = np.arange(size) >= size - condensed.shape[1]
    answered = damped and turning and detail > 1
    return ReducedLink(
        fixed.link.projected(basis, fixed.boundary.kept),
        basis,
        is_condensed,
        _damped_ends(fixed, basis, condensed) if answered else np.zeros((size, 0)),
    )


def _damped_ends(fixed: FixedInterfaceLink, basis: FloatArray, condensed: FloatArray) -> FloatArray:
    """Motions (n_reduced, r) of dependent ends whose damping deforms condensed shapes."""
    link, dependent = fixed.link, fixed.boundary.dependent
    force = link.damping @ fixed.boundary.unit[:, dependent]
    whole = (force * (fixed.flexibility @ force)).sum(axis=0)
    scale = 1 / np.sqrt(np.where(whole > 0, whole, np.inf))
    pushed = condensed.T @ force * scale
    stiffness = condensed.T @ (link.stiffness @ condensed)
    values, combination = np.linalg.eigh(pushed.T @ np.linalg.solve(stiffness, pushed))
    combination = combination[:, values > ROUND_OFF_SHAPE**2]
    ways = np.zeros((basis.shape[1], combination.shape[1]))
    ways[dependent] = scale[:, None] * combination
    return ways


def _turning_sections(fixed: FixedInterfaceLink) -> FloatArray:
    """Shapes (n, m) whose sections rotate and warp in waves without displacement of the axis."""
    link = fixed.link
    across = link.fields.across
    of_sections = np.flatnonzero(~link.is_axial & (across == 0))
    nodes = int(np.count_nonzero(across))
    place = np.linspace(0, 1, nodes)
    waves = np.cos(np.pi * place[:, None] * np.arange(min(TURNING_WAVES, nodes // NODES_A_WAVE)))
    kinds = of_sections.reshape(nodes, -1)
    shapes = np.zeros((link.size, kinds.shape[1], waves.shape[1]))
    shapes[kinds, np.arange(kinds.shape[1])] = waves[:, None]
    shapes[np.setdiff1d(np.arange(link.size), fixed.boundary.inner)] = 0.0
    return shapes.reshape(link.size, -1)


def _damping_shapes(fixed: FixedInterfaceLink, shapes: FloatArray) -> FloatArray:
    """Static responses (n, m) to the damping forces of shapes beyond one damping time.

    With one damping time the forces vanish on a constraint mode, and leave a mode a mode.
    """
    link, inner = fixed.link, fixed.boundary.inner
    if not len(inner):
        return shapes[:, :0]
    time = (fixed.flexibility * link.damping).sum() / len(inner)
    unlike = (link.damping @ shapes) / time - link.stiffness @ shapes
    responses = fixed.flexibility @ unlike
    response, shape = ((x * (link.mass @ x)).sum(axis=0) for x in (responses, shapes))
    return np.asarray(responses[:, response > ROUND_OFF_SHAPE**2 * shape])


def _complement(vectors: FloatArray, others: FloatArray, mass: FloatArray) -> FloatArray:
    """Mass-orthonormal complement of ``vectors`` to mass-orthonormal ``others``."""
    if not vectors.shape[1]:
        return vectors
    scale = np.sqrt((vectors * (mass @ vectors)).sum(axis=0))
    rest = vectors / np.where(scale > 0, scale, 1.0)
    for _ in range(2):  # twice is enough against round-off
        rest = rest - others @ (others.T @ (mass @ rest))
    values, combination = np.linalg.eigh(rest.T @ (mass @ rest))
    new = values > ROUND_OFF_SHAPE**2
    return np.asarray(rest @ combination[:, new] / np.sqrt(values[new]))
