"""Input shapers and shaped laws: closed forms, published fits, and an oscillator that changes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from flexmech import InputError, InputShaper, LawDrive, ShapedDrive, TableDrive, input_shaper
from flexmech.arrays import FloatArray
from flexmech.choices import SHAPERS, ShaperName
from flexmech.linkages import ConstantSpeed, Drive, FrequenciesOnPath, PathShapedDrive

RATIOS = np.linspace(0.6, 1.4, 41)


def test_zv_is_that_of_singer_and_seering() -> None:
    shaper = input_shaper("zv", 5.0, 0.1)
    left = math.exp(-0.1 * math.pi / math.sqrt(0.99))
    assert shaper.weights == pytest.approx((1 / (1 + left), left / (1 + left)))
    assert shaper.times == pytest.approx((0.0, 0.1 / math.sqrt(0.99)))


@pytest.mark.parametrize("kind", ["zv", "zvd"])
@pytest.mark.parametrize("ratio", [0.0, 0.02, 0.3])
def test_nothing_is_left_at_the_frequency(kind: ShaperName, ratio: float) -> None:
    assert float(input_shaper(kind, 7.0, ratio).residual(7.0, ratio)) < 1e-15


def test_robustness_without_damping_has_closed_forms() -> None:
    """Of two equal impulses half a period apart, and of twice two."""
    cosine = np.abs(np.cos(np.pi / 2 * RATIOS))
    np.testing.assert_allclose(input_shaper("zv", 3.0).residual(3 * RATIOS), cosine, atol=1e-15)
    np.testing.assert_allclose(input_shaper("zvd", 3.0).residual(3 * RATIOS), cosine**2, atol=1e-15)
    found = input_shaper("ei", 3.0, tolerated=0.05).residual(3 * RATIOS)
    wanted = np.abs(0.475 + 0.525 * np.cos(np.pi * RATIOS))
    np.testing.assert_allclose(found, wanted, atol=1e-15)


def test_ei_tolerates_a_wider_band_than_zvd() -> None:
    """Widths of the bands in which 5 % is left, 0.06, 0.29 and 0.40 as Singhose 1994 has them."""
    fine, quarter = np.linspace(0.5, 1.5, 100_001), 4 / math.pi
    widths = {
        "zv": quarter * math.asin(0.05),
        "zvd": quarter * math.asin(math.sqrt(0.05)),
        "ei": 2 - 2 / math.pi * math.acos((0.05 - 0.475) / 0.525),
    }
    assert list(widths.values()) == pytest.approx([0.06, 0.29, 0.40], abs=5e-3)
    for kind in SHAPERS:
        below = input_shaper(kind, 1.0, tolerated=0.05).residual(fine) <= 0.05 + 1e-12
        assert np.ptp(fine[below]) == pytest.approx(widths[kind], abs=1e-4)


@pytest.mark.parametrize("ratio", [0.01, 0.05, 0.1])
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
    # Its conditions: the tolerated part at the frequency, nothing on either side of it.
    assert float(shaper.residual(1.0, z)) == pytest.approx(v, rel=1e-9)
    sides = shaper.residual(np.linspace(0.7, 1.3, 60_001), z)
    middle = len(sides) // 2
    assert sides[:middle].min() < 2e-5
    assert sides[middle:].min() < 2e-5


def test_convolved_shapers_leave_the_product() -> None:
    one, two = input_shaper("zv", 5.0, 0.02), input_shaper("ei", 8.0, 0.05)
    both = one.convolved(two)
    assert both.duration == pytest.approx(one.duration + two.duration)
    assert sum(both.weights) == pytest.approx(1.0)
    wanted = one.residual(9 * RATIOS) * two.residual(9 * RATIOS)
    np.testing.assert_allclose(both.residual(9 * RATIOS), wanted, atol=1e-14)
    twice = input_shaper("zv", 5.0).convolved(input_shaper("zv", 5.0))
    assert twice.weights == pytest.approx(input_shaper("zvd", 5.0).weights)
    assert twice.times == pytest.approx(input_shaper("zvd", 5.0).times)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (lambda: input_shaper("zvv", 5.0), "zv"),  # type: ignore[arg-type]
        (lambda: input_shaper("zv", 0.0), "must be positive"),
        (lambda: input_shaper("zv", 5.0, 1.0), "less than 1"),
        (lambda: input_shaper("ei", 5.0, 0.5), "take ZV"),
        (lambda: InputShaper((0.0, 0.1), (0.5, 0.6)), "add up to 1"),
        (lambda: InputShaper((0.1, 0.2), (0.5, 0.5)), "from 0 s"),
        (lambda: InputShaper((0.0,), (0.5, 0.5)), "each impulse"),
        (lambda: ShapedDrive(ConstantSpeed(3.0), input_shaper("zv", 5.0)), "law that stops"),
        (lambda: FrequenciesOnPath((0.0, 1.0), (3.0, 4.0)), "six or more"),
    ],
)
def test_what_cannot_be_is_refused(wrong: object, said: str) -> None:
    assert callable(wrong)
    with pytest.raises(InputError, match=said):
        wrong()


LAWS: dict[str, Drive] = {
    "one move": LawDrive("modified sine", 2.0, 0.15, dwell=0.05, start_angle=0.3),
    "back and forth": LawDrive("trapezoid", -1.0, 0.1, 0.03, moves=3, forth_and_back=True),
    "table": TableDrive(
        tuple(np.linspace(0.0, 0.2, 41)),
        tuple(np.linspace(0.0, 1.5, 41) ** 2),
        ends="rest",
        dwell=0.1,
        moves=2,
    ),
    "held": TableDrive((0.0, 0.1, 0.2, 0.3), (0.0, 0.1, 0.4, 0.9), ends="held", dwell=0.1),
}


@pytest.mark.parametrize("law", LAWS.values(), ids=list(LAWS))
def test_a_shaped_law_is_the_sum_of_its_parts(law: Drive) -> None:
    shaper = input_shaper("zvd", 40.0, 0.02).convolved(input_shaper("zv", 70.0))
    shaped = ShapedDrive(law, shaper)
    assert shaped.law_time == pytest.approx(law.law_time + shaper.duration)
    assert shaped.run_time(1.0) == pytest.approx(law.run_time(1.0) + shaper.duration)
    assert shaped.start_angle == law.start_angle
    # Knots of a part differ by a rounding from those of the law, and a held law jumps there.
    time = np.linspace(0.0, shaped.run_time(1.0), 4001) + 1.234567e-6
    for name in ("crank_angle", "crank_speed", "crank_acceleration"):
        total = np.zeros(len(time))
        for later, weight in zip(shaper.times, shaper.weights, strict=True):
            begun = time >= later
            values = getattr(law, name)(np.maximum(time - later, 0.0))
            total += weight * (values if name == "crank_angle" else np.where(begun, values, 0.0))
        scale = np.abs(total).max()
        np.testing.assert_allclose(getattr(shaped, name)(time), total, atol=1e-12 * scale)


def test_a_law_that_is_shaped_twice_is_a_table_of_one() -> None:
    law, one, two = LAWS["one move"], input_shaper("zv", 40.0), input_shaper("ei", 70.0)
    twice = ShapedDrive(ShapedDrive(law, one), two)
    assert twice.to_table() == ShapedDrive(law, one.convolved(two)).to_table()


def test_stretched_laws_keep_travel_and_dwell() -> None:
    for law in LAWS.values():
        longer = law.stretched(1.5)
        assert float(longer.crank_angle(longer.law_time)) == pytest.approx(law.law.end_angle)
        dwells = (each.run_time(1.0) - each.law_time for each in (law, longer))
        assert next(dwells) == pytest.approx(next(dwells))
    with pytest.raises(InputError, match="law that stops"):
        ConstantSpeed(3.0).stretched(2.0)


def test_a_blow_is_a_jump_of_the_speed() -> None:
    held = LAWS["held"].law.blow
    assert held == pytest.approx((0.3, -6.0))
    assert [law.law.blow for name, law in LAWS.items() if name != "held"] == 3 * [None]


PLACES = np.linspace(0.3, 2.3, 41)


def on_path(frequency: FloatArray, kind: ShaperName = "zv", ratio: float = 0.0) -> PathShapedDrive:
    path = FrequenciesOnPath(tuple(PLACES), tuple(frequency))
    return PathShapedDrive(LAWS["one move"], input_shaper(kind, 1.0, ratio), path)


@pytest.mark.parametrize("kind", SHAPERS)
def test_along_a_path_of_one_frequency_it_is_the_plain_shaper(kind: ShaperName) -> None:
    found = on_path(np.full(41, 50.0), kind, 0.02)
    wanted = ShapedDrive(LAWS["one move"], input_shaper(kind, 50.0, 0.02))
    assert found.delay == pytest.approx(wanted.delay)
    time = np.linspace(0.0, wanted.law_time, 2001)
    for name, error in (("crank_angle", 1e-9), ("crank_speed", 1e-7), ("crank_acceleration", 1e-5)):
        values = getattr(wanted, name)(time)
        scale = np.abs(values).max()
        np.testing.assert_allclose(getattr(found, name)(time), values, atol=error * scale)


def test_a_law_shaped_along_its_path_is_written_as_a_table() -> None:
    drive = on_path(50 + 15 * np.sin(PLACES))
    table = drive.tabulated()
    time = np.linspace(0.0, drive.run_time(1.0), 2001)
    np.testing.assert_allclose(table.crank_angle(time), drive.crank_angle(time), atol=1e-7)
    assert table.run_time(1.0) == pytest.approx(drive.run_time(1.0))
    assert drive.to_table()["ends"] == "rest"


def rings(drive: Drive, path: FrequenciesOnPath) -> float:
    """Amplitude at the stop of an oscillator on the crank, ``q'' + omega^2 q = -theta''``."""

    def rate(time: float, state: FloatArray) -> list[float]:
        angle = drive.crank_angle(np.array([time]))
        square = (2 * np.pi * float(path.at(angle)[0][0])) ** 2
        return [state[1], -square * state[0] - float(drive.crank_acceleration(time))]

    end = drive.law_time
    found = solve_ivp(rate, (0.0, end), [0.0, 0.0], rtol=1e-8, atol=1e-12, max_step=1e-3)
    last = 2 * np.pi * float(path.at(drive.crank_angle(np.array([end])))[0][0])
    return float(np.hypot(found.y[0, -1], found.y[1, -1] / last))


def test_along_the_path_an_oscillator_that_changes_stays_quiet() -> None:
    """Its frequency rises by half on the way: a shaper for the end leaves most of it."""
    path = FrequenciesOnPath(tuple(PLACES), tuple(np.linspace(62.0, 95.0, 41)))
    law = LawDrive("cycloid", 2.0, 0.1, start_angle=0.3)
    plain = rings(law, path)
    at_end = ShapedDrive(law, input_shaper("zv", 95.0))
    along = PathShapedDrive(law, input_shaper("zv", 1.0), path)
    assert rings(at_end, path) > 0.3 * plain
    assert rings(along, path) < 0.005 * plain
