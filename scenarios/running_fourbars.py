"""How far do the links of both four-bars bend as they run, and is linear theory good enough?

The steel and the aluminium four-bar of Kumar & Chandrakar at 10 and 20 rad/s, started
undeformed with the rigid motion's velocities, without damping: Exudyn's nonlinear simulation
and the linear equations about the quasi-static equilibrium, with the same mesh.

    python scenarios/running_fourbars.py [--out results/running_fourbars]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from _common import four_bar, output_folder, save_pictures

from flexmech import CrankDrive, ExudynEngine, ReferenceEngine, Response, ResponseRequest, response

SPEEDS = (10.0, 20.0)


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


def main(
    out: Path,
    *,
    names: tuple[str, ...] = ("steel", "aluminium"),
    speeds: tuple[float, ...] = SPEEDS,
    revolutions: float = 2.0,
    elements: int = 8,
    samples: int = 720,
) -> dict[tuple[str, float], RunningAnswer]:
    """Run both four-bars, print peaks and checks, draw them.

    Parameters
    ----------
    out : Path
        Folder for the pictures.
    names : tuple of str
        Which four-bars.
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
        mechanism = four_bar(name)
        for speed in speeds:
            engines = [ReferenceEngine(mechanism, elements), ExudynEngine(mechanism, elements)]
            request = ResponseRequest(CrankDrive(speed), revolutions=revolutions, samples=samples)
            answer = answers[name, speed] = RunningAnswer(response(engines, request))
            for kind, figure in answer.response.figures().items():
                figures[f"{name}_{speed:g}_{kind}"] = figure
            print(answer.response.summary())
            print(
                f"{name} four-bar at {speed:g} rad/s: the coupler bends by up to "
                f"{1e3 * answer.peak:.4f} mm; linear theory is off by {100 * answer.gap:.2f} % of "
                "that\n"
            )
    save_pictures(figures, out)
    return answers


if __name__ == "__main__":
    main(output_folder(__doc__, "results/running_fourbars"))
