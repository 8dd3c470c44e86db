"""Comparison of beam theories by the frequencies of a linkage at rest."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
import scipy.linalg

from flexmech.arrays import FloatArray
from flexmech.choices import ELEMENTS_A_LINK, MODES
from flexmech.errors import InputError
from flexmech.linkages import (
    LinkMass,
    RigidMotion,
    Topology,
    picture_crank_angle,
)
from flexmech.linkages.applied_forces import SpringLine
from flexmech.materials import solid_stiffness
from flexmech.mechanics import (
    RESTRAINED_ENDS,
    Connectors,
    LinkFrames,
    LinkModel,
    RotationTerms,
    TheoryComparison,
    component_modes,
    rigid_link,
)
from flexmech.mechanics.beams.elements import BEAM_SHAPES, build_chain
from flexmech.mechanics.beams.restrained_ends import restrained_beam
from flexmech.mechanism import Mechanism
from flexmech.mesh import node_positions
from flexmech.sections import BeamSection, LaminateSection
from flexmech.sections.solid_section import SLOPES, VALUES, Parabolas, rows_of_runs
from flexmech.threads import one_thread

# Theories differ by the wavelength of a mode, hardly by the crank angle.
ANGLES = np.radians(np.arange(0.0, 360.0, 60.0))
# Slender links compare these two alone.
SIMPLEST = ("euler", "timoshenko")
# Elements of a link from which on component modes are not faster. Speed alone.
MOST_REDUCED = 16
# Rows of elements over the thickness of a link.
ROWS = 4
# Strains z, yz and xz, which no load of the plane keeps from a narrow layer.
ACROSS = np.array([2, 3, 4])


def compare_theories(mechanism: Mechanism, modes: int = MODES) -> TheoryComparison:
    """Compare beam theories on one linkage at rest.

    Parameters
    ----------
    mechanism : Mechanism
    modes : int
        How many of the lowest natural frequencies count.

    Returns
    -------
    TheoryComparison
        Frequencies by the theories in :data:`flexmech.mechanics.beams.BEAM_SHAPES`, and of links of
        off-axis plies whose ends joints restrain.
    """
    links, counted = _links_of(mechanism), max(modes, MODES)

    def compression() -> float:
        layered = (
            section.layers.smeared
            for section, mass in zip(links.sections, links.masses, strict=True)
            if section is not None and section.layers is not None and mass.mass_per_length
        )
        return min(map(compression_frequency, layered), default=np.inf)

    return TheoryComparison(
        lambda theory: _frequencies(links, theory, counted)[:, :modes],
        mechanism.is_eccentric,
        compression,
        lambda: _softening(links, modes, counted),
    )


def compression_frequency(section: LaminateSection) -> float:
    """Lowest thickness-stretch frequency of a wide layered plate in Hz.

    Its faces stay parallel: the layers are rods through the thickness. Beams know none of it.

    Parameters
    ----------
    section : LaminateSection

    Returns
    -------
    float
    """
    layers = section.laminate.layers
    faces, count = rows_of_runs(section.laminate.boundaries, ROWS)
    modulus = []
    for solid in map(solid_stiffness, layers):
        stiffness = solid[1, 1]
        if section.reduction != "wide":
            coupling = solid[ACROSS, 1]
            stiffness = stiffness - coupling @ np.linalg.solve(
                solid[np.ix_(ACROSS, ACROSS)], coupling
            )
        modulus.append(stiffness)
    line, density = Parabolas(faces), np.array([layer.ply.density for layer in layers])
    squares = scipy.linalg.eigh(
        line.integral(SLOPES, np.repeat(modulus, count)).toarray(),
        line.integral(VALUES, np.repeat(density, count)).toarray(),
        eigvals_only=True,
    )
    return float(np.sqrt(squares[1]) / (2 * np.pi))


def _links_of(mechanism: Mechanism) -> _Links:
    """Data that frequencies of a mechanism at rest depend on."""
    topology = mechanism.linkage.topology
    sections = tuple(
        None if link.rigid else mechanism.sections[link.name] for link in topology.links
    )
    motion, springs = _configurations(mechanism), (mechanism.springs, mechanism.joint_springs)
    positions = motion.angle.tobytes(), motion.origin.tobytes()
    key = topology, *positions, *springs
    return _Links(sections, mechanism.link_masses_in_order, key, mechanism, motion)


@dataclass(frozen=True)
class _Links:
    """Links of a mechanism at rest; equal ones have the same frequencies.

    Those depend on the sections, masses and what else the key has.
    """

    sections: tuple[BeamSection | None, ...]
    masses: tuple[LinkMass, ...]
    key: Hashable
    mechanism: Mechanism = field(compare=False)
    motion: RigidMotion = field(compare=False)

    @property
    def topology(self) -> Topology:
        return self.mechanism.linkage.topology

    @property
    def springs(self) -> bool:
        """Whether springs act on the links."""
        return bool(self.mechanism.springs or self.mechanism.joint_springs)

    @property
    def simple(self) -> bool:
        """Whether all links bend about the pins' axis, with no springs and no bodies on them."""
        return not self.springs and all(
            section is not None
            and not section.is_eccentric
            and mass.mass_per_length > 0
            and not mass.bodies
            for section, mass in zip(self.sections, self.masses, strict=True)
        )


def _configurations(mechanism: Mechanism) -> RigidMotion:
    """The linkage at rest at crank angles at which it can be assembled."""
    try:
        return _at_rest(mechanism, ANGLES)
    except InputError:  # it does not turn fully
        possible = []
    for angle in ANGLES:
        try:
            _at_rest(mechanism, np.array([angle]))
        except InputError:
            continue
        possible.append(angle)
    linkage = mechanism.linkage
    return linkage.motion(np.array(possible or [picture_crank_angle(linkage)]))


def _at_rest(mechanism: Mechanism, crank_angle: FloatArray) -> RigidMotion:
    """The linkage at rest at crank angles; InputError where a spring has no direction."""
    motion, topology = mechanism.linkage.motion(crank_angle), mechanism.linkage.topology
    for spring in mechanism.springs:
        SpringLine.of(spring, topology, motion)
    return motion


def _elements(modes: int) -> int:
    """Elements of a link for so many modes."""
    return max(ELEMENTS_A_LINK, 2 * modes)


@lru_cache(maxsize=64)
def _reduced(links: _Links, theory: str, modes: int) -> tuple[FloatArray, list[FloatArray]]:
    """Frequencies in Hz by component modes, right to 1e-5 or so, and shapes of unit mass.

    Shapes are by the coordinates of each link, (A, n_link, modes).
    """
    models = [_beam(links, number, theory, modes) for number in range(len(links.sections))]
    reduction = component_modes(links.topology, models, modes, 0.0, couples_axially=False)
    still = RotationTerms.all_or_none(False)
    frames, stiffness = reduction.frames, [link.stiffness for link in reduction.models]
    system = frames.assemble(links.motion, stiffness, still)
    with one_thread():
        lower = np.linalg.inv(np.linalg.cholesky(system.mass))
        across = np.swapaxes(lower, 1, 2)
        squares, vectors = np.linalg.eigh(lower @ system.stiffness @ across)
    ends = frames.link_coordinates(links.motion, across @ vectors[..., :modes])
    shapes = [
        link.basis @ ends_of_link for link, ends_of_link in zip(reduction.links, ends, strict=True)
    ]
    return np.asarray(np.sqrt(np.abs(squares[:, :modes])) / (2 * np.pi)), shapes


def _softening(links: _Links, modes: int, counted: int) -> float:
    """Relative change of frequencies by shear and rotary inertia, to first order (Timoshenko 1921).

    Half the energies of the shear force ``V = EI v'''`` and of the rotation that Euler-Bernoulli
    beams have none of, over that of the mode. It is the greatest of the lowest modes; infinite
    where links are not simple.
    """
    if not _is_reduced(links, counted):
        return np.inf
    frequency, shapes = _reduced(links, "euler", counted)
    square, change = (2 * np.pi * frequency[:, :modes]) ** 2, np.zeros(())
    for section, mass, shape in zip(links.sections, links.masses, shapes, strict=True):
        assert section is not None
        nodes = node_positions(mass.length, _elements(counted), mass.point_positions)
        length = np.diff(nodes)[:, None]
        across, turn = (
            shape.reshape(len(shape), len(nodes), 3, -1)[:, :, n, :modes] for n in (1, 2)
        )
        chord = (across[:, 1:] - across[:, :-1]) / length
        force = 6 * section.bending_stiffness * (turn[:, 1:] + turn[:, :-1] - 2 * chord) / length**2
        rotation = (turn[:, 1:] ** 2 + turn[:, :-1] ** 2) / 2
        change = change + (length * force**2).sum(axis=1) / section.shear_stiffness / square
        change = change + mass.rotary_inertia * (length * rotation).sum(axis=1)
    return float(change.max()) / 2


def _is_reduced(links: _Links, modes: int) -> bool:
    """Whether the simplest theories are compared by component modes."""
    return links.simple and _elements(modes) <= MOST_REDUCED


@lru_cache(maxsize=1024)
def _frequencies(links: _Links, theory: str, modes: int) -> FloatArray:
    """Natural frequencies in Hz of the lowest modes that there are, (A, modes)."""
    if theory in SIMPLEST and _is_reduced(links, modes):
        return _reduced(links, theory, modes)[0]
    chains = [_beam(links, number, theory, modes) for number in range(len(links.sections))]
    motion, still = links.motion, RotationTerms.all_or_none(False)
    frames = LinkFrames(links.topology, chains)
    system = frames.assemble(motion, [chain.stiffness for chain in chains], still)
    if links.springs:
        system = Connectors(links.mechanism, chains).added(frames, motion, system, still, "none")
    with one_thread():
        squares = [
            scipy.linalg.eigh(k, m, eigvals_only=True, subset_by_index=(0, min(modes, len(k)) - 1))
            for k, m in zip(system.stiffness, system.mass, strict=True)
        ]
    return np.asarray(np.sqrt(np.abs(np.stack(squares))) / (2 * np.pi))


def _beam(links: _Links, number: int, theory: str, modes: int) -> LinkModel:
    """One link of beam elements, or a rigid one."""
    name = links.topology.link_names[number]
    mass = links.masses[number]
    section, elements = links.sections[number], _elements(modes)
    if section is None:
        return rigid_link(name, mass)
    if theory == RESTRAINED_ENDS:
        beam, ends = restrained_beam(links.mechanism, name)
        chain = build_chain(name, beam, mass, elements, BEAM_SHAPES["timoshenko"])
        return chain.model if ends is None else ends.restrain(chain, mass.mass_per_length).model
    # In the words of an engine without loads, which then has the chain at no cost.
    return build_chain(name, section, mass, elements, BEAM_SHAPES[theory], ()).model
