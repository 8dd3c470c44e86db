"""Datasets for tests of figures: they look like results, without an engine behind them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from flexmech.linkages import FourBar, Linkage, RotatingArm, drawn_joints

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Variables = dict[str, tuple[tuple[str, ...], NDArray[Any]]]

DIMS = ("engine", "crank_speed", "crank_angle", "mode")
CHECK_DIMS = ("engine", "crank_speed", "check_angle", "mode")

FOURBAR = FourBar(ground=0.254, crank=0.102, coupler=0.2794, rocker=0.2667)
TERMS = ("geometric", "configuration", "coriolis", "centripetal", "tangential")
TURN = np.linspace(0.0, 2 * np.pi, 61)
FULL_TURN = tuple(np.radians(np.arange(0.0, 360.5, 5.0)))
MEANS = (44.0, 48.0, 115.0, 190.0, 402.0, 515.0, 760.0, 1120.0)
WAVES = (0.04, 0.03, 0.09, 0.06, 0.05, 0.03, 0.02, 0.04)

# Of speed sweeps.
LOWEST = np.array([43.1, 47.3, 112.0, 180.0]) * 2 * np.pi
HIGHEST = np.array([46.9, 49.7, 175.0, 198.0]) * 2 * np.pi

STATIONS = np.linspace(0.0, 1.0, 21)
COMPONENTS = ("x", "y")
ELEMENTS = {"reference": "euler", "exudyn": "ancf"}

# Of responses.
ARM = RotatingArm(length=0.4, hub_radius=0.05)
JOINTS = {3: ("O2", "A", "B", "O4"), 1: ("O2",)}
KINDS = {"O2": "clamp", "A": "pin", "B": "pin", "O4": "pivot"}
NATURAL = np.array([45.0, 49.0, 140.0, 190.0])
MOVING = np.array([0.01, 0.02, 0.2, 0.05])
AXIAL_RINGING = 5.0
WINDOWS = 40
FORCE = ("joint", "component")
SHAPE = ("time", "link", "station", "component")


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
    return xr.Dataset(
        variables,
        coords={
            "engine": list(engines),
            "element": ("engine", [ELEMENTS[name] for name in engines]),
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
        attrs={"drawing": json.dumps(drawn_joints(linkage.topology))},
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


def _rigid(linkage: Linkage, angle: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Positions (angle, link, station, 2) and unit vectors across the links (angle, link, 2)."""
    motion = linkage.motion(angle)
    links = [
        np.stack([motion.position(number, s * link.length) for s in STATIONS], axis=1)
        for number, link in enumerate(linkage.topology.links)
    ]
    return np.stack(links, axis=1), np.stack([-np.sin(motion.angle), np.cos(motion.angle)], axis=-1)


def _shapes(linkage: Linkage, check: FloatArray, modes: int) -> tuple[FloatArray, FloatArray]:
    """Rigid positions (check, link, station, 2) and real shapes (check, mode, link, ...)."""
    rigid, across = _rigid(linkage, check)
    across, lengths = across[:, :, None], linkage.topology.links
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
            "joint_kind": ("joint", [KINDS[name] for name in JOINTS[len(names)]]),
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
    rigid, across = _rigid(linkage, angle)
    lengths = linkage.topology.links
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


def sweep_dataset(
    modes: int = 2, links: int = 3, *, settled: bool = True, fastest: float = 40.0
) -> xr.Dataset:
    """Peaks with a resonance wherever a multiple of the speed meets a mean frequency."""
    speed = np.linspace(2.0, fastest, 77)
    order = np.arange(1, 21)
    peak = np.array([2e-6, 3e-5, 6e-5])[:links] * (1 + speed[:, None] ** 2 / 40)
    for centre in ((LOWEST + HIGHEST) / 2)[:2]:
        for number in range(2, 21):
            offset = (speed * number / centre - 1) / 0.01
            peak *= (1 + 6 / number / (1 + offset**2))[:, None]
    dataset = xr.Dataset(
        {
            "peak_deflection": (("crank_speed", "link"), peak),
            "critical_speed_low": (("mode", "order"), LOWEST[:modes, None] / order),
            "critical_speed_high": (("mode", "order"), HIGHEST[:modes, None] / order),
        },
        coords={
            "crank_speed": speed,
            "link": ["crank", "coupler", "rocker"][:links],
            "probe": ("link", ["tip", "middle", "middle"][:links]),
            "order": order,
            "mode": np.arange(1, modes + 1),
        },
        attrs={"mechanism": "aluminium four-bar"},
    )
    checked = np.unique([0, *peak.argmax(axis=0)])
    dataset = dataset.assign(
        peak_error=(("check_speed", "link"), np.full((len(checked), links), 2e-3)),
        discretisation_error=("mode", np.full(modes, 1e-4)),
    ).assign_coords(check_speed=speed[checked])
    if settled:
        some = [0, 20, 40, 76]
        dataset["settled_peak"] = (("settled_speed", "link"), 1.02 * peak[some])
        dataset = dataset.assign_coords(settled_speed=speed[some])
    return dataset


def campbell_dataset(
    branches: int = 4, *, peaks: bool = True, gap: bool = True, engines: int = 1
) -> xr.Dataset:
    """Bands that widen with speed, three critical speeds, and speeds without a result."""
    speed = np.linspace(0.0, 90.0, 31)
    mean = np.array(MEANS[:branches]) * np.ones((engines, len(speed), 1))
    half = mean * np.array(WAVES[:branches]) * (1 + speed[:, None] / 90)
    if gap:
        mean[:, -6:] = np.nan
    names = list(ELEMENTS)[:engines]
    over = ("engine", "crank_speed", "branch")
    ends = 2 * np.pi * np.array([[42.0, 46.0], [21.0, 23.0], [45.0, 51.0]]) / [[5], [5], [9]]
    dataset = xr.Dataset(
        {
            "lowest_frequency": (over, mean - half),
            "mean_frequency": (over, mean),
            "highest_frequency": (over, mean + half),
            "solved": (over[:2], np.ones((engines, len(speed)), dtype=bool)),
            "discretisation_error": (
                ("engine", "check_speed", "branch"),
                np.full((engines, 1, branches), 2.5e-4),
            ),
            "fit_error": ("engine", np.full(engines, 1e-4)),
            "projection_error": ("engine", np.full(engines, 1e-8)),
            "crossing_error": ("engine", np.full(engines, 1e-9)),
            "critical_engine": ("critical", [names[0]] * 3),
            "critical_order": ("critical", [5, 5, 9]),
            "critical_branch": ("critical", [1, 1, 2]),
            "critical_start": ("critical", ends[:, 0]),
            "critical_end": ("critical", ends[:, 1]),
            "critical_gap": ("critical", [0.0, 0.04, 0.0]),
            "critical_starts_inside": ("critical", [False] * 3),
            "critical_ends_inside": ("critical", [False, False, True]),
            "gap_engine": ("gap", [names[0]] * gap),
            "gap_first": ("gap", [75.0] * gap),
            "gap_last": ("gap", [90.0] * gap),
            "gap_count": ("gap", [6] * gap),
            "gap_reason": ("gap", ["the linkage buckles"] * gap),
        },
        coords={
            "engine": names,
            "element": ("engine", [ELEMENTS[name] for name in names]),
            "elements": ("engine", [8] * engines),
            "crank_speed": speed,
            "check_speed": [0.0],
            "branch": np.arange(1, branches + 1),
            "order": np.arange(1, 11),
        },
        attrs={"mechanism": "aluminium four-bar", "speed_unit": "rad/s"},
    )
    if peaks:
        dataset["peak_ratio"] = (("response_speed", "link"), 1 + 3 * np.eye(3))
        dataset = dataset.assign_coords(
            response_speed=[20.0, 40.0, 60.0],
            link=["crank", "coupler", "rocker"],
            probe=("link", ["tip", "middle", "middle"]),
        )
    return dataset


def vibration_dataset(
    modes: int = 4,
    engines: tuple[str, ...] = ("reference", "exudyn"),
    affected: tuple[int, ...] = (1,),
    step: float = 5.0,
) -> xr.Dataset:
    """Frequencies that the vibration of the affected engines moves by up to 0.4 per cent."""
    theta = np.radians(np.arange(0.0, 360.1, step))
    speed = np.array([10.0, -20.0, 5.0])
    still = np.array(MEANS[:modes]) * (1 + 0.04 * np.cos(theta[:, None] + np.arange(modes)))
    still = np.broadcast_to(still, (len(engines), speed.size, *still.shape)).copy()
    running = still.copy()
    for engine in affected:
        wave = np.sin(9 * theta[:, None] + np.arange(modes)) * np.linspace(1, 0.3, modes)
        running[engine] *= 1 + 1e-5 * speed[:, None, None] ** 2 * wave
    return xr.Dataset(
        {"frequency": (DIMS, running), "quasi_static_frequency": (DIMS, still)},
        coords={
            "engine": list(engines),
            "element": ("engine", [ELEMENTS.get(name, "euler") for name in engines]),
            "crank_speed": speed,
            "crank_angle": theta,
            "mode": np.arange(1, modes + 1),
        },
    )


def coupler_dataset(
    size: float = 0.1, *, looped: bool = True, states: int = 1, angles: FloatArray = TURN
) -> xr.Dataset:
    """A figure of eight in states of growing size, the last one a whole turn of the links on."""
    grown = size * (1 + 0.1 * np.arange(states))[:, None, None]
    eight = grown * np.stack([np.sin(2 * angles), np.sin(angles)], axis=-1)
    pins = grown * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    turned = np.stack([0.3 * np.sin(angles), 1 + 0.2 * np.cos(angles)], axis=-1)
    apart = 2 * np.pi * (np.arange(states) == states - 1) * (states > 1)
    names = ["dry", "+80 K", "wet"][:states]
    over = ("state", "crank_angle")
    fine = size * np.stack([np.sin(2 * TURN[25:36]), np.sin(TURN[25:36])], axis=-1)
    doubles = 2 if looped else 0
    dataset = xr.Dataset(
        {
            "position": ((*over, "component"), eight),
            "pin_position": ((*over, "pin", "component"), np.stack([pins, 2 * pins], axis=2)),
            "angle": ((*over, "link"), turned + apart[:, None, None]),
            "double_point_position": (
                ("double_point", "component"),
                np.array([[0.0, 0.0], fine[2]])[:doubles],
            ),
        },
        coords={
            "state": names,
            "crank_angle": angles,
            "component": list(COMPONENTS),
            "pin": ["A", "B"],
            "link": ["coupler", "rocker"],
            "double_point_state": ("double_point", np.array(["dry", "dry"])[:doubles]),
            "double_point_kind": ("double_point", np.array(["crunode", "cusp"])[:doubles]),
        },
        attrs={"mechanism": "resin four-bar"},
    )
    if looped:
        dataset["close_up"] = (
            ("state", "window", "point", "component"),
            np.stack([fine] * states)[:, None],
        )
        dataset["framed"] = (("framed_place", "component"), fine[3:8])
    return dataset


def moisture_dataset(day: float = 86400.0, *, over_width: bool = False) -> xr.Dataset:
    """Water in a coupler, and in a rocker with fewer cells, of which no law says anything."""
    part, time = np.linspace(-1.0, 1.0, 21), day * np.linspace(0.0, 4.0, 30)
    place = np.stack([1e-3 * part, np.where(np.arange(21) < 15, 5e-4 * part, np.nan)])
    profile = np.stack([0.05 * part**8, 0.05 * part**2])
    profile = np.where(np.isnan(place)[:, None], np.nan, profile)
    uptake = 1 - np.exp(-time / day)
    nothing = np.full(time.size, np.nan)
    of_time = ("link", "time")
    return xr.Dataset(
        {
            "place": (("link", "cell"), place),
            "profile": (("link", "profile_time", "cell"), profile),
            "uptake": (of_time, [uptake, uptake]),
            "short_time_uptake": (of_time, [np.sqrt(time / day), nothing]),
            "shen_springer_uptake": (of_time, [uptake, nothing]),
        },
        coords={
            "link": ["coupler", "rocker"],
            "time": time,
            "profile_time": day * np.array([0.5, 4.0]),
            "over_width": ("link", [over_width, over_width]),
        },
        attrs={"mechanism": "moist four-bar", "relative_humidity": 0.85, "temperature": 353.15},
    )


def transmission_dataset(count: int = 1, **wanted: float | str) -> xr.Dataset:
    """Transmission angles that do not change, one linkage a tenth of a radian above another."""
    angles = np.radians(np.arange(0.0, 361.0, 30.0))
    curves = np.repeat(1 + 0.1 * np.arange(count)[:, None], angles.size, axis=1)
    return xr.Dataset(
        {"transmission_angle": (("linkage", "crank_angle"), curves)},
        coords={
            "linkage": [f"case {number} as designed" for number in range(count)],
            "crank_angle": angles,
        },
        attrs=wanted,
    )


def linkage_dataset(linkage: Linkage = FOURBAR, degrees: float = 60.0) -> xr.Dataset:
    """A linkage at one crank angle, its joints at the ends of its links."""
    links = _rigid(linkage, np.radians([degrees]))[0][0]
    names = list(linkage.topology.link_names)
    joints = JOINTS[len(names)]
    places = [links[0, 0], links[0, -1], links[-1, -1], links[-1, 0]][: len(joints)]
    return xr.Dataset(
        {
            "rigid_position": (("link", "station", "component"), links),
            "joint_position": (("joint", "component"), np.array(places)),
        },
        coords={
            "link": names,
            "joint": list(joints),
            "joint_kind": ("joint", [KINDS[name] for name in joints]),
        },
        attrs={
            "mechanism": "test linkage",
            "drawing": json.dumps(drawn_joints(linkage.topology)),
        },
    )


def mechanism_dataset(linkage: Linkage = FOURBAR, degrees: float = 60.0) -> xr.Dataset:
    """A linkage with everything that a picture of a mechanism shows."""
    dataset = linkage_dataset(linkage, degrees)
    drawn = json.loads(dataset.attrs["drawing"])
    drawn["masses"] = [{"at": [dataset.sizes["link"] - 1, 0.5], "kg": 0.02}]
    if dataset.sizes["joint"] > 1:
        places = {joint["name"]: joint["at"] for joint in drawn["joints"]}
        joints = [{"at": places["A"], "kg": 0.04}, {"at": places["B"], "kg": 0.01}]
        drawn["masses"] = joints + drawn["masses"]
    dataset = dataset.assign_attrs(drawing=json.dumps(drawn))
    turn = np.radians(np.arange(0.0, 361.0, 5.0))
    links, whole = dataset.sizes["link"], _rigid(linkage, turn)[0]
    first = whole[:, 0, -1]
    paths = {"tip": first}
    if links > 1:
        middle = whole[:, 1].mean(axis=1) + 0.3 * (whole[:, 1, -1] - first)[:, ::-1] * [-1.0, 1.0]
        paths = {"A": first, "B": whole[:, 1, -1], "coupler point": middle}
    thickness = 1e-3 * np.array([10.0, 8.0, 6.0])[:links]
    part = np.linspace(-0.5, 0.5, 5) * thickness[:, None]
    plies = np.array([["C", "C", "G", "C"], ["C", "C", "G", "G"], ["", "", "", ""]])[:links]
    low, high = part[:, :-1].copy(), part[:, 1:].copy()
    if links > 2:
        # One section of one material, of which no width is known.
        low[2], high[2] = [[part[2, 0], *[np.nan] * 3], [part[2, -1], *[np.nan] * 3]]
    along = dataset["rigid_position"].isel(link=-1).mean("station").values
    here = [
        np.interp(np.radians(degrees), turn, each) for path in paths.values() for each in path.T
    ]
    dataset = dataset.assign(
        in_plane_thickness=("link", thickness),
        out_of_plane_width=("link", np.array([0.02, 0.025, np.nan])[:links]),
        stacking=("link", ["[C*2/G/C]", "[C*2/G*2]", ""][:links]),
        direction_of_layers=("link", ["through thickness"] * links),
        layer_low=(("link", "layer"), low),
        layer_high=(("link", "layer"), high),
        ply=(("link", "layer"), plies),
        joint_mass=("joint", np.array([0.0, 0.04, 0.01, 0.0])[: dataset.sizes["joint"]]),
        point_mass=("mass", [0.02]),
        point_mass_position=(("mass", "component"), [along]),
        posture_angle=np.radians(degrees),
        path=(("path", "crank_angle", "component"), np.array(list(paths.values()))),
        path_position=(("path", "component"), np.reshape(here, (-1, 2))),
    ).assign_coords(path_name=("path", list(paths)), crank_angle=turn)
    if isinstance(linkage, FourBar):
        dataset["transmission_angle"] = ("crank_angle", linkage.transmission_angle(turn))
        limits = np.array(linkage.transmission_angle_limits())
        dataset["transmission_angle_limit"] = ("limit", limits)
        dataset["usual_transmission_angle"] = ("limit", np.radians([40.0, 140.0]))
    return dataset


def verification_dataset() -> xr.Dataset:
    """Two cases of two subjects: the first passes in both of its numbers, the second fails."""
    return xr.Dataset(
        {
            "deviation": (("case", "number"), [[1e-6, 5e-5], [3e-3, np.nan]]),
            "tolerance": ("case", [1e-4, 1e-3]),
            "subject": ("case", ["four-bars", "arm"]),
            "verdict": ("case", ["passed", "failed"]),
        },
        coords={"case": ["four-bars: steel", "arm: clamped"]},
    )
