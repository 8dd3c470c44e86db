"""Commands that map natural frequencies and stability over the crank speed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import typer

from flexmech.analyses.options import CampbellOptions, FrequencyOptions, StabilityOptions
from flexmech.choices import ELEMENTS_A_LINK, TOLERANCE
from flexmech.cli import options
from flexmech.cli.asking import question
from flexmech.cli.deliver import Output
from flexmech.cli.stopping import Stopped, answered_signals


def _with_pictures(model: Path, keywords: dict[str, Any], output: Output) -> dict[str, Any]:
    """Ask for what pictures of the frequencies show besides."""
    drawn = bool(output.pictures.formats)
    details = drawn and output.pictures.details
    split = "fastest" if details and keywords["prestress"] != "none" else False
    keywords |= {"speed_effect": split, "smooth": drawn}
    return {}


def _exit_as_interrupted(found: Any) -> None:
    """Exit as the signal asks that ended a map early."""
    if found.is_interrupted:
        raise typer.Exit(Stopped(*answered_signals()[-1:]).exit_code)


frequencies = question(
    "frequencies",
    "frequencies.moving_frequencies",
    FrequencyOptions,
    prepare=_with_pictures,
    engine="both",
    rotation_terms=options.ALL,
    tolerance=TOLERANCE,
    mass="distributed",
)
campbell = question(
    "campbell",
    "campbell.campbell",
    CampbellOptions,
    engine="reference",
    rotation_terms=options.ALL,
    tolerance=TOLERANCE,
)
stability = question(
    "stability",
    "stability.stability",
    StabilityOptions,
    finish=_exit_as_interrupted,
    engine="reference",
    steps=options.AUTO,
    elements=ELEMENTS_A_LINK,
)
