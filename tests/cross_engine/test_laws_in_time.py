"""Runs by a law of motion: energy, agreement of the engines, and what rings after the stop."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from flexmech import (
    ConstantSpeed,
    Drive,
    ExudynEngine,
    LawDrive,
    ReferenceEngine,
    Response,
    ResponseRequest,
    TableDrive,
    response,
)
from flexmech.analyses.response.residual import envelope
from flexmech.arrays import FloatArray
from flexmech.choices import Prestress
from flexmech.linear_system import Engine
from flexmech.linkages import LAWS, LawName
from flexmech.time_domain import (
    DrivenLinkage,
    LinkState,
    Trajectory,
    linear_run,
    stretches_in_runs,
)
from flexmech.time_domain.equations_of_motion import stress_history
from flexmech.time_domain.integrators.position_table import PositionTable
from tests.support.strategies import arm, fourbar

FOUR_BAR = fourbar()
TIMES = np.linspace(0.0, 0.2, 101)
RISE = LawDrive("cycloid", np.radians(120), 0.15, dwell=0.05, start_angle=0.3)
DRIVES: dict[str, Drive] = {
    **{kind: LawDrive(kind, np.radians(120), 0.15, 0.05, start_angle=0.3) for kind in LAWS},
    "backwards": LawDrive("cycloid", -1.5, 0.15, 0.05),
    "forth and back": LawDrive("trapezoid", 1.0, 0.08, 0.02, moves=2, forth_and_back=True),
    "table at rest": TableDrive(tuple(TIMES), tuple(RISE.crank_angle(TIMES)), ends="rest"),
    "run-up": ConstantSpeed(20.0, 0.1),
}


def linear(drive: Drive, prestress: Prestress, step: float) -> Trajectory:
    engine = ReferenceEngine(FOUR_BAR, 4)
    linkage = DrivenLinkage(
        engine, drive, prestress, stretches=stretches_in_runs(engine, prestress)
    )
    still = np.zeros(linkage.size)
    return linear_run(linkage, still, still, TIMES, step)


@pytest.mark.parametrize(
    ("prestress", "name"),
    [
        pytest.param(
            *(prestress, name),
            marks=[] if prestress == "axial" or name == "cycloid" else [pytest.mark.thorough],
        )
        for prestress in ("none", "axial", "equilibrium")
        for name in DRIVES
    ],
)
def test_the_work_of_the_shaft_is_in_the_energies(prestress: Prestress, name: str) -> None:
    """From rest: all that moves and bends comes from the shaft, and goes back to it."""
    found = linear(DRIVES[name], prestress, 5e-5)
    assert np.ptp(found.energy.drive_work) > 0.9 * found.energy.kinetic.max()
    assert found.energy_error < 1e-5


@pytest.mark.parametrize("name", ["trapezoid", "cycloid", "table at rest", "forth and back"])
def test_the_work_of_the_shaft_is_in_the_energies_of_a_simulation(name: str) -> None:
    engine, drive = ExudynEngine(FOUR_BAR, 4), DRIVES[name]
    start = LinkState.rigid(engine.links)
    found = engine.simulate(drive, start, TIMES, 2e-5, band=600.0)
    assert np.ptp(found.energy.drive_work) > 0.9 * found.energy.kinetic.max()
    assert found.energy_error < 1e-6


def test_a_bowed_linkage_in_a_move_and_at_rest() -> None:
    """Under weight, about the equilibrium of each position: its stress follows the law."""
    heavy = fourbar(gravity=(0.0, -9.81), damping_time=1e-5)
    request = ResponseRequest(RISE, samples=400, start="equilibrium")
    run = response([ReferenceEngine(heavy, 4), ExudynEngine(heavy, 4)], request)
    agreement = run.agreement()
    assert agreement is not None
    assert float(agreement.max()) < 3e-3
    assert (run.dataset["energy_error"] < [1e-5, 1e-6]).all()
    first, second = run.dataset["modal_amplitude"].values
    np.testing.assert_allclose(first, second, atol=0.02 * second.max())


def test_halving_the_spacing_of_stresses_changes_little(monkeypatch: pytest.MonkeyPatch) -> None:
    """Along the law they are splines from one corner of the acceleration to the next."""
    drive = LawDrive("trapezoid", np.radians(120), 0.08, 0.05)
    runs = [linear(drive, "axial", 1e-4)]
    for name in ("SAMPLES_PER_TURN", "LEAST_OF_A_PIECE"):
        monkeypatch.setattr(stress_history, name, 2 * getattr(stress_history, name))
    runs.append(linear(drive, "axial", 1e-4))
    for one, finer in zip(*(run.displacement for run in runs), strict=True):
        assert np.abs(one - finer).max() < 1e-6 * np.abs(finer).max()


def test_stress_stands_still_with_the_crank() -> None:
    engine = ReferenceEngine(fourbar(gravity=(0.0, -9.81)), 4)
    stress = DrivenLinkage(engine, RISE, "axial").stress
    for own in stress.at(np.array([0.15, 0.17, 0.2])):
        np.testing.assert_array_equal(own.share_rate, 0.0)
        np.testing.assert_array_equal(own.stiffness[1:], own.stiffness[:-1])


class TestTableOfConstantSpeed:
    SPEED = 20.0
    TIME = np.linspace(0.0, 2 * np.pi / SPEED, 91)
    TABLE = TableDrive(tuple(TIME), tuple(0.2 + SPEED * TIME))

    def run(self, drive: Drive, engine: Engine) -> Response:
        request = ResponseRequest(drive, revolutions=1.0, samples=90, step=2e-4)
        return response(engine, request)

    def test_is_the_run_at_that_speed(self) -> None:
        engine = ReferenceEngine(FOUR_BAR, 4)
        drives = self.TABLE, ConstantSpeed(self.SPEED, start_angle=0.2)
        found, wanted = (self.run(drive, engine).dataset for drive in drives)
        for name in ("deflection", "driving_torque", "joint_force"):
            scale = 1e-9 * float(abs(wanted[name]).max())
            np.testing.assert_allclose(found[name], wanted[name], rtol=0, atol=scale)

    def test_is_it_as_a_spline_too(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """Where the run at constant speed solves every step too, and interpolates none."""
        monkeypatch.setattr("flexmech.linkages.drives.tabulated._STRAIGHT", 0.0)
        monkeypatch.setattr(PositionTable, "_packed", PositionTable._solved_at)
        table = TableDrive(self.TABLE.times, self.TABLE.angles)
        assert not table.is_constant
        engine, steady = ReferenceEngine(FOUR_BAR, 4), ConstantSpeed(self.SPEED, start_angle=0.2)
        runs = []
        for drive in (table, steady):
            linkage = DrivenLinkage(engine, drive, "equilibrium", stretches=True)
            still = np.zeros(linkage.size)
            runs.append(linear_run(linkage, still, still, self.TIME[:-2], 2e-4))
        found, wanted = (run.driving_torque for run in runs)
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-9 * np.abs(wanted).max())


def test_engines_agree_and_the_step_explains_the_rest() -> None:
    engines = [ReferenceEngine(FOUR_BAR, 4), ExudynEngine(FOUR_BAR, 4)]
    runs = [response(engines, ResponseRequest(RISE, step=h)) for h in (1e-4, 5e-5)]
    first, second = (float(run.agreement().max()) for run in runs)  # type: ignore[union-attr]
    assert second < 4e-3
    assert first / second == pytest.approx(4.0, rel=0.25)


BETA = np.array([1.8751040687, 4.6940911330, 7.8547574382])
# Of a clamped beam: ratio of the functions that its modes are made of.
SIGMA = (np.cosh(BETA) + np.cos(BETA)) / (np.sinh(BETA) + np.sin(BETA))


def waves_at_tip(drive: LawDrive, length: float) -> tuple[FloatArray, NDArray[np.complex128]]:
    """Angular frequencies of three modes of a clamped beam that a small rotation has shaken.

    And their complex amplitudes at its tip, by Duhamel's integral from the start of the move.
    """
    section = arm(length).sections["arm"]
    place = np.linspace(0.0, 1.0, 4001)
    argument = BETA[:, None] * place
    modes = np.cosh(argument) - np.cos(argument)
    modes -= SIGMA[:, None] * (np.sinh(argument) - np.sin(argument))
    share = np.trapezoid(place * length * modes, place) / np.trapezoid(modes**2, place)
    factor = np.sqrt(section.bending_stiffness / section.mass_per_length)
    frequency = (BETA / length) ** 2 * factor
    move = np.linspace(0.0, drive.time, 20_001)
    shaken = drive.crank_acceleration(move) * np.exp(-1j * frequency[:, None] * move)
    excited = np.trapezoid(shaken, move)
    return frequency, -(modes[:, -1] * share / frequency) * excited


@pytest.mark.parametrize("kind", LAWS)
def test_an_arm_rings_after_the_stop_as_duhamels_integral_says(kind: LawName) -> None:
    """A travel so small that the arm's rotation does not stiffen it."""
    mechanism, travel = arm(1.0), 1e-3
    frequency = BETA[0] ** 2 * np.sqrt(
        mechanism.sections["arm"].bending_stiffness / mechanism.sections["arm"].mass_per_length
    )
    drive = LawDrive(kind, travel, time=1.3 * 2 * np.pi / frequency, dwell=0.5)
    engine = ReferenceEngine(mechanism, 8, "euler")
    run = response(engine, ResponseRequest(drive, samples=2000, prestress="axial", step=1e-4))
    data = run.dataset.isel(engine=0, link=0)
    assert float(data["standing_frequency"][0]) == pytest.approx(frequency / 2 / np.pi, rel=1e-4)
    after = data.sel(time=data["time"] >= drive.time)
    angular, amplitudes = waves_at_tip(drive, 1.0)
    turning = np.exp(1j * np.multiply.outer(angular, after["time"].values))
    wanted = np.asarray(amplitudes @ turning).imag
    gap = np.abs(after["deflection"].values - wanted).max() / np.abs(wanted).max()
    assert gap < 5e-3
    width = round(2 * np.pi / frequency / (after["time"].values[1] - after["time"].values[0]))
    amplitude = envelope(wanted[:, None], width + 1)[0, 0]
    assert float(data["residual_amplitude"]) == pytest.approx(amplitude, rel=5e-3)
    found = data["modal_amplitude"].values[0]
    assert found == pytest.approx(np.abs(amplitudes[0]), rel=5e-3)
    assert "rings by" in run.summary().answer[-1]
