"""Critical speeds of a rotating arm, whose frequencies are known in closed form.

A slender cantilever without prestress. In the frozen inertial form it has the frequencies of a
clamped beam (Blevins, Formulas for Natural Frequency and Mode Shape, 1979, table 8-1), and in the
turning frame the centripetal terms alone are left, ``omega^2 = omega_0^2 - Omega^2``: order n meets
it at ``omega_0 / n``, and at ``omega_0 / sqrt(n^2 + 1)``.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from flexmech import Mechanism, ReferenceEngine, campbell

# Roots of cos(x) cosh(x) = -1.
CLAMPED = np.array([1.8751040687119611, 4.694091132974175])
SLENDERNESS = 2e4
# Beyond the first frequency at rest the arm without tension turns over.
FASTEST = 3.4
ORDERS = [1, 2, 3, 7, 8]


@pytest.mark.parametrize("rotation_terms", [False, True])
def test_crossings_of_a_rotating_arm(
    unit_arm: Callable[[float], Mechanism], *, rotation_terms: bool
) -> None:
    engine = ReferenceEngine(unit_arm(SLENDERNESS), 32)
    result = campbell(
        engine,
        np.linspace(0.0, FASTEST, 18),
        crank_angles=np.radians(np.arange(0.0, 360.0, 60.0)),
        orders=ORDERS,
        modes=2,
        prestress="none",
        rotation_terms=rotation_terms,
    )
    table = result.critical_speeds().query("nearest_relative_gap == 0")
    for branch, root in enumerate(CLAMPED, start=1):
        for order in ORDERS:
            wanted = root**2 / (np.sqrt(order**2 + 1) if rotation_terms else order)
            row = table[(table["order"] == order) & (table["branch"] == branch)]
            if wanted > FASTEST:
                assert row.empty
                continue
            assert len(row) == 1
            np.testing.assert_allclose(row["from_rad_s"], wanted, rtol=1e-6)
            np.testing.assert_allclose(row["to_rad_s"], wanted, rtol=1e-6)
