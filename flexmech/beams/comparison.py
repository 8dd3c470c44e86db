"""Comparison of beam theories by the frequencies of a linkage at rest."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
import scipy.linalg

from flexmech.arrays import FloatArray
from flexmech.beams.elements import BEAM_SHAPES
from flexmech.beams.link_matrices import build_chain
from flexmech.beams.plane_link import compression_frequency, plane_link
from flexmech.beams.restrained_ends import restrained_beam
from flexmech.choices import ELEMENTS_A_LINK, MODES
from flexmech.errors import InputError
from flexmech.linear_system import (
    ELASTICITY,
    RESTRAINED_ENDS,
    Connectors,
    LinkFrames,
    LinkModel,
    RotationTerms,
    TheoryComparison,
    component_modes,
    inverse_mass_root,
    rigid_link,
)
from flexmech.linkages import (
    JointSpring,
    LinkEnd,
    LinkMass,
    RigidMotion,
    Spring,
    Topology,
    picture_crank_angle,
)
from flexmech.linkages.applied_forces import SpringLine
from flexmech.mechanism import Mechanism
from flexmech.sections import BeamSection, DampingTimes
from flexmech.threads import one_thread

# Theories differ by the wavelength of a mode, hardly by the crank angle.
ANGLES = np.radians(np.arange(0.0, 360.0, 60.0))
FINEST = "zigzag"
# Of slender links these two are all that is compared.
SIMPLEST = ("euler", "timoshenko")
# Of the frequency at which the layers of a link are compressed: lower modes of sandwiches were
# all within 1 % of two-dimensional elasticity.
STIFF_THROUGH = 0.05


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
        Of the theories in :data:`flexmech.beams.BEAM_SHAPES`, and of two-dimensional elasticity
        for those links whose layers are compressed at such frequencies; and of links of off-axis
        plies whose ends joints restrain.
    """
    links, counted = _links_of(mechanism), max(modes, MODES)
    return TheoryComparison(
        lambda theory: _frequencies(links, theory, counted)[:, :modes],
        mechanism.is_eccentric,
        lambda: float(_changes_by_shear(links, counted)[:, :modes].max()),
    )


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
    motion = _configurations(mechanism)
    return _Links(
        topology,
        sections,
        mechanism.link_masses_in_order,
        tuple(map(tuple, motion.angle.tolist())),
        tuple(tuple(map(tuple, places)) for places in motion.origin.tolist()),
        mechanism.springs,
        mechanism.joint_springs,
        mechanism,
    )


@dataclass(frozen=True)
class _Links:
    """Data on which frequencies at rest depend, as a key of the cache.

    The mechanism is that whose springs these are.
    """

    topology: Topology
    sections: tuple[BeamSection | None, ...]
    masses: tuple[LinkMass, ...]
    angles: tuple[tuple[float, ...], ...]
    origins: tuple[tuple[tuple[float, ...], ...], ...]
    springs: tuple[Spring, ...]
    joint_springs: tuple[JointSpring, ...]
    mechanism: Mechanism = field(compare=False)

    @property
    def motion(self) -> RigidMotion:
        """The linkage at rest."""
        angle, places = np.array(self.angles), np.array(self.origins)
        still, nowhere = np.zeros(angle.shape), np.zeros((*angle.shape, 2))
        return RigidMotion(still[:, 0], still[:, 0], angle, still, still, places, nowhere, nowhere)

    @property
    def is_reducible(self) -> bool:
        """Whether component modes are right to 1e-5: elastic links with mass, without springs."""
        sprung = self.springs or self.joint_springs or None in self.sections
        return not sprung and all(mass.mass_per_length for mass in self.masses)

    def spring_places(self, link: int) -> tuple[float, ...]:
        """Places along a link, from its start, at which springs between points act."""
        name = self.topology.link_names[link]
        ends = (end for spring in self.springs for end in (spring.first, spring.second))
        return tuple(end.x for end in ends if end.link == name)


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


@lru_cache(maxsize=1024)
def _frequencies(links: _Links, theory: str, modes: int) -> FloatArray:
    """Natural frequencies in Hz of the lowest modes that there are, (A, modes)."""
    if theory == ELASTICITY:
        highest = float(_frequencies(links, FINEST, modes).max())
        compressed = [_is_compressed(*each, highest) for each in _flexible(links)]
        if not any(compressed):
            return _frequencies(links, FINEST, modes)
    else:
        compressed = [False] * len(links.sections)
    chains = [
        _plane(links, number, modes) if plane else _beam(links, number, theory, modes)
        for number, plane in enumerate(compressed)
    ]
    motion, still = links.motion, RotationTerms.all_or_none(False)
    frames = LinkFrames(links.topology, chains)
    if theory in SIMPLEST and links.is_reducible:
        frames = component_modes(links.topology, chains, modes, 0.0, couples_axially=False).frames
    system = frames.assemble(motion, [link.stiffness for link in frames.links], still)
    if links.springs or links.joint_springs:
        system = Connectors(links.mechanism, chains).added(frames, motion, system, still, "none")
    with one_thread():
        squares = [
            scipy.linalg.eigh(k, m, eigvals_only=True, subset_by_index=(0, min(modes, len(k)) - 1))
            for k, m in zip(system.stiffness, system.mass, strict=True)
        ]
    return np.asarray(np.sqrt(np.abs(np.stack(squares))) / (2 * np.pi))


@lru_cache(maxsize=1024)
def _changes_by_shear(links: _Links, modes: int) -> FloatArray:
    """Relative changes of frequencies by shear and rotary inertia, to first order, (A, modes).

    Of the modes of Euler-Bernoulli beams ``(EI v''')^2 / kGA`` is what shear takes of the strain
    energy, and ``rho I v'^2`` what the rotation of sections adds to the kinetic energy. Infinite
    where links are not reducible.
    """
    if not links.is_reducible:
        return np.full((1, modes), np.inf)
    models = [_beam(links, number, "euler", modes) for number in range(len(links.sections))]
    reduced = component_modes(links.topology, models, modes, 0.0, couples_axially=False)
    motion, frames, still = links.motion, reduced.frames, RotationTerms.all_or_none(False)
    system = frames.assemble(motion, [link.stiffness for link in frames.links], still)
    lower = inverse_mass_root(system.mass)
    across = np.swapaxes(lower, 1, 2)
    with one_thread():
        squares, vectors = np.linalg.eigh(lower @ system.stiffness @ across)
    squares, vectors = squares[:, :modes], across @ vectors[:, :, :modes]
    amplitudes = frames.link_coordinates(motion, vectors)
    found = np.zeros(squares.shape)
    for number, (section, mass) in enumerate(_flexible(links)):
        assert section is not None
        own = section.shearing_over(mass.length)
        nodal = (reduced.links[number].basis @ amplitudes[number]).reshape(
            len(vectors), -1, 3, vectors.shape[2]
        )
        v, turn = nodal[:, :, 1], nodal[:, :, 2]
        h = np.diff(models[number].readings.nodes)[:, None]
        start, end = turn[:, :-1], turn[:, 1:]
        third = 12 * ((start + end) / 2 - np.diff(v, axis=1) / h) / h**2
        shear = (h * (own.bending_stiffness * third) ** 2).sum(axis=1) / own.shear_stiffness
        found += shear / squares + own.rotary_inertia * (h * (start**2 + end**2) / 2).sum(axis=1)
    return found / 2


def _flexible(links: _Links) -> list[tuple[BeamSection | None, LinkMass]]:
    return list(zip(links.sections, links.masses, strict=True))


def _is_compressed(section: BeamSection | None, mass: LinkMass, highest: float) -> bool:
    """Whether frequencies in Hz come near to the one at which a link's layers are compressed."""
    if section is None or section.layers is None or not mass.mass_per_length:
        return False
    return highest > STIFF_THROUGH * compression_frequency(section.layers.smeared)


def _plane(links: _Links, number: int, modes: int) -> LinkModel:
    """One link in two-dimensional elasticity."""
    section, mass = links.sections[number], links.masses[number]
    assert section is not None
    assert section.layers is not None
    name = links.topology.link_names[number]
    ends = (LinkEnd(name, "start"), LinkEnd(name, "end"))
    joined = [end in links.topology.joined_ends for end in ends]
    return plane_link(
        name, section.layers.smeared, mass, joined, modes, links.spring_places(number)
    )


def _beam(links: _Links, number: int, theory: str, modes: int) -> LinkModel:
    """One link of beam elements, or a rigid one."""
    name, section, mass = links.topology.link_names[number], *_flexible(links)[number]
    if section is None:
        return rigid_link(name, mass)
    elements = _elements(modes)
    if theory == RESTRAINED_ENDS:
        own, ends = restrained_beam(links.mechanism, name)
        chain = build_chain(name, own, mass, elements, BEAM_SHAPES["timoshenko"])
        return chain.model if ends is None else ends.restrain(chain, mass.mass_per_length).model
    shapes = BEAM_SHAPES[FINEST if theory == ELASTICITY else theory]
    return build_chain(name, section, mass, elements, shapes).model
