"""Rigid bodies in natural coordinates, in which finite rotations are linear.

The point r of a body displaced by p and rotated by phi moves by ``p + d_1 r + d_2 J r`` with
``d = (cos(phi) - 1, sin(phi))``: linear in p and d, so that its constraints, its mass matrix and
its dead loads are constant and exact at any rotation (Garcia de Jalon & Bayo, *Kinematic and
Dynamic Simulation of Multibody Systems*, 1994, ch. 2). One condition remains, that lengths are
constant::

    d_1 + (d_1^2 + d_2^2) / 2 = 0

It is a strain with the squares of two slopes, as that of a bowed bar
(:class:`flexmech.mechanics.LinkStretch`), and is enforced as one: by a bar that is
:data:`RIGIDITY` times as stiff along itself as the stiffest elastic link (penalty method). Moving
rigid links are such bars, and so is what elastic links carry off their axis
(:class:`TurningSections`) and a free shaft with its hub. A weld ties a section's rotation to
``d_2``, which is exact to the second order.

Bodies on elastic links, the centres of mass of eccentric sections and their neutral axis are at
``d_1 r + d_2 J r`` from where the straight link has them, however far the section turns, of which
``d_2`` is the rotation. Forces on the neutral axis are those of nodes that ``d_1`` lifts with it.
Along an eccentric link ``d_1`` is smooth but where a force acts: there the moment of the link's
shear force about its axis jumps. It is a sum of few polynomials, and of one more coordinate at each
such section.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from flexmech.arrays import SAME_PLACE, FloatArray, IntArray
from flexmech.linkages import LinkEnd, Pivot, Topology
from flexmech.mechanics import (
    Engine,
    LinkModel,
    LinkStretch,
    RigidBody,
    body_nodes,
)
from flexmech.mechanics.engine_parameters import FreeShaft
from flexmech.mechanics.links.component_modes import link_boundary
from flexmech.mechanics.links.link_model import NO_VECTORS, NONE, RigidFields
from flexmech.mechanics.links.rigid_body import QUARTER_TURN

# Stiffness of a rigid body's bar against that of the stiffest elastic link along itself. Between
# 100 and 1000 deflections beside a rigid coupler change by 4e-6 of their peak, between 10 and 100
# by 4e-5; a stiffer bar costs digits.
RIGIDITY = 100.0
# Part of the inertia about its centre of mass of a link with turning joints that is on its
# rotation; the rest is on the difference of its ends. They turn alike, so that any part does that
# leaves both with mass.
ON_ROTATION = 0.5
# Polynomials by which d_1 varies along an eccentric link.
SMOOTH_SHAPES = 5
# Stiffness of the bars of all sections of an eccentric link against that of one body. What a shear
# force lifts the neutral axis by is one over it: frequencies at rest of links eight times as long
# as high are 1.4e-6 too low, with a tenth of it 1.4e-5. Ten times as much costs a deep bow its
# energy balance.
OF_ALL_SECTIONS = 1000.0


@dataclass(frozen=True)
class RunLink:
    """A link of a run, unreduced and in component modes, and its coordinates in the engine's.

    Parameters
    ----------
    model : LinkModel
        Unreduced.
    stretch : LinkStretch
    to_engine : ndarray, shape (n_engine, n)
        The engine's coordinates from the link's own.
    from_engine : ndarray, shape (n, n_engine)
        The link's own at small displacements.
    reduced : LinkModel
        In m component modes, or the unreduced one.
    basis : ndarray, shape (n, m)
        From its coordinates to those of the unreduced one.
    condensed : ndarray of bool, shape (m,)
        Which of these are condensed statically.
    natural : ndarray, shape (2, n), optional
        ``d`` of a bar, or of the free shaft that turns the link.
    """

    model: LinkModel
    stretch: LinkStretch
    to_engine: FloatArray
    from_engine: FloatArray
    reduced: LinkModel
    basis: FloatArray
    condensed: NDArray[np.bool_]
    natural: FloatArray | None = None

    @classmethod
    def of(cls, model: LinkModel, stretch: LinkStretch | None = None) -> RunLink:
        """An unreduced link in the engine's coordinates; it does not stretch by default."""
        unit, none = np.eye(model.size), np.zeros(model.size, dtype=bool)
        return cls(model, stretch or LinkStretch.none(model.size), unit, unit, model, unit, none)


def natural_links(engine: Engine) -> tuple[Topology, list[RunLink]]:
    """Links of a run whose moving rigid ones are bars.

    Parameters
    ----------
    engine : Engine
        One that provides the second-order stretch of its links.

    Returns
    -------
    Topology
        That of the engine, in which the bars are no rigid links and hold no slider on their lines;
        see :mod:`flexmech.mechanics.running.linkage_stretch`.
    list of RunLink
    """
    stretches = engine.stretches
    assert stretches is not None
    pairs = zip(engine.links, stretches, strict=True)
    links = [RunLink.of(model, stretch) for model, stretch in pairs]
    topology = engine.topology
    clamped = {clamp.link_end.link for clamp in topology.clamps if not clamp.free}
    bars = {link.name for link in topology.links if link.rigid} - clamped
    topology, shaft = _without_moving_lines(topology, bars), engine.free_shaft
    for number, link in enumerate(topology.links):
        if link.name in bars:
            joined = any(end.link == link.name and end.end == "end" for end in topology.joined_ends)
            turned = joined and _turns(engine, link.name)
            inertia = 0.0 if shaft is None or shaft.link != number else shaft.inertia
            [body] = links[number].model.bodies
            # What nothing joins at its end is as stiff as a body on a section.
            arm = link.length if joined or not body.arm else body.arm
            stiffness = bar_stiffness(engine, arm, inertia)
            links[number] = _bar(
                engine, links[number].model, link.length, joined, turned, stiffness, inertia
            )
    return topology, links


def bar_stiffness(engine: Engine, arm: float, inertia: float = 0.0) -> float:
    """Penalty stiffness of a rigid body's bar against ``d_1``, in N m.

    Parameters
    ----------
    engine : Engine
    arm : float
        Arm of the body in m.
    inertia : float
        Inertia of a shaft, in kg m^2: what a flywheel pulls at its bar must not stretch it either.

    Returns
    -------
    float
    """
    sections = engine.mechanism.sections
    elastic = [link for link in engine.mechanism.linkage.topology.links if not link.rigid]
    along = [sections[link.name].axial_stiffness / link.length for link in elastic]
    mass = [sections[link.name].mass_per_length * link.length for link in elastic]
    by_inertia = inertia * max(k / m for k, m in zip(along, mass, strict=True))
    return RIGIDITY * max(max(along) * arm**2, by_inertia)


def bar_damping_time(engine: Engine) -> float:
    """Damping time of a rigid body's bar in s, the greatest of the elastic links along themselves.

    Without it what the start of a run leaves in the bar would ring on.
    """
    return max(section.damping.axial for section in engine.mechanism.sections.values())


def _without_moving_lines(topology: Topology, bars: set[str]) -> Topology:
    """The topology with bars as elastic links, and without the sliders on their lines.

    Their ends, and those of the bars that guide them, remain ends at joints.
    """
    loose = [slider for slider in topology.sliders if slider.guide in bars]
    ends = {slider.link_end for slider in loose}
    ends |= {LinkEnd(slider.guide, "end") for slider in loose} - topology.joined_ends
    free = tuple(Pivot(f"{end.link} {end.end}", end, sprung=True) for end in sorted(ends, key=str))
    sliders = tuple(slider for slider in topology.sliders if slider not in loose)
    others = replace(topology, sliders=sliders, pivots=(*topology.pivots, *free))
    return others.with_elastic(bars)


def _turns(engine: Engine, name: str) -> bool:
    """Whether a joint of a link fixes its rotation or has a torsional spring."""
    topology = engine.topology
    welded = any(name in (weld.leader.link, weld.follower.link) for weld in topology.welds)
    sprung = {spring.joint for spring in engine.mechanism.joint_springs}
    pairs = {
        joint: {end.link for end in ends if end is not None}
        for joint, ends in topology.pinned_ends.items()
    }
    return welded or any(name in pairs.get(joint, set()) for joint in sprung)


def _bar(
    engine: Engine,
    rigid: LinkModel,
    length: float,
    joined: bool,
    turned: bool,
    axial: float,
    shaft: float,
) -> RunLink:
    """A rigid link as a stiff bar in natural coordinates.

    Its coordinates are the displacements of both ends, and its rotation where joints turn with it;
    of a link that nothing joins at its end that of the start, the rotation and the stretch. Its
    inertia has that of a free shaft in it, none of which is on the rotation.
    """
    mass = rigid.mass
    matter = RigidBody(mass[0, 0], (mass[1, 2], -mass[0, 2]), mass[2, 2], central_inertia=0.0)
    at_start, stretch, turn = np.eye(4)[:2], np.eye(4)[2], np.eye(4)[3]
    if joined:
        at_end = at_start + length * np.eye(4)[2:]
        rotation = [turn] if turned else []
        to_own = np.vstack([at_start, *rotation, at_end])
        inverse = np.hstack([np.eye(2), np.zeros((2, len(rotation) + 2))])
        difference = np.hstack([-np.eye(2), np.zeros((2, len(rotation))), np.eye(2)]) / length
        from_own = np.vstack([inverse, difference])
    else:
        to_own = np.vstack([at_start, turn, stretch])
        from_own = np.linalg.inv(to_own)
    size = len(to_own)
    start, end = np.array([0, 1]), np.array([size - 2, size - 1]) if joined else NONE.copy()
    turning = np.array([2]) if turned or not joined else NONE.copy()
    rotates = np.eye(size)[2] if len(turning) else from_own[3]
    about_centre = matter.about_centre.second_moment if matter.mass else 0.0
    shared = ON_ROTATION * max(about_centre - shaft, 0.0) if joined and turned else 0.0
    spread = replace(matter, second_moment=matter.second_moment - shared)
    inertia = from_own.T @ spread.natural_inertia(np.eye(2)) @ from_own
    translational = inertia.copy()
    inertia += shared * np.outer(rotates, rotates)
    shear = rotates - from_own[3]
    nodes = np.vstack([from_own[:2], rotates, from_own[:2] + length * from_own[2:], rotates])
    stiffness = axial * (np.outer(from_own[2], from_own[2]) + np.outer(shear, shear))
    time = bar_damping_time(engine)
    model = LinkModel(
        name=rigid.name,
        mass=inertia,
        gyroscopic=from_own.T @ spread.natural_inertia(QUARTER_TURN) @ from_own,
        centrifugal_mass=translational,
        first_moment=np.zeros((2, size)),
        stiffness=stiffness,
        damping=time * stiffness,
        is_axial=np.abs(to_own[:, [0, 2]]).sum(axis=1) > 0,
        start=start,
        end=end,
        start_rotation=turning,
        end_rotation=turning,
        readings=replace(rigid.readings, basis=nodes),
        fields=RigidFields(*to_own[:, [0, 1, 2, 3]].T),
        vectors=NO_VECTORS.copy(),
    )
    to_engine = np.vstack([from_own[:2], rotates])
    from_engine = to_own @ np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 0], [0, 0, 1]])
    link = RunLink.of(model, rigid_arm(from_own[2], from_own[3], axial, time))
    return replace(link, to_engine=to_engine, from_engine=from_engine, natural=from_own[2:])


def rigid_arm(
    stretch: FloatArray, turn: FloatArray, stiffness: float, damping_time: float
) -> LinkStretch:
    """The condition of a body that its lengths stay, as a strain.

    Parameters
    ----------
    stretch, turn : ndarray, shape (n,)
        ``d`` by a link's coordinates.
    stiffness : float
        Against ``d_1``, in N m.
    damping_time : float
        In s.

    Returns
    -------
    LinkStretch
        That one strain.
    """
    rows = np.stack([stretch, turn])
    root = float(np.sqrt(stiffness))
    return LinkStretch(root * rows[:1], rows, root * np.ones((1, 2)), np.array([damping_time]))


def joined_strains(strains: Sequence[LinkStretch]) -> LinkStretch:
    """Strains of several kinds, all by the same coordinates, as those of one link."""
    return LinkStretch(
        np.concatenate([strain.gradient for strain in strains]),
        np.concatenate([strain.slopes for strain in strains]),
        scipy.linalg.block_diag(*(strain.weights for strain in strains)),
        np.concatenate([strain.damping_time for strain in strains]),
    )


@dataclass(frozen=True)
class TurningSections:
    """k sections of an elastic link.

    Parameters
    ----------
    place : ndarray of int, shape (k, 3)
        Displacement of each section and its rotation among the link's coordinates.
    bodies : tuple of (int, RigidBody)
        What is fixed to the sections, by their numbers.
    stiffness : ndarray, shape (k,)
        Stiffness of the bar of each section against ``d_1``, in N m.
    shapes : ndarray, shape (k, r)
        ``d_1`` of the sections by the r coordinates that the link has of it.
    mass_axis, neutral_axis : float
        Distances of an eccentric link's own axes from that of its coordinates in m; of such a link
        all nodes are among the sections.
    share : ndarray, shape (k,)
        Share of an eccentric link's own mass in kg.
    damping_time : float
        Damping time of the bars in s.
    """

    place: IntArray
    bodies: tuple[tuple[int, RigidBody], ...]
    stiffness: FloatArray
    shapes: FloatArray
    mass_axis: float
    neutral_axis: float
    share: FloatArray
    damping_time: float

    @classmethod
    def of_shaft(cls, engine: Engine, shaft: FreeShaft) -> Self:
        """The section at its clamp of an elastic link that a free shaft turns.

        Parameters
        ----------
        engine : Engine
        shaft : FreeShaft

        Returns
        -------
        TurningSections
        """
        arm_model = engine.links[shaft.link]
        place = np.append(
            arm_model.end_displacement(shaft.clamp.link_end.end), shaft.rotation(arm_model)
        )
        arm = shaft.clamp.hub or float(arm_model.readings.nodes[-1])
        stiffness = np.array([bar_stiffness(engine, arm, shaft.inertia)])
        time = bar_damping_time(engine)
        matter = ((0, RigidBody(0.0, (0.0, 0.0), shaft.inertia, shaft.inertia)),)
        return cls(place[None], matter, stiffness, np.eye(1), 0.0, 0.0, np.zeros(1), time)

    @classmethod
    def of_link(cls, engine: Engine, number: int, neutral_axis: float) -> Self | None:
        """Sections of an elastic link that carry something off its axis.

        Parameters
        ----------
        engine : Engine
        number : int
            Number of the link.
        neutral_axis : float
            Its distance from the axis in m.

        Returns
        -------
        TurningSections or None
            All at nodes where the link is eccentric, those with bodies where it is not.
        """
        link, mass = engine.links[number], engine.mechanism.link_masses_in_order[number]
        nodes = link.readings.nodes
        off = abs(mass.offset) > SAME_PLACE * nodes[-1]
        axes = (mass.offset if off else 0.0, neutral_axis)
        fixed = [
            body for body in link.bodies if not body.of_section and (any(axes) or body.is_off_axis)
        ]
        points = zip(mass.point_positions, mass.point_masses, strict=True)
        fixed += [RigidBody(m, (0.0, 0.0), 0.0, 0.0, position=x) for x, m in points if any(axes)]
        at = body_nodes(nodes, fixed)
        used = np.arange(len(nodes)) if any(axes) else np.unique(at)
        if not len(used):
            return None
        shapes, (stiffness, share) = np.eye(len(used)), np.zeros((2, len(nodes)))
        for body, node in zip(fixed, at.tolist(), strict=True):
            if body.is_off_axis:
                stiffness[node] += bar_stiffness(engine, body.arm)
        if any(axes):
            share_of_node = np.convolve(np.diff(nodes), [0.5, 0.5]) / nodes[-1]
            arm = float(np.hypot(*axes))
            stiffness += OF_ALL_SECTIONS * share_of_node * bar_stiffness(engine, arm)
            share += share_of_node * mass.mass_per_length * nodes[-1]
            acting = [body.position for body in fixed]
            shapes = _shapes(nodes, [*acting, *engine.mechanism.acting_at(link.name)])
        place = link.readings.per_node * used[:, None] + np.array([0, 1, link.readings.slope])
        bodies = tuple(zip(np.searchsorted(used, at).tolist(), fixed, strict=True))
        time = bar_damping_time(engine)
        return cls(place, bodies, stiffness[used], shapes, *axes, share[used], time)

    def extended(self, link: RunLink) -> RunLink:
        """The link with r more coordinates, those of ``d_1``.

        Parameters
        ----------
        link : RunLink

        Returns
        -------
        RunLink
        """
        unit = np.eye(link.model.size, link.model.size + self.shapes.shape[1])
        return replace(
            link,
            model=self._model(link.model),
            stretch=self._stretch(link.stretch),
            to_engine=link.to_engine @ unit,
            from_engine=unit.T @ link.from_engine,
        )

    def _lifted(self, size: int, axis: float) -> FloatArray:
        """Displacements of an axis that ``d_1`` lifts, (size, size + r)."""
        lifted = np.eye(size, size + self.shapes.shape[1])
        lifted[self.place[:, 1], size:] = axis * self.shapes
        return lifted

    def _stretch(self, before: LinkStretch) -> LinkStretch:
        """Strains of the link and of the bars."""
        size = before.gradient.shape[1]
        of_link = before.in_coordinates(self._lifted(size, self.neutral_axis))
        unit = np.eye(size + self.shapes.shape[1])
        given = zip(self.shapes @ unit[size:], self.place[:, 2], self.stiffness, strict=True)
        bars = [rigid_arm(d_1, unit[turn], float(k), self.damping_time) for d_1, turn, k in given]
        return replace(joined_strains([of_link, *bars]), neutral_axis=of_link.neutral_axis)

    def _model(self, link: LinkModel) -> LinkModel:
        """The link's matrices, by ``d_1`` as well."""
        size, shapes = link.size, self.shapes
        elastic, bars_only = self._lifted(size, self.neutral_axis), slice(size, None)
        mass, gyroscopic, centrifugal = self._inertia(link)
        own_mass = self.share * (self.mass_axis**2 + self.neutral_axis**2)
        # Of the fourth order in the rotation, and at no place: it lets arms move that turn alone.
        mass[bars_only, bars_only] += (alone := shapes.T @ (own_mass[:, None] * shapes))
        bars = np.zeros_like(mass)
        bars[bars_only, bars_only] = shapes.T @ (self.stiffness[:, None] * shapes)
        # Where all matter is the field of centripetal accelerations says from now on.
        drawn = np.linalg.lstsq(shapes, np.ones(len(shapes)))[0]
        moment = np.zeros((2, len(mass)))
        moment[1, bars_only] = -alone @ drawn
        fields, none = link.fields, np.zeros(len(drawn))
        return replace(
            link,
            mass=mass,
            gyroscopic=gyroscopic,
            centrifugal_mass=centrifugal,
            first_moment=moment,
            stiffness=elastic.T @ link.stiffness @ elastic + bars,
            damping=elastic.T @ link.damping @ elastic + self.damping_time * bars,
            is_axial=np.append(link.is_axial, np.ones(len(drawn), dtype=bool)),
            readings=link.readings.projected(np.eye(size, len(mass))),
            fields=RigidFields(
                np.append(fields.along, none),
                np.append(fields.across, none),
                np.append(fields.centripetal, drawn),
                np.append(fields.tangential, none),
            ),
            bodies=(),
        )

    def _inertia(self, link: LinkModel) -> list[FloatArray]:
        """Mass, gyroscopic and centrifugal mass matrix, (n + r, n + r)."""
        matrices = [x.copy() for x in (link.mass, link.gyroscopic, link.centrifugal_mass)]
        for number, body in self.bodies:
            entries = np.ix_(self.place[number], self.place[number])
            straight = body.matrices(np.zeros(()))
            for matrix, as_rigid in zip(matrices, straight, strict=True):
                matrix[entries] -= as_rigid
        lifted = self._lifted(link.size, self.mass_axis)
        mass, gyroscopic, centrifugal = (lifted.T @ matrix @ lifted for matrix in matrices)
        unit = np.eye(len(mass))
        for number, body in self.bodies:
            u, v, phi = self.place[number]
            by = np.stack([unit[u], unit[v], self.shapes[number] @ unit[link.size :], unit[phi]])
            weighted = by.T @ body.natural_inertia(np.eye(2)) @ by
            mass += weighted
            centrifugal += weighted
            gyroscopic += by.T @ body.natural_inertia(QUARTER_TURN) @ by
        return [mass, gyroscopic, centrifugal]


def with_turning_sections(
    engine: Engine, topology: Topology, number: int, link: RunLink
) -> RunLink:
    """An elastic link that carries what is off its axis along however far its sections turn.

    A free shaft that turns the link is a body on the section at its clamp.

    Parameters
    ----------
    engine : Engine
    topology : Topology
        Topology of the run.
    number : int
        Number of the link.
    link : RunLink

    Returns
    -------
    RunLink
        With r more coordinates, reduced or not.
    """
    if engine.links[number].rigid:
        return link
    before, reduced, shaft = link.model, link.reduced, engine.free_shaft
    sections = TurningSections.of_link(engine, number, link.stretch.neutral_axis)
    if sections is not None:
        link = sections.extended(link)
    if shaft is not None and shaft.link == number and shaft.is_stiff:
        # Without mass its d_1 would be no coordinate.
        link = _on_shaft(engine, shaft, link) if shaft.inertia or shaft.clamp.hub else link
    model, basis = link.model, link.basis
    if model is not before:
        basis = scipy.linalg.block_diag(basis, np.eye(model.size - before.size))
    if reduced is not before and model is not before:
        if link.stretch.neutral_axis:
            basis[: before.size, reduced.size :] = _static_answer(topology, before, model)
        reduced = replace(model.projected(basis, reduced.kept_ends), reduced_ends=None)
    elif reduced is before:
        reduced = model
    return replace(link, reduced=reduced, basis=basis, condensed=np.zeros(reduced.size, dtype=bool))


def _static_answer(topology: Topology, link: LinkModel, extended: LinkModel) -> FloatArray:
    """Displacements (n, r) of a link whose joined ends rest as ``d_1`` lifts its neutral axis."""
    boundary = link_boundary(topology, link)
    inner, more = boundary.inner, slice(link.size, None)
    answer, stiffness = np.zeros((link.size, extended.size - link.size)), extended.stiffness
    answer[inner] = -np.linalg.solve(stiffness[inner[:, None], inner], stiffness[inner, more])
    return answer


def _on_shaft(engine: Engine, shaft: FreeShaft, link: RunLink) -> RunLink:
    """A link whose section at its clamp a free shaft turns; on a hub it moves with ``d_1``."""
    section = TurningSections.of_shaft(engine, shaft)
    link = section.extended(link)
    last, turn = link.model.size - 1, int(section.place[0, 2])
    model = replace(link.model, receding=np.array([last]))
    return replace(link, model=model, natural=np.eye(last + 1)[[last, turn]])


def _shapes(nodes: FloatArray, acting: list[float]) -> FloatArray:
    """``d_1`` at nodes (k,) of an eccentric link on which forces act at some places, (k, r)."""
    acting = [0.0, *acting, float(nodes[-1])]
    places = np.unique(np.abs(nodes - np.array(acting)[:, None]).argmin(axis=1))
    if len(nodes) - len(places) <= SMOOTH_SHAPES:
        return np.eye(len(nodes))
    smooth = np.polynomial.legendre.legvander(2 * nodes / nodes[-1] - 1, SMOOTH_SHAPES - 1)
    return np.hstack([smooth, np.eye(len(nodes))[:, places]])
