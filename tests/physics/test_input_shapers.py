"""Input shapers and shaped laws: closed forms, published fits, and an oscillator that changes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from flexmech import (
    ConstantSpeed,
    Drive,
    InputError,
    InputShaper,
    LawDrive,
    ShapedDrive,
    TableDrive,
    input_shaper,
)
from flexmech.linkages import FrequenciesOnPath, PathShapedDrive

RATIOS = np.linspace(0.6, 1.4, 41)
MOVE = LawDrive("modified sine", 2.0, 0.15, dwell=0.05, start_angle=0.3)


@pytest.mark.parametrize("ratio", [0.0, 0.1])
def test_zv_and_zvd_are_those_of_singer_and_seering(ratio: float) -> None:
    """Nothing is left at the frequency; ZVD is ZV twice."""
    root = math.sqrt(1 - ratio**2)
    left = math.exp(-ratio * math.pi / root)
    zv, zvd = (input_shaper(kind, 5.0, ratio) for kind in ("zv", "zvd"))
    assert zv.weights == pytest.approx((1 / (1 + left), left / (1 + left)))
    assert zv.times == pytest.approx((0.0, 0.1 / root))
    twice = zv.convolved(zv)
    assert zvd.weights == pytest.approx(twice.weights)
    assert zvd.times == pytest.approx(twice.times)
    for shaper in (zv, zvd):
        assert float(shaper.residual(5.0, ratio)) < 1e-15


def test_residuals_without_damping_have_closed_forms() -> None:
    """Two equal impulses half a period apart, twice two, and EI."""
    cosine = np.abs(np.cos(np.pi / 2 * RATIOS))
    for kind, expected in (
        ("zv", cosine),
        ("zvd", cosine**2),
        ("ei", np.abs(0.475 + 0.525 * np.cos(np.pi * RATIOS))),
    ):
        shaper = input_shaper(kind, 3.0, tolerated=0.05)
        np.testing.assert_allclose(shaper.residual(3 * RATIOS), expected, atol=1e-15)


@pytest.mark.parametrize("ratio", [0.01, 0.1])
def test_damped_ei_is_that_of_the_published_fits(ratio: float) -> None:
    """Curve fits of Singhose, Seering and Singer, of their own accuracy of half a percent."""
    v, z = 0.05, ratio
    shaper = input_shaper("ei", 1.0, z, v)
    first = 0.2497 + 0.2496 * v + 0.8001 * z + 1.233 * v * z + 0.4960 * z**2 + 3.173 * v * z**2
    period = 1 / math.sqrt(1 - z**2)
    half = 0.5 + 0.4616 * v * z + 4.262 * v * z**2 + 1.756 * v * z**3
    half += 8.578 * v**2 * z - 108.6 * v**2 * z**2 + 337 * v**2 * z**3
    assert shaper.weights[0] == pytest.approx(first, abs=1e-3)
    assert shaper.times == pytest.approx((0.0, half * period, period), abs=5e-4)
    # The tolerated part at the frequency, nothing on either side of it.
    assert float(shaper.residual(1.0, z)) == pytest.approx(v, rel=1e-9)
    sides = shaper.residual(np.linspace(0.7, 1.3, 60_001), z)
    assert max(sides[:30_000].min(), sides[30_000:].min()) < 2e-5


def test_convolved_shapers_leave_the_product_of_what_they_leave() -> None:
    one, two = input_shaper("zv", 5.0, 0.02), input_shaper("ei", 8.0, 0.05)
    both = one.convolved(two)
    assert both.duration == pytest.approx(one.duration + two.duration)
    product = one.residual(9 * RATIOS) * two.residual(9 * RATIOS)
    np.testing.assert_allclose(both.residual(9 * RATIOS), product, atol=1e-14)


LAWS: dict[str, Drive] = {
    "one move": MOVE,
    "back and forth": LawDrive("trapezoid", -1.0, 0.1, 0.03, moves=3, forth_and_back=True),
    "held": TableDrive((0.0, 0.1, 0.2, 0.3), (0.0, 0.1, 0.4, 0.9), ends="held", dwell=0.1),
}


@pytest.mark.parametrize("law", LAWS.values(), ids=list(LAWS))
def test_a_shaped_law_is_the_sum_of_delayed_parts(law: Drive) -> None:
    shaper = input_shaper("zvd", 40.0, 0.02).convolved(input_shaper("zv", 70.0))
    shaped = ShapedDrive(law, shaper)
    assert shaped.law_time == pytest.approx(law.law_time + shaper.duration)
    # Knots of a part differ by a rounding from those of the law, and a held law jumps there.
    time = np.linspace(0.0, shaped.run_time(1.0), 4001) + 1.234567e-6
    for name in ("crank_angle", "crank_speed", "crank_acceleration"):
        total = np.zeros(len(time))
        for later, weight in zip(shaper.times, shaper.weights, strict=True):
            values = getattr(law, name)(np.maximum(time - later, 0.0))
            begun = (time >= later) | (name == "crank_angle")
            total += weight * np.where(begun, values, 0.0)
        scale = np.abs(total).max()
        np.testing.assert_allclose(getattr(shaped, name)(time), total, atol=1e-12 * scale)


def on_path(frequencies: np.ndarray, kind: str, ratio: float = 0.0) -> PathShapedDrive:
    path = FrequenciesOnPath(tuple(np.linspace(0.3, 2.3, 41)), tuple(frequencies))
    return PathShapedDrive(MOVE, input_shaper(kind, 1.0, ratio), path)  # type: ignore[arg-type]


@pytest.mark.parametrize("kind", ["zv", "zvd", "ei"])
def test_along_a_path_of_one_frequency_it_is_the_plain_shaper(kind: str) -> None:
    along = on_path(np.full(41, 50.0), kind, 0.02)
    plain = ShapedDrive(MOVE, input_shaper(kind, 50.0, 0.02))  # type: ignore[arg-type]
    time = np.linspace(0.0, plain.law_time, 2001)
    for name, error in (("crank_angle", 1e-9), ("crank_speed", 1e-7), ("crank_acceleration", 1e-5)):
        values = getattr(plain, name)(time)
        scale = np.abs(values).max()
        np.testing.assert_allclose(getattr(along, name)(time), values, atol=error * scale)


def test_a_law_shaped_along_its_path_is_written_as_a_table() -> None:
    drive = on_path(50 + 15 * np.sin(np.linspace(0.3, 2.3, 41)), "zv")
    time = np.linspace(0.0, drive.run_time(1.0), 2001)
    written = drive.tabulated().crank_angle(time)
    np.testing.assert_allclose(written, drive.crank_angle(time), atol=1e-7)


def rings(drive: Drive, path: FrequenciesOnPath) -> float:
    """Amplitude at the stop of an oscillator on the crank, ``q'' + omega^2 q = -theta''``."""

    def rate(time: float, state: np.ndarray) -> list[float]:
        angle = drive.crank_angle(np.array([time]))
        square = (2 * np.pi * float(path.at(angle)[0][0])) ** 2
        return [state[1], -square * state[0] - float(drive.crank_acceleration(time))]

    end = drive.law_time
    run = solve_ivp(rate, (0.0, end), [0.0, 0.0], rtol=1e-7, atol=1e-11, max_step=2e-3)
    last = 2 * np.pi * float(path.at(drive.crank_angle(np.array([end])))[0][0])
    return float(np.hypot(run.y[0, -1], run.y[1, -1] / last))


def test_along_the_path_an_oscillator_that_changes_stays_quiet() -> None:
    """Its frequency rises by half on the way: a shaper for the end leaves most of it."""
    places = tuple(np.linspace(0.3, 2.3, 41))
    path = FrequenciesOnPath(places, tuple(np.linspace(62.0, 95.0, 41)))
    law = LawDrive("cycloid", 2.0, 0.1, start_angle=0.3)
    plain = rings(law, path)
    assert rings(ShapedDrive(law, input_shaper("zv", 95.0)), path) > 0.3 * plain
    assert rings(PathShapedDrive(law, input_shaper("zv", 1.0), path), path) < 0.005 * plain


REFUSED = {
    "zv": lambda: input_shaper("zvv", 5.0),
    "must be positive": lambda: input_shaper("zv", 0.0),
    "less than 1": lambda: input_shaper("zv", 5.0, 1.0),
    "take ZV": lambda: input_shaper("ei", 5.0, 0.5),
    "add up to 1": lambda: InputShaper((0.0, 0.1), (0.5, 0.6)),
    "from 0 s": lambda: InputShaper((0.1, 0.2), (0.5, 0.5)),
    "each impulse": lambda: InputShaper((0.0,), (0.5, 0.5)),
    "law that stops": lambda: ShapedDrive(ConstantSpeed(3.0), input_shaper("zv", 5.0)),
    "six or more": lambda: FrequenciesOnPath((0.0, 1.0), (3.0, 4.0)),
}


@pytest.mark.parametrize("said", REFUSED)
def test_shapers_that_are_none_are_refused(said: str) -> None:
    with pytest.raises(InputError, match=said):
        REFUSED[said]()
