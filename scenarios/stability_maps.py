"""At which crank speeds do four-bars shake themselves up, and how much damping stops them?

Growth rates of the steel and the aluminium four-bar of Kumar & Chandrakar over crank speed, about
the quasi-static equilibrium, with light Kelvin-Voigt damping; then over crank speed and damping
ratio. No load has to excite what grows in the unstable bands, and frozen natural frequencies do
not show them. Each band is named by the Floquet frequencies that meet there.

    python scenarios/stability_maps.py [--out results/stability_maps]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from pathlib import Path

import numpy as np
from _common import four_bar, output_folder, save_pictures

from flexmech import ReferenceEngine, StabilityMap, plots, stability
from flexmech.arrays import FloatArray

DAMPING_RATIO = 0.001
RATIOS = {"aluminium": np.linspace(0.0, 0.03, 13), "steel": np.linspace(0.0, 0.006, 13)}
SPEEDS = {"aluminium": np.arange(60.0, 100.1, 0.5), "steel": np.arange(140.0, 200.1, 0.5)}
MODES = 4


def main(
    out: Path,
    *,
    names: tuple[str, ...] = ("steel", "aluminium"),
    speeds: dict[str, FloatArray] = SPEEDS,
    ratios: dict[str, FloatArray] = RATIOS,
    elements: int = 4,
) -> dict[str, StabilityMap]:
    """Map the stability of both four-bars, print the bands, draw them.

    Parameters
    ----------
    out : Path
        Folder for the pictures.
    names : tuple of str
        Which four-bars.
    speeds : dict of str to ndarray
        Crank speeds of each in rad/s.
    ratios : dict of str to ndarray
        Damping ratios of the map over both.
    elements : int
        Elements a link.

    Returns
    -------
    dict of str to StabilityMap
        By ``"steel"`` and ``"aluminium"``.
    """
    maps, figures = {}, {}
    for name in names:
        found = maps[name] = stability(
            ReferenceEngine(four_bar(name), elements),
            speeds[name],
            prestress="equilibrium",
            modes=MODES,
            damping_ratio=DAMPING_RATIO,
            against=("damping-ratio", ratios[name]),
        )
        print(found.summary())
        if not found.bands().empty:
            fastest = found.bands().sort_values("largest_growth_rate_1_s").iloc[-1]
            print(
                f"{name} four-bar: grows most from {fastest['from_rad_s']:.2f} to "
                f"{fastest['to_rad_s']:.2f} rad/s; a damping ratio of "
                f"{100 * fastest['closing_damping_ratio']:.2g} % closes that band"
            )
        figures[f"{name}_stability"] = found.plot()
        figures[f"{name}_damping"] = plots.plot_stability_against(found.dataset)
    save_pictures(figures, out)
    return maps


if __name__ == "__main__":
    main(output_folder(__doc__, "results/stability_maps"))
