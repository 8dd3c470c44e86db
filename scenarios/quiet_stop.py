"""How much quieter does an input shaper leave a linkage whose natural frequency changes on the way?

The crank of the steel four-bar moves by 60 degrees and stops. Its first natural frequency rises
from 62 to 111 Hz on the way and falls back to 95 Hz where the crank stops. Zero-vibration shapers
are made for the frequency at the stop, and along the path. Amplitudes after the stop are computed
over the time of the move.

A shaper for the end leaves a third to a half: what the start has excited vibrates at another
frequency by then. Along the path the parts of the motion follow each other by half a period of the
vibration that is there, and next to nothing is left where the move takes many periods. Its limit is
the square of the speed in the linkage's forces, which no sum of laws adds up.

    python scenarios/quiet_stop.py [--out results/quiet_stop]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr
from _common import four_bar, output_folder, save_pictures
from matplotlib.figure import Figure

from flexmech import LawDrive, ReferenceEngine, ResponseRequest, Shaping, plots
from flexmech.analyses import LawShaper, amplitudes_after_stop
from flexmech.arrays import FloatArray

LAW = LawDrive("trapezoid", np.radians(60), time=0.2, dwell=0.05)
TIMES = np.linspace(0.1, 0.3, 41)
"""Of the move in s."""
STATED = 0.3
"""Time of the move in s whose numbers are printed."""
LOOKS = {"plain": "plain law", "end": "ZV for the end", "path": "ZV along the path"}


def main(out: Path, *, times: FloatArray = TIMES, elements: int = 8) -> xr.DataArray:
    """Compute what each law leaves over the time of the move, print and draw it.

    Parameters
    ----------
    out : Path
        Folder for the picture.
    times : ndarray, shape (T,)
        Of the move in s, :data:`STATED` among them.
    elements : int
        Elements a link.

    Returns
    -------
    DataArray
        Amplitude of the first mode in m, over ``law`` and ``move_time``, in the link that shows it
        most; ``whole_time`` until the stop in s.
    """
    engine = ReferenceEngine(four_bar("steel"), elements)
    end, path = (
        LawShaper.of(engine, ResponseRequest(LAW, modes=2), Shaping("zv", frequencies=which), (1,))
        for which in ("end", "path")
    )
    plain = [LAW.stretched(float(time) / LAW.time) for time in times]
    laws = [plain, *([shaper.shaped(law) for law in plain] for shaper in (end, path))]
    amplitudes = xr.DataArray(
        [[amplitudes_after_stop(engine, law, 2)[:, 0].max() for law in row] for row in laws],
        dims=("law", "move_time"),
        coords={
            "law": list(LOOKS),
            "move_time": times,
            "whole_time": (("law", "move_time"), [[law.law_time for law in row] for row in laws]),
        },
    )
    stated = amplitudes.sel(move_time=STATED, method="nearest")
    whole = float(stated.sel(law="plain"))
    print(f"a move in {STATED:g} s: the first mode rings by {1e3 * whole:.4f} mm")
    for law in ("end", "path"):
        left = 100 * float(stated.sel(law=law)) / whole
        longer = 1e3 * (float(stated["whole_time"].sel(law=law)) - STATED)
        print(f"  {LOOKS[law]} leaves {left:.2f} % of it, {longer:.1f} ms later")
    save_pictures({"residual": _draw(amplitudes)}, out)
    return amplitudes


def _draw(amplitudes: xr.DataArray) -> Figure:
    """Amplitudes over the time until the stop."""
    with plots.sheet(plots.grid(1, 1, 3.0)) as drawn:
        [axes] = drawn.panels
        for number, law in enumerate(LOOKS):
            line = 1e3 * amplitudes.sel(law=law)
            axes.plot(line["whole_time"], line, **plots.series_line(number))
        axes.set_yscale("log")
        drawn.label_x("Time until the stop (s)")
        drawn.label_y("Amplitude of the first mode (mm)")
        drawn.header(
            [plots.series_handle(number, words) for number, words in enumerate(LOOKS.values())],
            "Steel four-bar, crank from 0 to 60 deg by the modified trapezoid",
        )
    return drawn.figure


if __name__ == "__main__":
    main(output_folder(__doc__, "results/quiet_stop"))
