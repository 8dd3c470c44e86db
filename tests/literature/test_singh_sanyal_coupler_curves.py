"""Singh & Sanyal 2022, Figures 3-12: coupler curves of neat resin, dry and swollen.

The equations are the paper's with its slips corrected: a swollen length is the dry one times
one plus the strain (eq. 12), the frame's likewise without moisture, and the constant of the
coupler's angle has b^2 - c^2. R-914 takes up 7 % of water at a temperature rise of 80 K; its
coefficients are those of the table, wet. The numbers of crossings were found with them from
the curves, without the method that is under test; the cases of the verification hold them.
"""

from __future__ import annotations

import numpy as np
import pytest

from flexmech.linkages import CouplerCurve, CouplerPoint, FourBar, double_points
from flexmech.verification import verification_case
from scenarios._cusp_transitions import cusp_transitions
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
    assert [double.kind for double in found] == ["crunode"] * row.crossings(wet=wet)
    for double in found:
        passages = CouplerCurve(linkage, point).position(double.crank_angles)
        assert np.ptp(passages, axis=0).max() < 1e-12 * linkage.ground
    lengths = np.array([list(linkage.lengths.values())])
    points = np.array([[point.distance, point.angle]])
    drawn, _ = polylines(lengths, points, np.ones(1), 3600)
    assert crossings(drawn).tolist() == [len(found)]


def test_change_of_the_angles_in_figures_3_and_4() -> None:
    """100, 160, 160 and 200 mm, to the digits that the corrected equations give."""
    case = verification_case("Angles of swollen links, Figures 3 and 4: wet against dry")
    row = Row("3 and 4", 100, 160, 160, 200, 0, 0)
    dry, wet = (
        in_state(row, *state)[0].motion(np.radians([0.0, 180.0])).angle
        for state in ((0, 0), (RISE, SATURATED))
    )
    change = np.degrees(np.remainder(wet - dry + np.pi, 2 * np.pi) - np.pi)
    assert change[:, 0] == pytest.approx([0.0, 0.0], abs=case.tolerance)
    assert change[:, 1:].ravel() == pytest.approx(case.expected_values(), abs=case.tolerance)


@pytest.mark.parametrize(("figure", "appears"), [("5", True), ("8", False), ("10", True)])
def test_moisture_at_which_the_loop_is_a_cusp(figure: str, appears: bool) -> None:
    """At 80 K from dry to saturated; at a cusp the coupler point stands still."""
    moisture, crank_angle = (
        verification_case(f"Cusps on the way from dry to wet, Figures 5, 8 and 10: {quantity}")
        for quantity in ("moisture", "crank angle")
    )
    place = moisture.labels.index(f"Figure {figure}")
    row = next(row for row in ROWS if row.figure == figure)
    (cusp,) = cusp_transitions(lambda m: in_state(row, RISE, m), 0.0, SATURATED)
    assert cusp.kind == "cusp"
    assert cusp.parameter == pytest.approx(
        moisture.expected_values()[place], abs=moisture.tolerance
    )
    assert np.degrees(cusp.crank_angle) == pytest.approx(
        crank_angle.expected_values()[place], abs=crank_angle.tolerance
    )
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
