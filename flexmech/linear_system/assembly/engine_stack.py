"""Engines of several designs of one mechanism, which compute them at once."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, TypeVar

from flexmech.linear_system.assembly.engine import Engine
from flexmech.linkages import JointSpring, LinkageStack, Load, Spring, connections
from flexmech.mechanism import Mechanism

AnyEngine = TypeVar("AnyEngine", bound=Engine)


@dataclass(frozen=True)
class MechanismStack:
    """What linear systems of D designs need of their mechanisms, and no more.

    Parameters
    ----------
    mechanisms : tuple of Mechanism
        Without loads, springs and free strains, and of one gravity.
    linkage : LinkageStack
    """

    mechanisms: tuple[Mechanism, ...]
    linkage: LinkageStack
    is_free_strained: ClassVar[bool] = False
    loads: ClassVar[tuple[Load, ...]] = ()
    springs: ClassVar[tuple[Spring, ...]] = ()
    joint_springs: ClassVar[tuple[JointSpring, ...]] = ()

    @property
    def gravity(self) -> tuple[float, float]:
        """In ground axes, m/s^2."""
        return self.mechanisms[0].gravity


def likeness(engine: Engine) -> Hashable | None:
    """What engines must have in common to be stacked; None of one that stays by itself.

    Those of linkages that differ in their numbers alone can be, without loads, springs, rigid
    links and free strains, if the engine can stack their links.

    Parameters
    ----------
    engine : Engine
    """
    mechanism, links = engine.mechanism, engine.likeness_of_links
    acted_on = mechanism.loads or mechanism.springs or mechanism.joint_springs
    special = acted_on or mechanism.is_free_strained or engine.turns_as_one_body
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
