"""Stiffnesses of laminates printed by Nettles, *Basic Mechanics of Laminated Composite Plates*.

NASA RP-1351, October 1994, examples 2 and 9. The report rounds the smaller Poisson's ratio to 0.02:
its reduced stiffnesses are greater by ``(1 - 0.3 nu_21) / 0.994``, which both Young's moduli of the
ply below are multiplied by. "Strength of laminated composites is not covered" there: no failure
index of it is to be had.
"""

from __future__ import annotations

import numpy as np

from flexmech.materials import Laminate, Layer, Ply

# In lb/in^2 and in.
E1, E2, G12, NU12, THICK = 20_010_000.0, 1_301_000.0, 1_001_000.0, 0.3, 0.005
ROUNDED = (1 - NU12**2 * E2 / E1) / (1 - NU12 * 0.02)
PLY = Ply(ROUNDED * E1, ROUNDED * E2, G12, G12, G12, NU12, 1.0)


def stiffness(angle: float) -> np.ndarray:
    return Layer(PLY, THICK, np.radians(angle)).transformed_stiffness


def test_plies_of_nettles_example_1() -> None:
    printed = [[20_130_785, 392_656, 0], [392_656, 1_308_853, 0], [0, 0, 1_001_000]]
    np.testing.assert_allclose(stiffness(0.0), printed, atol=1)
    printed = [
        [6_557_237, 4_555_238, 4_705_483],
        [4_555_238, 6_557_237, 4_705_483],
        [4_705_483, 4_705_483, 5_163_582],
    ]
    np.testing.assert_allclose(stiffness(45.0), printed, atol=1)


def test_coupling_of_nettles_example_2() -> None:
    """[0, +45]: plies are counted from the top, here from below; B in lb."""
    laminate = Laminate.stacked([PLY] * 2, THICK, np.radians([45.0, 0.0]))
    printed = [[170, -52, -59], [-52, -66, -59], [-59, -59, -52]]
    np.testing.assert_allclose(laminate.stiffness_moment(1), printed, atol=0.51)


def test_laminate_of_nettles_example_9() -> None:
    """A in lb/in, B in lb, some of them printed without decimals."""
    laminate = Laminate.stacked([PLY] * 3, THICK, np.radians([90.0, 0.0, 45.0]))
    printed = [[139_984, 26_703, 23_527], [26_703, 139_984, 23_527], [23_527, 23_527, 35_828]]
    np.testing.assert_allclose(laminate.stiffness_moment(0), printed, atol=1)
    printed_b = [[131.2, 104, 117.6], [104, -339.4, 117.6], [117.6, 117.6, 104]]
    np.testing.assert_allclose(laminate.stiffness_moment(1), printed_b, atol=0.5)
