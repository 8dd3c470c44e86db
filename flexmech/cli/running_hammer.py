"""``flexmech hammer --running``: the hammer test on the running linkage."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from flexmech.cli.arguments import parse_speed, speed_remark
from flexmech.cli.deliver import deliver
from flexmech.cli.pictures import Pictures
from flexmech.errors import InputError

if TYPE_CHECKING:
    from flexmech.analyses.hammer import HammerRequest
    from flexmech.choices import Prestress
    from flexmech.linear_system import Engine


def refuse_when_running(angle: bool, grid: bool, uff: bool) -> None:
    """Refuse options that ask for what a test on the running linkage is not.

    Parameters
    ----------
    angle, grid, uff : bool
        Whether they are given.

    Raises
    ------
    InputError
        Names the option and what to do.
    """
    given = {"--angle": angle, "--grid": grid, "--uff": uff}
    reasons = {
        "--angle": "the crank is not locked; impacts come at angles all around the turn",
        "--grid": "mode shapes are those of the locked linkage",
        "--uff": "harmonic responses have no place in universal files",
    }
    for option, is_given in given.items():
        if is_given:
            raise InputError(
                f"{option} does not go with --running: {reasons[option]}; leave one of them out"
            )


def deliver_running_hammer(
    speed: str,
    asked: HammerRequest,
    prestress: Prestress,
    damping_ratio: float | None,
    engine: Engine,
    out: Path,
    model: Path,
    pictures: Pictures,
) -> None:
    """Hit the running linkage, write the files and print the summary.

    Parameters
    ----------
    speed : str
        As typed.
    asked : HammerRequest
        Points, records, averages and noise.
    prestress : {"none", "axial", "equilibrium"}
    damping_ratio : float, optional
    engine : Engine
    out : Path
    model : Path
    pictures : Pictures

    Raises
    ------
    InputError
        If the speed is none; names the option.
    """
    crank_speed, unit = parse_speed(speed, "--running")

    from flexmech.analyses.running_hammer import (
        RunningHammerRequest,
        RunningHammerTest,
        running_hammer_test,
    )

    request = RunningHammerRequest(
        crank_speed,
        asked.impact,
        asked.response,
        direction=asked.direction,
        prestress=prestress,
        damping_ratio=damping_ratio,
        averages=asked.averages,
        bandwidth=asked.bandwidth,
        duration=asked.duration,
        pulse=asked.pulse,
        noise=asked.noise,
        seed=asked.seed,
        speed_unit=unit,
    )
    deliver(
        RunningHammerTest,
        lambda progress: running_hammer_test(engine, request, progress=progress),
        out,
        model=model,
        pictures=pictures,
        speed_unit=unit,
        remark=speed_remark("--running", speed, [crank_speed]),
    )
