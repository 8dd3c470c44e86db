"""``flexmech coupler-curve``: the path of a coupler point, dry and in heat and moisture."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flexmech.cli.arguments import Angles, Model, NoPlots, Out, parse_angles
from flexmech.cli.coupler_curve_files import PICTURES, TABLES, write
from flexmech.cli.failures import reports_failures
from flexmech.cli.surroundings import (
    ExposureTime,
    Moisture,
    RelativeHumidity,
    TemperatureRise,
    parse_state,
)
from flexmech.errors import InputError
from flexmech.files import check_writable
from flexmech.units import ANGLE, LENGTH, parse_quantity

if TYPE_CHECKING:
    from flexmech.hygrothermal import State
    from flexmech.linkages import CouplerPoint
    from flexmech.mechanism import Mechanism

__all__ = ["HELP", "coupler_curve"]

HELP = (
    "Path of a point of the coupler. Its crossings and cusps, dry and in heat and moisture: "
    "tables and pictures."
)

Point = Annotated[
    str | None,
    typer.Option(
        help="Coupler point: its distance e from A and the angle gamma from A-B to it, as in "
        '"33 mm,320 deg" (m and deg unless units are given). Left out: the model file\'s.',
        metavar="e,gamma",
    ),
]


@reports_failures
def coupler_curve(
    model: Model,
    temperature_rise: TemperatureRise = None,
    moisture: Moisture = None,
    relative_humidity: RelativeHumidity = None,
    time: ExposureTime = None,
    point: Point = None,
    angles: Angles = "0:360:1",
    out: Out = Path("results"),
    no_plots: NoPlots = False,
) -> None:
    """Compute, save, draw and report the path of a coupler point."""
    crank_angles = parse_angles(angles)
    state = parse_state(temperature_rise, moisture, relative_humidity, time)
    given = None if point is None else parse_point(point)

    import numpy as np

    from flexmech.cli.coupler_curve_report import lines
    from flexmech.cli.pictures import file_lines
    from flexmech.hygrothermal import HygrothermalState, coupler_path
    from flexmech.modelfile import load_mechanism

    mechanism = load_mechanism(model)
    moving = _point_of(mechanism, given)
    check_writable(out, (*TABLES, *PICTURES))
    states: dict[str, State] = {"dry": HygrothermalState()}
    if state is not None:
        states["wet"] = state
    radians = np.radians(crank_angles)
    paths = {"dry": coupler_path(mechanism, moving, states["dry"], radians)}
    if state is not None:
        # The dry linkage has passed: what is wrong now is the state's doing.
        with _says_where(state.label):
            paths["wet"] = coupler_path(mechanism, moving, state, radians)
    files = write(paths, states, mechanism.provenance.name, out, draw=not no_plots)
    for line in (
        *lines(mechanism, paths, state),
        *file_lines(out, files, PICTURES),
    ):
        typer.echo(line)


def parse_point(text: str) -> CouplerPoint:
    """Coupler point of ``--point``.

    Parameters
    ----------
    text : str
        ``"e,gamma"``; m and degrees unless units are given.

    Returns
    -------
    CouplerPoint

    Raises
    ------
    InputError
        If it is not a length and an angle.
    """
    from flexmech.linkages import CouplerPoint

    parts = text.split(",")
    if len(parts) != 2:
        raise InputError(
            f"--point: got {text!r}, which has {len(parts)} parts; write distance and angle, for "
            'example "33 mm,320 deg"'
        )
    try:
        distance = parse_quantity(parts[0].strip(), LENGTH, default_unit="m")
        return CouplerPoint(distance, parse_quantity(parts[1].strip(), ANGLE, default_unit="deg"))
    except InputError as error:
        raise InputError(f"--point: {error}") from error


@contextmanager
def _says_where(state: str) -> Iterator[None]:
    """Name the state in which the linkage is refused."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{state}: {error}") from error


def _point_of(mechanism: Mechanism, given: CouplerPoint | None) -> CouplerPoint:
    found = mechanism.coupler_point if given is None else given
    if found is None:
        raise InputError(
            f"{mechanism.provenance.file}: linkage.coupler_point: is missing; add coupler_point = "
            '{ distance = "33 mm", angle = "320 deg" }, or give --point "33 mm,320 deg"'
        )
    return found
