"""The one contract between engines and analyses: a linear system over many positions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray
from flexmech.choices import LinkDirection, Prestress
from flexmech.linkages import RigidMotion
from flexmech.linkages.motion import direction, normal
from flexmech.mechanics.joints.carried_linkage import COORDINATES, CarriedLinkage
from flexmech.mechanics.joints.link_frames import LinkFrames
from flexmech.mechanics.links.body_forces import body_turns
from flexmech.mechanics.links.component_modes import ComponentModes
from flexmech.mechanics.links.link_inertia import rigid_inertia
from flexmech.mechanics.links.link_model import LinkModel, StressedLinks
from flexmech.mechanics.links.rotation_terms import RotationTerms, SystemMatrices
from flexmech.mechanics.loads.attached_points import LinkPoint, displacement_row
from flexmech.mechanics.loads.connectors import Connectors


@dataclass(frozen=True)
class LinearSystem:
    """``M z'' + C z' + K z = 0`` about a batch of B positions of the linkage.

    The coordinates z are displacements in the link frames (see
    :mod:`flexmech.mechanics.joints.link_frames`), reduced or not.

    Parameters
    ----------
    motion : RigidMotion
        The positions; batch of shape (B,).
    mass, damping, stiffness : ndarray, shape (B, n, n)
    terms : RotationTerms
        Terms of the turning frames that the matrices contain.
    frames : LinkFrames
        How z becomes the links' coordinates.
    expansion : ndarray, shape (B, size, n), or None
        From z to the coordinates of ``frames`` where some were condensed.
    bases : tuple of ndarray, shape (n_full, n_link), or None
        From each reduced link's coordinates to its unreduced ones.
    circulates : bool
        Whether there are circulatory forces: follower forces, or dampers of springs.
    carried : CarriedLinkage, optional
        Carried of a linkage whose frame is on springs: the last three coordinates are those of the
        frame, and the links move in its axes.
    rigid_modes : int
        Natural modes that deform nothing: 1 where the shaft turns freely. They are no
        vibration, and modes are counted without them.
    """

    motion: RigidMotion
    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    terms: RotationTerms
    frames: LinkFrames
    expansion: FloatArray | None = None
    bases: tuple[FloatArray, ...] | None = None
    rigid_modes: int = 0
    circulates: bool = False
    carried: CarriedLinkage | None = None

    @property
    def size(self) -> int:
        """Number of coordinates n."""
        return int(self.mass.shape[-1])

    @property
    def is_conservative(self) -> bool:
        """Whether the matrices are symmetric with no damping: frozen inertial form."""
        # Undamped, all positions and entries are one zero: it is looked at once.
        first = tuple(slice(None) if stride else slice(1) for stride in self.damping.strides)
        return not (self.terms.any or self.circulates or self.damping[first].any())

    def link_coordinates(self, vectors: NDArray[Any]) -> list[NDArray[Any]]:
        """Coordinates of each link; (B, n, m) -> list of (B, n_link, m)."""
        of_links = self._split(vectors)[0]
        full = of_links if self.expansion is None else self.expansion @ of_links
        return self.frames.link_coordinates(self.motion, full)

    def _split(self, vectors: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
        """Coordinates of the linkage (B, n, m), and of a frame on springs (B, 3 or 0, m)."""
        count = self.size - (0 if self.carried is None else COORDINATES)
        return vectors[:, :count], vectors[:, count:]

    def inertial_shapes(self, vectors: NDArray[Any]) -> NDArray[Any]:
        """Shapes scaled so that their products are weighted by mass, in every position alike.

        The coordinates z turn with the frames, and their mass matrix changes along the way;
        the shape of each link in its own frame has the same mass everywhere.

        Parameters
        ----------
        vectors : ndarray, shape (B, n, m)

        Returns
        -------
        ndarray, shape (B, N, m)
            ``y`` with ``y^H y`` equal to ``z^H M z`` of the same position.
        """
        if self.carried is not None:
            links, moved = self.link_coordinates(vectors), self._split(vectors)[1]
            return self.carried.inertial_shapes(self.motion, links, moved)
        pairs = zip(self.frames.links, self.link_coordinates(vectors), strict=True)
        return np.concatenate([link.mass_root.T @ q for link, q in pairs], axis=1)

    def unreduced_vectors(self, vectors: NDArray[Any], frames: LinkFrames) -> NDArray[Any]:
        """Shapes in the coordinates of the unreduced system.

        Parameters
        ----------
        vectors : ndarray, shape (B, n, m)
        frames : LinkFrames
            Frames of the unreduced links.

        Returns
        -------
        ndarray, shape (B, frames.size, m)
            Displacements in m and rad; the three coordinates of a frame on springs follow.
        """
        if self.bases is None:
            return vectors
        of_links = frames.independent(self.motion, self.unreduced_links(vectors))
        return np.concatenate([of_links, self._split(vectors)[1]], axis=1)

    def unreduced_links(self, vectors: NDArray[Any]) -> list[NDArray[Any]]:
        """Shapes (B, n, m) in the coordinates of each unreduced link, (B, n_link, m)."""
        moved = self.link_coordinates(vectors)
        if self.bases is None:
            return moved
        return [basis @ q for basis, q in zip(self.bases, moved, strict=True)]

    def modal_weights(
        self, vectors: NDArray[Any], links: Sequence[LinkModel]
    ) -> tuple[list[NDArray[Any]], NDArray[Any]]:
        """Mass times shapes in the first position: by them coordinates become modal ones.

        Parameters
        ----------
        vectors : ndarray, shape (B, n, m)
        links : sequence of LinkModel
            Unreduced.

        Returns
        -------
        list of ndarray, shape (n_link, m)
            Shapes in the coordinates of each unreduced link.
        ndarray, shape (3, m)
            Shapes in the coordinates of a frame on springs; zero where it stands.
        """
        shapes = [q[0] for q in self.unreduced_links(vectors)]
        of_frame = np.zeros((COORDINATES, vectors.shape[2]))
        if self.carried is None:
            return [k.mass @ q for k, q in zip(links, shapes, strict=True)], of_frame
        weights, moved = [], self._split(vectors)[1][0]
        fields = self.carried.fields(self.motion)[:, 0]
        for link, shape, field, rigid in zip(
            links, shapes, fields, self.carried.rigid, strict=True
        ):
            forces = rigid_inertia(link)[:, :3]
            weights.append(link.mass @ shape + forces @ field @ moved)
            of_frame = of_frame + field.T @ forces.T @ (shape + rigid @ field @ moved)
        return weights, of_frame + self.carried.frame.inertia_matrix @ moved

    def displacements(self, vectors: NDArray[Any]) -> NDArray[Any]:
        """Displacement at the stations of every link, in ground axes.

        Parameters
        ----------
        vectors : ndarray, shape (B, n, m)

        Returns
        -------
        ndarray, shape (B, m, n_links, n_stations, 2)
        """
        along, across = direction(self.motion.angle), normal(self.motion.angle)
        parts = []
        fields = None if self.carried is None else self.carried.fields(self.motion)
        for number, (link, q) in enumerate(
            zip(self.frames.links, self.link_coordinates(vectors), strict=True)
        ):
            local = np.einsum("scn,bnm->bmsc", link.shape, q)
            if fields is not None:
                # As the frame carries it: displacement of its start, and its rotation.
                moved = np.swapaxes(fields[number] @ self._split(vectors)[1], 1, 2)
                local = local + moved[:, :, None, :2]
                place = np.linspace(0.0, self.frames.topology.links[number].length, len(link.shape))
                local[..., 1] += place * moved[:, :, None, 2]
            axes = np.stack([along[:, number], across[:, number]], axis=1)
            parts.append(np.einsum("bmsc,bcd->bmsd", local, axes))
        return np.stack(parts, axis=2)


def condense(
    matrices: SystemMatrices, condensed: NDArray[np.bool_], forces: FloatArray | None = None
) -> tuple[SystemMatrices, FloatArray]:
    """Condense some coordinates statically (Guyan 1965) in every position.

    ``V' X W`` with ``K W = 0`` and ``V' K = 0`` in the condensed coordinates: the stiffness of
    damped links in rotating frames is not symmetric, and ``W' C W`` would be wrong. The static
    responses to ``forces`` remain as coordinates.

    Parameters
    ----------
    matrices : SystemMatrices
        Over a batch B with ``size`` coordinates.
    condensed : ndarray of bool, shape (size,)
    forces : ndarray, shape (B, c, r), optional
        On the c condensed coordinates.

    Returns
    -------
    SystemMatrices
        In the remaining coordinates and the static responses, n together.
    ndarray, shape (B, size, n)
        Expansion from these to all coordinates.
    """
    eliminated, kept = np.flatnonzero(condensed), np.flatnonzero(~condensed)
    count = len(kept)
    order = np.concatenate([kept, eliminated])
    mass, damping, stiffness = matrices.mass, matrices.damping, matrices.stiffness
    # Component modes are in order already; speed alone, a tenth of a map.
    if (np.diff(order) < 0).any():
        mass, damping, stiffness = (m[:, order[:, None], order] for m in (mass, damping, stiffness))
    flexibility = np.linalg.inv(stiffness[:, count:, count:])
    dependence = -flexibility @ stiffness[:, count:, :count]
    dual = -stiffness[:, :count, count:] @ flexibility
    if forces is not None:
        responses = flexibility @ forces
        responses /= np.linalg.norm(responses, axis=1, keepdims=True)
        dependence = np.concatenate([dependence, responses], axis=2)
        dual = np.concatenate([dual, np.swapaxes(responses, 1, 2)], axis=1)
    size = dependence.shape[2]

    def condensed_part(matrix: FloatArray) -> FloatArray:
        columns = matrix[:, :, count:] @ dependence
        columns[:, :, :count] += matrix[:, :, :count]
        block = dual @ columns[:, count:]
        block[:, :count] += columns[:, :count]
        return np.asarray(block)

    expansion = np.zeros((len(stiffness), len(condensed), size))
    expansion[:, kept, np.arange(count)] = 1.0
    expansion[:, eliminated] = dependence
    none = np.broadcast_to(0.0, (len(stiffness), size, size))
    condensed_damping = condensed_part(damping) if damping.any() else none
    # ``V' K W`` without what is zero in it.
    left = np.zeros((len(stiffness), size, size))
    left[:, :count, :count] = stiffness[:, :count, count:] @ dependence[:, :, :count]
    left[:, :count, :count] += stiffness[:, :count, :count]
    if forces is not None:
        left[:, count:, count:] = (
            np.swapaxes(responses, 1, 2) @ stiffness[:, count:, count:] @ responses
        )
    return SystemMatrices(condensed_part(mass), condensed_damping, left), expansion


def assembled_system(
    frames: LinkFrames,
    reduction: ComponentModes | None,
    motion: RigidMotion,
    stressed: StressedLinks,
    terms: RotationTerms,
    connectors: Connectors,
    prestress: Prestress,
) -> LinearSystem:
    """Linear system of stressed links in all their coordinates or in component modes.

    Coordinates without mass are condensed statically: rotations and nodes between lumped masses may
    have none; of component modes those are condensed that the reduction says.

    Parameters
    ----------
    frames : LinkFrames
        Frames of the unreduced links.
    reduction : ComponentModes or None
        None: all coordinates.
    motion : RigidMotion
        Batch of shape (B,).
    stressed : StressedLinks
    terms : RotationTerms
    connectors : Connectors
        Loads and springs, whose matrices are added.
    prestress : {"none", "axial", "equilibrium"}

    Returns
    -------
    LinearSystem
    """
    links, displacement = frames.links, stressed.displacement
    motion, turns = frames.displaced(motion, displacement), body_turns(links, displacement)
    damping, end_damping = stressed.damping, None
    forces, bases = None, None
    if reduction is None:
        tangent = stressed.tangent
    else:
        frames = reduction.frames
        damping, end_damping = _damping(links, reduction, stressed)
        forces = _damped_ends(frames, reduction, end_damping, motion)
        bases = tuple(link.basis for link in reduction.links)
        tangent = [
            link.model.stiffness
            if tangent is full.stiffness
            else link.basis.T @ (tangent @ link.basis)
            for full, link, tangent in zip(links, reduction.links, stressed.tangent, strict=True)
        ]
    matrices = frames.assemble(
        motion, tangent, terms, damping, stressed.guide_stiffness, turns, end_damping
    )
    matrices = connectors.added(frames, motion, matrices, terms, prestress, displacement)
    if reduction is None:
        condensed = np.all(np.diagonal(matrices.mass, axis1=1, axis2=2) == 0, axis=0)
        condensed[: len(frames.rigid.independent_coordinates)] = False
    else:
        condensed = np.zeros(frames.size, dtype=bool)
        for target, link in zip(frames.targets, reduction.links, strict=True):
            condensed[target[link.condensed]] = True
    expansion = None
    if condensed.any():
        matrices, expansion = condense(matrices, condensed, forces)
    return LinearSystem(
        motion,
        matrices.mass,
        matrices.damping,
        matrices.stiffness,
        terms,
        frames,
        expansion,
        bases,
    )


def _damping(
    links: Sequence[LinkModel], reduction: ComponentModes, stressed: StressedLinks
) -> tuple[list[FloatArray], list[FloatArray]] | tuple[None, None]:
    """Damping of the stressed links in component modes, and its forces by the ends alone."""
    if stressed.damping is None:
        return None, None
    damping, end_damping = [], []
    for full, link, matrix in zip(links, reduction.links, stressed.damping, strict=True):
        ends = (
            full.end_basis(link.model.size, link.model.kept_ends) if not full.rigid else link.basis
        )
        forces = link.basis.T @ matrix
        damping.append(forces @ link.basis)
        end_damping.append(forces @ ends)
    return damping, end_damping


def _damped_ends(
    frames: LinkFrames,
    reduction: ComponentModes,
    end_damping: Sequence[FloatArray] | None,
    motion: RigidMotion,
) -> FloatArray | None:
    """Damping forces of end motions on the condensed coordinates, (B, c, r) or None."""
    ways = [link.damped_ends.shape[-1] for link in reduction.links]
    if not any(ways):
        return None
    first = frames.size - sum(int(link.condensed.sum()) for link in reduction.links)
    forces = np.zeros((len(motion.crank_angle), frames.size - first, sum(ways)))
    last = np.cumsum(ways)
    for number, link in enumerate(reduction.links):
        if not ways[number]:
            continue
        ends = link.model.ends.damping if end_damping is None else end_damping[number]
        rows = frames.targets[number][link.condensed] - first
        columns = slice(last[number] - ways[number], last[number])
        forces[:, rows, columns] = ends[..., link.condensed, :] @ link.damped_ends
    return forces


def point_rows(system: LinearSystem, point: LinkPoint, direction: LinkDirection) -> FloatArray:
    """Displacement of a point in the coordinates of a linear system.

    Parameters
    ----------
    system : LinearSystem
        Batch of B positions.
    point : LinkPoint
    direction : {"transverse", "axial"}
        Across its link's frame or along it.

    Returns
    -------
    ndarray, shape (B, n)
        ``rows[b] @ z`` is the displacement in m in position b, against the ground where a frame on
        springs carries the linkage. A unit force there in that direction is the generalized force
        ``rows[b]``.

    Raises
    ------
    InputError
        If the linkage has no such link, or the direction is neither.
    """
    frames = system.frames
    number = point.index(frames.topology)
    row = displacement_row(frames.links[number], point.fraction, direction)
    unit = np.broadcast_to(np.eye(system.size), (len(system.mass), system.size, system.size))
    rows = np.asarray(row @ system.link_coordinates(unit)[number])
    if (carried := system.carried) is not None:
        place = point.fraction * frames.topology.links[number].length
        unit = np.array([1.0, 0.0, 0.0] if direction == "axial" else [0.0, 1.0, place])
        rows[:, -COORDINATES:] += unit @ carried.fields(system.motion)[number]
    return rows
