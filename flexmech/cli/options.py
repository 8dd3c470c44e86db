"""The options that several commands share, with the library's own words as choices."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from typer import Argument, Option

from flexmech import choices
from flexmech.analyses import typed
from flexmech.analyses.typed import Together
from flexmech.cli.deliver import Output, Pictures, Printing, typed_path
from flexmech.errors import InputError

# Defaults as users type them.
EVERY_5_DEGREES: Any = "0:360:5"
EVERY_DEGREE: Any = "0:360:1"
AUTO: Any = "auto"
ALL: Any = "all"
ZERO: Any = "0"
PNG: Any = "png"

Model = Annotated[Path, Argument(help="Model file.", metavar="MODEL", parser=typed_path)]
Out = Annotated[Path, Option(help="Folder for the files.", metavar="DIR", parser=typed_path)]
TypedPath = Annotated[Path, Option(parser=typed_path)]
OptionalPath = Annotated[Path | None, Option(parser=typed_path)]
GivenPath = Annotated[Path, Argument(parser=typed_path)]
Link = Annotated[str | None, Option(help="This link alone, such as coupler.", metavar="NAME")]

# Where, and at what speed.
Angles = Annotated[
    typed.FloatArray,
    Option(
        help="Crank angles in degrees: START:STOP:STEP, a comma list, or both, as in "
        '"10:170:10,190:350:10".'
    ),
    typed.ANGLES,
]
Speeds = Annotated[
    typed.Speeds | None,
    Option(
        help='Crank speeds: a comma list or START:STOP:STEP with one unit at the end, as in "0,50,'
        '100 rpm" or "0:300:10 rpm"; rad/s if there is none. Left out: standstill and the speeds '
        "at which the model operates; 0,10,20 rad/s if it names none.",
        metavar="LIST",
    ),
    typed.SPEEDS,
]
MomentPoint = Annotated[
    tuple[float, float] | None,
    Option(
        help="Point about which the shaking moment is taken, in ground axes, as in '127 mm,0 mm'. "
        "Left out: the axis of the shaft.",
        metavar="X,Y",
    ),
    typed.MOMENT_POINT,
]
DampingRatio = Annotated[
    float | None,
    Option(
        help='Damping ratio of the first natural frequency at rest, as in "0.1%" or 0.001, for all '
        "links in place of the model's damping. Left out: the model's.",
        metavar="Z",
    ),
    typed.DAMPING_RATIO,
]

# Engines, and what they linearize.
Engine = Annotated[choices.EngineChoice, Option(help="Which engine computes.")]
Element = Annotated[
    choices.ElementName | None,
    Option(
        help="Beam element: euler, timoshenko, reddy or zigzag in the reference, ancf or "
        "geometrically-exact in Exudyn; the other engine takes its element of the nearest theory. "
        "Left out: euler and ancf; where shear changes a frequency by more than 1 % or a link's "
        "neutral axis is off its pins, geometrically-exact and timoshenko, or zigzag where the "
        "warping of cross-sections does, as in sandwiches."
    ),
]
Elements = Annotated[int, Option(min=1, max=choices.MOST_ELEMENTS, help="Elements on each link.")]
PinnedElements = Annotated[
    int | None,
    Option(
        min=1,
        max=choices.MOST_ELEMENTS,
        help="Elements on each link, whatever the tolerance. Left out: 8, doubled by each engine "
        "until its frequencies are within the tolerance, up to 32.",
    ),
]
Tolerance = Annotated[
    float,
    Option(
        help="Estimated relative error by the mesh that is allowed, where --elements is left out."
    ),
]
_MODES = f"Number of natural frequencies. Left out: {choices.MODES}, or as many as there are."
Modes = Annotated[int | None, Option(min=1, max=choices.MOST_MODES, help=_MODES)]
KeptModes = Annotated[int, Option(min=1, max=choices.MOST_MODES)]
RotationTerms = Annotated[
    typed.RotationTerms,
    Option(
        help="Terms of the turning link frames that are counted: all, none (the same as "
        "--no-rotation-terms), or a comma list of coriolis, centripetal, tangential.",
        metavar="LIST",
    ),
    typed.ROTATION_TERMS,
]
Shaft = Annotated[
    choices.ShaftChoice,
    Option(
        help="prescribed: the shaft turns at the crank speed; free: it has its own inertia and "
        "the torque that the constant speed takes, and its rotation is one more coordinate."
    ),
]

ExposureTime = Annotated[float, typed.EXPOSURE_TIME]


def asked_pictures(
    no_plots: Annotated[bool, Option("--no-plots")] = False,
    formats: Annotated[tuple[choices.PictureFormat, ...], typed.FORMATS] = PNG,
    width: choices.PageWidth = "two-column",
) -> Pictures:
    """Formats and width of the pictures.

    Options
    -------
    no_plots
        Write no pictures.
    formats : LIST
        Formats of the pictures: png, pdf, svg or several.
    width
        Width of the pictures on a journal's page: 88 mm or 180 mm.
    """
    return Pictures(() if no_plots else formats, width)


def asked_printing(
    details: Annotated[bool, Option("--details")] = False,
    quiet: Annotated[bool, Option("--quiet")] = False,
    as_json: Annotated[bool, Option("--json")] = False,
) -> Printing:
    """How the summary is printed.

    Options
    -------
    details
        Print all that is known, as summary.txt beside the files has it.
    quiet
        Print warnings and errors alone.
    as_json
        Print answer, numbers, units and errors as JSON, for programs.
    """
    asked: dict[Printing, bool] = {"details": details, "nothing": quiet, "json": as_json}
    chosen = [printing for printing, wanted in asked.items() if wanted]
    if len(chosen) > 1:
        raise InputError("--details, --quiet and --json: give one of them")
    return chosen[0] if chosen else "answer"


AskedPictures = Annotated[Pictures, Together(asked_pictures)]
AskedPrinting = Annotated[Printing, Together(asked_printing)]


def asked_output(
    *, out: Out = Path("results"), pictures: AskedPictures, printing: AskedPrinting
) -> Output:
    """Files, pictures and what is printed."""
    return Output(out, pictures, printing)


def asked_optional_output(
    *, out: OptionalPath = None, pictures: AskedPictures, printing: AskedPrinting
) -> Output:
    """Files and pictures if a folder is named, and what is printed.

    Options
    -------
    out : DIR
        Folder for CSV files and pictures; none if left out.
    """
    return Output(out, pictures, printing)


AskedOutput = Annotated[Output, Together(asked_output)]
AskedOptionalOutput = Annotated[Output, Together(asked_optional_output)]
AskedEnvironment = Annotated[typed.Environment | None, typed.ENVIRONMENT]
