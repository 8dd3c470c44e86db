"""The options of ``flexmech hammer`` that no other command has."""

from __future__ import annotations

from typing import Annotated

from typer import Option

from flexmech import choices

LockedAngle = Annotated[
    str,
    Option(
        "--angle",
        help="Crank angles in degrees at which the crank is locked: START:STOP:STEP, or a comma "
        "list.",
        metavar="LIST",
    ),
]
Impact = Annotated[
    str | None,
    Option(
        help="Where the hammer hits: a link, and a fraction of its length from its first joint. "
        "Left out: the middle of the coupler, or of the last link where there is none.",
        metavar="LINK:FRACTION",
    ),
]
ResponsePoint = Annotated[
    str | None,
    Option(
        "--response",
        help="Where the displacement is measured. Left out: at the same place.",
        metavar="LINK:FRACTION",
    ),
]
Direction = Annotated[
    choices.LinkDirection,
    Option(help="Of force and displacement: across the frame of the rigid link, or along it."),
]
Averages = Annotated[int, Option(min=1, help="Impacts over which spectra are averaged.")]
Bandwidth = Annotated[
    str | None,
    Option(
        help="Greatest frequency. Left out: a quarter above the fourth natural frequency.",
        metavar="HZ",
    ),
]
Duration = Annotated[
    str | None,
    Option(
        help="Of a record. Left out: until the vibration has decayed to 1e-4.", metavar="SECONDS"
    ),
]
Pulse = Annotated[
    str | None,
    Option(
        help="Duration of the half-sine pulse. Left out: one over the bandwidth.",
        metavar="SECONDS",
    ),
]
Noise = Annotated[
    str,
    Option(
        help='Root mean square of noise over that of the signal, as in 0.01 or "1%".',
        metavar="RMS_FRACTION",
    ),
]
ImpactGrid = Annotated[
    int | None,
    Option(
        "--grid",
        min=2,
        help="Rove the impact over so many points of each link: mode shapes and MAC.",
        metavar="N",
    ),
]
HammerEngine = Annotated[
    choices.EngineName,
    Option(
        help="exudyn: its nonlinear transient; reference: the exact answer of the linear equations."
    ),
]
HammerPrestress = Annotated[
    choices.Prestress | None,
    Option(
        "--prestress",
        help="none: elastic stiffness alone; axial: with the axial forces of the rigid motion; "
        "equilibrium: at the nonlinear quasi-static equilibrium. Left out: none where the crank is "
        "locked, equilibrium with --running.",
    ),
]
Running = Annotated[
    str | None,
    Option(
        help="Hit the running linkage at this crank speed: rad/s unless a unit is given, as in "
        '"300 rpm".',
        metavar="SPEED",
    ),
]
UniversalFile = Annotated[
    bool, Option("--uff", help="Write universal files too, for the programs of a laboratory.")
]
Seed = Annotated[int, Option(min=0, help="Of the noise: the same seed gives the same noise.")]
