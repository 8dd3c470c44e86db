"""What one engine finds of the stability of the running linkage: modes and unstable bands."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flexmech.analyses.stability.growth import Sample
from flexmech.analyses.stability.selected_modes import GROWS, FloquetExponents
from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system import Engine

Kind = Literal["principal", "sum", "difference", "divergence", "unnamed"]
# ``f_a + f_a``, ``f_a + f_b`` or ``f_a - f_b`` a multiple of the crank's frequency, growth without
# oscillation, or none of these for certain.
KINDS: tuple[Kind, ...] = ("principal", "sum", "difference", "divergence", "unnamed")


@dataclass(frozen=True)
class BandEdge:
    """Where growth begins or ends.

    Parameters
    ----------
    crank_speed : float
        rad/s.
    step_error, reduction_error, mesh_error : float
        Parts of its error in rad/s; not a number where the band is open.
    is_open : bool
        Whether the band goes on beyond: the range of speeds, or the equilibrium, ends here.
    """

    crank_speed: float
    step_error: float
    reduction_error: float
    mesh_error: float
    is_open: bool

    @property
    def error(self) -> float:
        """Sum of the parts in rad/s."""
        return self.step_error + self.reduction_error + self.mesh_error


@dataclass(frozen=True)
class Band:
    """Neighbouring crank speeds at which a vibration grows.

    Parameters
    ----------
    lower, upper : BandEdge
    kind : Kind
    branches : tuple of int
        Numbers a, b of the branches that meet, from 1.
    order : int
        The n of ``f_a + f_b = n f_crank`` or ``f_a - f_b = n f_crank``; 0 without a name.
    largest_growth_rate : float
        1/s.
    fastest_speed : float
        Where it grows most, rad/s.
    closing_damping_ratio : float
        NaN if no damping ratio below 1 closes it.
    mismatch : float
        How far the frequencies are from the name, relative to the crank's frequency.
    signatures : tuple of float
        Krein signatures of the two multipliers that meet, beside the band of the undamped linkage;
        not a number without a name.
    """

    lower: BandEdge
    upper: BandEdge
    kind: Kind
    branches: tuple[int, ...]
    order: int
    largest_growth_rate: float
    fastest_speed: float
    closing_damping_ratio: float
    mismatch: float
    signatures: tuple[float, float]

    @property
    def error(self) -> float:
        """Greater of the edges' errors in rad/s; not a number where both are open."""
        return float(np.fmax(self.lower.error, self.upper.error))


@dataclass(frozen=True)
class TrackedSpeed(FloquetExponents):
    """Selected Floquet modes of a crank speed, in the order of the branches that they belong to.

    Branch b has the modes 2 b - 2 and 2 b - 1, counted from zero: the one that turns forward and
    its complex conjugate; where both are real, they are two modes of their own.

    Parameters
    ----------
    crank_speed : float
        rad/s.
    exponent : ndarray of complex, shape (k,)
        In 1/s; of the family ``lambda + i n omega`` the member with the largest harmonic.
    step_error : ndarray, shape (k,)
        Of the logarithm of each multiplier, by halving the steps.
    likeness : ndarray, shape (k,)
        How alike a mode is to the last unmixed shape of its branch: 1 for the same shape.
    harmonic_share : ndarray, shape (2 h + 1, k)
        Parts of the mean square displacement in the harmonics -h to h about the largest.
    krein_signature : ndarray, shape (k,)
        Of the undamped linkage's modes: zero where the multiplier is not on the unit circle.
    liouville_defect : float
    steps : int
    buckled_angle : float or None
        A crank angle in rad at which the linkage is statically unstable.
    orbit_distance : float or None
        Of the periodic motion from the quasi-static equilibrium, relative to the greatest
        displacement; with prestress ``trajectory`` alone.
    orbit_residual : float or None
        Of the periodic motion, relative to the inertia forces.
    rigid : ndarray of complex, shape (2 r,)
        Exponents in 1/s of the free shaft's own motion, which is none of the modes.
    """

    step_error: FloatArray
    likeness: FloatArray
    harmonic_share: FloatArray
    krein_signature: FloatArray
    liouville_defect: float
    steps: int
    buckled_angle: float | None = None
    orbit_distance: float | None = None
    orbit_residual: float | None = None
    rigid: NDArray[np.complex128] = field(default_factory=lambda: np.zeros(0, dtype=complex))

    @property
    def shaft_growth_rate(self) -> float | None:
        """Growth rate of the free shaft's own motion in 1/s; None where the shaft is not free."""
        return float(self.rigid.real.max()) if len(self.rigid) else None

    @property
    def branch(self) -> IntArray:
        """Number of each mode's branch, from 1, (k,)."""
        return np.arange(len(self.exponent)) // 2 + 1

    def signature_of(self, frequency: float, sense: int) -> float:
        """Krein signature of the mode of a frequency in Hz that turns forward (1) or back (-1).

        Of the nearest one: branches change places where their modes are mixtures.
        """
        nearest = int(np.abs(np.log(self.frequency[::2] / frequency)).argmin())
        own = slice(2 * nearest, 2 * nearest + 2)
        place = 2 * nearest + int((sense * self.exponent.imag[own]).argmax())
        return float(self.krein_signature[place])

    @property
    def frequency(self) -> FloatArray:
        """Of the largest harmonic in Hz, (k,)."""
        return np.abs(self.exponent.imag) / (2 * np.pi)

    @property
    def damping_ratio(self) -> FloatArray:
        """Of the largest harmonic: decay rate over the size of the exponent, (k,)."""
        return np.asarray(-self.exponent.real / np.abs(self.exponent))

    @property
    def is_unstable(self) -> bool:
        """Whether a modulus exceeds one by more than its error."""
        # Both multipliers of a steady shaft meet at one, and round-off about them is greater.
        return self.grows_beyond(np.maximum(self.step_error, GROWS if len(self.rigid) else 0.0))


@dataclass(frozen=True)
class NoEquilibrium:
    """A crank speed about which there is no motion to linearize.

    Parameters
    ----------
    crank_speed : float
        rad/s.
    reason : str
        Speaks of crank speeds in the result's unit.
    """

    crank_speed: float
    reason: str


@dataclass(frozen=True)
class ExponentErrors:
    """Greatest relative errors of the selected modes' exponents at a speed.

    Parameters
    ----------
    crank_speed : float
        rad/s.
    reduction, mesh, theory : float
        Change with the next larger number of moving modes; estimated error by the elements'
        length; change by beams of the next finer theory that the engine has. Not a number where
        linkages of that kind have no equilibrium at the speed.
    growth : float
        What all three change of the logarithm of the largest multiplier's modulus; not a number
        where one of them is not known.
    """

    crank_speed: float
    reduction: float
    mesh: float
    theory: float
    growth: float


@dataclass(frozen=True)
class EngineStability:
    """Stability map of one engine.

    Parameters
    ----------
    engine : Engine
        With the damping that counts.
    speeds : list of TrackedSpeed or NoEquilibrium
        In the order of the crank speeds asked for.
    bands : list of Band
        Unstable bands, by increasing speed.
    growth : list of Sample
        Growth at all speeds of the range that it is known at, in any order.
    errors : list of ExponentErrors
        At some speeds without growth.
    is_definite : bool
        Whether the Hamilton function of the undamped linkage is positive definite at all speeds,
        so that only sums of frequencies can be unstable without damping.
    moving_modes : int
        Number of moving modes at the fastest speed.
    closed_early : int
        Unstable bands so narrow that a damping ratio of 1e-5 closes them; they are left out.
    interrupted : bool
        Whether the map ends before the last of the speeds because it was interrupted.
    """

    engine: Engine
    speeds: list[TrackedSpeed | NoEquilibrium]
    bands: list[Band]
    growth: list[Sample]
    errors: list[ExponentErrors]
    is_definite: bool
    moving_modes: int
    closed_early: int
    interrupted: bool
