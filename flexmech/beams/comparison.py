"""Frequencies of a linkage at rest by several beam theories, to see which of them it needs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import scipy.linalg

from flexmech.beams.link_matrices import build_chain
from flexmech.beams.theories import BEAM_SHAPES
from flexmech.choices import MODES
from flexmech.errors import InputError
from flexmech.linear_system import LinkFrames, RotationTerms, TheoryComparison, rigid_link
from flexmech.linkages import Linkage, LinkMass, RigidMotion, Topology, shown_crank_angle
from flexmech.mechanism import Mechanism
from flexmech.sections import BeamSection, DampingTimes
from flexmech.threads import one_thread
from flexmech.types import FloatArray

__all__ = ["compare_theories"]

# Theories differ by the wavelength of a mode, hardly by the crank angle.
ANGLES = np.radians(np.arange(0.0, 360.0, 60.0))
LEAST_ELEMENTS = 8


def compare_theories(mechanism: Mechanism, modes: int = MODES) -> TheoryComparison:
    """Hold beam theories against each other on one linkage at rest.

    Parameters
    ----------
    mechanism : Mechanism
    modes : int
        How many of the lowest natural frequencies count.

    Returns
    -------
    TheoryComparison
        Of the theories in :data:`flexmech.beams.BEAM_SHAPES`.
    """
    topology = mechanism.linkage.topology
    # Damping, free strains and what a section is called do not matter to frequencies at rest.
    sections = tuple(
        None
        if link.rigid
        else replace(
            mechanism.sections[link.name],
            damping=DampingTimes(),
            specific_damping=None,
            damping_frequency=None,
            free_strain=0.0,
            free_curvature=0.0,
        )
        for link in topology.links
    )
    motion = _configurations(mechanism.linkage)
    angles = tuple(map(tuple, motion.angle.tolist()))
    origins = tuple(tuple(map(tuple, places)) for places in motion.origin.tolist())
    links = _Links(topology, sections, mechanism.link_masses_in_order, angles, origins)
    counted = max(modes, MODES)
    return TheoryComparison(
        lambda theory: _frequencies(links, theory, counted)[:, :modes], mechanism.is_eccentric
    )


@dataclass(frozen=True)
class _Links:
    """What frequencies at rest depend on, and nothing else."""

    topology: Topology
    sections: tuple[BeamSection | None, ...]
    masses: tuple[LinkMass, ...]
    angles: tuple[tuple[float, ...], ...]
    origins: tuple[tuple[tuple[float, ...], ...], ...]


def _configurations(linkage: Linkage) -> RigidMotion:
    """The linkage at rest at those crank angles that it can stand at."""
    try:
        return linkage.motion(ANGLES)
    except InputError:  # it does not turn fully
        possible = []
    for angle in ANGLES:
        try:
            linkage.motion(angle)
        except InputError:
            continue
        possible.append(angle)
    return linkage.motion(np.array(possible or [shown_crank_angle(linkage)]))


@lru_cache(maxsize=256)
def _frequencies(links: _Links, theory: str, modes: int) -> FloatArray:
    """Natural frequencies in Hz of the lowest modes that there are, (A, modes)."""
    elements = max(LEAST_ELEMENTS, 2 * modes)
    names = links.topology.link_names
    chains = [
        rigid_link(name, mass)
        if section is None
        else build_chain(name, section, mass, elements, BEAM_SHAPES[theory]).model
        for name, section, mass in zip(names, links.sections, links.masses, strict=True)
    ]
    angle = np.array(links.angles)
    still, nowhere = np.zeros(angle.shape), np.zeros((*angle.shape, 2))
    places = np.array(links.origins)
    motion = RigidMotion(still[:, 0], still[:, 0], angle, still, still, places, nowhere, nowhere)
    frames = LinkFrames(links.topology, chains)
    stiffness = [chain.stiffness for chain in chains]
    system = frames.assemble(motion, stiffness, RotationTerms.all_or_none(False))
    with one_thread():
        squares = [
            scipy.linalg.eigh(k, m, eigvals_only=True, subset_by_index=(0, min(modes, len(k)) - 1))
            for k, m in zip(system.stiffness, system.mass, strict=True)
        ]
    return np.asarray(np.sqrt(np.abs(np.stack(squares))) / (2 * np.pi))
