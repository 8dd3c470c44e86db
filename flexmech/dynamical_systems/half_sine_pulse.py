r"""A half-sine pulse, its spectrum, and the exact response of a constant system to it.

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
from numpy.typing import ArrayLike

from flexmech.numbers import NOT_NEGATIVE, POSITIVE, check_number
from flexmech.types import ComplexArray, FloatArray

# Where numerator and denominator of the spectrum vanish together, f T = 1/2.
NEAR_HALF = 1e-6
# What has decayed by exp(-GONE) is below the round-off of what remains.
GONE = 45.0


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
        """When it is over, in s."""
        return self.start + self.duration

    @property
    def momentum(self) -> float:
        """Its integral in N s."""
        return 2 * self.peak_force * self.duration / np.pi

    def force(self, time: ArrayLike) -> FloatArray:
        """Force in N at times in s, of their shape."""
        phase = (np.asarray(time, dtype=float) - self.start) / self.duration
        inside = (phase > 0) & (phase < 1)
        return np.where(inside, self.peak_force * np.sin(np.pi * phase), 0.0)

    def spectrum(self, frequency: ArrayLike) -> ComplexArray:
        """Fourier integral of the force in N s, ``int f(t) exp(-2j pi f t) dt``.

        Parameters
        ----------
        frequency : array_like
            In Hz.

        Returns
        -------
        ndarray of complex, of the same shape
        """
        frequency = np.asarray(frequency, dtype=float)
        periods = frequency * self.duration
        half = np.abs(np.abs(periods) - 0.5) < NEAR_HALF
        safe = np.where(half, 0.0, periods)
        # Both vanish at one half, where the limit is pi / 4.
        ratio = np.where(half, np.pi / 4, np.cos(np.pi * safe) / (1 - 4 * safe**2))
        delay = np.exp(-2j * np.pi * frequency * (self.start + self.duration / 2))
        return np.asarray(self.momentum * ratio * delay)


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
        Of the receptances of r displacements; see
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
