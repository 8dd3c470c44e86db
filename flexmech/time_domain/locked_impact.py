r"""Exact motion of a constant system under a half-sine pulse.

Each pole answers the pulse in closed form. With :math:`\omega = \pi / T` and time :math:`\tau`
from the pulse's start,

.. math:: g_k(\tau) = F \frac{\omega e^{\lambda_k \tau} - \lambda_k \sin \omega \tau
          - \omega \cos \omega \tau}{\lambda_k^2 + \omega^2}, \quad \tau \le T,

and afterwards it decays freely: :math:`g_k(T) e^{\lambda_k (\tau - T)}`. The displacement is
:math:`\sum_k R_k g_k`. There is no time step and no error of one. The equations stand in
docs/theory/hammer_test.md.
"""

from __future__ import annotations

import numpy as np

from flexmech.time_domain.pulse import HalfSinePulse
from flexmech.types import ComplexArray, FloatArray

# What has decayed by exp(-GONE) is below the round-off of what remains.
GONE = 45.0


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
        :meth:`flexmech.time_domain.frequency_response.StateModes.residues`.
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
