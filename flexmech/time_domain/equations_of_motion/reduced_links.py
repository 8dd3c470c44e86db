"""Links of a driven linkage in component modes, some of them condensed statically."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray
from flexmech.linear_system import (
    ComponentModes,
    Engine,
    LinkModel,
    LinkStretch,
    Prestress,
    component_modes,
)
from flexmech.linkages import Drive, Topology
from flexmech.time_domain.equations_of_motion.natural_coordinates import (
    NaturalLink,
    natural_links,
    with_turning_sections,
)

# A start at speed shakes more than the lowest modes: component modes are kept up to this
# many times the frequency that the natural frequencies themselves would need.
DETAIL = 8.0
# Axial modes of a link that a bow couples to bending, at the usual detail. Of bell cranks and other
# chains that bow by their neighbours' couples half of them leave errors of 1e-4.
AXIAL_MODES = 12
# Axial modes of a link that stretches by the square of its slopes. Its tension is a constant
# and as many waves along the link, whose lowest are all that the lowest bending modes feel.
STRETCHING_MODES = 3


@dataclass(frozen=True)
class ReducedLinks:
    """Links in component modes, or in all their coordinates.

    Parameters
    ----------
    topology : Topology
        Where links stretch, moving rigid ones are elastic bars.
    unreduced : tuple of NaturalLink
    models : tuple of LinkModel
    bases : tuple of ndarray, shape (n_full, n)
        From each reduced link's coordinates to those of the unreduced one.
    condensed : tuple of ndarray of bool, shape (n,)
        Coordinates that are condensed statically.
    """

    topology: Topology
    unreduced: tuple[NaturalLink, ...]
    models: tuple[LinkModel, ...]
    bases: tuple[FloatArray, ...]
    condensed: tuple[NDArray[np.bool_], ...]

    @classmethod
    def all_of(cls, engine: Engine) -> ReducedLinks:
        """The engine's links unreduced; links with massless nodes are refused."""
        engine.check_runs()
        return cls.of(engine.topology, list(map(NaturalLink.of, engine.links)))

    @classmethod
    def of(
        cls,
        topology: Topology,
        links: Sequence[NaturalLink],
        reduction: ComponentModes | None = None,
    ) -> ReducedLinks:
        """Links with constraint modes that rotate with the pins, or unreduced.

        Parameters
        ----------
        topology : Topology
        links : sequence of NaturalLink
        reduction : ComponentModes, optional
            Of these links.

        Returns
        -------
        ReducedLinks
        """
        if reduction is None:
            models = tuple(link.model for link in links)
            bases = tuple(np.eye(model.size) for model in models)
            condensed = tuple(np.zeros(model.size, dtype=bool) for model in models)
        else:
            models = tuple(replace(model, reduced_ends=None) for model in reduction.models)
            bases = tuple(link.basis for link in reduction.links)
            condensed = tuple(link.condensed for link in reduction.links)
        return cls(topology, tuple(links), models, bases, condensed)

    @property
    def engine_bases(self) -> tuple[FloatArray, ...]:
        """From each reduced link's coordinates to the engine's, (n_engine, n)."""
        pairs = zip(self.unreduced, self.bases, strict=True)
        return tuple(link.to_engine @ basis for link, basis in pairs)

    @property
    def stretches(self) -> list[LinkStretch]:
        """Second-order stretch of each reduced link."""
        pairs = zip(self.unreduced, self.bases, strict=True)
        return [link.stretch.projected(basis) for link, basis in pairs]


def is_reduced(engine: Engine) -> bool:
    """Whether an engine's linear equations in time are reduced to component modes.

    Those of links that are bent without load are not: modes of straight links do not contain
    the approach of the ends of a deep bow (2 % of the deflections of a coupler of
    280 mm that is bowed by 8 mm, of which double the detail recovers a tenth).
    Nor are links that rotate as one body on a free shaft: see
    :attr:`flexmech.linear_system.Engine.turns_as_one_body`.

    Parameters
    ----------
    engine : Engine

    Returns
    -------
    bool
    """
    if engine.shaft == "free" and engine.turns_as_one_body:
        return False
    return engine.component_modes and not engine.mechanism.is_free_strained


def stretches_in_runs(engine: Engine, prestress: Prestress) -> bool:
    """Whether a run by an engine's linear equations includes the second-order stretch.

    Parameters
    ----------
    engine : Engine
        One that simulates runs without them.
    prestress : {"none", "axial", "equilibrium"}

    Returns
    -------
    bool
    """
    return prestress == "equilibrium" and not engine.simulates and engine.stretches is not None


def stretching_links(engine: Engine, modes: int, detail: float) -> ReducedLinks:
    """Links for a run with second-order stretch, without condensed axial modes.

    Slopes stretch a link along its chord, whose direction does not depend on a bow.

    Parameters
    ----------
    engine : Engine
    modes : int
    detail : float
        As of :func:`prestressed_links`.

    Returns
    -------
    ReducedLinks
    """
    topology, links = natural_links(engine)
    reduction = None
    if is_reduced(engine):
        reduction = component_modes(
            topology,
            [link.model for link in links],
            modes,
            0.0,
            couples_axially=True,
            detail=detail,
            axial_modes=round(STRETCHING_MODES * max(1.0, detail / DETAIL)),
            turning_sections=False,
        )
    else:
        engine.check_runs()
    reduced = ReducedLinks.of(topology, links, reduction)
    found = [
        with_turning_sections(engine, topology, number, *link)
        for number, link in enumerate(zip(links, reduced.models, reduced.bases, strict=True))
    ]
    unreduced, models, bases = zip(*found, strict=True)
    condensed = tuple(np.zeros(model.size, dtype=bool) for model in models)
    return ReducedLinks(topology, unreduced, models, bases, condensed)


def prestressed_links(
    engine: Engine, drive: Drive, prestress: Prestress, modes: int, detail: float
) -> ReducedLinks:
    """Links for linear equations at a level of prestress.

    Parameters
    ----------
    engine : Engine
    drive : Drive
    prestress : {"none", "axial", "equilibrium"}
    modes : int
        Number of natural frequencies for which the reduction is accurate.
    detail : float
        Multiplies the frequency up to which component modes are kept.

    Returns
    -------
    ReducedLinks
    """
    if not is_reduced(engine):
        return ReducedLinks.all_of(engine)
    motion = drive.motion(engine.mechanism.linkage, drive.passing_times)
    return ReducedLinks.of(
        engine.topology,
        list(map(NaturalLink.of, engine.links)),
        component_modes(
            engine.topology,
            engine.links,
            modes,
            float(np.abs(motion.angular_velocity).max()),
            couples_axially=prestress == "equilibrium",
            detail=detail,
            axial_modes=max(
                round(AXIAL_MODES * max(1.0, detail / DETAIL)), engine.axial_modes_of_bows
            ),
        ),
    )
