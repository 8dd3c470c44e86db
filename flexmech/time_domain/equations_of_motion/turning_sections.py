"""Sections of elastic links in a run, with what is off the link's axis there.

Bodies, the centres of mass of eccentric sections and their neutral axis are at ``d_1 r + d_2 J r``
from where the straight link has them, however far the section turns: in the natural coordinates of
:mod:`flexmech.time_domain.equations_of_motion.natural_coordinates`, of which ``d_2`` is the
section's rotation. Forces on the neutral axis are those of nodes that ``d_1`` lifts with it.

Along an eccentric link ``d_1`` is smooth but where a force acts: there the moment of the link's
shear force about its axis jumps. It is a sum of few polynomials, and of one more coordinate at each
such section.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import scipy.linalg

from flexmech.arrays import SAME_PLACE, FloatArray, IntArray
from flexmech.linear_system import Engine, LinkModel, LinkStretch, RigidBody, body_nodes
from flexmech.linear_system.assembly.free_shaft import FreeShaft
from flexmech.linear_system.links.link_model import RigidFields
from flexmech.linear_system.links.rigid_body import QUARTER_TURN
from flexmech.linear_system.reduction.component_modes import link_boundary
from flexmech.linkages import Topology
from flexmech.time_domain.equations_of_motion.natural_coordinates import (
    NaturalLink,
    bar_damping_time,
    bar_stiffness,
    joined_strains,
    rigid_arm,
)

# Polynomials by which d_1 varies along an eccentric link.
SMOOTH_SHAPES = 5
# Stiffness of the bars of all sections of an eccentric link against that of one body. What a shear
# force lifts the neutral axis by is one over it: frequencies at rest of links eight times as long
# as high are 1.4e-6 too low, with a tenth of it 1.4e-5. Ten times as much costs a deep bow its
# energy balance.
OF_ALL_SECTIONS = 1000.0


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
        Of the bar of each section against ``d_1``, in N m.
    shapes : ndarray, shape (k, r)
        ``d_1`` of the sections by the r coordinates that the link has of it.
    mass_axis, neutral_axis : float
        Distances of an eccentric link's own axes from that of its coordinates in m; of such a link
        all nodes are among the sections.
    share : ndarray, shape (k,)
        Of an eccentric link's own mass in kg.
    damping_time : float
        Of the bars in s.
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
        own = engine.links[shaft.link]
        place = np.append(own.end_displacement(shaft.clamp.link_end.end), shaft.rotation(own))
        arm = shaft.clamp.hub or float(own.readings.nodes[-1])
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
            Of the link.
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
            part = np.convolve(np.diff(nodes), [0.5, 0.5]) / nodes[-1]
            arm = float(np.hypot(*axes))
            stiffness += OF_ALL_SECTIONS * part * bar_stiffness(engine, arm)
            share += part * mass.mass_per_length * nodes[-1]
            acting = [body.position for body in fixed]
            shapes = _shapes(nodes, [*acting, *engine.mechanism.acting_at(link.name)])
        place = link.readings.per_node * used[:, None] + np.array([0, 1, link.readings.slope])
        bodies = tuple(zip(np.searchsorted(used, at).tolist(), fixed, strict=True))
        time = bar_damping_time(engine)
        return cls(place, bodies, stiffness[used], shapes, *axes, share[used], time)

    def extended(self, link: NaturalLink) -> NaturalLink:
        """The link with r more coordinates, those of ``d_1``.

        Parameters
        ----------
        link : NaturalLink

        Returns
        -------
        NaturalLink
        """
        unit = np.eye(link.model.size, link.model.size + self.shapes.shape[1])
        return NaturalLink(
            self._model(link.model),
            self._stretch(link.stretch),
            link.to_engine @ unit,
            unit.T @ link.from_engine,
        )

    def _lifted(self, size: int, axis: float) -> FloatArray:
        """Displacements of an axis that ``d_1`` lifts, (size, size + r)."""
        lifted = np.eye(size, size + self.shapes.shape[1])
        lifted[self.place[:, 1], size:] = axis * self.shapes
        return lifted

    def _stretch(self, before: LinkStretch) -> LinkStretch:
        """Strains of the link and of the bars."""
        size = before.gradient.shape[1]
        own = before.in_coordinates(self._lifted(size, self.neutral_axis))
        unit = np.eye(size + self.shapes.shape[1])
        given = zip(self.shapes @ unit[size:], self.place[:, 2], self.stiffness, strict=True)
        bars = [rigid_arm(d_1, unit[turn], float(k), self.damping_time) for d_1, turn, k in given]
        return replace(joined_strains([own, *bars]), neutral_axis=own.neutral_axis)

    def _model(self, link: LinkModel) -> LinkModel:
        """The link's matrices, by ``d_1`` as well."""
        size, shapes = link.size, self.shapes
        elastic, own = self._lifted(size, self.neutral_axis), slice(size, None)
        mass, gyroscopic, centrifugal = self._inertia(link)
        own_mass = self.share * (self.mass_axis**2 + self.neutral_axis**2)
        # Of the fourth order in the rotation, and at no place: it lets arms move that turn alone.
        mass[own, own] += (alone := shapes.T @ (own_mass[:, None] * shapes))
        bars = np.zeros_like(mass)
        bars[own, own] = shapes.T @ (self.stiffness[:, None] * shapes)
        # Where all matter is the field of centripetal accelerations says from now on.
        drawn = np.linalg.lstsq(shapes, np.ones(len(shapes)))[0]
        moment = np.zeros((2, len(mass)))
        moment[1, own] = -alone @ drawn
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
        found = [x.copy() for x in (link.mass, link.gyroscopic, link.centrifugal_mass)]
        for number, body in self.bodies:
            entries = np.ix_(self.place[number], self.place[number])
            straight = body.matrices(np.zeros(()))
            for matrix, own in zip(found, straight, strict=True):
                matrix[entries] -= own
        lifted = self._lifted(link.size, self.mass_axis)
        mass, gyroscopic, centrifugal = (lifted.T @ matrix @ lifted for matrix in found)
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
    engine: Engine,
    topology: Topology,
    number: int,
    link: NaturalLink,
    reduced: LinkModel,
    basis: FloatArray,
) -> tuple[NaturalLink, LinkModel, FloatArray]:
    """An elastic link that carries what is off its axis along however far its sections turn.

    A free shaft that turns the link is a body on the section at its clamp.

    Parameters
    ----------
    engine : Engine
    topology : Topology
        Of the run.
    number : int
        Of the link.
    link : NaturalLink
        Unreduced.
    reduced : LinkModel
    basis : ndarray, shape (n, m)
        Of its component modes, or of all its coordinates.

    Returns
    -------
    NaturalLink
        With r more coordinates.
    LinkModel
        Likewise.
    ndarray, shape (n + r, m + r)
    """
    if engine.links[number].rigid:
        return link, reduced, basis
    before, shaft = link.model, engine.free_shaft
    sections = TurningSections.of_link(engine, number, link.stretch.neutral_axis)
    if sections is not None:
        link = sections.extended(link)
    if shaft is not None and shaft.link == number and shaft.is_stiff:
        # Without mass its d_1 would be no coordinate.
        link = _on_shaft(engine, shaft, link) if shaft.inertia or shaft.clamp.hub else link
    if link.model is before:
        return link, reduced, basis
    basis = scipy.linalg.block_diag(basis, np.eye(link.model.size - before.size))
    if reduced is before:
        return link, link.model, basis
    if link.stretch.neutral_axis:
        basis[: before.size, reduced.size :] = _static_answer(topology, before, link.model)
    ends = ("start", "end", "start_rotation", "end_rotation")
    kept = {name: getattr(reduced, name) for name in ends}
    model = link.model.projected(basis, kept)
    return link, replace(model, reduced_ends=None), basis


def _static_answer(topology: Topology, link: LinkModel, extended: LinkModel) -> FloatArray:
    """Displacements (n, r) of a link whose joined ends rest as ``d_1`` lifts its neutral axis."""
    boundary = link_boundary(topology, link)
    inner, more = boundary.inner, slice(link.size, None)
    answer, stiffness = np.zeros((link.size, extended.size - link.size)), extended.stiffness
    answer[inner] = -np.linalg.solve(stiffness[inner[:, None], inner], stiffness[inner, more])
    return answer


def _on_shaft(engine: Engine, shaft: FreeShaft, link: NaturalLink) -> NaturalLink:
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
