"""How far does noise pull what a hammer test identifies, and which way?

The coupler of the composite four-bar, whose plies damp it, is hit in the middle and looked at
there; force and displacement have white noise of 1 and of 5 percent of their root mean square.
Three impacts are averaged. Over 15 draws of the noise with fixed seeds: bias (mean error) and
scatter (standard deviation) of frequency and damping of the first three modes, by both methods.

    python scenarios/18_hammer_noise.py
"""  # noqa: D400 - a scenario asks a question

import numpy as np
import pandas as pd

from flexmech import ReferenceEngine, example_model, hammer_test, load_mechanism, plots

DRAWS = 15
CASES = [(method, noise) for method in ("lscf", "circle-fit") for noise in (0.01, 0.05)]
QUANTITIES = {"frequency_Hz": "frequency", "damping_ratio": "damping"}

engine = ReferenceEngine(load_mechanism(example_model("composite_fourbar")), 4)
draws = []
for method, noise in CASES:
    for seed in range(DRAWS):
        asked = {"noise": noise, "seed": seed, "method": method, "modes": 3}
        found = hammer_test(engine, np.radians([96.9]), **asked).identified().iloc[:3]
        errors = {
            words: 100 * (found[column] / found[f"eigen_{column}"] - 1)
            for column, words in QUANTITIES.items()
        }
        draws.append(pd.DataFrame({"method": method, "noise": noise, "mode": [1, 2, 3], **errors}))

# A mode that is not found in a draw has no error there.
groups = pd.concat(draws).groupby(["method", "noise", "mode"], sort=False)
table = groups["frequency"].agg(identified="count")
for quantity in QUANTITIES.values():
    table[f"{quantity} bias (%)"] = groups[quantity].mean()
    table[f"{quantity} scatter (%)"] = groups[quantity].std(ddof=0)
print(f"{DRAWS} draws")
print(table.to_string(float_format="{:.3g}".format))

with plots.sheet(plots.grid(1, 2, 3.0)) as drawn:
    for axes, quantity in zip(drawn.panels, QUANTITIES.values(), strict=True):
        for number, case in enumerate(CASES):
            bias, scatter = (
                table.loc[case][f"{quantity} {what} (%)"] for what in ("bias", "scatter")
            )
            style = plots.series_style(number)
            look = {"color": style.color, "marker": style.marker, "ls": "", "capsize": 3}
            axes.errorbar(bias.index + 0.2 * (number - 1.5), bias, scatter, **look)
        axes.axhline(0.0, color=plots.MID_GREY, lw=0.8)
        axes.set_xticks([1, 2, 3])
        axes.set_title(quantity.title())
    drawn.label_x("Mode")
    drawn.panels[0].set_ylabel("Bias, and scatter as bars (%)")
    handles = [
        plots.series_handle(number, f"{method}, noise {noise:.0%}", linestyle="", marker="o")
        for number, (method, noise) in enumerate(CASES)
    ]
    drawn.header(handles, "Errors of identified modes by noise")
drawn.figure.savefig("noise.png")
