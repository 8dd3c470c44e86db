"""Datasets that look like results of a response, without an engine behind them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from flexmech.linkages import Linkage, RotatingArm
from tests.unit.plot_data import COMPONENTS, FOURBAR, STATIONS

FloatArray = NDArray[np.float64]
Variables = dict[str, tuple[tuple[str, ...], Any]]

ARM = RotatingArm(length=0.4, hub_radius=0.05)
JOINTS = {3: ("O2", "A", "B", "O4"), 1: ("O2",)}
NATURAL = np.array([45.0, 49.0, 140.0, 190.0])
MOVING = np.array([0.01, 0.02, 0.2, 0.05])
ELEMENTS = {"reference": "euler", "exudyn": "ancf"}
AXIAL_RINGING = 5.0
WINDOWS = 40
FORCE = ("joint", "component")
SHAPE = ("time", "link", "station", "component")


def response_dataset(
    revolutions: float = 1.0,
    engines: Sequence[str] = ("reference", "exudyn"),
    *,
    speed: float = 20.0,
    start: str = "rigid",
    linkage: Linkage = FOURBAR,
    samples: int = 360,
    spectrogram: bool = True,
) -> xr.Dataset:
    """Dataset by the schema of Response, with smooth invented numbers of a real size.

    Engines differ by a part in a thousand.
    """
    duration = revolutions * 2 * np.pi / abs(speed)
    time = np.linspace(0.0, duration, round(revolutions * samples) + 1)
    angle = speed * time
    names = linkage.topology.link_names
    factor = 1.0 + 1e-3 * np.arange(len(engines))
    deflection = factor[:, None, None] * _deflection(time, angle, len(names))
    variables: Variables = {
        "deflection": (("engine", "time", "link"), deflection),
        "strain": (("engine", "time", "link"), 0.11 * deflection),
        **_forces(time, angle, factor, JOINTS[len(names)]),
        **_positions(linkage, angle, deflection),
        "step": (("engine",), np.full(len(engines), 5e-5)),
    }
    spectra, coordinates = _spectra(time, angle, deflection)
    variables.update(spectra)
    dataset = xr.Dataset(
        variables,
        coords={
            "engine": list(engines),
            "element": ("engine", [ELEMENTS[name] for name in engines]),
            "time": time,
            "crank_angle": ("time", angle),
            "link": list(names),
            "probe": ("link", ["tip", *["middle"] * (len(names) - 1)]),
            "joint": list(JOINTS[len(names)]),
            "station": STATIONS,
            "component": list(COMPONENTS),
            **coordinates,
        },
        attrs={
            "mechanism": "aluminium four-bar" if len(names) == 3 else "rotating arm",
            "crank_speed": speed,
            "run_up_time": 0.0,
            "start": start,
            "elements": 8,
            "prestress": "equilibrium",
        },
    )
    if not spectrogram:
        dataset = dataset.drop_dims(["window_time", "window_frequency", "mode"])
    return dataset


def arm_response(revolutions: float = 4.0, **options: Any) -> xr.Dataset:
    """One rotating arm, one engine."""
    return response_dataset(revolutions, ("reference",), linkage=ARM, **options)


def _deflection(time: FloatArray, angle: FloatArray, links: int) -> FloatArray:
    """Harmonics of the crank with natural vibrations on top, (time, link) in m."""
    size = 1e-3 * np.array([0.15, 0.9, 0.8])[:links]
    number = np.arange(links)
    slow = np.cos(angle[:, None] + number) + 0.4 * np.sin(2 * angle[:, None])
    fast = 0.5 * np.sin(2 * np.pi * NATURAL[number] * time[:, None])
    fast = fast + 0.1 * np.sin(2 * np.pi * NATURAL[2] * time[:, None] + number)
    return np.asarray(size * (0.5 * slow + fast))


def _forces(
    time: FloatArray, angle: FloatArray, factor: FloatArray, joints: Sequence[str]
) -> Variables:
    """Torque and forces, the first engine's ringing at more than the samples resolve."""
    turned = angle[:, None, None] + np.arange(len(joints))[:, None] + np.arange(2)
    rigid = 1.2 * np.cos(turned) + 0.3 * np.sin(2 * turned)
    noise = np.random.default_rng(3).standard_normal(rigid.shape)
    ringing = np.where(np.arange(factor.size) == 0, AXIAL_RINGING, 0.0)[:, None, None, None] * noise
    slow = rigid + 0.3 * np.sin(2 * np.pi * 45.0 * time)[:, None, None]
    torque = 0.05 * np.cos(angle)
    vibrating = torque + 0.03 * np.sin(2 * np.pi * 140.0 * time)
    return {
        "driving_torque": (("engine", "time"), factor[:, None] * vibrating),
        "rigid_driving_torque": (("time",), torque),
        "joint_force": (
            ("engine", "time", *FORCE),
            factor[:, None, None, None] * slow + ringing,
        ),
        "rigid_joint_force": (("time", *FORCE), rigid),
    }


def _positions(linkage: Linkage, angle: FloatArray, deflection: FloatArray) -> Variables:
    """Rigid positions, and links bowed across themselves by their deflections."""
    motion = linkage.motion(angle)
    lengths = [link.length for link in linkage.topology.links]
    rigid = np.stack(
        [
            np.stack([motion.position(link, s * length) for s in STATIONS], axis=1)
            for link, length in enumerate(lengths)
        ],
        axis=1,
    )
    across = np.stack([-np.sin(motion.angle), np.cos(motion.angle)], axis=-1)
    # A clamped link is bent at its tip, which has to stay on the coupler: only a lone one is.
    bow = np.where(len(lengths) == 1, STATIONS**2, np.sin(np.pi * STATIONS))
    displacement = deflection[..., None, None] * bow[:, None] * across[..., None, :]
    return {
        "rigid_position": (SHAPE, rigid),
        "displacement": (("engine", *SHAPE), displacement),
    }


def _spectra(
    time: FloatArray, angle: FloatArray, deflection: FloatArray
) -> tuple[Variables, dict[str, FloatArray]]:
    """Amplitude spectra, and ridges along moving natural frequencies."""
    engines, count, links = deflection.shape
    frequency = np.fft.rfftfreq(count - 1, time[1])
    amplitude = np.abs(np.fft.rfft(deflection[:, :-1] * np.hanning(count - 1)[:, None], axis=1))
    amplitude = 4 * amplitude.swapaxes(1, 2) / count + 1e-9
    shown = frequency <= 1.5 * NATURAL.max()
    window_time = np.linspace(0.1, 0.9, WINDOWS) * time[-1]
    window_frequency = np.arange(0.0, 290.0, 5.0)
    turned = np.interp(window_time, time, angle)
    natural = NATURAL * (1 + MOVING * np.cos(turned)[:, None])
    away = (window_frequency[:, None] - natural.T[:, None]) / 8.0
    ridges = 1e-3 * np.sum(np.exp(-(away**2)), axis=0) + 1e-7
    return {
        "spectrum": (("engine", "link", "spectrum_frequency"), amplitude[..., shown]),
        "spectrogram": (
            ("engine", "link", "window_frequency", "window_time"),
            np.broadcast_to(ridges, (engines, links, *ridges.shape)).copy(),
        ),
        "natural_frequency": (
            ("engine", "window_time", "mode"),
            np.broadcast_to(natural, (engines, *natural.shape)).copy(),
        ),
    }, {
        "spectrum_frequency": frequency[shown],
        "window_time": window_time,
        "window_frequency": window_frequency,
        "mode": np.arange(1.0, NATURAL.size + 1).astype(int),
    }
