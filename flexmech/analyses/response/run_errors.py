"""How far two runs of an engine differ, and what is left of that as their error."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.analyses.response.measurements import deflections, peaks_between
from flexmech.analyses.response.stresses import greatest_stresses
from flexmech.arrays import ROUND_OFF, FloatArray
from flexmech.dynamical_systems import LowPass
from flexmech.linear_system import Engine
from flexmech.linkages import Drive
from flexmech.time_domain import Trajectory, step_lag

# What is left of an error, over what the last halving has changed, of a run or of the extrapolated
# one. Of second order that is a third, and of the extrapolated run far less but where motion is too
# fast for the steps. Where links stretch fast motion is resolved last: 0.1 to 1.2 were left of
# deflections and 0.1 to 0.9 of joint forces, in runs of random mechanisms.
_LEFT, _LEFT_WHERE_LINKS_STRETCH = 1 / 3, 2 / 3
# A vibration that has run out of phase by so much in the longer of two steps, in rad, is not
# resolved: extrapolation from the two does not mend it. Up to twice as much, a third of what
# halving changes is a bound.
_OUT_OF_PHASE = 1.0
# Forces below this part of the greatest are the round-off of none.
_NO_FORCE = 1e-9


def order_of_steps(*, stretches: bool) -> int:
    """Order of the method's error, by which runs with two steps are extrapolated.

    Parameters
    ----------
    stretches : bool
        Whether the method is that of links that stretch.
    """
    return 4 if stretches else 2


@dataclass(frozen=True)
class RunError:
    """How far histories and their peaks are off, each over its own peak.

    A vibration that runs out of phase changes a history far more than its peak.

    Parameters
    ----------
    linkage : float
        Of the deflections of all links, over the greatest peak among them, fast or not: what a step
        is chosen by.
    of : dict of str to ndarray
        ``deflection`` and ``peak_deflection``, ``stress`` and ``peak_stress`` of each link
        (n_links,), ``force`` and ``peak_force`` of each joint (n_joints,), ``torque`` and
        ``peak_torque`` (1,).
    """

    linkage: float
    of: dict[str, FloatArray]

    def with_all(self, value: float) -> RunError:
        """The same, with one error of everything."""
        return RunError(value, {name: np.full_like(own, value) for name, own in self.of.items()})

    def __mul__(self, factor: float) -> RunError:
        """The same, a factor greater."""
        of = {name: factor * value for name, value in self.of.items()}
        return RunError(factor * self.linkage, of)


@dataclass(frozen=True)
class Remainder:
    """What is left of a change of the histories, as their error.

    Parameters
    ----------
    part : float
        Of the change.
    fast : float
        Of what the change has of vibration that is faster than ``resolved``.
    resolved : float
        In Hz.
    """

    part: float = 1.0
    fast: float = 1.0
    resolved: float = np.inf

    @classmethod
    def by_halving(cls, step: float, duration: float, *, stretches: bool) -> Remainder:
        """What is left of the change by halving a step, by extrapolation from both.

        A vibration that is out of phase in both runs, each by any angle, is off by up to
        ``2^p / (2^p - 1)`` of the greatest change, with the order p of the method.

        Parameters
        ----------
        step : float
            The longer one, in s.
        duration : float
            Of the run in s, in which a vibration runs out of phase.
        stretches : bool
            Whether the method is that of links that stretch.
        """
        order = order_of_steps(stretches=stretches)
        part = _LEFT_WHERE_LINKS_STRETCH if stretches else _LEFT
        # The phase goes with the power p + 1 of the frequency.
        phase = duration / step * step_lag(1.0, stretches=stretches)
        resolved = (_OUT_OF_PHASE / phase) ** (1 / (order + 1)) / (2 * np.pi * step)
        return cls(part, 2**order / (2**order - 1), resolved)


def difference_of_runs(
    first: tuple[Engine, Trajectory],
    finer: tuple[Engine, Trajectory],
    drive: Drive,
    left: Remainder | None = None,
) -> RunError:
    """Greatest differences over the peaks, or what is left of them; none of round-off of nothing.

    Peaks of histories whose fast parts are not resolved are off by as much as these.

    Parameters
    ----------
    first, finer : tuple of Engine and Trajectory
        At the same samples.
    drive : Drive
    left : Remainder, optional
        What is left of the differences; all by default.

    Returns
    -------
    RunError
    """
    left = Remainder() if left is None else left
    before, after = _histories(*first, drive), _histories(*finer, drive)
    engine, second = finer
    extent = sum(link.length for link in engine.mechanism.linkage.topology.links)
    nothing = _NO_FORCE * max(float(second.peak_joint_force.max()), np.finfo(float).tiny)
    deflected, stressed = (_sizes(after[of][0]).max(axis=0) for of in ("deflection", "stress"))
    scales = {
        "deflection": np.maximum(deflected, ROUND_OFF * extent),
        # Of links whose stress is not known it is zero.
        "stress": np.where(stressed > 0, stressed, 1.0),
        "force": np.maximum(second.peak_joint_force, nothing),
        "torque": np.maximum(second.peak_driving_torque, nothing * extent),
    }
    if "frame" in after:
        scales["frame"] = np.maximum(after["frame"][1], ROUND_OFF * extent)
    errors: dict[str, FloatArray] = {}
    linkage = 0.0
    for name, scale in scales.items():
        (was, reached), (now, reaches) = before[name], after[name]
        change = now - was
        fast = (left.fast - left.part) * _faster(change, second.time, left.resolved)
        apart = _sizes(left.part * change + fast).max(axis=0)
        higher = np.maximum(np.abs(reaches - reached), _at_peaks(_sizes(was), _sizes(now)))
        peak = left.part * higher + _sizes(fast).max(axis=0)
        errors |= {name: apart / scale, f"peak_{name}": peak / scale}
        if name == "deflection":
            linkage = float(left.part * _sizes(change).max() / scale.max())
    return RunError(linkage, errors)


def _histories(
    engine: Engine, run: Trajectory, drive: Drive
) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Histories (N, k, components) of what has an error, and their peaks (k,)."""
    deflection, stress = (
        deflections(engine, run.displacement),
        greatest_stresses(engine, run, drive),
    )
    found = {
        "deflection": (deflection[..., None], peaks_between(deflection, run.time)[0]),
        "stress": (stress[..., None], peaks_between(stress, run.time)[0]),
        "force": (run.joint_force, run.peak_joint_force),
        "torque": (run.driving_torque[:, None, None], np.array([run.peak_driving_torque])),
    }
    if run.frame is not None:
        moved = run.frame.displacement[:, None, :2]
        found["frame"] = moved, _sizes(moved).max(axis=0)
    return found


def _faster(history: FloatArray, time: FloatArray, frequency: float) -> FloatArray:
    """What histories (N, k, components) have of vibration faster than a frequency in Hz."""
    smooth = LowPass(frequency, float(time[1] - time[0]))
    if not smooth.half:
        return np.zeros_like(history)
    columns = history.reshape(len(history), -1)
    slow = np.concatenate([smooth.add(columns), smooth.finish()])
    return np.asarray(history - slow.reshape(history.shape))


def _sizes(history: FloatArray) -> FloatArray:
    """Lengths (N, k) of vectors (N, k, components)."""
    return np.asarray(np.linalg.norm(history, axis=-1))


def _at_peaks(first: FloatArray, second: FloatArray) -> FloatArray:
    """How far sizes (N, k) of histories differ where the second of them peak, (k,).

    Two peaks at different instants may be equally high by chance; at one instant a shift of
    phase counts in second order alone, and what else is off shows.
    """
    columns, number = np.arange(second.shape[1]), second.argmax(axis=0)
    return np.asarray(np.abs(second - first)[number, columns])
