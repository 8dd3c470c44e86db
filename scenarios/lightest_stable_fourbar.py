"""How thin may the aluminium four-bar's links be, with no unstable band below 1.3 times its speed?

The aluminium four-bar runs at 60 rad/s with a damping ratio of 0.1 %. Coupler and rocker are cut
from one sheet; the thinner it is, the lower the speeds at which vibrations grow. Of every sheet the
first unstable band above the crank speed is sought by the Floquet multipliers; the lightest linkage
is that of the thinnest sheet whose band begins at 1.3 times the speed or above. Both engines
confirm it with twice the elements.

    python scenarios/lightest_stable_fourbar.py [--out results/lightest_stable_fourbar]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from _common import MODELS, output_folder, save_pictures

from flexmech.studies import DesignSweep, Optimum, load_study, optimum_study, sweep_study

SHEETS = (1.9, 2.0, 2.1)
"""Thicknesses in mm."""
STUDY = """
model = "{model}"

[vary.sheet]
paths = ["links.coupler.in_plane_thickness", "links.rocker.in_plane_thickness"]
values = {sheets}

[vary.damping-ratio]
values = ["0.1 %"]

[outputs]
margin = {{ quantity = "stable_speed_margin", speed = "60 rad/s" }}
mass = {{ quantity = "mass" }}

[[limits]]
output = "margin"
above = 0.3

[[goals]]
output = "mass"
"""


def main(out: Path, *, sheets: Sequence[float] = SHEETS) -> tuple[DesignSweep, Optimum]:
    """Find the thinnest sheet that is stable far enough, print and draw it among the others.

    Parameters
    ----------
    out : Path
        Folder for the study, its results and the pictures.
    sheets : sequence of float
        Thicknesses in mm.

    Returns
    -------
    tuple of (DesignSweep, Optimum)
        All sheets, and the lightest that keeps the limit.
    """
    out.mkdir(parents=True, exist_ok=True)
    file = out / "sheets.toml"
    listed = [f"{sheet:g} mm" for sheet in sheets]
    file.write_text(
        STUDY.format(model=(MODELS / "aluminium_fourbar.toml").resolve().as_posix(), sheets=listed)
    )
    study = load_study(file)
    best = optimum_study(study)
    every = sweep_study(study)
    print(every.summary())
    print(best.summary())
    save_pictures({"sheets": every.plot()}, out)
    return every, best


if __name__ == "__main__":
    main(output_folder(__doc__, "results/lightest_stable_fourbar"))
