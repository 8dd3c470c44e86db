"""Commands beside a laboratory: a virtual hammer test, and a measured record."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from typer import Option

from flexmech.analyses import typed
from flexmech.analyses.options import ComparisonOptions, HammerOptions, RunningHammerOptions
from flexmech.analyses.typed import Together
from flexmech.choices import ELEMENTS_A_LINK
from flexmech.cli import options
from flexmech.cli.asking import ask, question, speeds_or_own
from flexmech.cli.deliver import Output, mechanism_of
from flexmech.crank_values import GREATEST
from flexmech.errors import InputError, naming

_LOCKED_ALONE = ("averages", "pulse", "noise", "seed", "grid")


def hammer(
    model: options.Model,
    keywords: Annotated[dict[str, Any], Together(HammerOptions, {"elements": ELEMENTS_A_LINK})],
    output: options.AskedOutput,
    running: Annotated[typed.Speeds | None, typed.RUNNING] = None,
    uff: Annotated[bool, Option("--uff")] = False,
) -> None:
    """Hammer test of the linkage, crank locked or running.

    Force pulse and response in time, coherence, frequency-response function, and natural
    frequencies and damping ratios identified from it, beside those of the eigen model: a table,
    CSV and NetCDF files, and pictures. With --running the harmonic transfer functions of the
    running linkage, by its linear equations.

    Options
    -------
    running : SPEED
        Harmonic transfer functions of the running linkage at this crank speed: rad/s unless a
        unit is given, as in "300 rpm"; alone, at the greatest speed at which the model operates.
    uff
        Write universal files too, for the programs of a laboratory.
    """
    keywords["engine"] = keywords["engine"] or ("exudyn" if running is None else "reference")
    if running is None:
        if uff:
            from flexmech.measured_data import check_uff

            with naming("--uff"):
                check_uff()
        further = (lambda result, folder, _: result.save_uff(folder)) if uff else None
        ask("hammer.hammer_test", HammerOptions, model, keywords, output, further=further)
        return
    usual = HammerOptions()
    given = [name for name in _LOCKED_ALONE if keywords.pop(name) != getattr(usual, name)]
    given += ["angle"] * any(keywords.pop("crank_angles")) + ["uff"] * uff
    if given:
        raise InputError(
            f"--{given[0]} does not go with --running, which hits nothing: its answer is that "
            "of the linear equations at all crank angles; leave one of them out"
        )
    asked = RunningHammerOptions, model, keywords | {"speed": running}, output
    ask("running_hammer.running_hammer_test", *asked)


def _with_record(model: Path, keywords: dict[str, Any], output: Output) -> dict[str, Any]:
    """Read the record; it was taken at the greatest speed of the model if it needs one."""
    from flexmech.measured_data import read_record

    path = keywords["record"]
    taken = keywords["record"] = read_record(path)
    if keywords["speed"] is keywords["angle"] is None and taken.abscissa == "time":
        keywords["speed"] = speeds_or_own(None, mechanism_of(model), "--speed", GREATEST)
    return {"record": path}


compare = question(
    "compare",
    "comparison.compare_with_record",
    ComparisonOptions,
    prepare=_with_record,
    engine="reference",
)
