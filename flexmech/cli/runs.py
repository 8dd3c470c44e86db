"""Commands on the running linkage in time: its response, and a script for Exudyn that runs it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from typer import Option

from flexmech import analyses, choices, plots
from flexmech.analyses.options import ResponseOptions, RunOptions
from flexmech.analyses.typed import Together
from flexmech.cli import options
from flexmech.cli.asking import ask, given_speeds, naming_options
from flexmech.cli.deliver import mechanism_of, progress_bar, say
from flexmech.cli.failures import telling
from flexmech.crank_values import Speeds
from flexmech.errors import naming, one_line
from flexmech.files import check_writable, given_path

NO_TURNS = (
    "remark: --revolutions counts for nothing under a law that ends: the run lasts until the end "
    "of its last dwell; leave it out"
)
NO_MP4 = "animation: a GIF alone, for MP4 needs ffmpeg; install it and run again"
_RUN = {"revolutions": None, "step": options.AUTO, "elements": choices.ELEMENTS_A_LINK}


def response(
    model: options.Model,
    keywords: Annotated[dict[str, Any], Together(ResponseOptions, _RUN | {"engine": "both"})],
    output: options.AskedOutput,
    animate: Annotated[bool, Option("--animate")] = False,
    store: choices.Store = "needed",
) -> None:
    """Response of the running mechanism over time.

    Deflections, strains, driving torque and joint forces at constant crank speed, or by the law or
    the motor of [drive]: a table, files, pictures and an animation; dry, or in heat and moisture.
    With --shaper: residual vibration by a shaped law beside the plain one.

    Options
    -------
    animate
        Write an animation: GIF, and MP4 where ffmpeg exists.
    store
        Content of response.nc; needed: for pictures, animation and comparisons; or all, with the
        places and energies of the links at every sample.
    """
    remarks = [NO_MP4] if animate and not plots.mp4_available() else []
    ask(
        "response.response",
        ResponseOptions,
        model,
        keywords,
        output,
        further=analyses.Response.save_animations if animate else None,
        remark="\n".join([*_no_turns(model, keywords), *remarks]),
        saving={"store": store},
    )


def _no_turns(model: Path, keywords: dict[str, Any]) -> list[str]:
    """The remark on turns that were typed for a law that ends."""
    if keywords["revolutions"] is None or keywords["speed"] is not None:
        return []
    law = mechanism_of(model).drive
    return [] if law is None or getattr(law, "turns_on", True) else [NO_TURNS]


def export(
    model: options.Model,
    keywords: Annotated[dict[str, Any], Together(RunOptions, _RUN)],
    out: options.TypedPath = Path("results"),
    *,
    printing: options.AskedPrinting,
) -> None:
    """The running mechanism as a script for Exudyn.

    Writes linkage.py, which needs exudyn and numpy alone and makes, solves and shows the system
    that response --engine exudyn runs.

    Options
    -------
    out : DIR
        Folder for linkage.py.
    """
    from flexmech.analyses.response.compute import exudyn_system
    from flexmech.multibody import SCRIPT

    mechanism = mechanism_of(model)
    given, speeds = given_speeds(RunOptions, keywords, mechanism)
    speeds = speeds or Speeds(())
    with naming("--out"):
        out = given_path(out)
        check_writable(out, [SCRIPT])
    with progress_bar() as progress, telling(model, speeds.unit), naming_options(RunOptions):
        system = exudyn_system(mechanism, **given, progress=progress)
    with naming("--out"):
        [file] = system.save(out)
    counts = (
        f"{len(system.nodes)} nodes, {len(system.objects)} elements, bodies and joints, "
        f"{len(system.sensors)} sensors; {system.steps} steps of {system.step:.4g} s"
    )
    named = one_line(str(file), most=len(str(file)))
    summary = analyses.Summary((counts,), trust=f"next: python {named}", warnings=system.remarks)
    remarks = [speeds.remark, *_no_turns(model, keywords)]
    say(summary, [file], [f"files: {named}"], remarks, printing)
