"""From the options of ``compare`` to its request."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from typer import Argument, Option

from flexmech import units
from flexmech.choices import EngineName
from flexmech.cli import arguments
from flexmech.cli.failures import naming
from flexmech.cli.paths import typed_path
from flexmech.errors import InputError

if TYPE_CHECKING:
    from flexmech.analyses import ComparisonRequest

Record = Annotated[
    Path,
    Argument(
        help="Measured record: CSV with units in its header, as 'time [s], strain (um/m)', or a "
        "universal file (.uff, .unv).",
        metavar="RECORD",
        parser=typed_path,
    ),
]
RecordSpeed = Annotated[
    str | None,
    Option(
        "--speed",
        help="Crank speed at which the record was taken: rad/s unless a unit is given; 0 for "
        "natural frequencies at rest.",
        metavar="W",
    ),
]
RecordAngle = Annotated[
    str | None,
    Option(
        "--angle",
        help="Crank angle in degrees at which the crank was locked, for a frequency-response "
        "function.",
        metavar="DEG",
    ),
]
Quantity = Annotated[
    str | None,
    Option(
        help="What is computed: a column of response.csv, such as coupler_mid_strain; for a "
        "frequency-response function the points of impact and response, as coupler:0.5,rocker:0.5, "
        "behind NAME@ where a file holds several. Left out: what the record's column names, else "
        "the middle of the coupler.",
        metavar="COLUMN",
    ),
]
Fit = Annotated[
    str | None,
    Option(
        help="What is fitted, a comma list: damping, damping:LINK, stiffness:LINK, offset, gain; "
        "or none. Left out: damping, of a frequency-response function gain too, and nothing for "
        "natural frequencies.",
        metavar="LIST",
    ),
]
OneEngine = Annotated[EngineName, Option(help="Which engine computes.")]


# How the library names arguments that are options here.
ARGUMENTS = ("fit: ", "quantity: ")


@contextmanager
def naming_options() -> Iterator[None]:
    """Name an argument of the comparison as the option that it is."""
    try:
        yield
    except InputError as error:
        if error.message.startswith(ARGUMENTS):
            raise InputError(f"--{error.message}") from error
        raise


def parse_comparison(
    speed: str | None, angle: str | None, quantity: str | None, fit: str | None
) -> ComparisonRequest:
    """Make the request of ``compare`` from what was typed.

    Parameters
    ----------
    speed, angle, quantity, fit : str, optional

    Returns
    -------
    ComparisonRequest

    Raises
    ------
    InputError
        If a value is impossible; names the option.
    """
    if (speed is None) == (angle is None):
        raise InputError(
            "--speed, --angle: give one of them: the crank speed at which the record was taken, or "
            "the angle at which the crank was locked"
        )
    unit, crank_speed, crank_angle = "rad/s", None, None
    if speed is not None:
        crank_speed = arguments.parse_option("--speed", speed, units.ANGULAR_SPEED, "rad/s")
        unit = units.parse_quantities(speed, units.ANGULAR_SPEED, "rad/s").unit
    if angle is not None:
        degrees = arguments.parse_option("--angle", angle, arguments.CRANK_ANGLE, "deg")
        if abs(degrees) > 360:
            raise InputError(f"--angle: got {angle!r}; give an angle from 0 to 360 deg")
        crank_angle = math.radians(degrees)
    names = None if fit is None else tuple(name.strip() for name in fit.split(","))

    from flexmech.analyses import ComparisonRequest

    with naming("--fit"):
        return ComparisonRequest(crank_speed, crank_angle, quantity, names, unit)
