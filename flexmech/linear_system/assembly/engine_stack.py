"""Engines of several designs of one mechanism, which compute them at once."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, TypeVar

import numpy as np

from flexmech.arrays import IntArray
from flexmech.linear_system.assembly.engine import Engine, equal_batches
from flexmech.linkages import (
    InverseDynamics,
    JointSpring,
    LinkageStack,
    LinkMass,
    Load,
    RigidMotion,
    Spring,
    connections,
    inverse_dynamics,
)
from flexmech.mechanism import Mechanism

AnyEngine = TypeVar("AnyEngine", bound=Engine)


# Positions of each design of a stack in a batch. Memory alone, and speed: the memory of more is
# given back to the system after every step, and asked for anew. As many of a small stack, so that
# its numbers are those of a large one to the last bit.
STACK_POSITIONS = 12


@dataclass(frozen=True)
class MechanismStack:
    """What linear systems of D designs need of their mechanisms, and no more.

    Parameters
    ----------
    mechanisms : tuple of Mechanism
        Without loads, springs, frames on these and free strains, and of one gravity.
    linkage : LinkageStack
    """

    mechanisms: tuple[Mechanism, ...]
    linkage: LinkageStack
    is_free_strained: ClassVar[bool] = False
    loads: ClassVar[tuple[Load, ...]] = ()
    springs: ClassVar[tuple[Spring, ...]] = ()
    joint_springs: ClassVar[tuple[JointSpring, ...]] = ()
    frame: ClassVar[None] = None

    def forces(self, motion: RigidMotion) -> InverseDynamics:
        """Forces in the rigid linkages, each in its positions.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,), with ``design``.

        Returns
        -------
        InverseDynamics
            Places along links are to be given in each position.
        """
        every = [mechanism.link_masses_in_order for mechanism in self.mechanisms]
        masses = [_mass_of_designs(own, motion) for own in zip(*every, strict=True)]
        topology = self.linkage.topology
        length = np.stack([mass.length for mass in masses], axis=-1)
        longer = length - [link.length for link in topology.links]
        return inverse_dynamics(topology, motion, masses, self.gravity, longer=longer)

    @property
    def gravity(self) -> tuple[float, float]:
        """In ground axes, m/s^2."""
        return self.mechanisms[0].gravity


def _mass_of_designs(masses: Sequence[LinkMass], motion: RigidMotion) -> LinkMass:
    """Mass of one link whose numbers are those of each position's design, (B,)."""
    own = motion.design

    def every(numbers: list[float]) -> Any:
        return np.array(numbers)[own]

    points = range(len(masses[0].point_masses))
    return LinkMass(
        every([mass.length for mass in masses]),
        every([mass.mass_per_length for mass in masses]),
        tuple(every([mass.point_positions[number] for mass in masses]) for number in points),
        tuple(every([mass.point_masses[number] for mass in masses]) for number in points),
        rotary_inertia=every([mass.rotary_inertia for mass in masses]),
    )


def likeness(engine: Engine) -> Hashable | None:
    """What engines must have in common to be stacked; None of one that stays by itself.

    Those of linkages that differ in their numbers alone can be, without sliders, hubs, loads,
    springs, a frame on these, rigid links and free strains, if the engine can stack their links.

    Parameters
    ----------
    engine : Engine
    """
    mechanism, links = engine.mechanism, engine.likeness_of_links
    acted_on = mechanism.loads or mechanism.springs or mechanism.joint_springs or mechanism.frame
    topology = mechanism.linkage.topology
    joined = topology.sliders or any(clamp.hub for clamp in topology.clamps)
    special = joined or acted_on or mechanism.is_free_strained or engine.turns_as_one_body
    if links is None or special or engine.shaft != "prescribed" or not engine.component_modes:
        return None
    return type(engine), engine.elements, links, mechanism.gravity, connections(mechanism.linkage)


def stack_engines(engines: Sequence[AnyEngine]) -> AnyEngine:
    """One engine of D designs, whose positions are those of one design after the other.

    Parameters
    ----------
    engines : sequence of Engine
        Of the same :func:`likeness`.

    Returns
    -------
    Engine
        Its links have the leading dimension D, and it takes as many positions of every design.
    """
    stack = copy(engines[0])
    mechanisms = tuple(engine.mechanism for engine in engines)
    # What is computed of the first one alone must not be taken for all.
    for name in [*vars(stack)]:
        if isinstance(getattr(type(stack), name, None), cached_property):
            del vars(stack)[name]
    vars(stack).update(
        mechanism=MechanismStack(mechanisms, LinkageStack(tuple(m.linkage for m in mechanisms))),
        members=tuple(engines),
        _reductions={},
    )
    return stack


def stack_batches(count: int, designs: int) -> list[IntArray]:
    """Batches of positions of several designs, as many of each design in every batch.

    Parameters
    ----------
    count : int
        Positions, as many of each design, one after the other.
    designs : int

    Returns
    -------
    list of ndarray of int
        Numbers of the positions.
    """
    places = np.arange(count).reshape(designs, -1)
    parts = equal_batches(places.shape[1], STACK_POSITIONS)
    return [places[:, part].ravel() for part in parts]
