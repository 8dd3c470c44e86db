r"""Constant systems ``M z'' + C z' + K z = p f``: frequency response, and response to a pulse.

The receptance from a force on ``p`` to a displacement ``r z`` is

.. math:: H(s) = r^T (s^2 M + s C + K)^{-1} p = \sum_k \frac{R_k}{s - \lambda_k},

at :math:`s = 2 \pi i f`, with the poles :math:`\lambda_k` and the residues :math:`R_k` of the
state-space modes (Ewins 2000, ch. 2). The first form is the direct solution, the second the
superposition. What a superposition leaves out answers a force far below its frequencies
statically: its residual term is the static flexibility less that of the modes kept.

A pulse of peak :math:`F` and duration :math:`T` has the spectrum
:math:`2 F T \cos(\pi f T) / (\pi (1 - 4 f^2 T^2))` times the delay of its middle. Its first zero
is at ``1.5 / T``; at ``1 / T`` it is a third of that at zero frequency (9.5 dB lower).

Each pole answers the pulse in closed form. With :math:`\omega = \pi / T` and time :math:`\tau`
from the pulse's start,

.. math:: g_k(\tau) = F \frac{\omega e^{\lambda_k \tau} - \lambda_k \sin \omega \tau
          - \omega \cos \omega \tau}{\lambda_k^2 + \omega^2}, \quad \tau \le T,

and afterwards it decays freely: :math:`g_k(T) e^{\lambda_k (\tau - T)}`. The displacement is
:math:`\sum_k R_k g_k`. There is no time step and no error of one. The equations stand in
docs/theory/hammer_test.md.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike, NDArray

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.errors import ComputationError
from flexmech.validation import NOT_NEGATIVE, POSITIVE, check_number

# Complex numbers in memory at a time. Memory alone: 32 MB, a few times of which the solution takes.
AT_ONCE = 2_000_000
# What has decayed by exp(-GONE), 3e-20, is below the round-off of what remains.
GONE = 45.0


def direct_receptance(
    mass: FloatArray,
    damping: FloatArray,
    stiffness: FloatArray,
    response: FloatArray,
    force: FloatArray,
    frequency: FloatArray,
) -> ComplexArray:
    """Receptance by a solution of the equations at each frequency.

    Parameters
    ----------
    mass, damping, stiffness : ndarray, shape (n, n)
    response : ndarray, shape (r, n)
        Rows that read displacements.
    force : ndarray, shape (p, n)
        Generalized forces of unit loads.
    frequency : ndarray, shape (F,)
        In Hz.

    Returns
    -------
    ndarray of complex, shape (F, r, p)
        In m/N.
    """
    receptance = np.empty((len(frequency), len(response), len(force)), dtype=complex)
    at_once = max(1, AT_ONCE // mass.size)
    for first in range(0, len(frequency), at_once):
        rows = slice(first, first + at_once)
        s = 2j * np.pi * frequency[rows, None, None]
        dynamic = s**2 * mass + s * damping + stiffness
        right = np.broadcast_to(force.T.astype(complex), (len(dynamic), *force.T.shape))
        receptance[rows] = response @ np.linalg.solve(dynamic, right)
    return receptance


@dataclass(frozen=True)
class StateModes:
    """Poles of a constant system and its modes in state space.

    Parameters
    ----------
    poles : ndarray of complex, shape (2n,)
        In rad/s, by their size; conjugate poles stand side by side.
    right : ndarray of complex, shape (n, 2n)
        Displacement of each mode.
    left : ndarray of complex, shape (2n, n)
        What forces on the coordinates put into each mode.
    flexibility : ndarray, shape (n, n)
        Inverse of the stiffness.
    """

    poles: ComplexArray
    right: ComplexArray
    left: ComplexArray
    flexibility: FloatArray

    def residues(self, response: FloatArray, force: FloatArray) -> ComplexArray:
        """Residues of the receptance, in m/(N s).

        Parameters
        ----------
        response : ndarray, shape (r, n)
        force : ndarray, shape (p, n)

        Returns
        -------
        ndarray of complex, shape (2n, r, p)
        """
        read, put = self.right.T @ response.T, self.left @ force.T
        return np.asarray(read[:, :, None] * put[:, None, :])

    def below(self, frequency: float) -> NDArray[np.bool_]:
        """Whether poles, (2n,), oscillate and are smaller than a frequency in Hz."""
        oscillates: NDArray[np.bool_] = self.poles.imag != 0
        return oscillates & (np.abs(self.poles) < 2 * np.pi * frequency)

    def residual(
        self, response: FloatArray, force: FloatArray, kept: NDArray[np.bool_]
    ) -> FloatArray:
        """Static flexibility of what a superposition leaves out, in m/N.

        Parameters
        ----------
        response : ndarray, shape (r, n)
        force : ndarray, shape (p, n)
        kept : ndarray of bool, shape (2n,)

        Returns
        -------
        ndarray, shape (r, p)
        """
        static = response @ self.flexibility @ force.T
        of_kept = np.einsum(
            "krp,k->rp", self.residues(response, force)[kept], -1 / self.poles[kept]
        )
        return np.asarray(static - of_kept.real)

    def receptance(
        self,
        response: FloatArray,
        force: FloatArray,
        frequency: FloatArray,
        kept: NDArray[np.bool_] | None = None,
        *,
        shift: float = 0.0,
    ) -> ComplexArray:
        """Receptance by superposition of modes.

        Parameters
        ----------
        response : ndarray, shape (r, n)
        force : ndarray, shape (p, n)
        frequency : ndarray, shape (F,)
            In Hz.
        kept : ndarray of bool, shape (2n,), optional
            Modes that are superposed; the others add their static flexibility. All by default.
        shift : float
            Real part of s in 1/s: what an exponential window over the records adds.

        Returns
        -------
        ndarray of complex, shape (F, r, p)
            In m/N.
        """
        chosen = np.ones(len(self.poles), dtype=bool) if kept is None else kept
        residues = self.residues(response, force)[chosen]
        shape = (len(frequency), len(response), len(force))
        receptance = np.empty(shape, dtype=complex)
        at_once = max(1, AT_ONCE // max(1, chosen.sum()))
        for first in range(0, len(frequency), at_once):
            rows = slice(first, first + at_once)
            s = shift + 2j * np.pi * frequency[rows, None]
            receptance[rows] = np.tensordot(1 / (s - self.poles[chosen]), residues, axes=(1, 0))
        if kept is not None:
            receptance += self.residual(response, force, kept)
        return receptance


def state_modes(mass: FloatArray, damping: FloatArray, stiffness: FloatArray) -> StateModes:
    """Poles and state-space modes of a constant system.

    The equations are written in coordinates of unit mass and in the modes of their symmetric
    stiffness, each scaled by its frequency: links that stretch a thousand times faster than
    they bend do not blur the poles.

    Parameters
    ----------
    mass, damping, stiffness : ndarray, shape (n, n)
        The mass is symmetric and positive.

    Returns
    -------
    StateModes

    Raises
    ------
    ComputationError
        If poles meet so that the modes are no basis, as at critical damping.
    """
    size = len(mass)
    symmetric = (stiffness + stiffness.T) / 2
    squares, basis = scipy.linalg.eigh(symmetric, mass)
    natural = np.sqrt(np.abs(squares))
    state = np.zeros((2 * size, 2 * size))
    state[:size, size:] = np.diag(natural)
    state[size:, :size] = -(basis.T @ stiffness @ basis) / natural
    state[size:, size:] = -basis.T @ damping @ basis
    poles, vectors = np.linalg.eig(state)
    order = np.lexsort((poles.imag, np.abs(poles).round(9)))
    poles, vectors = poles[order].astype(complex), vectors[:, order].astype(complex)
    inverse = np.linalg.inv(vectors)
    off = np.abs(vectors * poles @ inverse - state).max()
    if not off <= 1e-6 * np.abs(state).max():
        raise ComputationError(
            "the damped modes of the linkage meet in one pole, so that its response is no sum of "
            "modes; change the damping ratio slightly"
        )
    right = (basis / natural) @ vectors[:size]
    left = inverse[:, size:] @ basis.T
    flexibility = np.asarray(np.linalg.inv(stiffness), dtype=float)
    return StateModes(poles, right, left, flexibility)


@dataclass(frozen=True)
class HalfSinePulse:
    """``F sin(pi (t - start) / T)`` while the pulse lasts, zero before and after.

    Parameters
    ----------
    peak_force : float
        In N; negative pushes the other way.
    duration : float
        T in s.
    start : float
        In s.

    Raises
    ------
    InputError
        If one is no number, the duration is not positive or the start negative.
    """

    peak_force: float
    duration: float
    start: float = 0.0

    def __post_init__(self) -> None:
        check_number(self.peak_force, "peak_force of a pulse", "N")
        check_number(self.duration, "duration of a pulse", "s", POSITIVE)
        check_number(self.start, "start of a pulse", "s", NOT_NEGATIVE)

    @property
    def end(self) -> float:
        """Time at which the pulse is over, in s."""
        return self.start + self.duration

    def force(self, time: ArrayLike) -> FloatArray:
        """Force in N at times in s, of their shape."""
        phase = (np.asarray(time, dtype=float) - self.start) / self.duration
        inside = (phase > 0) & (phase < 1)
        return np.where(inside, self.peak_force * np.sin(np.pi * phase), 0.0)


def pulse_response(
    poles: ComplexArray,
    residues: ComplexArray,
    pulse: HalfSinePulse,
    time: FloatArray,
) -> FloatArray:
    """Displacements of a system at rest that a pulse hits.

    Parameters
    ----------
    poles : ndarray of complex, shape (k,)
        In rad/s, closed under conjugation.
    residues : ndarray of complex, shape (k, r)
        Residues of the receptances of r displacements; see
        :meth:`flexmech.dynamical_systems.StateModes.residues`.
    pulse : HalfSinePulse
    time : ndarray, shape (N,)
        Ascending, in s.

    Returns
    -------
    ndarray, shape (N, r)
        In m.
    """
    rate, duration = np.pi / pulse.duration, pulse.duration
    since = time - pulse.start
    first, over = np.searchsorted(since, [0.0, duration])
    motion = np.zeros((len(time), residues.shape[1]))
    during, after = since[first:over], since[over:] - duration
    for pole, residue in zip(poles, residues, strict=True):
        if pole.imag < 0:
            continue
        # A pole and its conjugate give twice the real part; a real pole stands alone.
        amount = (2.0 if pole.imag > 0 else 1.0) * pulse.peak_force / (pole**2 + rate**2) * residue
        forced = rate * np.exp(pole * during)
        forced = forced - pole * np.sin(rate * during) - rate * np.cos(rate * during)
        motion[first:over] += (forced[:, None] * amount).real
        lasts = len(after)
        if pole.real < 0:
            lasts = int(np.searchsorted(after, GONE / -pole.real))
        free = rate * (np.exp(pole * duration) + 1) * np.exp(pole * after[:lasts])
        motion[over : over + lasts] += (free[:, None] * amount).real
    return motion
