"""How far do the links of four-bars bend as they run, and is linear theory good enough?

The steel and the aluminium four-bar of Kumar & Chandrakar and one of carbon and epoxy, dry and in
equilibrium with 85 % humidity at 80 degC, at 10 and 20 rad/s. They start undeformed with the rigid
motion's velocities, without damping: Exudyn's nonlinear simulation and the linear equations about
the quasi-static equilibrium, with the same mesh. Water softens the composite's links and makes them
heavier: both bend them more.

    python scenarios/running_fourbars.py [--out results/running_fourbars]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from _common import FOUR_BARS, four_bar, output_folder, save_pictures
from _moist_linkage import EVENLY_WET
from matplotlib.figure import Figure

from flexmech import (
    ConstantSpeed,
    ExudynEngine,
    Mechanism,
    ReferenceEngine,
    Response,
    ResponseRequest,
    mechanism_in_state,
    plots,
    response,
)

SPEEDS = (10.0, 20.0)
WET = "wet_composite"
TITLES = FOUR_BARS | {WET: f"Wet composite four-bar ({EVENLY_WET.label})"}
# Links whose deflections are drawn, in mm, at the points that `flexmech response` watches.
DRAWN = {"coupler": "Coupler's middle", "rocker": "Rocker's middle"}


@dataclass(frozen=True)
class RunningAnswer:
    """One four-bar at one crank speed.

    Parameters
    ----------
    response : Response
        Both engines.
    """

    response: Response

    @property
    def peak(self) -> float:
        """Greatest deflection of the coupler's middle in Exudyn's run, m."""
        return float(self.response.peaks()["deflection"].sel(engine="exudyn", link="coupler"))

    @property
    def gap(self) -> float:
        """Greatest difference of the linear coupler deflection from it, over the peak."""
        agreement = self.response.agreement()
        assert agreement is not None
        return float(agreement.sel(link="coupler"))

    @property
    def peak_angle(self) -> float:
        """Crank angle in deg, within a turn, at which the coupler bends most in Exudyn's run."""
        run = self.response.dataset.sel(engine="exudyn")
        place = int(np.abs(run["deflection"].sel(link="coupler").values).argmax())
        return float(np.degrees(run["crank_angle"].values[place]) % 360)


def running(name: str) -> Mechanism:
    """Load one of the four-bars of ``TITLES``."""
    if name == WET:
        return mechanism_in_state(four_bar("moist_composite"), EVENLY_WET)
    return four_bar(name)


def main(
    out: Path,
    *,
    names: tuple[str, ...] = tuple(TITLES),
    speeds: tuple[float, ...] = SPEEDS,
    revolutions: float = 2.0,
    elements: int = 8,
    samples: int = 720,
) -> dict[tuple[str, float], RunningAnswer]:
    """Run the four-bars, print peaks and checks, draw them.

    Parameters
    ----------
    out : Path
        Folder for the pictures.
    names : tuple of str
        Which of ``TITLES``.
    speeds : tuple of float
        Crank speeds in rad/s.
    revolutions : float
    elements : int
        Elements a link.
    samples : int
        Samples a turn.

    Returns
    -------
    dict of tuple to RunningAnswer
        By mechanism and crank speed.
    """
    answers, figures = {}, {}
    for name in names:
        mechanism = running(name)
        for speed in speeds:
            engines = [ReferenceEngine(mechanism, elements), ExudynEngine(mechanism, elements)]
            request = ResponseRequest(
                ConstantSpeed(speed), revolutions=revolutions, samples=samples
            )
            answer = answers[name, speed] = RunningAnswer(response(engines, request))
            for kind, figure in answer.response.figures().items():
                figures[f"{name}_{speed:g}_{kind}"] = figure
            print(answer.response.summary())
            print(
                f"{name.replace('_', ' ')} four-bar at {speed:g} rad/s: the coupler bends by up to "
                f"{1e3 * answer.peak:.4f} mm, at crank angle {answer.peak_angle:.0f} deg; linear "
                f"theory is off by {100 * answer.gap:.2f} % of that\n"
            )
        of_name = {speed: answers[name, speed].response for speed in speeds}
        figures[f"{name}_over_crank_angle"] = _draw(name, of_name)
    for speed in speeds:
        if {(WET, speed), ("moist_composite", speed)} <= answers.keys():
            more = answers[WET, speed].peak / answers["moist_composite", speed].peak - 1
            words = "further" if more > 0 else "less far"
            print(
                f"composite at {speed:g} rad/s: wet, the coupler bends {100 * abs(more):.1f} % "
                f"{words} than dry"
            )
    save_pictures(figures, out)
    return answers


def _draw(name: str, responses: Mapping[float, Response]) -> Figure:
    """Deflections in mm against crank angle, one panel a link and crank speed."""
    looks: list[dict[str, Any]] = [plots.series_line(n) for n in range(2)]
    looks[0]["linewidth"], looks[1]["linewidth"] = 1.8, 1.0
    layout = plots.grid(len(DRAWN) * len(responses), 1, 6.8, sharex=True)
    with plots.sheet(layout) as drawn:
        panels = iter(drawn.panels)
        for link, words in DRAWN.items():
            for speed, run in responses.items():
                axes, data = next(panels), run.dataset
                axes.axhline(0.0, color=plots.MID_GREY, lw=0.6, zorder=1)
                degrees = np.degrees(data["crank_angle"].values)
                for look, engine in zip(looks, data["engine"].values, strict=True):
                    bent = 1e3 * data["deflection"].sel(engine=engine, link=link)
                    axes.plot(degrees, bent, **look)
                axes.set_title(f"{words}, {plots.speed_label(speed)}")
                plots.crank_angle_axis(axes, degrees)
                plots.plain_numbers(axes)
        drawn.label_x("Crank angle (deg)")
        drawn.label_y("Deflection (mm)")
        words = ("reference, linear about the equilibrium", "Exudyn, nonlinear")
        handles = [plots.line_handle(w, **look) for w, look in zip(words, looks, strict=True)]
        drawn.header(handles, f"{TITLES[name]}: deflection off the line of a link's pins")
    return drawn.figure


if __name__ == "__main__":
    main(output_folder(__doc__, "results/running_fourbars"))
