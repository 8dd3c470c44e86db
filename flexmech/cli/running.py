"""From the options of a run in time to its request."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from flexmech.cli import arguments
from flexmech.cli.failures import naming
from flexmech.errors import InputError

if TYPE_CHECKING:
    from flexmech.analyses import ResponseRequest
    from flexmech.choices import Integrator, Prestress, Start


def parse_request(
    speed: str,
    revolutions: str,
    run_up: str,
    step: str,
    *,
    samples: int,
    start: Start,
    modes: int,
    integrator: Integrator,
    prestress: Prestress = "equilibrium",
) -> ResponseRequest:
    """Make the request of ``response`` and ``export`` from what was typed.

    Parameters
    ----------
    speed, revolutions, run_up, step : str
    samples : int
    start, integrator, prestress : str
    modes : int

    Returns
    -------
    ResponseRequest

    Raises
    ------
    InputError
        If a value is impossible; names the option.
    """
    crank_speed, unit = arguments.parse_speed(speed)
    turns = arguments.parse_revolutions(revolutions)
    run_up_time, time_step = arguments.parse_run_up(run_up), arguments.parse_step(step)
    if start == "periodic" and run_up_time:
        raise InputError(
            "--start periodic needs a constant crank speed; leave --run-up out, or choose "
            "--start rigid or equilibrium"
        )

    from flexmech.analyses import ResponseRequest
    from flexmech.linkages import CrankDrive

    with naming("--revolutions, --samples, --run-up"):
        request = ResponseRequest(
            CrankDrive(crank_speed, run_up_time),
            turns,
            samples,
            start,
            modes=modes,
            integrator=integrator,
            prestress=prestress,
            speed_unit=unit,
        )
    with naming("--step"):
        return replace(request, step=time_step)
