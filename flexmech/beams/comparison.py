"""Comparison of beam theories by the frequencies of a linkage at rest."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
import scipy.linalg

from flexmech.arrays import FloatArray, IntArray
from flexmech.beams.elements import BEAM_SHAPES
from flexmech.beams.link_matrices import build_chain, stack_chains
from flexmech.beams.restrained_ends import restrained_beam
from flexmech.choices import ELEMENTS_A_LINK, MODES
from flexmech.errors import InputError
from flexmech.linear_system import (
    MOST_STACKED,
    RESTRAINED_ENDS,
    Connectors,
    LinkFrames,
    LinkModel,
    RotationTerms,
    TheoryComparison,
    among_alike,
    component_modes,
    rigid_link,
)
from flexmech.linkages import (
    LinkMass,
    RigidMotion,
    Topology,
    connections,
    picture_crank_angle,
)
from flexmech.linkages.applied_forces import SpringLine
from flexmech.materials import solid_stiffness
from flexmech.mechanism import Mechanism
from flexmech.sections import BeamSection, DampingTimes, LaminateSection
from flexmech.sections.solid_section import SLOPES, VALUES, Parabolas, rows_of_runs
from flexmech.threads import one_thread

# Theories differ by the wavelength of a mode, hardly by the crank angle.
ANGLES = np.radians(np.arange(0.0, 360.0, 60.0))
# Of slender links these two are all that is compared.
SIMPLEST = ("euler", "timoshenko")
# Designs whose links are in memory at a time. Memory and speed alone.
AT_ONCE = 32
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
        Of the theories in :data:`flexmech.beams.BEAM_SHAPES`, and of links of off-axis plies whose
        ends joints restrain.
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
        own = solid[1, 1]
        if section.reduction != "wide":
            coupling = solid[ACROSS, 1]
            own = own - coupling @ np.linalg.solve(solid[np.ix_(ACROSS, ACROSS)], coupling)
        modulus.append(own)
    line, density = Parabolas(faces), np.array([layer.ply.density for layer in layers])
    squares = scipy.linalg.eigh(
        line.integral(SLOPES, np.repeat(modulus, count)).toarray(),
        line.integral(VALUES, np.repeat(density, count)).toarray(),
        eigvals_only=True,
    )
    return float(np.sqrt(squares[1]) / (2 * np.pi))


def _links_of(mechanism: Mechanism) -> _Links:
    """What frequencies of a mechanism at rest depend on."""
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
    def likeness(self) -> Hashable | None:
        """What several must have in common to be computed at once; None of one by itself."""
        if self.springs or None in self.sections:
            return None
        if any(section is not None and section.is_eccentric for section in self.sections):
            return None
        if any(mass.bodies or not mass.mass_per_length for mass in self.masses):
            return None
        points = tuple(len(mass.point_masses) for mass in self.masses)
        return connections(self.mechanism.linkage), points, len(self.motion.crank_angle)


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


def prepare_comparisons(mechanisms: Sequence[Mechanism], modes: int = MODES) -> None:
    """Find what :func:`compare_theories` needs first of many mechanisms, those alike at once.

    Parameters
    ----------
    mechanisms : sequence of Mechanism
    modes : int
        As there.
    """
    _PREPARED.clear()
    alike: dict[Hashable, list[_Links]] = {}
    for mechanism in mechanisms:
        links = _links_of(mechanism)
        if (likeness := links.likeness) is not None:
            alike.setdefault(likeness, []).append(links)
    counted = max(modes, MODES)
    if _elements(counted) > MOST_STACKED:
        return
    for own in alike.values():
        for theory in SIMPLEST:

            def frequencies(numbers: IntArray) -> Sequence[FloatArray]:
                some = [own[number] for number in numbers]  # noqa: B023
                return [*_of_stack(some, theory, counted)]  # noqa: B023

            for first in range(0, len(own), AT_ONCE):
                numbers = np.arange(first, min(first + AT_ONCE, len(own)))
                for number, found in zip(numbers, among_alike(numbers, frequencies), strict=True):
                    _PREPARED[own[number], theory, counted] = found


def _elements(modes: int) -> int:
    """Elements of a link for so many modes."""
    return max(ELEMENTS_A_LINK, 2 * modes)


# Frequencies that are found beforehand, until they are asked for.
_PREPARED: dict[tuple[_Links, str, int], FloatArray] = {}


def _of_stack(designs: Sequence[_Links], theory: str, modes: int) -> FloatArray:
    """Natural frequencies in Hz of D designs of one likeness by a simple theory, (D, A, modes).

    Links are reduced to component modes, which are right to 1e-5 or so.
    """
    names = designs[0].topology.link_names
    shapes, elements = BEAM_SHAPES[theory], _elements(modes)
    models = []
    for number, name in enumerate(names):
        sections = [links.sections[number] for links in designs]
        masses = [links.masses[number] for links in designs]
        own = [section for section in sections if section is not None]
        models.append(stack_chains(name, own, masses, elements, shapes).model)
    reduction = component_modes(
        designs[0].topology, models, modes, np.zeros(len(designs)), couples_axially=False
    )
    motion = RigidMotion.of_designs([links.motion for links in designs])
    still = RotationTerms.all_or_none(False)
    stiffness = [link.stiffness for link in reduction.models]
    system = reduction.frames.assemble(motion, stiffness, still)
    with one_thread():
        lower = np.linalg.inv(np.linalg.cholesky(system.mass))
        squares = np.linalg.eigvalsh(lower @ system.stiffness @ np.swapaxes(lower, 1, 2))
    found = np.sqrt(np.abs(squares[:, :modes])) / (2 * np.pi)
    return np.asarray(found.reshape(len(designs), -1, found.shape[1]))


@lru_cache(maxsize=1024)
def _frequencies(links: _Links, theory: str, modes: int) -> FloatArray:
    """Natural frequencies in Hz of the lowest modes that there are, (A, modes)."""
    if (prepared := _PREPARED.pop((links, theory, modes), None)) is not None:
        return prepared
    if theory in SIMPLEST and links.likeness is not None and _elements(modes) <= MOST_STACKED:
        return np.asarray(_of_stack([links], theory, modes)[0])
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
    section, mass = links.sections[number], links.masses[number]
    if section is None:
        return rigid_link(name, mass)
    elements = _elements(modes)
    if theory == RESTRAINED_ENDS:
        own, ends = restrained_beam(links.mechanism, name)
        chain = build_chain(name, own, mass, elements, BEAM_SHAPES["timoshenko"])
        return chain.model if ends is None else ends.restrain(chain, mass.mass_per_length).model
    return build_chain(name, section, mass, elements, BEAM_SHAPES[theory]).model
