"""Is the damping of a running linkage found back from the record of a strain gauge?

The aluminium four-bar with a Kelvin-Voigt time that damps its first mode by 0.5 %, at 20 rad/s.
Exudyn's nonlinear simulation starts from undeformed links, and rings. The strains in the middle of
coupler and rocker are taken as if they were measured: with white noise of 3 % of the signal, from a
crank angle that nobody has written down, as a CSV file in micrometres per metre. The model that is
fitted knows nothing of damping, and its linear equations are those of the reference engine.

    python scenarios/damping_found_back.py [--out results/damping_found_back]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from _common import four_bar, output_folder, save_pictures

from flexmech import (
    ComparisonRequest,
    ConstantSpeed,
    ExudynEngine,
    Mechanism,
    ReferenceEngine,
    Response,
    ResponseRequest,
    compare_with_record,
    response,
)
from flexmech.analyses import Comparison

SPEED = 20.0
RATIO, FREQUENCY = 0.005, 44.66
TURNS, SAMPLES, STEP = 4.0, 360, 1e-4
# The record begins so many samples after the start, at a crank angle of 137 deg.
FIRST = 137
NOISE, SEED = 0.03, 17
GAUGES = ("coupler", "rocker")


@dataclass(frozen=True)
class Found:
    """What the record of one gauge tells.

    Parameters
    ----------
    link : str
    damping_time : float
        Of the simulated linkage in s.
    comparison : Comparison
    """

    link: str
    damping_time: float
    comparison: Comparison

    @property
    def ratio(self) -> float:
        """Damping time found over the true one."""
        return self.comparison.fitted("damping").value / self.damping_time

    @property
    def is_held(self) -> bool:
        """Whether the 95 % interval holds the true damping time."""
        found = self.comparison.fitted("damping")
        return found.lower <= self.damping_time <= found.upper


def damped(mechanism: Mechanism) -> Mechanism:
    """The mechanism with the same Kelvin-Voigt time in all links."""
    sections = {
        name: section.with_damping_ratio(RATIO, FREQUENCY)
        for name, section in mechanism.sections.items()
    }
    return replace(mechanism, sections=sections)


def simulated(mechanism: Mechanism, elements: int, step: float) -> Response:
    """The nonlinear run that is taken as the real machine."""
    request = ResponseRequest(ConstantSpeed(SPEED), TURNS, SAMPLES, step=step)
    return response(ExudynEngine(mechanism, elements), request)


def write_record(run: Response, link: str, path: Path) -> None:
    """Strain of a gauge with noise, as a laboratory would hand it over."""
    data = run.dataset.isel(engine=0, time=slice(FIRST, None))
    time, strain = data["time"].values, data["strain"].sel(link=link).values
    random = np.random.default_rng([SEED, GAUGES.index(link)])
    strain = strain + NOISE * strain.std() * random.standard_normal(strain.size)
    rows = (f"{t - time[0]:.7f},{1e6 * e:.4f}" for t, e in zip(time, strain, strict=True))
    path.write_text("\n".join(["time [s],strain (um/m)", *rows]) + "\n", encoding="utf-8")


def told(found: Found) -> str:
    """What a gauge tells, and whether it is right."""
    fitted, angle = (found.comparison.fitted(name) for name in ("damping", "start_angle"))
    verdict = "holds" if found.is_held else "does not hold"
    return (
        f"{found.link}: damping time {1e6 * fitted.value:.2f} us, 95 % interval "
        f"{1e6 * fitted.lower:.2f} to {1e6 * fitted.upper:.2f} us, which {verdict} the true "
        f"{1e6 * found.damping_time:.2f} us; crank angle at the start {angle.value:.2f} deg, true "
        f"{360 * FIRST / SAMPLES:.0f} deg; {100 * found.comparison.unexplained:.3f} % unexplained, "
        f"of which noise {100 * NOISE**2 / (1 + NOISE**2):.3f} %"
    )


def main(out: Path, elements: int = 8, step: float = STEP) -> list[Found]:
    """Simulate, write the records, fit, draw and tell."""
    plain = four_bar("aluminium")
    true = damped(plain)
    run = simulated(true, elements, step)
    out.mkdir(parents=True, exist_ok=True)
    answers = []
    for link in GAUGES:
        record = out / f"{link}_strain.csv"
        write_record(run, link, record)
        request = ComparisonRequest(SPEED, quantity=f"{link}_mid_strain")
        comparison = compare_with_record(ReferenceEngine(plain, elements), record, request)
        answers.append(Found(link, true.sections[link].damping.bending, comparison))
    for found in answers:
        print(told(found))
    save_pictures({f.link: f.comparison.plot() for f in answers}, out)
    return answers


if __name__ == "__main__":
    main(output_folder(__doc__, "results/damping_found_back"))
