"""Linear and periodic systems without a linkage: modes, stability, response, and filters.

This room knows arrays and functions of time alone and nothing of mechanisms: Fourier series,
transition matrices of ``x' = A(t) x`` by the Magnus expansion, Floquet modes and their Krein
signatures, harmonic transfer functions of periodic systems, the frequency response and the response
to a pulse of constant ones, Lobatto's integration methods, and low-pass filters.

Examples
--------
Mathieu's equation ``y'' + (1 + 0.4 cos 2 t) y = 0`` is unstable in its principal region:

>>> import numpy as np
>>> from flexmech.dynamical_systems import StatedPeriodicSystem, floquet_modes
>>> def matrix(time):
...     stiffness = 1 + 0.4 * np.cos(2 * time)
...     return np.array([[[0.0, 1.0], [-k, 0.0]] for k in stiffness])
>>> modes = floquet_modes(StatedPeriodicSystem(matrix, np.pi), steps=64)
>>> [round(float(growth), 4) for growth in modes.exponent.real]
[0.0995, -0.0995]
"""

from flexmech.dynamical_systems.constant_systems import (
    HalfSinePulse,
    StateModes,
    direct_receptance,
    pulse_response,
    state_modes,
)
from flexmech.dynamical_systems.floquet import (
    FloquetModes,
    PeriodicSystem,
    SampledPeriodicSystem,
    StatedPeriodicSystem,
    floquet_modes,
    krein_signature,
    magnus_exponents,
    matrix_exponentials,
    transition_matrices,
)
from flexmech.dynamical_systems.fourier import FourierSeries, differentiation_matrices
from flexmech.dynamical_systems.harmonic_response import (
    ForcedPeriodicSystem,
    balanced_response,
    harmonic_response,
)
from flexmech.dynamical_systems.lobatto import (
    EquationsOfMotion,
    VibrationState,
    initial_state,
    march,
    parabolic_work,
    step_matrices,
)
from flexmech.dynamical_systems.signals import (
    ON_A_STEP,
    LowPass,
    hermite_interpolation,
    linear_interpolation,
    look_ahead,
    sample_intervals,
)

__all__ = [
    "ON_A_STEP",
    "EquationsOfMotion",
    "FloquetModes",
    "ForcedPeriodicSystem",
    "FourierSeries",
    "HalfSinePulse",
    "LowPass",
    "PeriodicSystem",
    "SampledPeriodicSystem",
    "StateModes",
    "StatedPeriodicSystem",
    "VibrationState",
    "balanced_response",
    "differentiation_matrices",
    "direct_receptance",
    "floquet_modes",
    "harmonic_response",
    "hermite_interpolation",
    "initial_state",
    "krein_signature",
    "linear_interpolation",
    "look_ahead",
    "magnus_exponents",
    "march",
    "matrix_exponentials",
    "parabolic_work",
    "pulse_response",
    "sample_intervals",
    "state_modes",
    "step_matrices",
    "transition_matrices",
]
