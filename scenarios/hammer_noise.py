"""How far does noise pull what a hammer test identifies, and which way?

The coupler of the composite four-bar, whose plies damp it, is hit in the middle and looked at
there; force and displacement have white noise of 1 and of 5 percent of their root mean square.
Three impacts are averaged. Over 15 draws of the noise with fixed seeds: bias (mean error) and
scatter (standard deviation) of frequency and damping of the first three modes, by both methods.

    python scenarios/hammer_noise.py [--out results/hammer_noise]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from _common import MODELS, output_folder, save_pictures
from matplotlib.figure import Figure

from flexmech import HammerRequest, ReferenceEngine, hammer_test, load_mechanism, plots
from flexmech.arrays import FloatArray

NOISE = (0.01, 0.05)
METHODS = ("lscf", "circle-fit")
DRAWS, MODES = 15, 3
CRANK_ANGLE = 96.9
FACTORS = (1e6, 100.0)
"""Of errors of frequency and damping: millionths and percent."""
WORDS = {"frequency": "Frequency", "damping_ratio": "Damping ratio"}


@dataclass(frozen=True)
class NoiseAnswer:
    """Relative errors of what was identified, over draw and mode; not a number if not found.

    Parameters
    ----------
    errors : dict of (str, float, str) to ndarray, shape (draws, modes)
        By method, noise, and ``"frequency"`` or ``"damping_ratio"``.
    """

    errors: dict[tuple[str, float, str], FloatArray]

    def table(self) -> pd.DataFrame:
        """Bias and scatter, one row a method, noise and mode."""
        rows = []
        for method, noise, quantity in self.errors:
            if quantity != "frequency":
                continue
            both = [self.errors[method, noise, name] for name in WORDS]
            for mode in range(both[0].shape[1]):
                own = [
                    factor * each[np.isfinite(each[:, mode]), mode]
                    for factor, each in zip(FACTORS, both, strict=True)
                ]
                found = len(own[0])
                numbers = [f(each) if found else np.nan for each in own for f in (np.mean, np.std)]
                share = f"{found} of {len(both[0])}"
                rows.append([method, f"{noise:.0%}", mode + 1, share, *numbers])
        names = [
            f"{name} {what} ({unit})"
            for name, unit in (("frequency", "1e-6"), ("damping", "%"))
            for what in ("bias", "scatter")
        ]
        return pd.DataFrame(rows, columns=["method", "noise", "mode", "identified", *names])


def main(
    out: Path,
    *,
    draws: int = DRAWS,
    methods: Sequence[str] = METHODS,
    noise: Sequence[float] = NOISE,
    elements: int = 4,
) -> NoiseAnswer:
    """Draw noise, identify, print the table, draw the errors.

    Parameters
    ----------
    out : Path
        Folder for the picture.
    draws : int
        Seeds from 0.
    methods : sequence of str
    noise : sequence of float
        Root mean square over that of the signal.
    elements : int
        Elements a link.

    Returns
    -------
    NoiseAnswer
    """
    engine = ReferenceEngine(load_mechanism(MODELS / "composite_fourbar.toml"), elements)
    errors: dict[tuple[str, float, str], FloatArray] = {}
    for method in methods:
        for level in noise:
            found = [_one_draw(engine, method, level, seed) for seed in range(draws)]
            for number, name in enumerate(WORDS):
                errors[method, level, name] = np.array([each[number] for each in found])
    answer = NoiseAnswer(errors)
    print(answer.table().to_string(index=False, float_format=lambda value: f"{value:.3g}"))
    save_pictures({"noise": _draw(answer)}, out)
    return answer


def _one_draw(
    engine: ReferenceEngine, method: str, noise: float, seed: int
) -> tuple[FloatArray, FloatArray]:
    """Relative errors of frequency and damping of the first modes."""
    request = HammerRequest(
        np.radians([CRANK_ANGLE]), noise=noise, seed=seed, method=method, modes=MODES
    )
    table = hammer_test(engine, request).identified().iloc[:MODES]
    return (
        (table["frequency_Hz"] / table["eigen_frequency_Hz"] - 1).to_numpy(),
        (table["damping_ratio"] / table["eigen_damping_ratio"] - 1).to_numpy(),
    )


def _draw(answer: NoiseAnswer) -> Figure:
    cases = [(method, noise) for method, noise, name in answer.errors if name == "frequency"]
    width = 0.8 / len(cases)
    with plots.sheet(plots.grid(1, 2, 3.0)) as drawn:
        for axes, (quantity, heading) in zip(drawn.panels, WORDS.items(), strict=True):
            for number, (method, noise) in enumerate(cases):
                values = 100 * answer.errors[method, noise, quantity]
                modes = np.arange(1, values.shape[1] + 1)
                place = modes + (number - (len(cases) - 1) / 2) * width
                style = plots.series_style(number)
                # A mode that some draws did not show has no bar: those that did are its best.
                axes.errorbar(
                    place,
                    np.mean(values, axis=0),
                    np.std(values, axis=0),
                    color=style.color,
                    marker=style.marker,
                    markersize=4,
                    lw=1.0,
                    capsize=3,
                    ls="none",
                )
            axes.axhline(0.0, color="0.2", lw=0.8)
            axes.set_xticks(modes, [str(mode) for mode in modes])
            axes.set_title(heading, fontsize=8)
        drawn.label_x("Mode")
        drawn.panels[0].set_ylabel("Bias, and scatter as bars (%)")
        drawn.header(
            [
                plots.line_handle(
                    f"{method}, noise {noise:.0%}",
                    color=plots.series_style(n).color,
                    marker=plots.series_style(n).marker,
                    ls="none",
                )
                for n, (method, noise) in enumerate(cases)
            ],
            "Errors of identified modes by noise",
        )
    return drawn.figure


if __name__ == "__main__":
    main(output_folder(__doc__, "results/hammer_noise"))
