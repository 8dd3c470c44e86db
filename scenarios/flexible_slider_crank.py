"""How far does the rod of Simeon's flexible slider-crank bend, and does it soften as it bends?

The slider-crank of Simeon (1996; IVP Test Set, problem "crank") at 150 rad/s. Three small models of
its rod by few functions, from linear strain to all of the strain's square, stand beside the runs of
both engines. The corrected form of the test set has the work of the tension against the slope,
EA u' w'^2 / 2, without the square of w'^2 / 2 that belongs to the same strain energy. What is left
between the engines and the whole strain energy is a free vibration: the engines start in
quasi-static balance, the test set from rates of its own.

    python scenarios/flexible_slider_crank.py [--out results/flexible_slider_crank]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from _common import MODELS, output_folder, save_pictures
from matplotlib.figure import Figure

from flexmech import (
    ConstantSpeed,
    ExudynEngine,
    ReferenceEngine,
    ResponseRequest,
    load_mechanism,
    plots,
    response,
)
from flexmech.arrays import FloatArray
from flexmech.verification import FloatingRod, verification_case

SMALL = {
    "linear": "linear",
    "third order": "third order",
    "whole": "whole strain energy",
}
ENGINES = {"reference": "reference engine", "exudyn": "Exudyn"}
LABELS = SMALL | ENGINES
FORMULAS = {
    "linear": ", $EA\\,u'^2/2$",
    "third order": ", with $EA\\,u'w'^2/2$",
    "whole": ", $EA\\,(u' + w'^2/2)^2/2$",
}
SAMPLES = 2000
SAMPLES_OF_A_TURN = 1000
SPEED, END_TIME = 150.0, 0.1
AGREES = 0.01


@dataclass(frozen=True)
class RodAnswer:
    """Deflection of the rod's middle.

    Parameters
    ----------
    time : ndarray, shape (T,)
        In s, from 0 to 0.1.
    deflection : dict of str to ndarray, shape (T,)
        In m, of the small models ``"linear"``, ``"third order"`` and ``"whole"``, and of the
        engines ``"reference"`` and ``"exudyn"``.
    """

    time: FloatArray
    deflection: Mapping[str, FloatArray]

    def peak(self, name: str) -> float:
        """Greatest deflection in m."""
        return float(np.abs(self.deflection[name]).max())

    def peak_time(self, name: str) -> float:
        """Time of the greatest deflection in s."""
        return float(self.time[np.abs(self.deflection[name]).argmax()])

    def apart(self, name: str, other: str) -> float:
        """Greatest difference of two deflections over the greatest of the second."""
        difference = self.deflection[name] - self.deflection[other]
        return float(np.abs(difference).max()) / self.peak(other)


def main(
    out: Path, *, small: Collection[str] = tuple(SMALL), elements: int = 8, step: float = 2e-5
) -> RodAnswer:
    """Run the small models and the engines, print what the peaks tell, draw the deflections.

    Parameters
    ----------
    out : Path
        Folder for the pictures.
    small : collection of str
        Small models to run, of ``"linear"``, ``"third order"`` and ``"whole"``.
    elements : int
        Of the engines' rod.
    step : float
        Of the engines' runs in s.

    Returns
    -------
    RodAnswer
    """
    time = np.linspace(0.0, END_TIME, SAMPLES + 1)
    curves = {name: _by_few_functions(name) for name in small}
    for name in ENGINES:
        curves[name] = _by_engine(name, elements, step, time)
    answer = RodAnswer(time, curves)
    for line in told(answer):
        print(line)
    save_pictures({"deflection": _draw(answer)}, out)
    return answer


def _by_few_functions(name: str) -> FloatArray:
    rods = {
        "linear": lambda: FloatingRod.of_the_test_set(excess=14.0),
        "third order": lambda: FloatingRod.of_the_test_set(order=3),
        "whole": FloatingRod.rich,
    }
    # A tolerance of 1e-4 changes the seventh digit: the integrator's stability holds its steps.
    return rods[name]().run(tolerance=1e-4, samples=SAMPLES)[1][0]


def _by_engine(name: str, elements: int, step: float, time: FloatArray) -> FloatArray:
    """Run of slender beams from the straight rod's quasi-static stretch."""
    mechanism = load_mechanism(MODELS / "slider_crank.toml")
    engine = (
        ReferenceEngine(mechanism, elements, "euler")
        if name == "reference"
        else ExudynEngine(mechanism, elements, "ancf")
    )
    turns = END_TIME * SPEED / (2 * np.pi)
    request = ResponseRequest(
        ConstantSpeed(SPEED), turns, samples=SAMPLES_OF_A_TURN, start="equilibrium", step=step
    )
    data = response(engine, request).dataset
    deflection = data["deflection"].isel(engine=0).sel(link="rod")
    return np.asarray(np.interp(time, data["time"], deflection))


def told(answer: RodAnswer) -> list[str]:
    """What the peaks tell, with verdicts that follow from the numbers."""
    lines = [
        f"{label}: peak {1e3 * answer.peak(name):.4f} mm at {answer.peak_time(name):.4f} s, "
        f"{1e3 * answer.deflection[name][-1]:.5f} mm at 0.1 s"
        for name, label in LABELS.items()
        if name in answer.deflection
    ]
    if "linear" in answer.deflection:
        published = published_end()
        off = answer.deflection["linear"][-1] / published - 1
        lines.append(
            f"test set's own model at 0.1 s: {1e3 * published:.5f} mm published, {off:+.1e} of it: "
            + verdict(off, 1e-5, "reproduced", "not reproduced")
        )
    stated = float(verification_case(CORRECTED).expected_values()[0])
    if "third order" in answer.deflection:
        off = answer.peak("third order") / stated - 1
        lines.append(
            f"peak of the corrected form: {1e3 * stated:.4f} mm stated, {100 * off:+.2f} %: "
            + verdict(off, AGREES, "reproduced", "not reproduced")
        )
    between = answer.peak("exudyn") / answer.peak("reference") - 1
    lines.append(
        f"engines: peaks differ by {100 * between:+.3f} %: "
        + verdict(between, AGREES, "they agree", "they do not agree")
    )
    for name, form in (("third order", "the corrected form"), ("whole", "the whole strain energy")):
        if name in answer.deflection:
            off = answer.peak("reference") / answer.peak(name) - 1
            lines.append(
                f"reference engine against {form}: peak {100 * off:+.2f} %: "
                + verdict(off, AGREES, "borne out", "not borne out")
            )
    return lines


CORRECTED = "Flexible slider-crank of Simeon: peak with tension against slopes in third order"
OWN_MODEL = "Flexible slider-crank of Simeon: state at 0.1 s by the test set's own model"


def published_end() -> float:
    """First sine at 0.1 s in m, as published."""
    return float(verification_case(OWN_MODEL).expected_values()[2])


def verdict(off: float, limit: float, yes: str, no: str) -> str:
    """One of two verdicts by a relative difference."""
    return yes if abs(off) <= limit else no


def _draw(answer: RodAnswer) -> Figure:
    """Deflections over time above; below, what the engines' differ by from the whole energy's."""
    styles = {name: number for number, name in enumerate(LABELS)}
    base = "whole" if "whole" in answer.deflection else "reference"
    with plots.sheet(plots.grid(2, 1, 4.6, sharex=True)) as drawn:
        above, below = drawn.panels
        for name, curve in answer.deflection.items():
            look = plots.series_line(styles[name])
            above.plot(1e3 * answer.time, 1e3 * curve, **look)
            if name in ENGINES:
                below.plot(1e3 * answer.time, 1e3 * (curve - answer.deflection[base]), **look)
        above.set_xlim(0.0, 1e3 * END_TIME)
        above.set_ylabel("Deflection of the rod (mm)")
        below.set_ylabel(f"Difference from\n{LABELS[base]} (mm)")
        drawn.label_x("Time (ms)")
        drawn.header(
            [
                plots.series_handle(styles[name], LABELS[name] + FORMULAS.get(name, ""))
                for name in answer.deflection
            ],
            "Flexible slider-crank at 150 rad/s",
        )
    return drawn.figure


if __name__ == "__main__":
    main(output_folder(__doc__, "results/flexible_slider_crank"))
