"""The options of all commands, by subject, with the library's own words as choices."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from flexmech import choices
from flexmech.cli.paths import typed_path

# The model and the files.
Model = Annotated[Path, Argument(help="Model file.", metavar="MODEL", parser=typed_path)]
Out = Annotated[Path, Option(help="Folder for the files.", metavar="DIR", parser=typed_path)]
OptionalOut = Annotated[
    Path | None,
    Option(
        help="Folder for CSV files and pictures; none if left out.",
        metavar="DIR",
        parser=typed_path,
    ),
]
Include = Annotated[
    str | None,
    Option(
        help="What goes in, a comma list: frequencies, campbell, response, kinematics, "
        "coupler-curve, section, moisture. Left out: all that the model has; the coupler curve "
        "where it names a coupler point, moisture with --relative-humidity and --time.",
        metavar="LIST",
    ),
]
NoPlots = Annotated[bool, Option("--no-plots", help="Write no pictures.")]
Formats = Annotated[
    str,
    Option("--format", help="Formats of the pictures: png, pdf, svg or several.", metavar="LIST"),
]
Width = Annotated[
    choices.PageWidth,
    Option(help="Width of the pictures on a journal's page: 88 mm or 180 mm."),
]
Animate = Annotated[
    bool, Option("--animate", help="Write an animation: GIF, and MP4 where ffmpeg exists.")
]

Store = Annotated[
    choices.Store,
    Option(
        help="What response.nc holds: needed for pictures, animation and comparisons; or all, with "
        "the places and energies of the links at every sample."
    ),
]

# Where, and at what speed.
Angles = Annotated[str, Option(help="Crank angles in degrees: START:STOP:STEP, or a comma list.")]
ShapesAt = Annotated[
    str | None,
    Option(
        help="Crank angles in degrees at which mode shapes are drawn, a picture each. Left out: "
        "the first of --angles.",
        metavar="LIST",
    ),
]
PostureAngle = Annotated[
    str | None,
    Option(
        help="Crank angle of the picture and the natural frequencies in degrees. Left out: "
        "frequencies at 0, and a picture in which the links stand apart.",
        metavar="DEG",
    ),
]
Speeds = Annotated[
    str | None,
    Option(
        help='Crank speeds: a comma list or START:STOP:STEP with one unit at the end, as in "0,50,'
        '100 rpm" or "0:300:10 rpm"; rad/s if there is none. Left out: standstill and the speeds '
        "at which the model operates; 0,10,20 rad/s if it names none.",
        metavar="LIST",
    ),
]
CampbellSpeeds = Annotated[
    str,
    Option(
        "--speeds",
        help="Crank speeds: START:STOP:STEP or a comma list with one unit at the end, as in "
        '"0:900:10 rpm"; rad/s if there is none.',
        metavar="LIST",
    ),
]
TurningSpeeds = Annotated[
    str,
    Option(
        "--speeds",
        help="Crank speeds: START:STOP:STEP or a comma list with one unit at the end, as in "
        '"50:1100:10 rpm"; rad/s if there is none. Not zero, and all of one sign.',
        metavar="LIST",
    ),
]
FurtherCampbellSpeeds = Annotated[
    str | None,
    Option(
        "--campbell-speeds",
        help="Crank speeds of the Campbell diagram, as in --speeds. Left out: from zero to twice "
        "the greatest of --speeds.",
        metavar="LIST",
    ),
]
Orders = Annotated[
    str,
    Option(
        help='Multiples of the crank\'s speed: START:STOP, or a comma list such as "1,2,4".',
        metavar="LIST",
    ),
]
Speed = Annotated[
    str,
    Option(
        help='Crank speed: rad/s unless a unit is given, as in "300 rpm". Negative turns backwards.'
    ),
]
OptionalSpeed = Annotated[
    str | None,
    Option(
        "--speed",
        help='Crank speed: rad/s unless a unit is given, as in "190 rpm". Left out: the first '
        "speed at which the model operates; 0 if it names none.",
    ),
]
Lumped = Annotated[
    str | None,
    Option(
        help="Also with lumped masses: elements of each link, whose mass is halved onto their "
        "ends, in the order of the links, as in 1,4,4; or one number for all.",
        metavar="LIST",
    ),
]
Link = Annotated[str | None, Option(help="This link alone, such as coupler.", metavar="NAME")]
OnLink = Annotated[
    str,
    Option(
        help="Link that the point is on: the coupler, or any link of any linkage.", metavar="NAME"
    ),
]
Point = Annotated[
    str | None,
    Option(
        help='Distance e from A and angle gamma from A-B, as in "33 mm,320 deg"; from the first '
        "joint of another link. Left out: the coupler point of the model file.",
        metavar="e,gamma",
    ),
]

# Engines, and what they linearize.
Engine = Annotated[choices.EngineChoice, Option(help="Which engine computes.")]
CampbellEngine = Annotated[
    choices.EngineChoice,
    Option(help="Which engine computes; exudyn takes ten times as long, both stand side by side."),
]
StabilityEngine = Annotated[
    choices.EngineChoice, Option(help="Which engine computes; both stand side by side.")
]
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
CheckMesh = Annotated[
    bool, Option("--check-mesh", help="Repeat with twice the elements and compare.")
]
Modes = Annotated[
    int | None,
    Option(
        min=1,
        max=choices.MOST_MODES,
        help=f"Number of natural frequencies. Left out: {choices.MODES}, or as many as there are.",
    ),
]
ModesOfInterest = Annotated[
    int,
    Option(
        min=1,
        max=choices.MOST_MODES,
        help="Natural frequencies of interest: set the time step and the spectra's range.",
    ),
]
MapPrestress = Annotated[
    choices.MapPrestress,
    Option(
        help="none: elastic stiffness alone; axial: with the axial forces of the rigid motion; "
        "equilibrium: at the nonlinear quasi-static equilibrium; trajectory: in the states that "
        "Exudyn's settled simulation runs through, beside the quasi-static ones."
    ),
]
Prestress = Annotated[
    choices.Prestress,
    Option(
        help="none: elastic stiffness alone; axial: with the axial forces of the rigid motion; "
        "equilibrium: at the nonlinear quasi-static equilibrium."
    ),
]
StabilityPrestress = Annotated[
    choices.StabilityPrestress,
    Option(
        help="About which motion: axial: straight links with the axial forces of the rigid "
        "motion; equilibrium: the nonlinear quasi-static equilibrium; trajectory: the periodic "
        "motion itself."
    ),
]
Frame = Annotated[
    choices.MovingFrame,
    Option(help="Frame of the coordinates; multipliers are the same in both."),
]
KeptModes = Annotated[
    int,
    Option(
        "--modes",
        min=1,
        max=choices.MOST_MODES,
        help="Natural modes whose Floquet modes are kept.",
    ),
]
StepsATurn = Annotated[
    str,
    Option(
        "--steps",
        help="Steps of the propagator a turn, a multiple of 16; auto: by the fastest mode.",
        metavar="auto|N",
    ),
]
DampingRatio = Annotated[
    str | None,
    Option(
        help='Damping ratio of the first natural frequency at rest, as in "0.1%" or 0.001, for all '
        "links in place of the model's damping. Left out: the model's.",
        metavar="Z",
    ),
]
Against = Annotated[
    tuple[str, str] | None,
    Option(
        help="Also a map over a second parameter: damping-ratio, moisture, temperature-rise, or a "
        "quantity of the model file such as links.coupler.in_plane_thickness; over a comma list or "
        'START:STOP:STEPS, as in "damping-ratio 0:2%:20" for 20 equal steps from 0 to 2 %.',
        metavar="PARAMETER RANGE",
    ),
]
PeriodicResponse = Annotated[
    bool,
    Option(
        "--response",
        help="Also the peaks of the periodic motion over the quasi-static ones: from a twentieth "
        "of the greatest speed on, at a hundred of the speeds at most; about a third of a second "
        "each, longer at low speeds.",
    ),
]
Shaft = Annotated[
    choices.ShaftChoice,
    Option(
        help="prescribed: the shaft turns at the crank speed; free: it has its own inertia and "
        "the torque that the constant speed takes, and its rotation is one more coordinate."
    ),
]
Mass = Annotated[
    choices.MassChoice,
    Option(
        help="distributed: along the links; lumped: in points as Kumar & Chandrakar have it, "
        "twelve of a four-bar. Of the reference engine; Exudyn keeps distributed mass."
    ),
]
RunPrestress = Annotated[
    choices.Prestress,
    Option(
        help="Of the reference engine's equations and of the frequencies drawn into the "
        "spectrogram: as in frequencies; at equilibrium the running links stretch by the square "
        "of their slopes."
    ),
]
RotationTerms = Annotated[
    bool,
    Option(
        "--rotation-terms/--no-rotation-terms",
        help="Coriolis, centripetal and tangential terms of the link frames, or none of them.",
    ),
]

# A run in time.
Revolutions = Annotated[
    str, Option(help="Turns at that speed; may be a fraction.", metavar="NUMBER")
]
Start = Annotated[
    choices.Start,
    Option(
        help="rigid: undeformed links at the rigid motion's velocities; equilibrium: links bent "
        "quasi-statically by the loads; periodic: on the periodic motion of the linear equations."
    ),
]
RunUp = Annotated[
    str,
    Option(
        help="Duration of a smooth (cycloidal) run-up to the speed, before the turns: s unless a "
        "unit is given.",
        metavar="SECONDS",
    ),
]
Step = Annotated[
    str,
    Option(
        help='Time step: s unless a unit is given, as in "0.1 ms"; auto: halved until '
        "deflections hold still.",
        metavar="auto|SECONDS",
    ),
]
Samples = Annotated[int, Option(min=8, help="Samples saved of each turn.")]
Integrator = Annotated[
    choices.Integrator,
    Option(help="Time integration in Exudyn; the reference engine has its own."),
]

# Heat and moisture.
TemperatureRise = Annotated[
    str | None,
    Option(
        help="Temperature over the model's reference temperature: degrees Celsius unless a unit "
        "is given.",
        metavar="C",
    ),
]
Temperature = Annotated[
    str | None,
    Option(
        help="Temperature of air and links: degrees Celsius unless a unit is given. Left out: the "
        "model's reference temperature.",
        metavar="C",
    ),
]
Moisture = Annotated[
    str | None,
    Option(
        help="Moisture of every resin: mass of water over its dry mass, in percent.",
        metavar="PERCENT",
    ),
]
RelativeHumidity = Annotated[
    str | None,
    Option(
        help="Instead of --moisture: humidity of the surrounding air in percent, with --time.",
        metavar="PERCENT",
    ),
]
RequiredHumidity = Annotated[str, Option(help="Humidity of the air in percent.", metavar="PERCENT")]
_TIME = Option(
    *("--time", "--exposure-time"),
    help='Time of exposure since the links were dry, such as "30 day".',
    metavar="T",
)
ExposureTime = Annotated[str | None, _TIME]
RequiredExposureTime = Annotated[str, _TIME]

# The proportions of a crank-rocker.
Deviation = Annotated[
    float, Option(help="Greatest deviation of the transmission angle from 90 deg, in deg.")
]
RockerAngle = Annotated[float, Option(help="Angle of the rocker at crank angle zero, in deg.")]
Ground = Annotated[
    str | None,
    Option(
        help='Distance of the ground pivots, such as "400 mm": prints a table for a model file.',
        metavar="LENGTH",
    ),
]

# The verification.
Thorough = Annotated[bool, Option("--thorough", help="With the cases that take longer.")]
