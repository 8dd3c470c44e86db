"""Laws of motion of the crank: closed forms, continuity, repeated moves, tables."""

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
    ShapedDrive,
    TableDrive,
    input_shaper,
)
from flexmech.arrays import FloatArray
from flexmech.linkages import LAWS, FrequenciesOnPath, LawName, LockedCrank, PathShapedDrive
from flexmech.multibody.running.user_functions import Shaft

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
FINE = np.linspace(0.0, TIME, 60_001)


def law(kind: LawName = "cycloid", **others: object) -> LawDrive:
    return LawDrive(kind, TRAVEL, TIME, **others)  # type: ignore[arg-type]


def peak(values: FloatArray) -> float:
    return float(np.abs(values).max())


@pytest.mark.parametrize("kind", LAWS)
def test_peaks_are_those_of_the_handbook(kind: LawName) -> None:
    drive = law(kind)
    speed, acceleration, jerk = FACTORS[kind]
    assert peak(drive.crank_speed(FINE)) * TIME / TRAVEL == pytest.approx(speed, abs=5.1e-4)
    found = drive.crank_acceleration(FINE)
    assert peak(found) * TIME**2 / TRAVEL == pytest.approx(acceleration, abs=5.1e-4)
    rate = np.diff(found) / np.diff(FINE)
    assert peak(rate) * TIME**3 / TRAVEL == pytest.approx(jerk, rel=1e-3)


def test_closed_forms_of_the_cycloid() -> None:
    drive, part = law(start_angle=0.4), FINE / TIME
    wanted = 0.4 + TRAVEL * (part - np.sin(2 * np.pi * part) / (2 * np.pi))
    np.testing.assert_allclose(drive.crank_angle(FINE), wanted, atol=1e-14)
    wanted = TRAVEL / TIME**2 * 2 * np.pi * np.sin(2 * np.pi * part)
    np.testing.assert_allclose(drive.crank_acceleration(FINE), wanted, atol=1e-9)


def test_closed_form_of_the_run_up() -> None:
    """Simo & Vu-Quoc 1986, and the constant speed after it."""
    drive, total = ConstantSpeed(20.0, run_up_time=0.5, start_angle=0.3), 0.5
    time = np.linspace(0.0, 0.9, 1801)
    inside = np.minimum(time, total)
    rising = inside**2 / (2 * total)
    rising -= total * (1 - np.cos(2 * np.pi * inside / total)) / (2 * np.pi) ** 2
    wanted = 0.3 + 20.0 * (rising + np.maximum(time - total, 0.0))
    np.testing.assert_allclose(drive.crank_angle(time), wanted, atol=1e-13)
    part = inside / total
    wanted = 20.0 * (part - np.sin(2 * np.pi * part) / (2 * np.pi))
    np.testing.assert_allclose(drive.crank_speed(time), wanted, atol=1e-13)


def test_a_constant_speed_is_the_line_to_the_last_digit() -> None:
    time = np.linspace(0.0, 3.0, 301)
    drive = ConstantSpeed(-17.3, start_angle=0.2)
    assert drive.is_constant
    np.testing.assert_array_equal(drive.crank_angle(time), 0.2 - 17.3 * time)
    np.testing.assert_array_equal(drive.crank_speed(time), -17.3)
    np.testing.assert_array_equal(LockedCrank(0.7).crank_angle(time), 0.7)


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
    "table at rest": TableDrive(
        tuple(np.linspace(0.0, 0.2, 41)), tuple(np.linspace(0.0, 1.5, 41) ** 2), ends="rest"
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
def test_speed_and_acceleration_are_rates_of_the_angle(drive: Drive) -> None:
    """The angle is the integral of the speed, and that of the acceleration: nothing jumps."""
    # At the very end a table goes on at the speed that it has there.
    time = np.linspace(0.0, drive.run_time(1.0) * (1 - 1e-9), 40_001)
    angle, speed = drive.crank_angle(time), drive.crank_speed(time)
    acceleration = drive.crank_acceleration(time)

    def integral(values: FloatArray) -> FloatArray:
        steps = (values[1:] + values[:-1]) / 2 * np.diff(time)
        return np.concatenate([[0.0], np.cumsum(steps)])

    np.testing.assert_allclose(angle[0] + integral(speed), angle, atol=1e-6 * peak(angle))
    np.testing.assert_allclose(speed[0] + integral(acceleration), speed, atol=1e-6 * peak(speed))
    # And the acceleration has no jump either.
    assert np.abs(np.diff(acceleration)).max() < 0.02 * peak(acceleration)


@pytest.mark.parametrize("drive", DRIVES.values(), ids=list(DRIVES))
def test_exudyn_prescribes_the_same_motion(drive: Drive) -> None:
    from flexmech.multibody.running.model import _plain_pieces

    begin = float(drive.crank_angle(0.0))
    shaft = Shaft(begin, drive.speed, _plain_pieces(drive))
    end = drive.run_time(1.0) + 0.01
    # With the knots, at which one piece follows the other.
    time = np.union1d(np.linspace(0.0, end, 997), drive.law.knots)
    angle, speed = np.transpose([shaft.motion(float(t)) for t in time])
    np.testing.assert_allclose(angle, drive.crank_angle(time), rtol=1e-13, atol=1e-13)
    np.testing.assert_allclose(speed, drive.crank_speed(time), rtol=1e-11, atol=1e-10)


def test_a_piece_that_ends_a_rounding_before_the_next_is_not_the_last() -> None:
    """0.1 + 0.2 is beyond 0.3: at 0.3 the first piece is at its end, and the law goes on."""
    still = ()
    pieces = ((0.0, 0.3, (0.0, 0.6), still), (0.1 + 0.2, 0.3, (0.6, 0.6), still))
    assert Shaft(0.0, 99.0, pieces).motion(0.3) == pytest.approx((0.6, 2.0))
    assert Shaft(0.0, 99.0, pieces).motion(0.7)[1] == 99.0


def test_moves_go_on_or_back() -> None:
    onward = law(dwell=0.05, moves=3, start_angle=0.1)
    ends = 0.1 + TRAVEL * np.array([0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0])
    time = np.array([0.0, 0.15, 0.2, 0.35, 0.4, 0.55, 0.6])
    np.testing.assert_allclose(onward.crank_angle(time), ends, atol=1e-13)
    back = replace(onward, forth_and_back=True)
    ends = 0.1 + TRAVEL * np.array([0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0])
    np.testing.assert_allclose(back.crank_angle(time), ends, atol=1e-13)
    assert (onward.law_time, onward.run_time(4.0)) == pytest.approx((0.55, 0.6))
    assert not onward.turns_on
    assert onward.passed_angles(5)[[0, -1]] == pytest.approx([0.1, 0.1 + 4 / 5 * 2 * np.pi])
    assert back.passed_angles(5)[[0, -1]] == pytest.approx([0.1, 0.1 + TRAVEL])


class TestTables:
    TIMES = np.linspace(0.0, TIME, 61)

    def table(self, angles: FloatArray, **others: object) -> TableDrive:
        return TableDrive(tuple(self.TIMES), tuple(angles), **others)  # type: ignore[arg-type]

    def test_of_a_law_are_the_law(self) -> None:
        drive = law("polynomial 4567")
        found = self.table(drive.crank_angle(self.TIMES), ends="rest")
        inside = FINE[:-1]
        gap = found.crank_angle(inside) - drive.crank_angle(inside)
        assert peak(gap) < 1e-9 * TRAVEL
        gap = found.crank_acceleration(inside) - drive.crank_acceleration(inside)
        assert peak(gap) < 1e-5 * peak(drive.crank_acceleration(inside))
        assert (found.speed, found.deviation < 1e-12) == (0.0, True)
        assert found.greatest_acceleration == pytest.approx(
            peak(drive.crank_acceleration(inside)), rel=1e-3
        )

    def test_converge_with_their_rows(self) -> None:
        """In sixth order, as splines of fifth degree do."""
        drive = law("polynomial 4567")

        def gap(rows: int) -> float:
            times = np.linspace(0.0, TIME, rows)
            found = TableDrive(tuple(times), tuple(drive.crank_angle(times)), ends="rest")
            return peak(found.crank_angle(FINE) - drive.crank_angle(FINE))

        assert math.log2(gap(17) / gap(33)) == pytest.approx(6.0, abs=0.5)

    def test_of_constant_speed_are_a_drive_of_constant_speed(self) -> None:
        found = self.table(0.3 + 20.0 * self.TIMES)
        assert found.is_constant
        assert found.turns_on
        assert found.speed == pytest.approx(20.0, rel=1e-14)
        assert found.run_time(4.0) == TIME
        rounded = self.table(np.round(0.3 + 52 / 3 * self.TIMES, 6), smoothing=1e-6)
        assert rounded.is_constant
        assert not replace(rounded, smoothing=0.0).is_constant

    def test_are_smoothed_by_as_much_as_they_say(self) -> None:
        random, drive = np.random.default_rng(5), law()
        noise = 1e-4 * random.normal(size=self.TIMES.size)
        noise[[0, -1]] = 0.0
        rough = self.table(drive.crank_angle(self.TIMES) + noise, ends="rest")
        smooth = replace(rough, smoothing=1e-4)
        assert rough.deviation < 1e-12
        assert 1e-4 < smooth.deviation < 4e-4
        inside = FINE[:-1]
        wanted = drive.crank_acceleration(inside)
        gaps = [peak(each.crank_acceleration(inside) - wanted) for each in (rough, smooth)]
        assert gaps[1] < 0.7 * gaps[0]
        left = smooth.crank_angle(self.TIMES) - np.array(rough.angles)
        assert np.sqrt(np.mean(left**2)) == pytest.approx(1e-4, rel=0.1)

    def test_repeated_with_free_ends_are_periodic(self) -> None:
        phase = 2 * np.pi * self.TIMES / TIME
        found = self.table(20.0 * self.TIMES + 0.1 * np.sin(phase + 0.4), moves=3)
        before, after = TIME - 1e-9, TIME + 1e-9
        for rate in (found.crank_speed, found.crank_acceleration):
            assert float(rate(before)) == pytest.approx(float(rate(after)), rel=1e-5)
        assert float(found.crank_angle(3 * TIME) - found.crank_angle(0.0)) == pytest.approx(9.0)

    @pytest.mark.parametrize(
        ("times", "angles", "message"),
        [
            ([0, 1, 1, 2], [0, 1, 2, 3], "not increasing in time: 1 s follows 1 s in row 3"),
            ([0, 2, 1, 3], [0, 1, 2, 3], "not increasing in time: 1 s follows 2 s in row 3"),
            ([0, 1, 2], [0, 1, 2], "3 times and 3 angles; give four rows or more"),
            ([0, 1, 2, 3], [0, 1, 2, 9], "the angle jumps from 114.592 to 515.662 deg in row 4"),
            (range(12), [0.0] * 6 + [1.0] * 6, "the angle jumps from 0 to 57.2958 deg in row 7"),
            (
                range(12),
                [0.1 * n + 2.5 * (n > 6) for n in range(12)],
                "from 34.3775 to 183.346 deg",
            ),
            (range(360), np.radians((np.arange(360) * 7) % 360), "jumps from 357 to 4 deg"),
            ([0, 1, math.nan, 3], [0, 1, 2, 3], "times of a table must be finite numbers"),
            ([0, 1, 2, 3], [0, 1, math.inf, 3], "angles of a table must be finite numbers"),
        ],
    )
    def test_that_are_none_are_refused(
        self, times: list[float], angles: list[float], message: str
    ) -> None:
        with pytest.raises(InputError, match=message):
            TableDrive(tuple(times), tuple(angles))


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"kind": "cyclod"}, "law must be one of"),
        ({"travel": 0.0}, "travel must be an angle other than zero"),
        ({"travel": math.nan}, "travel must be a number, got nan"),
        ({"time": 0.0}, "time must be positive"),
        ({"dwell": -1.0}, "dwell must be zero or positive"),
        ({"moves": 0}, "moves must be 1 or more"),
        ({"forth_and_back": 1}, "forth_and_back must be True or False"),
    ],
)
def test_laws_that_are_none_are_refused(wrong: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        LawDrive(**({"kind": "cycloid", "travel": 1.0, "time": 0.1} | wrong))  # type: ignore[arg-type]
