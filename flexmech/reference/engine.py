"""Reference engine: plane beam elements of four theories on NumPy and SciPy alone.

In runs its links stretch by the square of their slopes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import ClassVar

import numpy as np
import scipy.linalg

from flexmech.arrays import SAME_PLACE, FloatArray
from flexmech.choices import ELEMENTS, MASSES, MassChoice
from flexmech.linkages import LinkMass, RigidMotion
from flexmech.linkages.inverse_dynamics import LinkForces
from flexmech.linkages.motion import direction
from flexmech.mechanics import (
    DeadMoments,
    Engine,
    LinkModel,
    LinkStretch,
    StressedLinks,
    TheoryComparison,
    chain_matrix,
    rigid_link,
)
from flexmech.mechanics.beams.comparison import compare_theories
from flexmech.mechanics.beams.elements import BEAM_SHAPES, BeamElements, Chain, build_chain
from flexmech.mechanics.beams.restrained_ends import restrained_beam
from flexmech.mechanism import Mechanism
from flexmech.reference.equilibrium import Equilibrium, ForceBalance

# Directions in which an element's slopes are none but for round-off, to the greatest.
_NO_SLOPE = 1e-12
# Ways of an element to move without bending, to the stiffest: round-off.
_NO_BENDING = 1e-10


def chain_stretch(chain: Chain, *, turns_far: bool = False) -> LinkStretch:
    """Mean axial strain of each element of a link, to second order about the straight link.

    The strain of a corotational element (:mod:`flexmech.reference.corotational`) for small
    turns: the elongation of the chord and half the mean of the squared slope. That mean is a
    weighted sum of the squares of some slopes.

    Parameters
    ----------
    chain : Chain
    turns_far : bool
        Whether the link turns so far against its frame that bending must not depend on it.

    Returns
    -------
    LinkStretch
    """
    elements, to_neutral = chain.elements, chain.elements.to_neutral_axis
    values, directions = _squares(elements.arch, elements.arch)
    kept = np.abs(values) > _NO_SLOPE * np.abs(values).max(axis=1, keepdims=True)
    stiffness = float(elements.neutral_stiffness[0, 0, 0] * elements.length[0])
    scale = np.sqrt(stiffness * elements.length)
    number = np.nonzero(kept)[0]
    weights = np.zeros((len(kept), len(number)))
    weights[number, np.arange(len(number))] = (scale[:, None] * values)[kept]
    axis = sum(elements.shapes.arms(elements.section))
    # Two arms of a symmetric section leave their round-off.
    axis *= abs(axis) > SAME_PLACE * chain.nodes[-1]
    axial = LinkStretch(
        scale[:, None] * _elongations(elements),
        _of_link(directions @ to_neutral)[kept],
        weights,
        np.full(len(kept), elements.section.damping.axial),
        neutral_axis=float(axis),
    )
    return _with_bending(chain, axial) if turns_far else axial


def _with_bending(chain: Chain, axial: LinkStretch) -> LinkStretch:
    """Strains of a chain with large rotation against its frame.

    Where an element's chord is at the angle beta, its ends turn against it by the difference of
    their sines over ``cos(beta)``, which to second order is less than one by what the chord is
    shorter along the frame. A product is a difference of squares:
    ``4 b u = (b + u)^2 - (b - u)^2``.
    """
    elements, longer = chain.elements, _longer(chain.elements)
    stretching = elements.neutral_stiffness @ longer
    bending = elements.neutral_stiffness - stretching[..., None] * longer / 2
    values, directions = _squares(bending, elements.neutral_stiffness)
    kept = values > _NO_BENDING * values.max(axis=1, keepdims=True)
    root = np.sqrt(values[kept])[:, None]
    bent = _of_link(directions @ elements.to_neutral_axis)[kept]
    stretched = _elongations(elements)[np.nonzero(kept)[0]]
    slopes = np.stack([bent + stretched, bent - stretched], axis=1)
    # Curvature damps all bending, and is alone of the second order.
    time = np.full(len(root), elements.section.damping.bending)
    return replace(
        axial,
        gradient=np.concatenate([axial.gradient, root * bent]),
        slopes=np.concatenate([axial.slopes, slopes.reshape(-1, bent.shape[1])]),
        weights=scipy.linalg.block_diag(axial.weights, np.kron(np.diag(root[:, 0]), [-0.5, 0.5])),
        damping_time=np.append(axial.damping_time, time),
    )


def _longer(elements: BeamElements) -> FloatArray:
    """Elongation of an element by its nodes' coordinates, (2 p,)."""
    longer = np.zeros(2 * elements.shapes.per_node)
    longer[[0, elements.shapes.per_node]] = -1.0, 1.0
    return longer


def _elongations(elements: BeamElements) -> FloatArray:
    """Strain of each element by its nodes' displacements along the link, (e, n)."""
    strain = _longer(elements) @ elements.to_neutral_axis / elements.length[:, None]
    return _of_link(strain[:, None])[:, 0]


def _of_link(rows: FloatArray) -> FloatArray:
    """Rows (e, k, 2 p) by the coordinates of elements as rows (e, k, n) by those of the link."""
    count, kinds, both = rows.shape
    total = np.zeros((count, kinds, both // 2 * (count + 1)))
    for number in range(count):
        first = both // 2 * number
        total[number, :, first : first + both] = rows[number]
    return total


def _squares(matrices: FloatArray, alike: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Quadratic forms as sums of weighted squares, whatever the units of the coordinates.

    Parameters
    ----------
    matrices : ndarray, shape (..., n, n)
        Symmetric.
    alike : ndarray, shape (..., n, n)
        Whose diagonal tells how large each coordinate's entries are.

    Returns
    -------
    ndarray, shape (..., n)
        Weights, ascending.
    ndarray, shape (..., n, n)
        A row for each weight, whose product with the coordinates is squared.
    """
    size = np.sqrt(np.abs(np.diagonal(alike, axis1=-2, axis2=-1)))
    size = np.where(size > 0, size, 1.0)
    weights, vectors = np.linalg.eigh(matrices / (size[..., :, None] * size[..., None, :]))
    return weights, np.swapaxes(vectors, -1, -2) * size[..., None, :]


class ReferenceEngine(Engine):
    """Beam elements with consistent mass, in link frames.

    Elements: ``euler`` (Euler-Bernoulli, without rotary inertia), ``timoshenko`` (shear and
    rotary inertia), ``reddy`` (third-order shear; sections whose layers are known) and
    ``zigzag`` (cross-sections that warp as their layers ask for, as of sandwiches).

    Prestress levels: ``none``; ``axial`` (Turcic & Midha 1984: tension of each element
    from the linear static solution, geometric stiffness of Kumar & Chandrakar, eq. 1.58);
    ``equilibrium`` (corotational beams and Newton's method). Mass: distributed, or ``lumped``
    as Kumar & Chandrakar's twelve masses (their Figure 1.5). Parameters as for
    :class:`flexmech.mechanics.Engine`.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> engine = flexmech.ReferenceEngine(mechanism, elements=8)
    >>> engine.with_(element="timoshenko").element
    'timoshenko'
    """

    name: ClassVar[str] = "reference"
    element_kinds: ClassVar[tuple[str, ...]] = ELEMENTS["reference"]
    counterparts: ClassVar[dict[str, str]] = {
        "ancf": "euler",
        "geometrically-exact": "timoshenko",
    }
    masses: ClassVar[tuple[MassChoice, ...]] = MASSES
    restrains_ends: ClassVar[bool] = True
    theories: ClassVar[dict[str, str]] = {theory: theory for theory in BEAM_SHAPES}
    finer_elements: ClassVar[dict[str, str]] = {"euler": "timoshenko", "timoshenko": "zigzag"}

    @classmethod
    def compare_theories(cls, mechanism: Mechanism, modes: int) -> TheoryComparison:
        """See :meth:`Engine.compare_theories`."""
        return compare_theories(mechanism, modes)

    @cached_property
    def chains(self) -> dict[int, Chain]:
        """Links of beam elements by their number in the topology: all but rigid ones."""
        links = enumerate(self.mechanism.linkage.topology.links)
        return {number: self._chain(number, link.name) for number, link in links if not link.rigid}

    def _chain(self, number: int, name: str) -> Chain:
        """Beam elements of one flexible link."""
        mass, at = self._masses[number], tuple(self.mechanism.acting_at(name))
        section, restraint = restrained_beam(self.mechanism, name)
        shapes = BEAM_SHAPES[self.element]
        chain = build_chain(name, section, mass, self.elements, shapes, at)
        return chain if restraint is None else restraint.restrain(chain, mass.mass_per_length)

    @cached_property
    def _masses(self) -> tuple[LinkMass, ...]:
        masses = self.mechanism.link_masses_in_order
        if self._lumped is None:
            return masses
        return tuple(mass.lumped(n) for mass, n in zip(masses, self._lumped, strict=True))

    @cached_property
    def clamped_links(self) -> tuple[LinkModel, ...]:
        """Unreduced link models, coordinates (u, v, phi, ...) node by node."""
        return tuple(
            rigid_link(link.name, self._masses[number]) if link.rigid else self.chains[number].model
            for number, link in enumerate(self.mechanism.linkage.topology.links)
        )

    @cached_property
    def stretches(self) -> tuple[LinkStretch, ...] | None:
        """Second-order stretch of each link; see :attr:`Engine.stretches`."""
        if self.mechanism.is_free_strained:
            return None
        turns_far = self.free_shaft is not None and self.free_shaft.is_stiff
        return tuple(
            chain_stretch(self.chains[number], turns_far=turns_far)
            if number in self.chains
            else LinkStretch.none(link.size)
            for number, link in enumerate(self.clamped_links)
        )

    @property
    def nodes(self) -> list[FloatArray]:
        """Node positions of each link in m; the ends of a rigid one."""
        return [link.readings.nodes for link in self.clamped_links]

    @cached_property
    def balance(self) -> ForceBalance:
        """Forces and tangents of displaced links."""
        return ForceBalance(self.clamped_frames, self.chains, self.connectors)

    @cached_property
    def equilibrium(self) -> Equilibrium:
        """Solver for the quasi-static equilibrium on this mesh."""
        alone = not self.connectors.depend_on_displacement
        return Equilibrium(self.balance, stable_alone=alone)

    def _elastic_equilibrium(
        self,
        motion: RigidMotion,
        loads: Sequence[FloatArray],
        dead: DeadMoments,
        near: Sequence[FloatArray] | None,
    ) -> StressedLinks:
        varying = self._varying(motion)
        displacement = self.equilibrium.solve(motion, loads, varying, dead, near)
        return self._elastic(displacement, varying)

    def internal_forces(
        self, motion: RigidMotion, displacement: Sequence[FloatArray]
    ) -> list[FloatArray]:
        """See :meth:`Engine.internal_forces`."""
        return self.balance.response(displacement, self._varying(motion))[0]

    def running_links(
        self,
        motion: RigidMotion,
        displacement: Sequence[FloatArray],
        rate: Sequence[FloatArray] | None = None,
    ) -> StressedLinks:
        """Elastic stiffness, forces and damping; see :meth:`Engine.running_links`.

        The tension varies inside an element as the inertia forces of the rigid motion make it;
        what those of the elastic motion add inside it is left out, and falls with the square
        of the element length. Their mean is that of the state.
        """
        stressed = self._elastic(displacement, self._varying(motion))
        if rate is None or not self.has_damped_links:
            return stressed
        tangent = list(stressed.tangent)
        for number, change in self.balance.damping_stiffness(displacement, rate).items():
            tangent[number] = tangent[number] + change
        return replace(stressed, tangent=tangent)

    def _elastic(
        self, displacement: Sequence[FloatArray], varying: Sequence[FloatArray]
    ) -> StressedLinks:
        force, of_chains = self.balance.response(displacement, varying)
        tangent = [
            of_chains.get(number, np.zeros((*q.shape, q.shape[1])))
            for number, q in enumerate(displacement)
        ]
        return StressedLinks(tangent, list(displacement), force, self._damping(displacement))

    def _damping(self, displacement: Sequence[FloatArray]) -> list[FloatArray] | None:
        """Damping of displaced links, (B, n_link, n_link); None where none is damped."""
        if not self.has_damped_links:
            return None
        bent = self.balance.damping(displacement)
        return [bent.get(n, np.zeros((*q.shape, 3))) for n, q in enumerate(displacement)]

    def _tensioned(self, motion: RigidMotion, forces: LinkForces) -> dict[int, FloatArray]:
        """Tangents of the straight links; the tension varies inside elements."""
        tangent, gravity = {}, np.asarray(self.mechanism.gravity)
        for number, chain in self.chains.items():
            nodes, stiffness = chain.nodes, chain.model.stiffness
            tension = varying_tension(motion, number, chain, gravity)
            middle = forces.axial_force(number, (nodes[:-1] + nodes[1:]) / 2)
            tension[..., 0] = middle + tension[..., 2] / 2
            tangent[number] = stiffness + chain_matrix(chain.elements.geometric_stiffness(tension))
        return tangent

    def _varying(self, motion: RigidMotion) -> list[FloatArray]:
        """Geometric stiffness of each element, (e, r, r, B), by flexible link: its varying part.

        A corotational element has its mean tension; the varying part is that of the inertia
        forces inside it, by its relative coordinates.
        """
        gravity = np.asarray(self.mechanism.gravity)
        every = [
            chain.elements.geometric_stiffness(varying_tension(motion, number, chain, gravity))
            for number, chain in self.chains.items()
        ]
        pairs = zip(self.balance.links.values(), every, strict=True)
        return [link.by_relative(matrices) for link, matrices in pairs]


def varying_tension(
    motion: RigidMotion, link: int, chain: Chain, gravity: FloatArray
) -> FloatArray:
    """Tension inside elements against its mean, by the inertia of distributed mass and its weight.

    Point masses, bodies, loads and springs are at nodes: inside an element the tension has the
    slope ``rho A (p - omega^2 x - alpha y)``, p the acceleration of the link's start along it less
    gravity.

    Parameters
    ----------
    motion : RigidMotion
        Batch of shape (B,).
    link : int
        Number of the link.
    chain : Chain
    gravity : ndarray, shape (2,)
        In ground axes, m/s^2.

    Returns
    -------
    ndarray, shape (B, e, 3)
        Legendre coefficients along each element: mean (zero), linear, quadratic; in N.
    """
    line, nodes = chain.line_mass, chain.nodes
    length, middle = np.diff(nodes), (nodes[:-1] + nodes[1:]) / 2
    pull = motion.origin_acceleration[:, link] - gravity
    along = np.sum(pull * direction(motion.angle[:, link]), axis=-1)
    offset = chain.elements.section.mass_axis
    along = (along - motion.angular_acceleration[:, link] * offset)[:, None]
    square = motion.angular_velocity[:, link, None] ** 2
    linear = line * length / 2 * (along - square * middle)
    quadratic = -line * square * length**2 / 12
    return np.stack([np.zeros_like(linear), linear, quadratic], axis=-1)
