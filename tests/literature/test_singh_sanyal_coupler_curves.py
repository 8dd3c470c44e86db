"""Singh & Sanyal 2022, Figures 3-12: coupler curves of neat resin, dry and swollen.

The equations are the paper's with its slips corrected: a swollen length is the dry one times
one plus the strain (eq. 12), the frame's likewise without moisture, and the constant of the
coupler's angle has b^2 - c^2. R-914 takes up 7 % of water at a temperature rise of 80 K; its
coefficients are those of the table, wet. The numbers of crossings were found with them from
the curves, without the method that is under test.
"""

from __future__ import annotations

import numpy as np
import pytest

from flexmech.linkages import (
    CouplerCurve,
    CouplerPoint,
    FourBar,
    cusp_transitions,
    double_points,
)
from tests.analytical.coupler_polylines import crossings, polylines
from tests.literature.coupler_curve_rows import ROWS, Row

THERMAL, MOIST = 62.6e-6, 3.02e-3  # R-914 wet: per K, per percent of water
RISE, SATURATED = 80.0, 7.0
every_row = pytest.mark.parametrize("row", ROWS, ids=[row.figure for row in ROWS])


def in_state(row: Row, rise: float, moisture: float) -> tuple[FourBar, CouplerPoint]:
    """Links swell with temperature and moisture, the frame with temperature."""
    link = 1e-3 * (1 + THERMAL * rise + MOIST * moisture)
    frame = 1e-3 * (1 + THERMAL * rise)
    linkage = FourBar(row.frame * frame, *(link * v for v in (row.crank, row.coupler, row.rocker)))
    return linkage, CouplerPoint(row.distance, np.radians(row.angle)).scaled(link)


def test_strain_of_saturated_r914() -> None:
    dry, wet = (in_state(ROWS[-3], *state)[0] for state in ((0, 0), (RISE, SATURATED)))
    assert wet.crank / dry.crank == pytest.approx(1.026148, abs=1e-9)
    assert wet.crank == pytest.approx(0.1026148, abs=1e-9)


@every_row
@pytest.mark.parametrize("wet", [False, True], ids=["dry", "wet"])
def test_crossings(row: Row, wet: bool) -> None:
    linkage, point = in_state(row, *((RISE, SATURATED) if wet else (0, 0)))
    found = double_points(linkage, point)
    assert [double.kind for double in found] == ["crunode"] * (row.wet if wet else row.dry)
    for double in found:
        passages = CouplerCurve(linkage, point).position(double.crank_angles)
        assert np.ptp(passages, axis=0).max() < 1e-12 * linkage.ground
    lengths = np.array([list(linkage.lengths.values())])
    points = np.array([[point.distance, point.angle]])
    drawn, _ = polylines(lengths, points, np.ones(1), 3600)
    assert crossings(drawn).tolist() == [len(found)]


@pytest.mark.parametrize(
    ("crank_angle", "coupler", "rocker"), [(0.0, 0.77493, -0.77493), (180.0, 2.02411, -2.02411)]
)
def test_change_of_the_angles_in_figures_3_and_4(
    crank_angle: float, coupler: float, rocker: float
) -> None:
    """100, 160, 160 and 200 mm, to the digits that the corrected equations give."""
    row = Row("3 and 4", 100, 160, 160, 200, 0, 0, 0, 0)
    dry, wet = (
        in_state(row, *state)[0].motion(np.radians(crank_angle)).angle
        for state in ((0, 0), (RISE, SATURATED))
    )
    change = np.degrees(np.remainder(wet - dry + np.pi, 2 * np.pi) - np.pi)
    assert change == pytest.approx([0.0, coupler, rocker], abs=5.1e-6)


@pytest.mark.parametrize(
    ("figure", "moisture", "crank_angle", "appears"),
    [
        ("5", 0.957922, 338.281, True),
        ("8", 5.787376, 210.088, False),
        ("10", 0.149440, 8.683, True),
    ],
)
def test_moisture_at_which_the_loop_is_a_cusp(
    figure: str, moisture: float, crank_angle: float, appears: bool
) -> None:
    """At 80 K from dry to saturated; at a cusp the coupler point stands still."""
    row = next(row for row in ROWS if row.figure == figure)
    (cusp,) = cusp_transitions(lambda m: in_state(row, RISE, m), 0.0, SATURATED)
    assert cusp.kind == "cusp"
    assert cusp.parameter == pytest.approx(moisture, abs=1e-6)
    assert np.degrees(cusp.crank_angle) == pytest.approx(crank_angle, abs=1e-3)
    assert (cusp.crunodes_before, cusp.crunodes_after) == ((0, 1) if appears else (1, 0))
    curve = CouplerCurve(*in_state(row, RISE, cusp.parameter))
    assert curve.speed(cusp.crank_angle) < 1e-11 * curve.linkage.crank
    assert curve.position(cusp.crank_angle) == pytest.approx(cusp.position, abs=1e-12)


@pytest.mark.parametrize("figure", ["6", "11", "12"])
def test_the_other_curves_keep_their_kind_at_every_moisture(figure: str) -> None:
    row = next(row for row in ROWS if row.figure == figure)
    assert cusp_transitions(lambda m: in_state(row, RISE, m), 0.0, SATURATED) == ()


@every_row
def test_a_frame_of_the_same_resin_changes_no_angle(row: Row) -> None:
    linkage, point = in_state(row, 0, 0)
    swollen = FourBar(**{name: 1.026148 * r for name, r in linkage.lengths.items()})
    dry, wet = double_points(linkage, point), double_points(swollen, point.scaled(1.026148))
    for before, after in zip(dry, wet, strict=True):
        assert after.crank_angles == pytest.approx(before.crank_angles, abs=1e-9)
        assert after.position == pytest.approx(1.026148 * before.position, rel=1e-12)
