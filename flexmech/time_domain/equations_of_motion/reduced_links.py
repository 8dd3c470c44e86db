"""Links of a driven linkage in component modes, some of them condensed statically."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flexmech.linear_system import (
    ComponentModes,
    Engine,
    Prestress,
    component_modes,
)
from flexmech.linkages import Drive, Topology
from flexmech.time_domain.equations_of_motion.natural_coordinates import (
    RunLink,
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


def unreduced_links(engine: Engine) -> list[RunLink]:
    """The engine's links unreduced; links with massless nodes are refused."""
    engine.check_runs()
    return list(map(RunLink.of, engine.links))


def _in_modes(links: Sequence[RunLink], reduction: ComponentModes) -> list[RunLink]:
    """Links with constraint modes that rotate with the pins."""
    return [
        replace(
            link,
            reduced=replace(model, reduced_ends=None),
            basis=modes.basis,
            condensed=modes.condensed,
        )
        for link, model, modes in zip(links, reduction.models, reduction.links, strict=True)
    ]


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


def stretching_links(engine: Engine, modes: int, detail: float) -> tuple[Topology, list[RunLink]]:
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
    Topology
        Whose moving rigid links are elastic bars.
    list of RunLink
    """
    topology, links = natural_links(engine)
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
        links = _in_modes(links, reduction)
    else:
        engine.check_runs()
    return topology, [
        with_turning_sections(engine, topology, *numbered) for numbered in enumerate(links)
    ]


def prestressed_links(
    engine: Engine, drive: Drive, prestress: Prestress, modes: int, detail: float
) -> list[RunLink]:
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
    list of RunLink
    """
    if not is_reduced(engine):
        return unreduced_links(engine)
    motion = drive.motion(engine.mechanism.linkage, drive.passing_times)
    return _in_modes(
        list(map(RunLink.of, engine.links)),
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
