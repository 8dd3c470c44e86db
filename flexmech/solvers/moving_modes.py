"""Running linkage in its moving modes: a small periodic Hamiltonian system with damping.

The lowest frozen natural modes at every crank angle span a subspace that varies with the crank
angle. The motion is sought there (Galerkin), with the rates of the varying shapes. Stiff
coordinates, such as stretching, are condensed statically in each mode. The coordinates of all links
are ``q = P(t) y`` with ``P' M P = 1``; a dot is a rate. The Lagrange function of links in turning
frames gives::

    B = P' M P. + P' omega S P                                                 (skew)
    Q = P' (K - omega^2 M_t) P - P.' M P. + P' omega S P. + (P' omega S P.)'  (symmetric)

and with the momentum ``p = y. + B y`` the equations of motion are those of the Hamilton function
``H = |p - B y|^2 / 2 + y' Q y / 2`` and of the damping forces ``-P' D (P y. + P. y)``. About a
periodic motion these forces change with the displacement as well, ``-P' D_q P y`` with the
derivative ``D_q`` of ``D(q) q.`` by q at the rate of that motion.

Connectors move by ``d = E(t) W(t) y`` with the basis W in the linkage's coordinates. Their
stiffness ``E' K E`` is in Q by its symmetric part; the skew part and the dampers, which have no
potential, give the forces ``-W' (E' K E - (E' K E)') W y / 2 - (E W)' C (E W y.+ (E W). y)``.

The subspace is smooth where its highest mode does not cross the next one; modes may cross within
it. At each crank angle its basis is the one nearest to a fixed basis, so that it returns after a
turn.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.choices import MovingFrame
from flexmech.dynamical_systems import FourierSeries, SampledPeriodicSystem
from flexmech.mechanics import LinkModel, RotationTerms
from flexmech.solvers.sampled_turn import SampledTurn

# A subspace turns fast where its highest frequency comes nearer than this part to the next one,
# and is far from its fixed basis where a direction of it has less than this part in common.
LEAST_GAP = 0.1
LEAST_OVERLAP = 0.2
# Modes besides those asked for, among which the end of the subspace is sought.
SPARE_MODES = 10


@dataclass(frozen=True)
class MovingModes:
    """The linkage in m moving modes; its states are ``(sqrt(w) y, p / sqrt(w))``.

    Parameters
    ----------
    turn : SampledTurn
    basis : ndarray, shape (N, n, m)
        From y to the coordinates of the linkage.
    scale : ndarray, shape (m,)
        ``w`` in rad/s: natural frequencies of the stiffness averaged over the turn. The scaled
        states are canonical too.
    conservative, dissipative : FourierSeries
        Matrix (2 m, 2 m) of the system without damping, and the part by the links' damping, to
        which it is proportional.
    attached : FourierSeries
        Part of the system's matrix by dampers of springs and joints and by follower forces.
    stiffness : ndarray, shape (N, m, m)
        Q in (rad/s)^2, as sampled.
    fixed : ndarray, shape (n, m)
        Fixed basis to which the moving one is nearest.
    """

    turn: SampledTurn
    basis: FloatArray
    scale: FloatArray
    conservative: FourierSeries
    dissipative: FourierSeries
    attached: FourierSeries
    stiffness: FloatArray
    fixed: FloatArray

    @property
    def size(self) -> int:
        """Number m of moving modes."""
        return len(self.scale)

    @property
    def is_definite(self) -> bool:
        """Whether the Hamilton function is positive definite at every sample."""
        return bool(np.linalg.eigvalsh(self.stiffness)[:, 0].min() > 0)

    @property
    def series_error(self) -> float:
        """Estimated relative error of the system's matrix between the samples."""
        return self.conservative.tail

    def samples_for(self, tolerance: float) -> int:
        """Number of samples at which the estimated error would be within a tolerance.

        Harmonics of smooth functions shrink by the same part from one to the next.
        """
        return int(np.ceil(len(self.basis) * np.log(tolerance) / np.log(self.series_error)))

    def system(self, damping: float = 1.0) -> SampledPeriodicSystem:
        """Periodic system with the damping of links times a factor; 0 leaves it out."""
        matrix = self.with_undamped_links.plus(self.dissipative, damping)
        return SampledPeriodicSystem(matrix, self.turn.period)

    @property
    def with_undamped_links(self) -> FourierSeries:
        """The system's matrix without the damping of links, that of connectors included."""
        return self.conservative.plus(self.attached, 1.0)


def counts_of_modes(turn: SampledTurn, modes: int, wanted: int) -> list[int]:
    """Numbers of moving modes above the requested one whose subspace is smooth.

    Parameters
    ----------
    turn : SampledTurn
    modes : int
        Without rigid ones.
    wanted : int
        How many numbers to look for.

    Returns
    -------
    list of int
        Increasing. Where fewer are smooth, the smoothest ones above them follow. All coordinates,
        if nothing changes along the turn or there are no more than are asked for.
    """
    squares, largest = turn.frozen_squares, turn.size
    modes += turn.rigid_modes
    if turn.is_constant:
        return [largest]
    counts: list[int] = []
    smoothness: dict[int, float] = {}
    for count in range(modes + 1, min(modes + SPARE_MODES, largest - 1) + 1):
        if len(counts) == wanted:
            break
        below, above = squares[:, count - 1], squares[:, count]
        gap = float(np.sqrt(above / below).min()) - 1 if below.min() > 0 else 0.0
        overlap = float(turn.subspace(count)[2].min())
        smoothness[count] = min(gap / LEAST_GAP, overlap / LEAST_OVERLAP)
        if smoothness[count] > 1:
            counts.append(count)
    while len(counts) < wanted:
        more = [count for count in smoothness if count > max(counts, default=0)]
        if not more:
            break
        counts.append(max(more, key=lambda count: smoothness[count]))
    return counts or [largest]


def moving_modes(
    turn: SampledTurn, count: int, like: MovingModes | None = None, frame: MovingFrame = "link"
) -> MovingModes:
    """Project the running linkage onto its moving modes.

    Parameters
    ----------
    turn : SampledTurn
    count : int
        Number m of moving modes, at most all coordinates.
    like : MovingModes, optional
        As many of another crank speed in the same component modes, whose fixed basis and scale
        to take: matrices of both then change continuously from one speed to the other.
    frame : {"link", "inertial"}
        Axes in which rates are taken of the nodes' displacements: those of the links, or of
        the ground. It is the same system.

    Returns
    -------
    MovingModes
    """
    modes = turn.frozen_modes[:, :, :count]
    if like is None:
        scale, fixed, alignment = _scale_and_fixed_basis(turn, count)
    else:
        scale, fixed = like.scale, like.fixed
        alignment = turn.aligned(count, fixed)[0]
    basis = modes @ alignment
    skew, stiffness, links = _projected(turn, basis, frame)
    root = np.sqrt(scale)
    matrix = np.zeros((len(basis), 2 * count, 2 * count))
    y, p = slice(0, count), slice(count, None)
    across = np.swapaxes(skew, 1, 2)
    matrix[:, y, y] = -skew * root[:, None] / root
    matrix[:, y, p] = np.diag(scale)
    matrix[:, p, y] = -(stiffness + across @ skew) / root[:, None] / root
    matrix[:, p, p] = across / root[:, None] * root
    return MovingModes(
        turn,
        basis,
        scale,
        turn.series(matrix),
        turn.series(links.matrix(skew, root)),
        turn.series(_of_connectors(turn, basis).matrix(skew, root)),
        stiffness,
        fixed,
    )


def _scale_and_fixed_basis(
    turn: SampledTurn, count: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Natural frequencies (m,) of the averaged stiffness; its modes, and those nearest to them."""
    fixed, alignment, _ = turn.subspace(count)
    squares = turn.frozen_squares[:, :count]
    average = np.einsum("aij,ai,aik->jk", alignment, squares, alignment)
    mean_squares, turned = np.linalg.eigh(average / len(squares))
    scale = np.sqrt(np.abs(mean_squares))
    # Any scale makes canonical states; that of a rigid mode would be zero.
    rigid = slice(turn.rigid_modes)
    scale[rigid] = np.maximum(scale[rigid], abs(turn.crank_speed))
    return scale, fixed @ turned, alignment @ turned


@dataclass(frozen=True)
class _Forces:
    """Forces ``-damping y. - stiffness y`` without a potential, each (N, m, m)."""

    damping: FloatArray
    stiffness: FloatArray

    def matrix(self, skew: FloatArray, root: FloatArray) -> FloatArray:
        """Part of the system's matrix (N, 2 m, 2 m), by B and the roots of the scale."""
        samples, count, _ = skew.shape
        matrix = np.zeros((samples, 2 * count, 2 * count))
        y, p = slice(0, count), slice(count, None)
        matrix[:, p, y] = (self.damping @ skew - self.stiffness) / root[:, None] / root
        matrix[:, p, p] = -self.damping / root[:, None] * root
        return matrix


def _of_connectors(turn: SampledTurn, basis: FloatArray) -> _Forces:
    """Forces of dampers of springs and joints, and follower forces."""
    connected, across = turn.connected, np.swapaxes(basis, 1, 2)
    if connected is None or connected.is_conservative:
        nothing = np.zeros_like(across @ basis)
        return _Forces(nothing, nothing)
    forces = across @ connected.damping
    rate_forces = across @ ((connected.rate_stiffness + connected.circulatory) @ basis)
    return _Forces(forces @ basis, forces @ turn.rate(basis) + rate_forces)


def _projected(
    turn: SampledTurn, basis: FloatArray, frame: MovingFrame
) -> tuple[FloatArray, FloatArray, _Forces]:
    """B and Q, each (N, m, m), and ``P' D P`` with ``P' D P.`` of links."""
    count, _, size = basis.shape
    skew, stiffness, damping, moving_damping = np.zeros((4, count, size, size))
    if turn.carried is not None:
        skew, stiffness = _on_a_frame(turn, basis)
    for number, shapes in enumerate(turn.link_coordinates(basis)):
        across = np.swapaxes(shapes, 1, 2)
        in_frame = _in_link_frame if frame == "link" else _in_ground_axes
        inertia, rates = in_frame(turn, number, shapes)
        if turn.carried is None:
            for sign, (b, q) in [(1.0, inertia), *_turned_bodies(turn, number, shapes)]:
                skew += sign * b
                stiffness += sign * q
            stiffness += across @ (turn.tangent[number] @ shapes)
        forces = across @ turn.damping[number]
        damping += forces @ shapes
        moving_damping += forces @ rates
        if turn.damping_stiffness:
            moving_damping += across @ (turn.damping_stiffness[number] @ shapes)
    if turn.connected is not None:
        stiffness += np.swapaxes(basis, 1, 2) @ (turn.connected.potential @ basis)
    # What round-off and the missing harmonics leave of the other part would not be Hamiltonian.
    skew = (skew - np.swapaxes(skew, 1, 2)) / 2
    stiffness = (stiffness + np.swapaxes(stiffness, 1, 2)) / 2
    damping = (damping + np.swapaxes(damping, 1, 2)) / 2
    return skew, stiffness, _Forces(damping, moving_damping)


def _on_a_frame(turn: SampledTurn, basis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """B and Q of a linkage that a frame on springs carries, each (N, m, m).

    By its Lagrange function ``z.' M z. / 2 + z.' B z - z' Q z / 2`` with a skew B the equations of
    motion have the damping matrix ``M. + 2 B`` and the stiffness ``Q + B.``: their skew and
    symmetric parts tell both.
    """
    whole = turn.assembled(RotationTerms.all_or_none(True))
    gyroscopic = (whole.damping - np.swapaxes(whole.damping, 1, 2)) / 4
    potential = (whole.stiffness + np.swapaxes(whole.stiffness, 1, 2)) / 2
    one = np.ones((1, 1, 1))
    b, q = _inertia((whole.mass, gyroscopic, -potential), one, basis, turn.rate(basis))
    # The mass varies: what b has of a symmetric part is a rate but for its own, y' b. y / 2.
    return b, q + turn.rate((b + np.swapaxes(b, 1, 2)) / 2)


def _inertia(
    matrices: Iterable[FloatArray],
    speed: FloatArray,
    shapes: FloatArray,
    rates: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Contributions of a link's ``M``, ``S`` and ``M_t`` to B and Q.

    They belong to ``|P y. + P. y|_M^2 / 2 + omega (P y. + P. y)' S P y + omega^2 y' P' M_t P y /
    2``.
    """
    mass, gyroscopic, centrifugal = matrices
    turning = speed * (gyroscopic @ shapes)
    across, across_rates = np.swapaxes(shapes, 1, 2), np.swapaxes(rates, 1, 2)
    coriolis = across_rates @ turning
    stiffness = -coriolis - np.swapaxes(coriolis, 1, 2) - across_rates @ (mass @ rates)
    stiffness -= across @ (speed**2 * (centrifugal @ shapes))
    return across @ (mass @ rates + turning), stiffness


def _turned_bodies(
    turn: SampledTurn, number: int, shapes: FloatArray
) -> Iterator[tuple[float, tuple[FloatArray, FloatArray]]]:
    """Inertia of bodies on a link rotated with its sections, less that on the straight link."""
    speed = turn.frame_speed[:, number, None, None]
    angles = [] if turn.turns is None else turn.turns[number]
    for body, angle in zip(turn.models[number].bodies, angles, strict=bool(angles)):
        if body.is_off_axis:
            for sign, turned in ((1.0, angle), (-1.0, np.zeros_like(angle))):
                centre = body.centre_map(turned) @ (body.rows @ shapes)
                about_centre = body.about_centre.matrices(np.zeros(()))
                yield sign, _inertia(about_centre, speed, centre, turn.rate(centre))


def _in_link_frame(
    turn: SampledTurn, number: int, shapes: FloatArray
) -> tuple[tuple[FloatArray, FloatArray], FloatArray]:
    """Inertia by rates in the link's frame, and these rates (N, n_link, m)."""
    link, speed = turn.models[number], turn.frame_speed[:, number, None, None]
    rates, matrices = turn.rate(shapes), (link.mass, link.gyroscopic, link.centrifugal_mass)
    return _inertia(matrices, speed, shapes, rates), rates


def _in_ground_axes(
    turn: SampledTurn, number: int, shapes: FloatArray
) -> tuple[tuple[FloatArray, FloatArray], FloatArray]:
    """Inertia by rates in ground axes; the rates that damping feels, (N, n_link, m).

    Each vector of a link, the displacement of a node or its slope vector, is turned by the link's
    angle: ``d = R q``. With J the quarter turn of all vectors, the rate seen in the link's axes is
    ``v = R' d. = q. + omega J q``, and what the kinetic energy of the link has besides
    ``v' M v / 2`` is ``omega v' S* q + omega^2 q' M_t* q / 2`` with::

        S* = S - M J
        M_t* = M_t + J' M J - J' S - S' J

    Both vanish where the shape functions turn with the nodes, as those of ANCF cables do: then the
    inertia has no terms of turning frames in ground axes. Along beams whose displacements along
    and across are of different degree a small rest remains, of the element's length.
    """
    link, reduction, angle = turn.unreduced[number], turn.bases[number], turn.displaced.angle
    speed, full = turn.frame_speed[:, number, None, None], reduction @ shapes
    ground = turn.rate(_vectors_turned(link, full, angle[:, number]))
    moving = _vectors_turned(link, ground, -angle[:, number])
    quarter = np.zeros((link.size, link.size))
    x, y = link.vectors
    quarter[x, y], quarter[y, x] = -1.0, 1.0
    crossed = quarter.T @ link.gyroscopic
    centrifugal = link.centrifugal_mass + quarter.T @ link.mass @ quarter
    matrices = (
        link.mass,
        link.gyroscopic - link.mass @ quarter,
        centrifugal - crossed - crossed.T,
    )
    rates = moving - speed * (quarter @ full)
    return _inertia(matrices, speed, full, moving), np.linalg.pinv(reduction) @ rates


def _vectors_turned(link: LinkModel, shapes: FloatArray, angle: FloatArray) -> FloatArray:
    """Shapes (N, n, m) whose vectors are turned by angles (N,); other coordinates stay."""
    x, y = link.vectors
    cosine, sine = np.cos(angle)[:, None, None], np.sin(angle)[:, None, None]
    turned = shapes.copy()
    turned[:, x] = cosine * shapes[:, x] - sine * shapes[:, y]
    turned[:, y] = sine * shapes[:, x] + cosine * shapes[:, y]
    return turned
