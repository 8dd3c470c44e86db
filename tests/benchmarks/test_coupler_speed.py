"""Time for the double points of one coupler curve, against a plain search for crossings."""

import numpy as np
import pytest

from flexmech.linkages import CouplerCurve, CouplerPoint, FourBar, double_points
from flexmech.threads import one_thread

LINKAGE = FourBar(4.5, 2.25, 4.5, 4.5)
POINT = CouplerPoint(5.0, np.radians(336.0))
ANGLES = np.radians(np.arange(360.0))
CURVES = 100


@pytest.fixture(autouse=True)
def _one_thread():
    with one_thread():
        yield


def many():
    for distance in np.linspace(0.1, 9.0, CURVES):
        double_points(LINKAGE, CouplerPoint(float(distance), POINT.angle))


def search():
    """Crossings of all pairs of segments of one curve, a degree each."""
    place = CouplerCurve(LINKAGE, POINT).position(ANGLES)
    here, ahead = place[:, None], np.roll(place, -1, axis=0)[:, None]
    one = side(here, ahead, place[None]) * side(here, ahead, np.roll(place, -1, axis=0)[None])
    return np.argwhere((one < 0) & (one.T < 0))


def side(start, end, place):
    way, other = end - start, place - start
    return way[..., 0] * other[..., 1] - way[..., 1] * other[..., 0]


def test_double_points_of_one_curve(against):
    assert len(double_points(LINKAGE, POINT)) == 1
    against(f"double points of {CURVES} coupler curves", many, search, plain_covers=1 / CURVES)
