"""Numbers of the analyses: each test fails if its constant is taken away or is another one."""

from __future__ import annotations

import multiprocessing
import os
import select
import signal
import struct
import sys
import time
import tracemalloc
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from flexmech import (
    ReferenceEngine,
    coupler_paths,
    load_mechanism,
    moisture_uptake,
    moving_frequencies,
)
from flexmech.analyses import netcdf
from flexmech.analyses.campbell import compute as campbell
from flexmech.analyses.campbell.compute import steady_response
from flexmech.analyses.comparison.fit import Parameter, fitted
from flexmech.analyses.kinematics.result import Kinematics
from flexmech.analyses.moisture import compute as moisture
from flexmech.analyses.response import dataset as responses
from flexmech.analyses.stability import compute as stability
from flexmech.analyses.stability import engine_map, parallel, vibrating_linkage
from flexmech.analyses.stability.engine_stability import ExponentErrors
from flexmech.analyses.stability.request import StabilityRequest
from flexmech.dynamical_systems import FourierSeries, SampledPeriodicSystem, floquet_modes
from flexmech.errors import ComputationError
from tests.support.kinematics_data import kinematics_dataset

TURN = np.radians([0.0, 90.0, 180.0, 270.0])

# --- Campbell diagrams --------------------------------------------------------------------------


def test_vibrations_of_higher_modes_hardly_raise_the_peaks(aluminium, monkeypatch):
    engine = ReferenceEngine(aluminium, elements=2)

    def peaks():
        found = steady_response(engine, np.array([20.0]), "none", lambda count: None, "rad/s")
        return found.ratio

    usual = peaks()
    monkeypatch.setattr(campbell, "RESPONSE_MODES", 6)
    assert 8e-5 < np.abs(peaks() - usual).max() < 1e-3


# --- frequencies --------------------------------------------------------------------------------


def test_a_branch_may_dip_below_two_others_and_come_back(aluminium):
    """More of them than that would be solved for in vain."""
    found = moving_frequencies(ReferenceEngine(aluminium, elements=2), TURN, [0.0], modes=1)
    assert 2 <= found.dataset.sizes["branch"] - found.dataset.sizes["mode"] <= 4


# --- paths and moisture over time ---------------------------------------------------------------


def test_a_finely_drawn_loop_leaves_the_curve_by_less_than_a_printers_dot(models):
    mechanism = load_mechanism(models / "neat_resin_figure_8.toml")
    drawn = coupler_paths(mechanism, TURN).dataset
    points = drawn["close_up"].values[0, 0]
    # A parabola's height above its chord is a quarter of that above the chord of twice the length.
    chord, aside = points[2:] - points[:-2], points[1:-1] - (points[2:] + points[:-2]) / 2
    height = np.abs(np.linalg.det(np.stack([chord, aside], -1))) / np.linalg.norm(chord, axis=1) / 4
    dots = 6.0 * 300
    assert 5e-3 < dots * height.max() / np.ptp(points, axis=0).max() < 3e-2
    assert drawn.sizes["framed_place"] == len(points) + 1


def test_uptake_between_its_times_is_a_straight_line_over_the_root_of_time(models, monkeypatch):
    mechanism = load_mechanism(models / "moist_composite_fourbar.toml")

    def uptake():
        data = moisture_uptake(mechanism, 0.85, 300 * 86400.0, 353.15, link="rocker").dataset
        return np.sqrt(data["time"].values), data["uptake"].values[0]

    root, share = uptake()
    monkeypatch.setattr(moisture, "_TIMES", 601)
    fine_root, fine_share = uptake()
    assert 1.5e-5 < np.abs(np.interp(fine_root, root, share) - fine_share).max() < 1.5e-4


# --- fits to measurements -----------------------------------------------------------------------


def test_a_fit_ends_in_the_second_half_of_its_progress():
    time_of = np.linspace(0.0, 1.0, 200)

    def decay(values):
        rate, frequency, size = values
        return size * np.exp(-rate * time_of)[None] * np.cos(frequency * time_of)

    problem = SimpleNamespace(
        parameters=[Parameter(n, "", 1.5, 1.0) for n in ("rate", "frequency", "size")],
        measured=decay([3.0, 4.0, 1.0]) + 0.01 * np.random.default_rng(1).normal(size=(1, 200)),
        linear_unknowns=0,
        computed=decay,
    )
    shares = []
    fitted(problem, lambda done, most: shares.append(done / most))
    assert all(np.diff(shares) > 0)
    assert 0.5 < shares[-1] < 1.0


# --- stability maps -----------------------------------------------------------------------------


def test_errors_of_a_map_are_told_at_both_ends_and_in_the_middle(monkeypatch):
    monkeypatch.setattr(
        engine_map, "exponent_errors", lambda of, w: ExponentErrors(w, *np.zeros(4))
    )
    tracked = [SimpleNamespace(crank_speed=10.0 + n, is_unstable=n > 20) for n in range(30)]
    mapped = SimpleNamespace(
        _solver=None, _by_ratio=None, _each=lambda label, task, jobs: [task(job) for job in jobs]
    )
    _, _, errors = engine_map._EngineMap._measured(mapped, [], [], tracked)
    assert [error.crank_speed for error in errors] == [10.0, 20.0, 30.0]


def moving_bands(engine, speeds, **given):
    data = stability._moving(engine, StabilityRequest(crank_speeds=speeds, modes=2, **given))
    return data["moving_speed"].values, data["mean_frequency"].values


def test_bands_of_moving_frequencies_are_straight_between_their_speeds(aluminium, monkeypatch):
    engine, speeds = ReferenceEngine(aluminium, elements=2), np.linspace(1.0, 40.0, 33)
    speed, hertz = moving_bands(engine, speeds, prestress="axial")
    monkeypatch.setattr(stability, "MOST_SPEEDS", 33)
    every, exact = moving_bands(engine, speeds, prestress="axial")
    off = [np.abs(np.interp(every, speed, hertz[:, m]) / exact[:, m] - 1).max() for m in range(2)]
    assert 1e-4 < max(off) < 2e-3


def test_ends_of_moving_bands_are_known_to_half_a_percent(monkeypatch):
    """Of a frequency that changes by a half, where its extremes lie between crank angles."""

    def frequencies_along(engine, angle, *rest):
        hertz = 10 + 5 * np.cos(angle - np.radians(15.0))
        return SimpleNamespace(rigid_modes=0, frozen_squares=(2 * np.pi * hertz[:, None]) ** 2)

    monkeypatch.setattr(stability, "stressed_along_turn", lambda *given: None)
    monkeypatch.setattr(stability, "SampledTurn", SimpleNamespace(of=frequencies_along))
    linkage = SimpleNamespace(motion=lambda angle, speed: angle)
    engine = SimpleNamespace(mechanism=SimpleNamespace(linkage=linkage))
    hertz = stability._frequencies(engine, 1.0, "none", 1)
    assert 5e-4 < 1 - hertz.max() / 15 < 5e-3


def test_the_memory_of_waves_is_told_to_half_of_it(monkeypatch):
    """Of a system of many harmonics, whose waves take nearly all of it."""
    harmonics, steps = 400, 512
    random = np.random.default_rng(2)
    coefficients = 1e-3 * random.standard_normal((harmonics + 1, 2, 2)) + 0j
    system = SampledPeriodicSystem(FourierSeries(coefficients), 1.0)
    tracemalloc.start()
    floquet_modes(system, steps).shapes()
    _, used = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    moving = SimpleNamespace(
        size=1, conservative=system.matrix, is_constant=False, fastest=1.0, crank_speed=1.0
    )
    monkeypatch.setattr(vibrating_linkage, "MOST_BYTES", 2 * used)
    assert vibrating_linkage.steps_of_turn(moving, steps, beside_free_shaft=False) == steps
    monkeypatch.setattr(vibrating_linkage, "MOST_BYTES", used / 2)
    with pytest.raises(ComputationError, match="GB"):
        vibrating_linkage.steps_of_turn(moving, steps, beside_free_shaft=False)


needs_two_processors = pytest.mark.skipif(
    not sys.platform.startswith("linux") or len(os.sched_getaffinity(0)) < 2,
    reason="one process does it all",
)


@needs_two_processors
def test_a_signal_waits_for_its_answer_no_longer_than_a_person_notices(monkeypatch):
    waits, wait = [], parallel.wait
    monkeypatch.setattr(parallel, "wait", lambda of, most: waits.append(most) or wait(of, most))
    assert list(parallel.in_order(str, range(4))) == ["0", "1", "2", "3"]
    # Each wait ends an idle stretch of the program that waits.
    assert all(0.05 < each < 0.5 for each in waits)


@needs_two_processors
def test_no_process_outlives_the_one_that_waits_for_it():
    """They keep a pipe open, which ends with the last of them."""
    reader, writer = os.pipe()

    def task(item):
        os.write(writer, struct.pack("i", os.getpid()))
        time.sleep(60.0)

    def waiting():
        os.close(reader)
        list(parallel.in_order(task, range(6)))

    parent = multiprocessing.get_context("fork").Process(target=waiting)
    parent.start()
    os.close(writer)
    size = struct.calcsize("i")
    try:
        others = struct.unpack("ii", os.read(reader, size) + os.read(reader, size))
        assert parent.pid not in others
        parent.kill()
        parent.join()
        ready, _, _ = select.select([reader], [], [], 5.0)
        ended = bool(ready) and not os.read(reader, size)
        for process in () if ended else others:
            os.kill(process, signal.SIGKILL)
        assert ended
    finally:
        parent.kill()
        os.close(reader)


# --- responses and results ----------------------------------------------------------------------


def test_the_spectrograms_window_follows_frequencies_that_come_near_in_between(monkeypatch):
    """Nearest at 15 deg and each half turn on: between two of the positions every 10 deg."""
    turn = 100.0
    request = SimpleNamespace(
        drive=SimpleNamespace(law_time=0.0),
        duration=4 * turn,
        sample_interval=1.0,
        sample_time=lambda: np.array([0.0, 4 * turn]),
    )

    def predicted(engine, request, time):
        angle = 2 * np.pi * time / turn
        apart = 1.0 - 0.3 * np.cos(2 * (angle - np.radians(15.0)))
        return np.stack([100 + 0 * apart, 100 + apart], axis=1)

    monkeypatch.setattr(responses, "_predicted", predicted)
    usual = responses._window(None, request, 100.0)
    monkeypatch.setattr(responses, "_PREDICTIONS", 4 * 1440 + 1)
    exact = responses._window(None, request, 100.0)
    assert 2e-3 < 1 - usual / exact < 2e-2


def test_pictures_are_twice_as_fine_as_a_screen(tmp_path, monkeypatch):
    result = Kinematics(kinematics_dataset())
    picture = Figure((2.0, 1.0))
    monkeypatch.setattr(Kinematics, "figures", lambda result: {"picture": picture})
    result.save(tmp_path, figures=True)
    (wide,) = struct.unpack(">I", (tmp_path / "picture.png").read_bytes()[16:20])
    screen = 96.0 * picture.get_size_inches()[0]
    assert 1.5 < wide / screen < 3.0


@pytest.mark.parametrize("count", [500, 2500])
def test_variables_are_compressed_where_that_makes_files_smaller(monkeypatch, count):
    curve = xr.Dataset({"curve": ("angle", np.sin(np.linspace(0.0, 6.0, count)))})
    written = len(netcdf.netcdf_bytes(curve, {}))
    sizes = []
    for least in (0, 10**9):
        monkeypatch.setattr(netcdf, "LEAST_COMPRESSED", least)
        sizes.append(len(netcdf.netcdf_bytes(curve, {})))
    assert written == min(sizes) < max(sizes)
