"""Rigid bodies in natural coordinates, in which finite rotations are linear.

The point r of a body displaced by p and rotated by phi moves by ``p + d_1 r + d_2 J r`` with
``d = (cos(phi) - 1, sin(phi))``: linear in p and d, so that its constraints, its mass matrix and
its dead loads are constant and exact at any rotation (Garcia de Jalon & Bayo, *Kinematic and
Dynamic Simulation of Multibody Systems*, 1994, ch. 2). One condition remains, that lengths are
constant::

    d_1 + (d_1^2 + d_2^2) / 2 = 0

It is a strain with the squares of two slopes, as that of a bowed bar
(:class:`flexmech.linear_system.LinkStretch`), and is enforced as one: by a bar that is
:data:`RIGIDITY` times as stiff along itself as the stiffest elastic link (penalty method). Moving
rigid links are such bars, and so is what elastic links carry off their axis
(:mod:`flexmech.time_domain.equations_of_motion.turning_sections`) and a free shaft with its hub. A
weld ties a section's rotation to ``d_2``, which is exact to the second order.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg

from flexmech.arrays import FloatArray
from flexmech.linear_system import (
    Engine,
    LinkModel,
    LinkStretch,
    RigidBody,
)
from flexmech.linear_system.links.link_model import NO_VECTORS, NONE, RigidFields
from flexmech.linear_system.links.rigid_body import QUARTER_TURN
from flexmech.linkages import LinkEnd, Pivot, Topology

# Stiffness of a rigid body's bar against that of the stiffest elastic link along itself. Between
# 100 and 1000 deflections beside a rigid coupler change by 4e-6 of their peak, between 10 and 100
# by 4e-5; a stiffer bar costs digits.
RIGIDITY = 100.0
# Part of the inertia about its centre of mass of a link with turning joints that is on its
# rotation; the rest is on the difference of its ends. They turn alike, so that any part does that
# leaves both with mass.
ON_ROTATION = 0.5


@dataclass(frozen=True)
class NaturalLink:
    """A link of a run, and its coordinates in the engine's.

    Parameters
    ----------
    model : LinkModel
    stretch : LinkStretch
    to_engine : ndarray, shape (n_engine, n)
        The engine's coordinates from the link's own.
    from_engine : ndarray, shape (n, n_engine)
        The link's own at small displacements.
    natural : ndarray, shape (2, n), optional
        ``d`` of a bar, or of the free shaft that turns the link.
    """

    model: LinkModel
    stretch: LinkStretch
    to_engine: FloatArray
    from_engine: FloatArray
    natural: FloatArray | None = None

    @classmethod
    def of(cls, model: LinkModel, stretch: LinkStretch | None = None) -> NaturalLink:
        """A link in the engine's coordinates; it does not stretch by default."""
        unit = np.eye(model.size)
        return cls(model, stretch or LinkStretch.none(model.size), unit, unit)


def natural_links(engine: Engine) -> tuple[Topology, list[NaturalLink]]:
    """Links of a run whose moving rigid ones are bars.

    Parameters
    ----------
    engine : Engine
        One that provides the second-order stretch of its links.

    Returns
    -------
    Topology
        That of the engine, in which the bars are no rigid links and hold no slider on their lines;
        see :mod:`flexmech.time_domain.equations_of_motion.moving_guides`.
    list of NaturalLink
    """
    stretches = engine.stretches
    assert stretches is not None
    pairs = zip(engine.links, stretches, strict=True)
    links = [NaturalLink.of(model, stretch) for model, stretch in pairs]
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
        Of the body in m.
    inertia : float
        Of a shaft, in kg m^2: what a flywheel pulls at its bar must not stretch it either.

    Returns
    -------
    float
    """
    sections = engine.mechanism.sections
    elastic = [each for each in engine.mechanism.linkage.topology.links if not each.rigid]
    along = [sections[each.name].axial_stiffness / each.length for each in elastic]
    mass = [sections[each.name].mass_per_length * each.length for each in elastic]
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
) -> NaturalLink:
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
    own = matter.about_centre.second_moment if matter.mass else 0.0
    shared = ON_ROTATION * max(own - shaft, 0.0) if joined and turned else 0.0
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
    stretch_of_arm = rigid_arm(from_own[2], from_own[3], axial, time)
    return NaturalLink(model, stretch_of_arm, to_engine, from_engine, from_own[2:])


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
