"""Growth of one engine's running linkage: its measure over the crank speed, modes and bands.

The measure changes its sign at the edge of an unstable band.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Literal

import numpy as np
import scipy.optimize
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, IntArray
from flexmech.mechanics import Engine
from flexmech.solvers.floquet_modes import (
    GROWS,
    FloquetExponents,
    SelectedModes,
    VibratingLinkage,
    wrapped,
)
from flexmech.solvers.stability import LinkageSolver


@dataclass(frozen=True)
class Sample:
    """Growth at a crank speed.

    Parameters
    ----------
    crank_speed : float
        rad/s.
    signed_growth : float
        Positive where a vibration grows; see
        :class:`flexmech.analyses.stability.growth.SignedGrowth`.
    growth_rate : float
        1/s.
    """

    crank_speed: float
    signed_growth: float
    growth_rate: float


@dataclass(frozen=True)
class RunOfGrowth:
    """Samples without one between them at which nothing grows.

    Parameters
    ----------
    samples : list of Sample
        By increasing speed.
    before, after : float or None
        Nearest speeds at which nothing grows; None where the samples end, or a speed without
        equilibrium comes first.
    """

    samples: list[Sample]
    before: float | None
    after: float | None

    @property
    def brackets(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Speeds inside and outside of the lower and of the upper edge; the same where open."""
        first, last = self.samples[0].crank_speed, self.samples[-1].crank_speed
        lower = first if self.before is None else self.before
        upper = last if self.after is None else self.after
        return (first, lower), (last, upper)

    @property
    def fastest(self) -> float:
        """Speed of the sample that grows most."""
        return max(self.samples, key=lambda sample: sample.growth_rate).crank_speed


def runs_of_growth(samples: Sequence[Sample], refused: Sequence[float]) -> list[RunOfGrowth]:
    """Find the runs.

    Parameters
    ----------
    samples : sequence of Sample
        In any order.
    refused : sequence of float
        Crank speeds without equilibrium.

    Returns
    -------
    list of RunOfGrowth
        By increasing speed.
    """
    ordered = sorted(samples, key=lambda sample: sample.crank_speed)
    runs: list[RunOfGrowth] = []
    here: list[Sample] = []
    before: float | None = None
    last: float | None = None

    def end(after: float | None) -> None:
        if here:
            runs.append(RunOfGrowth(here.copy(), before, after))
            here.clear()

    for sample in ordered:
        gap = last is not None and any(last < speed < sample.crank_speed for speed in refused)
        if gap:
            end(None)
        if sample.signed_growth > 0:
            if not here:
                before = None if gap else last
            here.append(sample)
        else:
            end(sample.crank_speed)
        last = sample.crank_speed
    end(None)
    return runs


def speeds_between(samples: Sequence[Sample], step: float, refused: Sequence[float]) -> list[float]:
    """Speeds between neighbouring samples that grow, no farther apart than a step.

    Parameters
    ----------
    samples : sequence of Sample
        In any order.
    step : float
        rad/s.
    refused : sequence of float
        Crank speeds without equilibrium; nothing is asked for across them.

    Returns
    -------
    list of float
    """
    speeds: list[float] = []
    ordered = sorted(samples, key=lambda sample: sample.crank_speed)
    for first, last in pairwise(ordered):
        low, high = first.crank_speed, last.crank_speed
        grows = first.signed_growth > 0 and last.signed_growth > 0
        if grows and not any(low < speed < high for speed in refused):
            count = math.ceil((high - low) / step)
            speeds += [low + (high - low) * number / count for number in range(1, count)]
    return speeds


# Part of the distance of a dip's neighbours: two bands whose gap is narrower stay
# one.
NARROWEST_GAP = 0.02


@dataclass(frozen=True)
class Dip:
    """A sample that grows less than both its neighbours: a band may end there, and another begin.

    Parameters
    ----------
    before, lowest, after : Sample
    """

    before: Sample
    lowest: Sample
    after: Sample


def dips(samples: Sequence[Sample], refused: Sequence[float]) -> list[Dip]:
    """Dips of the growth inside runs.

    Parameters
    ----------
    samples : sequence of Sample
        In any order.
    refused : sequence of float
        Crank speeds without equilibrium.

    Returns
    -------
    list of Dip
    """
    return [
        Dip(before, here, after)
        for run in runs_of_growth(samples, refused)
        for before, here, after in zip(run.samples, run.samples[1:], run.samples[2:], strict=False)
        if here.signed_growth < min(before.signed_growth, after.signed_growth)
    ]


def speeds_inside(runs: Sequence[RunOfGrowth], parts: int, least_width: float) -> list[float]:
    """Speeds inside runs, closer together towards their ends, where growth is steep.

    Parameters
    ----------
    runs : sequence of RunOfGrowth
    parts : int
        Into which the range between the nearest speeds without growth is divided.
    least_width : float
        Narrower ranges have none, rad/s.

    Returns
    -------
    list of float
    """
    share = (1 - np.cos(np.pi * np.arange(1, parts) / parts)) / 2
    ranges = [(lower[1], upper[1]) for lower, upper in (run.brackets for run in runs)]
    return [
        float(speed)
        for low, high in ranges
        if high - low >= least_width
        for speed in low + (high - low) * share
    ]


@dataclass(frozen=True)
class SignedGrowth:
    """Positive where a vibration grows, negative where none does, zero at the edge of a band.

    With damping or follower forces it is the greatest growth rate in 1/s. Without, that is
    zero outside of bands; but where modes a and b meet, ``((lambda_a - conj(lambda_b)) / 2)^2``
    is the square of the growth rate in the band, negative beside it, and smooth.

    Parameters
    ----------
    solver : LinkageSolver
    """

    solver: LinkageSolver

    def __call__(self, crank_speed: float) -> float:
        """Measure at a crank speed in rad/s."""
        return self.at(self.solver.moving(crank_speed))

    def sample(self, crank_speed: float) -> Sample:
        """Measure and growth rate at a crank speed in rad/s."""
        moving = self.solver.moving(crank_speed)
        if not self.solver.is_hamiltonian:
            growth = self.solver.growth_at(moving)
            return Sample(crank_speed, growth, growth)
        modes = self.solver.solve(moving)
        return Sample(crank_speed, self._of(modes), modes.growth_rate)

    def into(self, dip: Dip) -> list[Sample]:
        """Samples towards the bottom of a dip, up to one at which nothing grows."""
        samples: list[Sample] = []

        def measure(crank_speed: float) -> float:
            samples.append(self.sample(crank_speed))
            if samples[-1].signed_growth <= 0:
                raise StopIteration
            return samples[-1].signed_growth

        ends = dip.before.crank_speed, dip.after.crank_speed
        options = {"xatol": NARROWEST_GAP * (ends[1] - ends[0])}
        with suppress(StopIteration):
            scipy.optimize.minimize_scalar(measure, bounds=ends, method="bounded", options=options)
        return samples

    def at(self, moving: VibratingLinkage) -> float:
        """Measure of a linkage in its moving modes."""
        if not self.solver.is_hamiltonian:
            return self.solver.growth_at(moving)
        return self._of(self.solver.solve(moving))

    def _of(self, modes: SelectedModes) -> float:
        return self.of_exponents(modes.exponent, modes.period)

    def of_exponents(self, exponent: NDArray[np.complex128], period: float) -> float:
        """Measure of exponents (k,) in 1/s that are known, of a turn's time in s."""
        growth = float(exponent.real.max())
        if not self.solver.is_hamiltonian:
            return growth
        if growth * period > GROWS:
            return growth**2
        return -(nearest_meeting(exponent, period) ** 2)


def nearest_meeting(exponent: NDArray[np.complex128], period: float) -> float:
    """Half of the least angular velocity by which two modes of opposite sense pass, in rad/s.

    Either mode of a conjugate pair may be kept: the other one turns as fast the other way.
    """
    forward = np.abs(exponent.imag) * period
    total = forward[:, None] + forward
    return float(np.abs(wrapped(total)).min() / (2 * period))


YES, NO, NO_EQUILIBRIUM = "yes", "no", "no equilibrium"
# State of speeds that an interrupted map has not reached.
NOT_COMPUTED = "not computed"
EDGES, PARTS = ("lower", "upper"), ("step", "reduction", "mesh")

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
        Step error of the logarithm of each multiplier, by halving the steps.
    likeness : ndarray, shape (k,)
        How alike a mode is to the last unmixed shape of its branch: 1 for the same shape.
    harmonic_share : ndarray, shape (2 h + 1, k)
        Parts of the mean square displacement in the harmonics -h to h about the largest.
    krein_signature : ndarray, shape (k,)
        Krein signature of the undamped linkage's modes: zero where the multiplier is not on the
        unit circle.
    liouville_defect : float
    steps : int
    buckled_angle : float or None
        A crank angle in rad at which the linkage is statically unstable.
    orbit_distance : float or None
        Distance of the periodic motion from the quasi-static equilibrium, relative to the
        greatest displacement; with prestress ``trajectory`` alone.
    orbit_residual : float or None
        Residual of the periodic motion, relative to the inertia forces.
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

        The nearest frequency counts: branches change places where their modes are mixtures.
        """
        nearest = int(np.abs(np.log(self.frequency[::2] / frequency)).argmin())
        pair = slice(2 * nearest, 2 * nearest + 2)
        place = 2 * nearest + int((sense * self.exponent.imag[pair]).argmax())
        return float(self.krein_signature[place])

    @property
    def frequency(self) -> FloatArray:
        """Frequency of the largest harmonic in Hz, (k,)."""
        return np.abs(self.exponent.imag) / (2 * np.pi)

    @property
    def damping_ratio(self) -> FloatArray:
        """Damping ratio of the largest harmonic: decay rate over the size of the exponent, (k,)."""
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
    speed : float
        Speed of the crank in rad/s.
    reduction, mesh, theory : float
        Change with the next larger number of moving modes; estimated error by the elements'
        length; change by beams of the next finer theory that the engine has. Not a number where
        linkages of that kind have no equilibrium at the speed.
    growth : float
        What all three change of the logarithm of the largest multiplier's modulus; not a number
        where one of them is not known.
    """

    speed: float
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
