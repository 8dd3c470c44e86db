"""What a strain gauge or a dial gauge on a running linkage would read.

Spectra of a response: over the whole run, and over a window that moves along it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import ShortTimeFFT, get_window, periodogram

from flexmech.arrays import FloatArray
from flexmech.linkages import LinkEnd, RigidMotion
from flexmech.linkages.motion import direction, normal
from flexmech.mechanics import Engine, LinkModel
from flexmech.mechanics.running import Trajectory


def probes(engine: Engine) -> list[str]:
    """Where each link's deflection is read: the ``tip`` of a clamped link, else the ``middle``."""
    topology = engine.mechanism.linkage.topology
    clamped = {clamp.link_end.link for clamp in topology.clamps}
    return ["tip" if name in clamped else "middle" for name in topology.link_names]


def deflections(engine: Engine, displacement: Sequence[FloatArray]) -> FloatArray:
    """Deflection of every link at its probe, positive along the link frame's y axis.

    Of the middle from the straight line between the link's own ends, or of a clamped link's
    tip from the clamped tangent.

    Parameters
    ----------
    engine : Engine
    displacement : sequence of ndarray, shape (N, n_link)
        Displacement of each link in the frame of its rigid motion.

    Returns
    -------
    ndarray, shape (N, n_links)
        In m.
    """
    parts = []
    bodies = engine.mechanism.linkage.topology.links
    for body, link, place, q in zip(
        bodies, engine.links, probes(engine), displacement, strict=True
    ):
        if link.rigid:
            parts.append(np.zeros(len(q)))
            continue
        stations = [0, len(link.shape) // 2, -1]
        start, middle, end = np.einsum("scn,bn->sbc", link.shape[stations], q)
        if place == "tip":
            parts.append(end[:, 1] - start[:, 1])
        else:
            parts.append(_off_chord(start, middle, end, body.length))
    return np.stack(parts, axis=1)


def _off_chord(start: FloatArray, middle: FloatArray, end: FloatArray, length: float) -> FloatArray:
    """Distance of the middle from the line between the displaced ends, to its left."""
    along = np.array([length, 0.0])
    chord = along + end - start
    arm = along / 2 + middle - start
    cross = chord[:, 0] * arm[:, 1] - chord[:, 1] * arm[:, 0]
    return np.asarray(cross / np.hypot(chord[:, 0], chord[:, 1]))


def bending_strains(engine: Engine, trajectory: Trajectory) -> FloatArray:
    """Bending strain in the middle of every link, of the surface on its frame's +y side.

    Positive where that surface is stretched, as it is by a positive deflection of a pinned
    link.

    Parameters
    ----------
    engine : Engine
    trajectory : Trajectory
        N samples.

    Returns
    -------
    ndarray, shape (N, n_links)
    """
    pairs = zip(engine.links, trajectory.displacement, strict=True)
    return np.stack([q @ surface_strain(engine, link) for link, q in pairs], axis=1)


def surface_strain(engine: Engine, link: LinkModel) -> FloatArray:
    """Bending strain in the middle of a link by its coordinates, of the surface at its +y side.

    Parameters
    ----------
    engine : Engine
    link : LinkModel
        Link of the engine.

    Returns
    -------
    ndarray, shape (n_link,)
        Zero for a rigid link, whatever it is made of.
    """
    section = engine.mechanism.sections.get(link.name)
    thickness = 0.0 if section is None else section.in_plane_thickness
    return np.asarray(-thickness / 2 * link.curvature)


def ground_displacements(engine: Engine, trajectory: Trajectory, motion: RigidMotion) -> FloatArray:
    """Elastic displacement at the stations of every link in ground axes.

    Parameters
    ----------
    engine : Engine
    trajectory : Trajectory
    motion : RigidMotion
        At the N samples.

    Returns
    -------
    ndarray, shape (N, n_links, n_stations, 2)
    """
    along, across = direction(motion.angle), normal(motion.angle)
    parts = []
    for number, (link, q) in enumerate(zip(engine.links, trajectory.displacement, strict=True)):
        local = np.einsum("scn,bn->bsc", link.shape, q)
        axes = np.stack([along[:, number], across[:, number]], axis=1)
        parts.append(local @ axes)
    return np.stack(parts, axis=1)


def constraint_drift(engine: Engine, displacement: FloatArray, motion: RigidMotion) -> float:
    """Greatest violation of the constraints of pins, clamps and pivots in position, in m.

    Parameters
    ----------
    engine : Engine
    displacement : ndarray, shape (N, n_links, n_stations, 2)
        Displacement of :func:`ground_displacements`.
    motion : RigidMotion
        At the N samples.

    Returns
    -------
    float
    """
    topology = engine.mechanism.linkage.topology

    def elastic(end: LinkEnd) -> FloatArray:
        return displacement[:, topology.index(end.link), 0 if end.end == "start" else -1]

    def place(end: LinkEnd) -> FloatArray:
        return elastic(end) + motion.position(*topology.end_place(end))

    gaps = [place(pin.follower) - place(topology.leader_of(pin.leader)) for pin in topology.pins]
    gaps += [elastic(clamp.link_end) for clamp in topology.clamps]
    gaps += [elastic(pivot.link_end) for pivot in topology.pivots]
    return float(max(np.hypot(gap[:, 0], gap[:, 1]).max() for gap in gaps))


_WINDOW = "hann"
# Window of signals that repeat: over whole periods none is needed.
WHOLE_PERIODS = "boxcar"
# Distance of two frequencies that a Hann window tells apart, over one by its length: half the
# width of its main lobe.
_RESOLVED = 2.0
# Length of the moving window in periods of the lowest natural frequency: shorter, and
# neighbouring frequencies merge; longer, and they have moved on meanwhile.
_PERIODS_IN_WINDOW = 6.0
# As many columns as a picture shows, and samples of which a spectrum can be made.
_MOST_WINDOWS = 160
_LEAST_WINDOW = 16


@dataclass(frozen=True)
class Spectrogram:
    """Amplitude over frequency and time.

    Parameters
    ----------
    time : ndarray, shape (W,)
        Middle of each window in s.
    frequency : ndarray, shape (F,)
        Hz; evenly spaced by one over the window's length.
    amplitude : ndarray, shape (k, F, W)
        Single-sided, of k signals, in their unit.
    """

    time: FloatArray
    frequency: FloatArray
    amplitude: FloatArray


def amplitude_spectrum(
    signals: FloatArray, interval: float, up_to: float, window: str = _WINDOW
) -> tuple[FloatArray, FloatArray]:
    """Single-sided amplitude spectrum of whole signals under a window.

    Parameters
    ----------
    signals : ndarray, shape (k, N)
    interval : float
        Between samples in s.
    up_to : float
        Highest frequency wanted in Hz.
    window : str
        Hann's; ``"boxcar"`` is none, for whole periods without their last sample, whose
        amplitudes are then those of the Fourier series.

    Returns
    -------
    ndarray, shape (F,)
        Frequencies in Hz.
    ndarray, shape (k, F)
        Amplitudes in the signals' unit; the mean is taken off.
    """
    frequency, power = periodogram(
        signals, 1 / interval, window=window, detrend="constant", scaling="spectrum"
    )
    wanted = frequency <= up_to
    return frequency[wanted], np.sqrt(2 * power[:, wanted])


def spectrogram(
    signals: FloatArray,
    interval: float,
    lowest: float,
    up_to: float,
    duration: float | None = None,
) -> Spectrogram | None:
    """Spectra under a Hann window that moves along the signals.

    Parameters
    ----------
    signals : ndarray, shape (k, N)
    interval : float
        Between samples in s.
    lowest : float
        Lowest natural frequency in Hz, which sets the window's length.
    up_to : float
        Highest frequency wanted in Hz.
    duration : float, optional
        Length of the window in s instead.

    Returns
    -------
    Spectrogram or None
        None where the signals are shorter than the window.
    """
    duration = duration or _PERIODS_IN_WINDOW / lowest
    length = max(_LEAST_WINDOW, round(duration / interval))
    count = signals.shape[1]
    if count < length:
        return None
    hop = max(1, -(-(count - length) // _MOST_WINDOWS))
    transform = ShortTimeFFT(
        get_window(_WINDOW, length), hop, 1 / interval, fft_mode="onesided2X", scale_to="magnitude"
    )
    inside = slice(transform.lower_border_end[1], transform.upper_border_begin(count)[1])
    middle = signals - signals.mean(axis=1, keepdims=True)
    amplitude = np.abs(transform.stft(middle, p0=inside.start, p1=inside.stop))
    wanted = transform.f <= up_to
    return Spectrogram(
        time=transform.t(count, p0=inside.start, p1=inside.stop),
        frequency=transform.f[wanted],
        amplitude=amplitude[:, wanted],
    )


def window_duration(time: FloatArray, frequency: FloatArray, lowest: float) -> float:
    """Length of a window that tells the first two natural frequencies apart, if one can.

    It must be long enough for their distance, and so short that they move by less than half of
    it meanwhile, and that the run holds two of it.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Evenly spaced, in s.
    frequency : ndarray, shape (n, m)
        Predicted natural frequencies in Hz, ascending.
    lowest : float
        Lowest natural frequency in Hz.

    Returns
    -------
    float
        In s; six periods of the lowest frequency where none can, or where these suffice.
    """
    shortest = _PERIODS_IN_WINDOW / lowest
    if frequency.shape[1] < 2 or len(time) < 2:
        return shortest
    apart = frequency[:, 1] - frequency[:, 0]
    # Apart all the time, or else for half of it.
    for gap in (float(apart.min()), float(np.median(apart))):
        wanted = _RESOLVED / gap if gap > 0 else np.inf
        if wanted <= shortest:
            return shortest
        if wanted <= float(time[-1] - time[0]) / 2:
            points = min(len(time), int(np.ceil(wanted / (time[1] - time[0]))) + 1)
            passed = np.lib.stride_tricks.sliding_window_view(frequency[:, :2], points, axis=0)
            if float(np.ptp(passed, axis=-1).max()) <= gap / 2:
                return wanted
    return shortest


def resolution_note(frequency: FloatArray, duration: float) -> str:
    """Say which neighbouring natural frequencies a window tells apart.

    Parameters
    ----------
    frequency : ndarray, shape (n, m)
        Predicted, in Hz, ascending.
    duration : float
        Length of the window in s.

    Returns
    -------
    str
    """
    resolved = _RESOLVED / duration
    note = f"window {duration:.3g} s, resolution {resolved:.3g} Hz"
    nearest = np.diff(frequency, axis=1).min(axis=0)
    merged = [
        f"f{n} and f{n + 1} (nearest {gap:.3g} Hz)"
        for n, gap in enumerate(nearest.tolist(), start=1)
        if gap < resolved
    ]
    return f"{note}: cannot tell {', '.join(merged)} apart" if merged else note
