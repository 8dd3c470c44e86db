"""Laws of motion of the crank: handbook, closed forms, continuity, repeated moves, tables."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from flexmech import (
    ConstantSpeed,
    Drive,
    InputError,
    LawDrive,
    Mechanism,
    ShapedDrive,
    TableDrive,
    input_shaper,
    kinematics,
)
from flexmech.analyses import KinematicsRequest
from flexmech.linkages import LAWS, FrequenciesOnPath, LawName, LockedCrank, PathShapedDrive
from tests.support.strategies import fourbar

# Greatest speed over travel / time, greatest acceleration over travel / time^2, greatest jerk over
# travel / time^3: Norton, Cam Design and Manufacturing Handbook, 2nd ed., Table 3-2; his polynomial
# 4567 in Table 3-3.
FACTORS: dict[LawName, tuple[float, float, float]] = {
    "trapezoid": (2.000, 4.888, 61.43),
    "cycloid": (2.000, 6.283, 39.48),
    "modified sine": (1.760, 5.528, 69.47),
    "polynomial 4567": (2.188, 7.513, 52.50),
}
TRAVEL, TIME = 2.1, 0.15
FINE = np.linspace(0.0, TIME, 20_001)
TIMES = np.linspace(0.0, TIME, 61)


def law(kind: LawName = "cycloid", **others: object) -> LawDrive:
    return LawDrive(kind, TRAVEL, TIME, **others)  # type: ignore[arg-type]


def table(angles: np.ndarray, **others: object) -> TableDrive:
    return TableDrive(tuple(TIMES), tuple(angles), **others)  # type: ignore[arg-type]


def peak(values: np.ndarray) -> float:
    return float(np.abs(values).max())


@pytest.mark.parametrize("kind", LAWS)
def test_peaks_are_those_of_the_handbook(kind: LawName) -> None:
    drive, (speed, acceleration, jerk) = law(kind), FACTORS[kind]
    assert peak(drive.crank_speed(FINE)) * TIME / TRAVEL == pytest.approx(speed, abs=5.1e-4)
    values = drive.crank_acceleration(FINE)
    assert peak(values) * TIME**2 / TRAVEL == pytest.approx(acceleration, abs=5.1e-4)
    assert peak(np.diff(values) / np.diff(FINE)) * TIME**3 / TRAVEL == pytest.approx(jerk, rel=1e-3)


def test_closed_forms_of_cycloid_and_run_up() -> None:
    """The run-up of Simo & Vu-Quoc 1986, and the constant speed after it."""
    part = FINE / TIME
    angle = 0.4 + TRAVEL * (part - np.sin(2 * np.pi * part) / (2 * np.pi))
    np.testing.assert_allclose(law(start_angle=0.4).crank_angle(FINE), angle, atol=1e-14)
    change = TRAVEL / TIME**2 * 2 * np.pi * np.sin(2 * np.pi * part)
    np.testing.assert_allclose(law().crank_acceleration(FINE), change, atol=1e-9)
    drive, total = ConstantSpeed(20.0, run_up_time=0.5, start_angle=0.3), 0.5
    time = np.linspace(0.0, 0.9, 1801)
    inside = np.minimum(time, total)
    rising = inside**2 / (2 * total)
    rising -= total * (1 - np.cos(2 * np.pi * inside / total)) / (2 * np.pi) ** 2
    angle = 0.3 + 20.0 * (rising + np.maximum(time - total, 0.0))
    np.testing.assert_allclose(drive.crank_angle(time), angle, atol=1e-13)
    part = inside / total
    speed = 20.0 * (part - np.sin(2 * np.pi * part) / (2 * np.pi))
    np.testing.assert_allclose(drive.crank_speed(time), speed, atol=1e-13)


def test_a_constant_speed_is_the_line_to_the_last_digit() -> None:
    time = np.linspace(0.0, 3.0, 301)
    drive = ConstantSpeed(-17.3, start_angle=0.2)
    assert drive.is_constant
    np.testing.assert_array_equal(drive.crank_angle(time), 0.2 - 17.3 * time)
    np.testing.assert_array_equal(drive.crank_speed(time), -17.3)


DRIVES: dict[str, Drive] = {
    **{kind: law(kind, dwell=0.05, moves=3) for kind in LAWS},
    "back": law("modified sine", dwell=0.02, moves=4, forth_and_back=True),
    "without dwell": law("trapezoid", moves=2),
    "run-up": ConstantSpeed(20.0, 0.1, 0.3),
    "table": TableDrive(
        tuple(np.linspace(0.0, 0.2, 41)),
        tuple(np.linspace(0.0, 3.0, 41) + np.sin(np.linspace(0.0, 2 * np.pi, 41))),
        moves=3,
    ),
    "table that dwells": TableDrive(
        tuple(np.linspace(0.0, 0.2, 41)),
        tuple(LawDrive("cycloid", TRAVEL, 0.2).crank_angle(np.linspace(0.0, 0.2, 41))),
        ends="rest",
        moves=3,
        dwell=0.05,
    ),
    "shaped": ShapedDrive(
        law("modified sine", dwell=0.02, moves=2, forth_and_back=True),
        input_shaper("zvd", 60.0, 0.02).convolved(input_shaper("zv", 90.0)),
    ),
    "shaped on its path": PathShapedDrive(
        law("cycloid"),
        input_shaper("ei", 1.0),
        FrequenciesOnPath(
            tuple(np.linspace(0.0, TRAVEL, 31)), tuple(np.linspace(40.0, 70.0, 31) ** 1.01)
        ),
    ),
}


@pytest.mark.parametrize("drive", DRIVES.values(), ids=list(DRIVES))
def test_angles_are_integrals_of_speeds_and_these_of_accelerations(drive: Drive) -> None:
    """Nothing jumps, the acceleration neither."""
    # At the very end a table goes on at the speed that it has there.
    time = np.linspace(0.0, drive.run_time(1.0) * (1 - 1e-9), 40_001)
    angle, speed = drive.crank_angle(time), drive.crank_speed(time)
    acceleration = drive.crank_acceleration(time)
    for values, rates in ((angle, speed), (speed, acceleration)):
        steps = (rates[1:] + rates[:-1]) / 2 * np.diff(time)
        np.testing.assert_allclose(
            np.cumsum(steps), values[1:] - values[0], atol=1e-6 * peak(values)
        )
    assert np.abs(np.diff(acceleration)).max() < 0.02 * peak(acceleration)


def test_moves_go_on_or_back() -> None:
    onward = law(dwell=0.05, moves=3, start_angle=0.1)
    time = np.array([0.0, 0.15, 0.2, 0.35, 0.4, 0.55, 0.6])
    for drive, ends in (
        (onward, [0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0]),
        (replace(onward, forth_and_back=True), [0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0]),
    ):
        expected = 0.1 + TRAVEL * np.array(ends)
        np.testing.assert_allclose(drive.crank_angle(time), expected, atol=1e-13)
        assert (drive.law_time, drive.run_time(4.0)) == pytest.approx((0.55, 0.6))


def test_a_stretched_law_keeps_travel_and_dwell() -> None:
    drive = law(dwell=0.05, start_angle=0.3)
    longer = drive.stretched(1.5)
    assert float(longer.crank_angle(1.5 * TIME)) == pytest.approx(0.3 + TRAVEL)
    assert longer.run_time(1.0) - longer.law_time == pytest.approx(0.05)
    with pytest.raises(InputError, match="law that stops"):
        ConstantSpeed(3.0).stretched(2.0)


def test_a_table_of_a_law_is_the_law_in_sixth_order() -> None:
    """As splines of fifth degree converge with their rows."""
    drive = law("polynomial 4567")

    def gap(rows: int, name: str = "crank_angle") -> float:
        times = np.linspace(0.0, TIME, rows)
        rows_of_it = TableDrive(tuple(times), tuple(drive.crank_angle(times)), ends="rest")
        inside = FINE[:-1]
        return peak(getattr(rows_of_it, name)(inside) - getattr(drive, name)(inside))

    assert math.log2(gap(17) / gap(33)) == pytest.approx(6.0, abs=0.5)
    assert gap(61) < 1e-9 * TRAVEL
    assert gap(61, "crank_acceleration") < 1e-5 * peak(drive.crank_acceleration(FINE))


def test_a_table_of_constant_speed_is_a_constant_speed() -> None:
    """Rounded angles are smoothed into one."""
    exact = table(0.3 + 20.0 * TIMES)
    assert exact.is_constant
    assert exact.speed == pytest.approx(20.0, rel=1e-14)
    rounded = table(np.round(0.3 + 52 / 3 * TIMES, 6), smoothing=1e-6)
    assert rounded.is_constant
    assert not replace(rounded, smoothing=0.0).is_constant


def test_a_table_is_smoothed_by_as_much_as_it_says() -> None:
    random, drive = np.random.default_rng(5), law()
    noise = 1e-4 * random.normal(size=TIMES.size)
    noise[[0, -1]] = 0.0
    rough = table(drive.crank_angle(TIMES) + noise, ends="rest")
    smooth = replace(rough, smoothing=1e-4)
    left = smooth.crank_angle(TIMES) - np.array(rough.angles)
    assert np.sqrt(np.mean(left**2)) == pytest.approx(1e-4, rel=0.1)
    exact = drive.crank_acceleration(FINE[:-1])
    gaps = [peak(each.crank_acceleration(FINE[:-1]) - exact) for each in (rough, smooth)]
    assert gaps[1] < 0.7 * gaps[0]


def test_a_repeated_table_with_free_ends_is_periodic() -> None:
    phase = 2 * np.pi * TIMES / TIME
    drive = table(20.0 * TIMES + 0.1 * np.sin(phase + 0.4), moves=3)
    before, after = TIME - 1e-9, TIME + 1e-9
    for rate in (drive.crank_speed, drive.crank_acceleration):
        assert float(rate(before)) == pytest.approx(float(rate(after)), rel=1e-5)
    assert float(drive.crank_angle(3 * TIME) - drive.crank_angle(0.0)) == pytest.approx(9.0)


LAW = LawDrive("cycloid", np.radians(120), 0.15, dwell=0.1, start_angle=0.3)


@pytest.fixture(scope="module")
def driven() -> tuple[Mechanism, object]:
    """A four-bar and its kinematics under a law."""
    mechanism = fourbar(shaft_inertia=1e-4)
    return mechanism, kinematics(mechanism, LAW).dataset


def test_each_state_under_a_law_is_that_of_an_accelerated_crank(driven) -> None:  # type: ignore[no-untyped-def]
    mechanism, data = driven
    time = data["time"].values
    assert time[[0, -1]] == pytest.approx([0.0, 0.25])
    np.testing.assert_array_equal(data["crank_angle"], LAW.crank_angle(time))
    np.testing.assert_allclose(data["shaft_inertia_torque"], 1e-4 * LAW.crank_acceleration(time))
    power = data["driving_torque"] * data["crank_speed_over_time"]
    np.testing.assert_allclose(data["driving_power"], power)
    for number in (100, 420):
        one = data.isel(time=number)
        asked = KinematicsRequest(
            float(one["crank_speed_over_time"]),
            crank_angles=[float(one["crank_angle"])],
            crank_acceleration=float(one["crank_acceleration"]),
        )
        state = kinematics(mechanism, asked).dataset.isel(crank_angle=0)
        for name in ("joint_force", "driving_torque", "shaking_force", "shaking_moment"):
            np.testing.assert_allclose(one[name], state[name], rtol=1e-9, atol=1e-9)


def test_from_rest_to_rest_the_drive_gets_back_what_it_gives(driven) -> None:  # type: ignore[no-untyped-def]
    data = driven[1]
    work = np.trapezoid(data["driving_power"], data["time"])
    assert abs(work) < 1e-6 * float(abs(data["driving_power"]).max())


REFUSED = {
    "travel must be a number, got nan": lambda: LawDrive("cycloid", math.nan, 0.1),
    "dwell must be zero or positive": lambda: LawDrive("cycloid", 1.0, 0.1, dwell=-1.0),
    "forth_and_back must be True": lambda: LawDrive("cycloid", 1.0, 0.1, forth_and_back=1),
    "give four rows or more": lambda: TableDrive((0, 1, 2), (0, 1, 2)),
    "from 114.592 to 515.662 deg in row 4": lambda: TableDrive((0, 1, 2, 3), (0, 1, 2, 9)),
    "jumps from 357 to 4 deg": lambda: TableDrive(
        tuple(range(360)), tuple(np.radians((np.arange(360) * 7) % 360))
    ),
    "times of a table must be finite": lambda: TableDrive((0, 1, math.nan, 3), (0, 1, 2, 3)),
    "angles of a table must be finite": lambda: TableDrive((0, 1, 2, 3), (0, 1, math.inf, 3)),
    "choose ends rest or held": lambda: table(20.0 * TIMES, dwell=0.1),
    "a locked crank does not turn": lambda: fourbar(drive=LockedCrank(1.0)),
    "drive must be": lambda: fourbar(drive=20.0),
    "its own angles": lambda: KinematicsRequest(LAW, crank_acceleration=1.0),
}


@pytest.mark.parametrize("said", REFUSED)
def test_laws_and_tables_that_are_none_are_refused(said: str) -> None:
    with pytest.raises(InputError, match=said):
        REFUSED[said]()
