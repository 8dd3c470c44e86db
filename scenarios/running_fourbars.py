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

from flexmech import ExudynEngine, ReferenceEngine
from flexmech.analyses.response import Response, ResponseRequest, response
from flexmech.linkages import CrankDrive
from flexmech.plots import plot_forces, plot_response, plot_spectrogram, plot_spectrum

SPEEDS = (10.0, 20.0)


@dataclass(frozen=True)
class RunningAnswer:
    """One four-bar at one crank speed.

    Parameters
    ----------
    response : Response
        Both engines.
    peak : float
        Greatest deflection of the coupler's middle in Exudyn's run, m.
    gap : float
        Greatest difference of the linear coupler deflection from it over the run, over the
        peak.
    """

    response: Response
    peak: float
    gap: float


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
            answer = _answer(response(engines, request))
            answers[name, speed] = answer
            data, stem = answer.response.dataset, f"{name}_{speed:g}"
            figures[f"{stem}_response.png"] = plot_response(data)
            figures[f"{stem}_forces.png"] = plot_forces(data)
            figures[f"{stem}_spectrum.png"] = plot_spectrum(data)
            if "spectrogram" in data:
                figures[f"{stem}_spectrogram.png"] = plot_spectrogram(data)
            _report(name, speed, answer)
    print("pictures: " + ", ".join(str(path) for path in save_pictures(figures, out)))
    return answers


def _answer(result: Response) -> RunningAnswer:
    agreement = result.agreement()
    assert agreement is not None
    peaks = result.peaks()["deflection"]
    return RunningAnswer(
        response=result,
        peak=float(peaks.sel(engine="exudyn", link="coupler")),
        gap=float(agreement.sel(link="coupler")),
    )


def _report(name: str, speed: float, answer: RunningAnswer) -> None:
    data = answer.response.dataset
    errors = ", ".join(
        f"{engine}: energy {float(data['energy_error'].sel(engine=engine)):.1e}, "
        f"time step {float(data['step_error'].sel(engine=engine)):.1e}"
        for engine in data["engine"].values
    )
    print(
        f"{name} four-bar at {speed:g} rad/s: the coupler bends by up to "
        f"{1e3 * answer.peak:.4f} mm; linear theory is off by {100 * answer.gap:.2f} % of that "
        f"({errors})"
    )


if __name__ == "__main__":
    main(output_folder(__doc__, "results/running_fourbars"))
