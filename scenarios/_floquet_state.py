"""The state of the links in one Floquet mode, from which a run can start."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flexmech.dynamical_systems import FloquetModes, FourierSeries
from flexmech.errors import InputError
from flexmech.mechanics.running import LinkState
from flexmech.solvers import MovingModes


def floquet_state(
    moving: MovingModes, modes: FloquetModes, number: int = 0
) -> tuple[LinkState, LinkState]:
    """Real and imaginary part v and w of a Floquet mode at the start of the turn.

    With the multiplier ``exp(lambda T)``, links that move by ``v`` at the start of a turn move by
    ``Re((v + i w) exp(k lambda T))`` after k turns. Where the multiplier is real, w is zero but
    for round-off. The displacement is ``q = P(t) phi(t) exp(lambda t)`` in the frames of the
    links, its rate at the start ``P. phi + P phi. + lambda P phi``.

    Parameters
    ----------
    moving : MovingModes
    modes : FloquetModes
        Of ``moving.system()``; the number of steps is a multiple of the number of samples of the
        turn.
    number : int
        Of the mode; that which grows most is the first.

    Returns
    -------
    LinkState
        v, of the engine's unreduced links. The greatest displacement at stations along the links
        is real and 1 m.
    LinkState
        w.

    Raises
    ------
    InputError
        If there is no step at a sample of the turn.
    """
    turn = moving.turn
    samples = len(moving.basis)
    states = modes.shapes()
    if len(states) % samples:
        raise InputError(
            f"Floquet modes of {len(states)} steps a turn have no shape at each of the {samples} "
            f"samples of the turn; take a multiple of {samples} steps"
        )
    shape = states[:: len(states) // samples, : moving.size, number] / np.sqrt(moving.scale)
    coordinates = turn.frames.link_coordinates(
        turn.displaced, (moving.basis @ shape[..., None]).astype(complex)
    )
    displacement = [b @ q[0, :, 0] for b, q in zip(turn.bases, coordinates, strict=True)]
    rate = [
        basis @ (_rate_at_start(q[..., 0]) / turn.period + modes.exponent[number] * q[0, :, 0])
        for basis, q in zip(turn.bases, coordinates, strict=True)
    ]
    moved = np.concatenate(
        [(link.shape @ d).ravel() for link, d in zip(turn.unreduced, displacement, strict=True)]
    )
    scale = moved[np.abs(moved).argmax()]
    whole = [d / scale for d in displacement], [d / scale for d in rate]
    return (
        LinkState(*([part.real for part in parts] for parts in whole)),
        LinkState(*([part.imag for part in parts] for parts in whole)),
    )


def _rate_at_start(q: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Derivative by the phase at the first of N samples (N, n) of a turn."""
    real, imaginary = (
        FourierSeries.through(part).rate().samples(1)[0] for part in (q.real, q.imag)
    )
    return np.asarray(real + 1j * imaginary)
