"""Synthesis of crank-rockers: what is asked for comes back, and nothing else is accepted."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

from flexmech.cli.app import app
from flexmech.errors import InputError
from flexmech.linkages import FourBar, rocker_swing, synthesize_crank_rocker
from flexmech.plots import plot_transmission_angle
from tests.strategies import numbers


@given(numbers(0.5, 89.5), numbers(0.01, 0.99))
def test_angles_that_are_asked_for_come_back(deviation: float, part: float) -> None:
    least = 90 - deviation
    rocker_angle = least + part * (180 - least)
    linkage = synthesize_crank_rocker(*np.radians([deviation, rocker_angle])).linkage(0.4)
    limits = np.degrees(linkage.transmission_angle_limits())
    assert limits == pytest.approx([least, 180 - least], abs=1e-6)
    assert np.degrees(linkage.motion(0.0).angle[2]) == pytest.approx(rocker_angle, abs=1e-5)
    assert linkage.grashof_class == "crank-rocker"
    # Equation 11: the limits lie evenly about a right angle.
    ratios = np.array(list(linkage.lengths.values())[1:]) / linkage.ground
    assert ratios[2] ** 2 + ratios[1] ** 2 - ratios[0] ** 2 == pytest.approx(1.0)


def test_designs_are_computed_at_once() -> None:
    deviation, rocker_angle = np.radians([20.0, 30.0])[:, None], np.radians([90.0, 100, 120])
    found = synthesize_crank_rocker(deviation, rocker_angle)
    assert found.crank.shape == (2, 3)
    one = synthesize_crank_rocker(deviation[1, 0], rocker_angle[2])
    assert found.crank[1, 2] == one.crank
    with pytest.raises(InputError, match="one design, these are 6"):
        found.linkage()


def test_the_swing_is_what_the_motion_covers() -> None:
    linkage = FourBar(1.0, 0.27, 0.83, 0.67)
    angles = linkage.motion(np.linspace(0, 2 * np.pi, 20001)).angle[:, 2]
    assert rocker_swing(linkage) == pytest.approx(np.ptp(angles), abs=1e-6)
    with pytest.raises(InputError, match="double-crank"):
        rocker_swing(FourBar(0.2, 1.0, 0.9, 0.8))


@pytest.mark.parametrize(
    ("deviation", "rocker_angle", "message"),
    [
        (0.0, 100.0, "deviation must lie between 0 and 90 deg, got 0 deg"),
        (95.0, 100.0, "deviation must lie between 0 and 90 deg, got 95"),
        (np.nan, 100.0, "deviation .* got nan"),
        (20.0, 60.0, "rocker angle must lie between 70 and 180 deg, got 60 deg"),
        (20.0, 180.0, "rocker angle must lie between 70 and 180 deg"),
    ],
)
def test_what_cannot_be(deviation: float, rocker_angle: float, message: str) -> None:
    with pytest.raises(InputError, match=message):
        synthesize_crank_rocker(*np.radians([deviation, rocker_angle]))


def test_command(tmp_path: Path) -> None:
    arguments = ["--deviation", "20", "--rocker-angle", "100", "--ground", "400 mm"]
    result = CliRunner().invoke(app, ["synthesize", *arguments, "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    assert "crank 0.1408, coupler 0.9005, rocker 0.4572 of the ground" in result.output
    assert "transmission angle 70 to 110 deg, rocker at 100 deg" in result.output
    assert 'crank = "56.3188 mm"' in result.output
    table = np.loadtxt(tmp_path / "transmission_angle.csv", delimiter=",", skiprows=1)
    assert table[[0, 180], 1] == pytest.approx([70.0, 110.0])
    assert (tmp_path / "transmission_angle.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--deviation", "20", "--rocker-angle", "60"], "rocker angle must lie between 70"),
        (
            ["--deviation", "20", "--rocker-angle", "100", "--ground", "4 kg"],
            "not that of a length",
        ),
        (["--deviation", "20"], "rocker-angle"),
    ],
)
def test_command_refuses(arguments: list[str], message: str) -> None:
    result = CliRunner().invoke(app, ["synthesize", *arguments])
    assert result.exit_code == 2
    assert message in result.stderr


@given(st.integers(1, 6))
def test_one_curve_a_linkage(count: int) -> None:
    angle = np.radians(np.arange(0.0, 361.0, 30.0))
    curves = {f"case {n}": np.full_like(angle, n) for n in range(count)}
    figure = plot_transmission_angle(angle, curves)
    assert len(figure.axes[0].lines) == count + 1
    assert figure.axes[0].get_ylabel() == "Transmission angle (deg)"
    with pytest.raises(InputError, match="curves can be drawn"):
        plot_transmission_angle(angle, {})
