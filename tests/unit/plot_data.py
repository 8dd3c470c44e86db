"""Datasets that look like results of moving_frequencies, without an engine behind them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from flexmech.linkages import FourBar, Linkage, RotatingArm

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Variables = dict[str, tuple[tuple[str, ...], NDArray[Any]]]

DIMS = ("engine", "crank_speed", "crank_angle", "mode")
CHECK_DIMS = ("engine", "crank_speed", "check_angle", "mode")

FOURBAR = FourBar(ground=0.254, crank=0.102, coupler=0.2794, rocker=0.2667)
TERMS = ("geometric", "posture", "coriolis", "centripetal", "tangential")
FULL_TURN = tuple(np.radians(np.arange(0.0, 360.5, 5.0)))
MEANS = (44.0, 48.0, 115.0, 190.0, 402.0, 515.0, 760.0, 1120.0)
WAVES = (0.04, 0.03, 0.09, 0.06, 0.05, 0.03, 0.02, 0.04)
STATIONS = np.linspace(0.0, 1.0, 21)
COMPONENTS = ("x", "y")


def frequency_dataset(
    speeds: Sequence[float] = (0.0, 10.0, 20.0),
    angles: Sequence[float] = FULL_TURN,
    modes: int = 4,
    engines: Sequence[str] = ("reference", "exudyn"),
    *,
    crossing: bool = False,
    speed_effect: bool = True,
    linkage: Linkage = FOURBAR,
) -> xr.Dataset:
    """Dataset by the schema of MovingFrequencies, with smooth invented numbers.

    With ``crossing``, branches 2 and 1 cross twice in a full turn.
    """
    theta, omega = np.asarray(angles, dtype=float), np.asarray(speeds, dtype=float)
    branch_frequency, terms = _branches(theta, omega, modes, crossing)
    order = np.argsort(branch_frequency, axis=-1)
    frequency = np.take_along_axis(branch_frequency, order, axis=-1)
    variables = _frequency_variables(theta, omega, frequency, order, len(engines))
    check = theta[:: max(1, theta.size // 12)]
    variables.update(_check_variables(linkage, check, omega, modes, len(engines)))
    if speed_effect:
        sorted_terms = np.take_along_axis(terms, np.broadcast_to(order, terms.shape), axis=-1)
        variables["speed_effect"] = (("term", *DIMS[1:]), sorted_terms)
    elements = {"reference": "euler", "exudyn": "ancf"}
    return xr.Dataset(
        variables,
        coords={
            "engine": list(engines),
            "element": ("engine", [elements[name] for name in engines]),
            "crank_speed": omega,
            "crank_angle": theta,
            "mode": np.arange(1, modes + 1),
            "branch": np.arange(1, modes + 1),
            "check_angle": check,
            "link": list(linkage.topology.link_names),
            "station": STATIONS,
            "component": list(COMPONENTS),
            "part": ["real", "imaginary"],
            "term": list(TERMS),
        },
    )


def arm_dataset(hub_radius: float = 0.05, modes: int = 3) -> xr.Dataset:
    """One rotating arm at a single angle and two speeds, one engine."""
    return frequency_dataset(
        speeds=(0.0, 30.0),
        angles=(np.radians(30.0),),
        modes=modes,
        engines=("reference",),
        linkage=RotatingArm(length=0.4, hub_radius=hub_radius),
    )


def _frequency_variables(
    theta: FloatArray, omega: FloatArray, frequency: FloatArray, order: IntArray, n_engines: int
) -> Variables:
    """Frequencies of all engines and what tracking says of them."""
    modes = frequency.shape[-1]
    shape = (n_engines, *frequency.shape)
    # Engines apart by parts in a million, more at speed and in higher modes, never twice alike.
    ripple = 1.1 + np.sin(3 * theta + 1)[:, None] + 0.05 * np.cos(17 * theta)[:, None]
    gap = 2e-7 * (1 + omega[:, None, None] ** 2 / 4) * ripple * np.arange(1, modes + 1)
    apart = np.arange(n_engines)[:, None, None, None] * gap
    near = np.diff(frequency, axis=-1, append=np.inf) / frequency < 0.012
    veering = near | np.concatenate([np.zeros_like(near[..., :1]), near[..., :-1]], axis=-1)
    return {
        "frequency": (DIMS, frequency * (1 + apart)),
        "damping_ratio": (DIMS, np.full(shape, 0.002)),
        "branch_of_mode": (DIMS, np.broadcast_to(order + 1, shape).copy()),
        "mac": (DIMS, np.full(shape, 0.999)),
        "veering": (DIMS, np.broadcast_to(veering, shape).copy()),
        "branch_whole": (("engine", "crank_speed", "branch"), np.ones((*shape[:2], modes), bool)),
    }


def _check_variables(
    linkage: Linkage, check: FloatArray, omega: FloatArray, modes: int, n_engines: int
) -> Variables:
    """Errors and shapes at the check angles."""
    error = 4e-6 * np.arange(1, modes + 1) ** 2 * (1 + 0.3 * np.cos(check))[:, None]
    error = error * (1 + np.arange(n_engines))[:, None, None, None]
    error = np.repeat(error, omega.size, axis=1)
    rigid, displacement = _shapes(linkage, check, modes)
    shapes = _complex_parts(displacement, n_engines, omega)
    return {
        "discretisation_error": (CHECK_DIMS, error),
        "reduction_error": (CHECK_DIMS, 0.01 * error),
        "mode_shape": ((*CHECK_DIMS, "part", "link", "station", "component"), shapes),
        "rigid_position": (("check_angle", "link", "station", "component"), rigid),
    }


def _branches(
    theta: FloatArray, omega: FloatArray, modes: int, crossing: bool
) -> tuple[FloatArray, FloatArray]:
    """Frequencies by branch (speed, angle, branch) and their terms (term, ...)."""
    number = np.arange(modes)
    means, waves = np.array(MEANS[:modes]), np.array(WAVES[:modes])
    if crossing:
        waves = waves.copy()
        waves[0] = 0.16
    at_rest = means * (1 + waves * np.cos(theta[:, None] * (1 + number % 2) + 0.7 * number))
    weight = np.array([0.6, 0.35, -0.15, -0.25, 0.1])[:, None, None, None]
    phase = np.arange(len(TERMS))[:, None, None, None]
    terms = (
        2e-5
        * omega[:, None, None] ** 2
        * means
        * weight
        * (1 + 0.6 * np.cos(theta[:, None] + phase + 0.5 * number))
    )
    return at_rest + terms.sum(axis=0), terms


def _shapes(linkage: Linkage, check: FloatArray, modes: int) -> tuple[FloatArray, FloatArray]:
    """Rigid positions (check, link, station, 2) and real shapes (check, mode, link, ...)."""
    motion = linkage.motion(check)
    lengths = [link.length for link in linkage.topology.links]
    rigid = np.stack(
        [
            np.stack([motion.position(link, s * length) for s in STATIONS], axis=1)
            for link, length in enumerate(lengths)
        ],
        axis=1,
    )
    across = np.stack([-np.sin(motion.angle), np.cos(motion.angle)], axis=-1)[:, :, None]
    s = STATIONS[:, None]
    shapes = np.zeros((check.size, modes, *rigid.shape[1:]))
    for mode in range(modes):
        waves = mode // 3 + 1
        bow = np.sin(waves * np.pi * s)
        shapes[:, mode, 0] = (0.35 * s**2 * (3 - s) + 0.3 * mode * s * bow) * across[:, 0]
        if len(lengths) == 3:
            _close_loop(shapes[:, mode], across, bow, mode)
    return rigid, shapes


def _close_loop(shape: FloatArray, across: FloatArray, bow: FloatArray, mode: int) -> None:
    """Add coupler and rocker so that the pins stay together and the coupler keeps its length."""
    s = STATIONS[:, None]
    along = np.stack([across[:, 1, 0, 1], -across[:, 1, 0, 0]], axis=-1)
    pin_a = shape[:, 0, -1]
    rocker = across[:, 2, 0]
    size = np.sum(pin_a * along, axis=-1) / np.sum(rocker * along, axis=-1)
    pin_b = size[:, None] * rocker
    bows = ((1.0, 0.4), (0.3, -1.0), (0.9, 0.8))[mode % 3]
    shape[:, 1] = pin_a[:, None] * (1 - s) + pin_b[:, None] * s + bows[0] * bow * across[:, 1]
    shape[:, 2] = pin_b[:, None] * s + bows[1] * bow * across[:, 2]


def _complex_parts(real: FloatArray, n_engines: int, omega: FloatArray) -> FloatArray:
    """Give each engine and speed its own phase; (engine, speed, check, mode, part, ...)."""
    phase = np.exp(1j * (0.4 + np.arange(n_engines)[:, None] + 1.9 * np.arange(omega.size)))
    growth = 1 + 0.004 * omega
    turned = real * (phase * growth)[(..., *(None,) * real.ndim)]
    largest = np.abs(turned).max(axis=(-3, -2, -1), keepdims=True)
    return np.stack([turned.real / largest, turned.imag / largest], axis=-4)
