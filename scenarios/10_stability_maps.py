"""At which crank speeds do four-bars shake themselves up, and how much damping stops them?

Growth rates of the steel and the aluminium four-bar of Kumar & Chandrakar over crank speed, about
the quasi-static equilibrium, with light Kelvin-Voigt damping; then over crank speed and damping
ratio. No load has to excite what grows in the unstable bands, and frozen natural frequencies do
not show them. Each band is named by the Floquet frequencies that meet there.

    python scenarios/10_stability_maps.py
"""  # noqa: D400 - a scenario asks a question

import numpy as np

from flexmech import ReferenceEngine, example_model, load_mechanism, plots, stability

SPEEDS = {"steel": np.arange(140.0, 200.1, 0.5), "aluminium": np.arange(60.0, 100.1, 0.5)}
RATIOS = {"steel": np.linspace(0.0, 0.006, 13), "aluminium": np.linspace(0.0, 0.03, 13)}

maps = {}
for name, speeds in SPEEDS.items():
    found = maps[name] = stability(
        ReferenceEngine(load_mechanism(example_model(f"{name}_fourbar")), 4),
        speeds,
        prestress="equilibrium",
        modes=4,
        damping_ratio=0.001,
        against=("damping-ratio", RATIOS[name]),
    )
    print(found.summary())
    bands = found.bands()
    if not bands.empty:
        fastest = bands.loc[bands["largest_growth_rate_1_s"].idxmax()]
        print(
            f"{name} four-bar: grows most from {fastest['from_rad_s']:.2f} to "
            f"{fastest['to_rad_s']:.2f} rad/s; a damping ratio of "
            f"{100 * fastest['closing_damping_ratio']:.2g} % closes that band"
        )
    found.plot().savefig(f"{name}_stability.png")
    plots.plot_stability_against(found.dataset).savefig(f"{name}_damping.png")
