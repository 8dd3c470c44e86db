"""What an engine is, and all that two finite-element engines have in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal, Self

import numpy as np
from numpy.typing import ArrayLike

from flexmech.errors import InputError
from flexmech.linear_system.component_modes import ComponentModes, component_modes
from flexmech.linear_system.link_frames import LinkDamping, LinkFrames, RotationTerms
from flexmech.linear_system.link_model import LinkModel
from flexmech.linear_system.stressed_links import StressedLinks
from flexmech.linear_system.system import LinearSystem, condense
from flexmech.linkages import RigidMotion
from flexmech.mechanism import Mechanism
from flexmech.types import FloatArray

__all__ = ["PRESTRESS_LEVELS", "ConvergenceOrders", "Engine", "Prestress"]

Prestress = Literal["none", "axial", "equilibrium"]
PRESTRESS_LEVELS: tuple[Prestress, ...] = ("none", "axial", "equilibrium")
# Working memory of a batch; keeps what is alive at a time independent of the map's size.
BATCH_BYTES = 32_000_000


@dataclass(frozen=True)
class ConvergenceOrders:
    """Order in the element length of each part of a natural frequency's error.

    Parameters
    ----------
    elastic : int
        Of the unloaded linkage at rest.
    prestress : int
        Of the change by prestress.
    rotation : int
        Of the change by rotation terms. A pin's displacement turns with the leader's
        frame, the rest of the link with its own: a layer one element wide, so first order.
    """

    elastic: int
    prestress: int
    rotation: int = 1


class Engine(ABC):
    """Turns a mechanism and crank positions into a :class:`LinearSystem`.

    Parameters
    ----------
    mechanism : Mechanism
    elements : int
        Finite elements a link.
    element : str, optional
        Kind of beam element; one of ``element_kinds``, :meth:`default_element` by default.
    component_modes : bool
        Reduce each link to component modes (Craig-Bampton). Off: all coordinates.

    Raises
    ------
    InputError
        If the element is unknown or there is no element.
    """

    name: ClassVar[str]
    element_kinds: ClassVar[tuple[str, ...]]

    def __init__(
        self,
        mechanism: Mechanism,
        elements: int = 8,
        element: str | None = None,
        component_modes: bool = True,
    ) -> None:
        if elements < 1:
            raise InputError(f"elements must be 1 or more a link, got {elements}")
        element = element or self.default_element(mechanism)
        if element not in self.element_kinds:
            raise InputError(
                f"the {self.name} engine has no element {element!r}; "
                f"it has {', '.join(self.element_kinds)}"
            )
        self.mechanism = mechanism
        self.elements = elements
        self.element = element
        self.component_modes = component_modes
        self._reductions: dict[tuple[int, float, bool, float], ComponentModes] = {}

    @classmethod
    def default_element(cls, mechanism: Mechanism) -> str:
        """Kind of element for a mechanism if none is asked for: the first."""
        return cls.element_kinds[0]

    @property
    @abstractmethod
    def links(self) -> tuple[LinkModel, ...]:
        """Unreduced link models in the topology's order."""

    @abstractmethod
    def convergence(self, prestress: Prestress) -> ConvergenceOrders:
        """Orders of the frequencies' error in the element length."""

    @abstractmethod
    def stressed_links(self, motion: RigidMotion, prestress: Prestress) -> StressedLinks:
        """Tangent stiffness of each link in its frame under the motion's inertia forces.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        prestress : {"none", "axial", "equilibrium"}

        Returns
        -------
        StressedLinks

        Raises
        ------
        ComputationError
            If the equilibrium does not converge or is unstable; names the crank angle.
        """

    @property
    def prestress_at_rest(self) -> Prestress:
        """Level that describes the linkage at rest: ``none``, unless links bend without load."""
        return "equilibrium" if self.mechanism.is_free_strained else "none"

    def _is_straight(self, motion: RigidMotion, prestress: Prestress) -> bool:
        """Whether the links are taken as straight and without stress."""
        if self.mechanism.is_free_strained:
            if prestress != "equilibrium":
                raise InputError(
                    f"prestress {prestress!r} is of straight links, but moisture or heat bends or "
                    "stretches some of these; use prestress 'equilibrium'"
                )
            return False
        unloaded = not motion.crank_speed.any() and not any(self.mechanism.gravity)
        return prestress == "none" or unloaded

    def running_links(
        self, motion: RigidMotion, displacement: Sequence[FloatArray]
    ) -> StressedLinks:
        """Tangent stiffness of each link in states of the running linkage.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        displacement : sequence of ndarray, shape (B, n_link)
            Elastic displacement of each link in its frame.

        Returns
        -------
        StressedLinks

        Raises
        ------
        InputError
            If the engine does not linearize about given states.
        """
        raise InputError(
            f"the {self.name} engine does not linearize about states of the running linkage"
        )

    def with_elements(self, elements: int) -> Self:
        """The same engine on another mesh."""
        return type(self)(self.mechanism, elements, self.element, self.component_modes)

    def unreduced(self) -> Self:
        """The same engine without component modes."""
        return type(self)(self.mechanism, self.elements, self.element, component_modes=False)

    @property
    def batch_size(self) -> int:
        """Positions to hold in memory at a time."""
        coordinates = sum(link.size**2 for link in self.links)
        return max(16, BATCH_BYTES // (8 * 4 * coordinates))

    def linear_system(
        self,
        crank_angle: ArrayLike,
        crank_speed: ArrayLike = 0.0,
        *,
        prestress: Prestress = "equilibrium",
        running: Sequence[FloatArray] | None = None,
        rotation_terms: bool | RotationTerms = True,
        modes: int = 6,
        fastest: float | None = None,
        detail: float = 1.0,
    ) -> LinearSystem:
        """Linear system at crank angles and speeds.

        Parameters
        ----------
        crank_angle, crank_speed : array_like
            In rad and rad/s; broadcast against each other and flattened to a batch of B.
        prestress : {"none", "axial", "equilibrium"}
        running : sequence of ndarray, shape (B, n_link), optional
            Elastic displacements of states to linearize about, in place of the prestress.
        rotation_terms : bool or RotationTerms
            Terms of the turning frames; at crank speed zero they vanish.
        modes : int
            Number of natural frequencies that the reduction must get right.
        fastest : float, optional
            Greatest angular velocity of a link in the whole map in rad/s, by which the
            reduction is chosen; the greatest of this batch by default.
        detail : float
            Multiplies the frequency up to which component modes are kept.

        Returns
        -------
        LinearSystem
            Batch of B positions.

        Raises
        ------
        InputError
            Where the linkage cannot be assembled or locks.
        ComputationError
            If the equilibrium does not converge.
        """
        if prestress not in PRESTRESS_LEVELS:
            raise InputError(
                f"prestress must be one of {', '.join(PRESTRESS_LEVELS)}, got {prestress!r}"
            )
        angle, speed = np.broadcast_arrays(
            np.asarray(crank_angle, dtype=float), np.asarray(crank_speed, dtype=float)
        )
        motion = self.mechanism.linkage.motion(angle.ravel(), speed.ravel())
        terms = (
            rotation_terms
            if isinstance(rotation_terms, RotationTerms)
            else RotationTerms.all_or_none(rotation_terms)
        )
        if not motion.crank_speed.any():
            terms = RotationTerms.all_or_none(False)
        stressed = (
            self.stressed_links(motion, prestress)
            if running is None
            else self.running_links(motion, running)
        )
        if not self.component_modes:
            return _unreduced_system(self.mechanism, self.links, motion, stressed, terms)
        greatest = float(np.max(np.abs(motion.angular_velocity), initial=0.0))
        if not terms.any:
            greatest = 0.0
        elif fastest is not None:
            greatest = abs(fastest)
        loaded = any(t.ndim == 3 for t in stressed.tangent)
        reduction = self._reduction(modes, greatest, loaded, detail)
        return _reduced_system(self.mechanism, self.links, reduction, motion, stressed, terms)

    def _reduction(self, modes: int, fastest: float, loaded: bool, detail: float) -> ComponentModes:
        key = (modes, fastest, loaded, detail)
        if key not in self._reductions:
            self._reductions[key] = component_modes(
                self.mechanism.linkage.topology,
                self.links,
                modes,
                fastest,
                couples_axially=loaded,
                detail=detail,
            )
        return self._reductions[key]


def _unreduced_system(
    mechanism: Mechanism,
    links: Sequence[LinkModel],
    motion: RigidMotion,
    stressed: StressedLinks,
    terms: RotationTerms,
) -> LinearSystem:
    frames = LinkFrames(mechanism.linkage.topology, links)
    damping = None
    if stressed.damping is not None:
        damping = [LinkDamping(matrix, matrix) for matrix in stressed.damping]
    matrices = frames.assemble(motion, stressed.tangent, terms, damping)
    return LinearSystem(motion, matrices.mass, matrices.damping, matrices.stiffness, terms, frames)


def _reduced_system(
    mechanism: Mechanism,
    links: Sequence[LinkModel],
    reduction: ComponentModes,
    motion: RigidMotion,
    stressed: StressedLinks,
    terms: RotationTerms,
) -> LinearSystem:
    frames = LinkFrames(mechanism.linkage.topology, reduction.models)
    projected = [
        link.basis.T @ (tangent @ link.basis)
        for link, tangent in zip(reduction.links, stressed.tangent, strict=True)
    ]
    matrices = frames.assemble(motion, projected, terms, _damping(links, reduction, stressed))
    condensed = np.zeros(frames.size, dtype=bool)
    for target, link in zip(frames.targets, reduction.links, strict=True):
        condensed[target[link.condensed]] = True
    expansion = None
    if condensed.any():
        matrices, expansion = condense(matrices, condensed)
    return LinearSystem(
        motion,
        matrices.mass,
        matrices.damping,
        matrices.stiffness,
        terms,
        frames,
        expansion,
        tuple(link.basis for link in reduction.links),
        # Component modes are normalized by the mass; condensed ones bring theirs along.
        unit_mass_from=frames.end_count if expansion is None else None,
    )


def _damping(
    links: Sequence[LinkModel], reduction: ComponentModes, stressed: StressedLinks
) -> list[LinkDamping] | None:
    """Damping of the stressed links in component modes."""
    if stressed.damping is None:
        return None
    damping = []
    for full, link, matrix in zip(links, reduction.links, stressed.damping, strict=True):
        ends = full.end_basis(link.model.size, {"start": link.model.start, "end": link.model.end})
        forces = link.basis.T @ matrix
        damping.append(LinkDamping(forces @ link.basis, forces @ ends))
    return damping
