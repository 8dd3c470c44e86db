"""Flutter at rest under a force that follows: Beck's column, in what users read first."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import newton

import flexmech
from flexmech import (
    BeamSection,
    ExudynEngine,
    Load,
    Material,
    Mechanism,
    ReferenceEngine,
    RotatingArm,
)
from flexmech.linkages import AttachmentPoint

LENGTH = 0.3
SECTION = BeamSection.rectangle(Material(70e9, 2700.0), 3e-3, 25e-3)
UNIT = SECTION.bending_stiffness / LENGTH**2


def column(part: float) -> Mechanism:
    """Cantilever under a force of so many EI / L^2 along its end's tangent."""
    tip = AttachmentPoint("arm", LENGTH)
    load = Load("follows", tip, ((-part * UNIT, 0.0),), axes="link")
    return Mechanism(RotatingArm(LENGTH), {"arm": SECTION}, loads=(load,))


def becks_eigenvalue(part: float) -> complex:
    """The lowest one that grows, in 1/s, by Beck's determinant (1952)."""

    def determinant(w: complex) -> complex:
        root = np.sqrt(part**2 / 4 + w**2)
        a, b = np.sqrt(root + part / 2), np.sqrt(root - part / 2)
        waves = part * w * np.sin(a) * np.sinh(b) + 2 * w**2 * np.cos(a) * np.cosh(b)
        return complex(part**2 + 2 * w**2 + waves)

    frequency = complex(newton(determinant, 12 - 5j, tol=1e-14))
    scale = np.sqrt(SECTION.bending_stiffness / SECTION.mass_per_length) / LENGTH**2
    return 1j * frequency * scale


@pytest.mark.parametrize("part", [21.0, 25.0, 40.0])
def test_becks_column_grows_with_the_rate_of_its_closed_form_in_both_engines(part: float) -> None:
    expected, mechanism = becks_eigenvalue(part), column(part)
    assert expected.real > 0
    engines = [ReferenceEngine(mechanism, 16, "euler"), ExudynEngine(mechanism, 16, "ancf")]
    found = flexmech.moving_frequencies(engines, [0.0], [0.0], modes=2, prestress="axial")
    data = found.dataset.isel(crank_speed=0, crank_angle=0)
    size = abs(expected)
    assert data["frequency"].values == pytest.approx(size / (2 * np.pi), rel=2e-5)
    # The mode that grows stands before the one that decays.
    ratio = np.array([-expected.real, expected.real]) / size
    assert data["damping_ratio"].values == pytest.approx(np.stack([ratio, ratio]), rel=1e-3)
    assert data["flutter_growth_rate"].values == pytest.approx(expected.real, rel=1e-3)
    first, *_ = found.summary().answer
    assert first.startswith("At rest the linkage flutters at crank angle 0 deg")
    assert f"{expected.real:.3g} 1/s" in first
    told = {(one.name, one.of): one.value for one in found.summary().numbers}
    assert told["lowest_damping_ratio", "mode 1 at 0 rad/s"] == pytest.approx(
        100 * ratio[0], rel=1e-3
    )


def test_a_column_below_becks_load_is_said_to_be_none_that_flutters() -> None:
    engine = ReferenceEngine(column(20.0), 12, "euler")
    found = flexmech.moving_frequencies(engine, [0.0], [0.0], modes=2)
    assert found.dataset["flutter_growth_rate"].values == 0
    assert found.summary().answer[0].startswith("At rest f1")


@pytest.mark.parametrize("terms", [True, False])
def test_flutter_is_named_at_rest_and_at_speed(terms: bool) -> None:
    """At 1 rad/s the arm turns with the forces: its frozen modes are those of the running arm."""
    engine = ReferenceEngine(column(25.0), 8, "euler")
    found = flexmech.moving_frequencies(
        engine, np.radians([0.0, 90.0]), [1.0], modes=1, prestress="axial", rotation_terms=terms
    )
    rate = found.dataset["flutter_growth_rate"].values
    assert rate == pytest.approx(becks_eigenvalue(25.0).real, rel=1e-3)
    assert found.summary().answer[0].startswith("At 1 rad/s the frozen linkage flutters")


@pytest.mark.parametrize("part", [12.0, 19.0])
def test_a_column_is_not_said_to_buckle_below_the_load_of_its_flutter(part: float) -> None:
    """The symmetric part of its stiffness is no measure: Beck's column never buckles."""
    engine = ReferenceEngine(column(part), 8, "euler")
    still, moving = flexmech.natural_frequencies(engine, 0.0, [0.0, 0.1], modes=2)
    assert moving == pytest.approx(still, rel=1e-5)


def test_check_and_campbell_say_first_that_the_linkage_flutters() -> None:
    engine = ReferenceEngine(column(25.0), 8, "euler")
    said: list[Any] = [
        flexmech.check_mechanism(engine),
        flexmech.campbell(
            engine, [0.0, 1.0], modes=2, orders=[3], crank_angles=[0.0], prestress="axial"
        ),
    ]
    for result in said:
        assert "flutters at crank angle 0 deg" in result.summary().answer[0]
        assert f"{becks_eigenvalue(25.0).real:.3g} 1/s" in result.summary().answer[0]


def test_a_fluttering_column_grows_at_every_slow_speed_and_its_band_stays_in_the_range() -> None:
    """At 1 rad/s it grows by exp(780) within a turn, which no number holds."""
    engine = ReferenceEngine(column(25.0), 8, "euler")
    found = flexmech.stability(engine, [0.5, 1.0, 2.0], prestress="axial", modes=2)
    rate = becks_eigenvalue(25.0).real
    assert found.dataset["growth_rate"].values == pytest.approx(rate, rel=1e-3)
    assert found.dataset["unstable"].values.tolist() == [["yes", "yes", "yes"]]
    [band] = found.bands().to_dict("records")
    assert (band["from_rad_s"], band["to_rad_s"], band["cut"]) == (0.5, 2.0, "from to")
    with np.errstate(over="raise", invalid="raise"):
        assert "fastest at 0.5 to 2 rad/s, where the range ends" in found.summary().answer[0]
    for figure in found.figures().values():
        figure.canvas.draw()
