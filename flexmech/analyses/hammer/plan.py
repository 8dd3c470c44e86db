"""How the records of a hammer test are taken: band, pulse, sampling, duration and force.

The linkage at one locked crank angle: its damped modes and exact receptances.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from flexmech.analyses.hammer.request import HammerRequest
from flexmech.arrays import ROUND_OFF, ComplexArray, FloatArray
from flexmech.choices import LinkDirection, Prestress
from flexmech.dynamical_systems import HalfSinePulse, StateModes, pulse_response, state_modes
from flexmech.errors import InputError
from flexmech.mechanics import Engine, LinearSystem, LinkPoint, point_rows
from flexmech.modal_testing import ExponentialWindow, ForceWindow

# Unreduced systems beyond so many coordinates take longer than their last digits are worth.
_MOST_COORDINATES = 400
# Detail of the component modes that are taken instead: those of links up to eight times the usual
# frequency.
_DETAIL = 8.0
# A mode of a lesser damping ratio never decays: it is round-off.
_LEAST_DAMPING = 1e-8


@dataclass(frozen=True)
class LockedLinkage:
    """A linkage whose crank is locked.

    Parameters
    ----------
    engine : Engine
    angle : float
        Angle of the crank in rad.
    prestress : {"none", "axial", "equilibrium"}
    system : LinearSystem
        At that position alone.
    """

    engine: Engine
    angle: float
    prestress: Prestress
    system: LinearSystem

    @classmethod
    def at(cls, engine: Engine, angle: float, prestress: Prestress) -> LockedLinkage:
        """Lock the crank of a linkage.

        Parameters
        ----------
        engine : Engine
        angle : float
            In rad.
        prestress : {"none", "axial", "equilibrium"}

        Returns
        -------
        LockedLinkage

        Raises
        ------
        InputError
            If the linkage cannot be assembled there.
        ComputationError
            If there is no equilibrium.
        """
        whole = sum(link.size for link in engine.links) <= _MOST_COORDINATES
        chosen = engine.unreduced() if whole else engine
        detail = 1.0 if whole else _DETAIL
        system = chosen.linear_system([angle], 0.0, prestress=prestress, detail=detail)
        return cls(engine, angle, prestress, system)

    @cached_property
    def modes(self) -> StateModes:
        """Poles and damped modes."""
        return state_modes(*self.matrices)

    def poles(self, bandwidth: float) -> ComplexArray:
        """Poles that oscillate below a frequency.

        Parameters
        ----------
        bandwidth : float
            In Hz.

        Returns
        -------
        ndarray of complex, shape (k,)
            With positive imaginary part, by their size.

        Raises
        ------
        InputError
            If one is not damped.
        """
        every = self.modes.poles[self.modes.below(bandwidth)]
        forward = every[every.imag > 0]
        if np.any(-forward.real < _LEAST_DAMPING * np.abs(forward)):
            raise InputError(
                "the linkage is not damped, so that a record never decays; give a damping ratio "
                '(--damping-ratio, such as "0.5%"), or damping in the model file'
            )
        return np.asarray(forward[np.argsort(np.abs(forward))])

    def natural_frequencies(self, count: int) -> FloatArray:
        """Lowest natural frequencies in Hz, (count,) or fewer."""
        poles = self.modes.poles[self.modes.below(np.inf)]
        return np.asarray(np.sort(np.abs(poles[poles.imag > 0]))[:count] / (2 * np.pi))

    def rows(self, points: Sequence[LinkPoint], direction: LinkDirection) -> FloatArray:
        """Displacement of points in the system's coordinates.

        Parameters
        ----------
        points : sequence of LinkPoint
        direction : {"transverse", "axial"}

        Returns
        -------
        ndarray, shape (p, n)

        Raises
        ------
        InputError
            If a point is on no link, or held by a joint.
        """
        rows = np.stack([point_rows(self.system, point, direction)[0] for point in points])
        for point, row in zip(points, rows, strict=True):
            if np.abs(row).max() <= ROUND_OFF:
                raise InputError(
                    f"the point {point} is held by a joint and does not move {direction}ly; give a "
                    "point inside the link, such as "
                    f"{point.link}:0.5"
                )
        return rows

    def motion(
        self, response: FloatArray, force: FloatArray, pulse: HalfSinePulse, time: FloatArray
    ) -> FloatArray:
        """Exact displacements under a pulse.

        Parameters
        ----------
        response : ndarray, shape (r, n)
        force : ndarray, shape (n,)
        pulse : HalfSinePulse
        time : ndarray, shape (N,)

        Returns
        -------
        ndarray, shape (N, r)
            In m.
        """
        residues = self.modes.residues(response, force[None])[:, :, 0]
        return pulse_response(self.modes.poles, residues, pulse, time)

    def station_rows(self) -> FloatArray:
        """Displacement along and across at the stations of all links, (rows, n)."""
        unit = np.eye(self.system.size)[None]
        moved = self.system.displacements(unit)[0]
        return np.asarray(moved.reshape(self.system.size, -1).T)

    @property
    def matrices(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Mass, damping and stiffness, (n, n) each."""
        return self.system.mass[0], self.system.damping[0], self.system.stiffness[0]


# Bandwidth over the highest natural frequency wanted: its peak is to be whole, and the pulse still
# excites it well.
_ABOVE_MODES = 1.25
# Sampling rate over bandwidth, as analysers have it: the anti-aliasing filter falls between.
_SAMPLES_A_HERTZ = 2.56
# Part of the slowest vibration left at the end of a record, window included: what is cut
# off there is below the noise of a good test.
LEFT = 1e-4
# Spectral lines of a record: analysers have twice as many from setting to setting.
_FEWEST_LINES, _MOST_LINES = 200, 6400
# Least samples of a given duration: 50 spectral lines, with which a fit can begin.
_LEAST_SAMPLES = 128
# In periods of the bandwidth: silence before the pulse, and the ringing of the filter after it.
_BEFORE, _AFTER, _TAPER = 6.25, 6.0, 2.0
# Frequency times pulse duration at which the pulse's spectrum has fallen by 20 dB.
_EXCITED = 1.3
# Steps of the transient a sample, and a pulse at least.
_STEPS_A_SAMPLE, STEPS_A_PULSE = 10, 20
# Times as many where they cost nothing: the exact transient's force is sampled more finely.
_EXACT = 4
# More take hours of simulation.
_MOST_STEPS = 4_000_000
# Greatest displacement over the shortest link's length: second-order terms are as small a part.
_DEFLECTION = 1e-6
# Periods of the first mode in which the greatest displacement is looked for, and instants.
_PERIODS, _INSTANTS = 3.0, 300


@dataclass(frozen=True)
class RecordPlan:
    """How records are taken.

    Parameters
    ----------
    bandwidth : float
        Greatest frequency kept in Hz.
    pulse : HalfSinePulse
        With the silence before it.
    sampling_rate : float
        Sampling rate of the records in Hz.
    samples : int
        Samples of a record.
    oversampling : int
        Steps of the transient a sample.
    window : ExponentialWindow or None
    """

    bandwidth: float
    pulse: HalfSinePulse
    sampling_rate: float
    samples: int
    oversampling: int
    window: ExponentialWindow | None

    @property
    def duration(self) -> float:
        """Duration of a record in s."""
        return self.samples / self.sampling_rate

    @property
    def time(self) -> FloatArray:
        """Time of a record's samples in s, shape (N,)."""
        return np.asarray(np.arange(self.samples) / self.sampling_rate)

    @property
    def step(self) -> float:
        """Step of the transient in s."""
        return 1 / (self.sampling_rate * self.oversampling)

    @property
    def decay_rate(self) -> float:
        """Rate in 1/s that the exponential window adds to every pole."""
        return self.window.decay_rate if self.window else 0.0

    @property
    def force_window(self) -> ForceWindow:
        """From the record's begin until the filtered pulse is over."""
        return ForceWindow(self.pulse.end + _AFTER / self.bandwidth, _TAPER / self.bandwidth)


def planned_record(request: HammerRequest, locked: Sequence[LockedLinkage]) -> RecordPlan:
    """Choose what the request leaves open, for all angles alike.

    Parameters
    ----------
    request : HammerRequest
    locked : sequence of LockedLinkage
        At its crank angles.

    Returns
    -------
    RecordPlan

    Raises
    ------
    InputError
        If a mode in the band is not damped, or band, pulse and duration do not belong together.
    """
    bandwidth = _bandwidth(request, locked)
    pulse = 1 / bandwidth if request.pulse is None else request.pulse
    if bandwidth * pulse > _EXCITED * (1 + 1e-9):
        raise InputError(
            f"a pulse of {pulse:g} s excites frequencies up to {_EXCITED / pulse:.4g} Hz, the "
            f"bandwidth is {bandwidth:g} Hz; give a pulse of {1 / bandwidth:.3g} s, or a smaller "
            "bandwidth"
        )
    slowest = min(_slowest(linkage, bandwidth) for linkage in locked)
    rate = _SAMPLES_A_HERTZ * bandwidth
    start = _BEFORE / bandwidth
    samples = _samples(request, bandwidth, start + pulse - np.log(LEFT) / slowest)
    if start + pulse >= samples / rate:
        raise InputError(
            f"the pulse of {pulse:g} s, {start:.3g} s after the record's begin, is longer than the "
            f"record of {samples / rate:.4g} s; give a shorter pulse or a longer duration"
        )
    lasting = samples / rate - start - pulse
    missing = -np.log(LEFT) / lasting - slowest
    oversampling = max(_STEPS_A_SAMPLE, int(np.ceil(STEPS_A_PULSE / (pulse * rate))))
    if not locked[0].engine.simulates:
        oversampling *= _EXACT
    if samples * oversampling > _MOST_STEPS:
        raise InputError(
            f"a record of {samples / rate:.4g} s up to {bandwidth:g} Hz with a pulse of {pulse:g} "
            f"s takes {samples * oversampling} steps, more than {_MOST_STEPS}; give a shorter "
            "duration, a smaller bandwidth or a longer pulse"
        )
    unit = HalfSinePulse(1.0, pulse, start)
    return RecordPlan(
        bandwidth,
        HalfSinePulse(_force(request, locked, unit), pulse, start),
        rate,
        samples,
        oversampling,
        ExponentialWindow(missing) if missing > 1e-3 * slowest else None,
    )


def _bandwidth(request: HammerRequest, locked: Sequence[LockedLinkage]) -> float:
    modes = locked[0].engine.elements * len(locked[0].engine.links)
    carried = min(float(linkage.natural_frequencies(modes)[-1]) for linkage in locked)
    if request.bandwidth is not None:
        if request.bandwidth > carried:
            raise InputError(
                f"a bandwidth of {request.bandwidth:g} Hz is above {carried:.4g} Hz, up to which "
                f"{locked[0].engine.elements} elements a link can vibrate; give a smaller "
                "bandwidth or more elements"
            )
        return request.bandwidth
    highest = max(float(linkage.natural_frequencies(request.modes)[-1]) for linkage in locked)
    wanted = _two_digits(_ABOVE_MODES * highest)
    return wanted if request.pulse is None else min(wanted, 1 / request.pulse)


def _slowest(locked: LockedLinkage, bandwidth: float) -> float:
    """Least rate in 1/s at which a mode of the band decays."""
    poles = locked.poles(bandwidth)
    if not len(poles):
        raise InputError(
            f"no natural frequency lies below {bandwidth:g} Hz, the first at "
            f"{locked.natural_frequencies(1)[0]:.4g} Hz; give a greater bandwidth, or a shorter "
            "pulse"
        )
    return float(-poles.real.max())


def _samples(request: HammerRequest, bandwidth: float, needed: float) -> int:
    """Samples of a record in which a vibration decays, as analysers take them; or those given."""
    if request.duration is None:
        doubled = max(0, int(np.ceil(np.log2(needed * bandwidth / _FEWEST_LINES))))
        wanted: int = _FEWEST_LINES * 2**doubled
        return round(_SAMPLES_A_HERTZ * min(int(wanted), _MOST_LINES))
    samples = 2 * round(_SAMPLES_A_HERTZ * bandwidth * request.duration / 2)
    if samples < _LEAST_SAMPLES:
        raise InputError(
            f"a record of {request.duration:g} s has {samples} samples up to {bandwidth:g} Hz; "
            f"give a duration of {_LEAST_SAMPLES / (_SAMPLES_A_HERTZ * bandwidth):.3g} s or more"
        )
    return samples


def _force(request: HammerRequest, locked: Sequence[LockedLinkage], unit: HalfSinePulse) -> float:
    """Peak force in N by which links move a millionth of the shortest one's length.

    Rounded down to 1, 2 or 5 times a power of ten, so that both engines are hit alike.
    """
    links = locked[0].engine.mechanism.linkage.topology.links
    allowed = _DEFLECTION * min(link.length for link in links)
    greatest = 0.0
    for linkage in locked:
        period = 1 / linkage.natural_frequencies(1)[0]
        time = unit.start + np.linspace(0.0, unit.duration + _PERIODS * period, _INSTANTS)
        hit = linkage.rows([request.impact], request.direction)[0]
        greatest = max(
            greatest, float(np.abs(linkage.motion(linkage.station_rows(), hit, unit, time)).max())
        )
    power = 10.0 ** np.floor(np.log10(allowed / greatest))
    return float(max(round(n * power, 15) for n in (1, 2, 5) if n * power <= allowed / greatest))


def _two_digits(value: float) -> float:
    """Rounded up to two significant digits."""
    unit = 10.0 ** (np.floor(np.log10(value)) - 1)
    return float(np.ceil(value / unit * (1 - 1e-12)) * unit)
