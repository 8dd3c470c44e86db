"""How much quieter does an input shaper leave a linkage whose natural frequency changes on the way?

The crank of the steel four-bar moves by 60 degrees and stops. Its first natural frequency rises
from 62 to 111 Hz on the way and falls back to 95 Hz where the crank stops. Zero-vibration shapers
are made for the frequency at the stop, and along the path. Amplitudes after the stop are computed
over the time of the move.

A shaper for the end leaves a third to a half: what the start has excited vibrates at another
frequency by then. Along the path the parts of the motion follow each other by half a period of the
vibration that is there, and next to nothing is left where the move takes many periods. Its limit is
the square of the speed in the linkage's forces, which no sum of laws adds up.

    python scenarios/07_quiet_stop.py
"""  # noqa: D400 - a scenario asks a question

import numpy as np

from flexmech import LawDrive, ReferenceEngine, Shaping, example_model, load_mechanism, plots
from flexmech.analyses import LawShaper, ResponseRequest, amplitudes_after_stop

LAW = LawDrive("trapezoid", np.radians(60), time=0.2, dwell=0.05)
TIMES = np.linspace(0.1, 0.3, 41)  # of the move, s
ELEMENTS = 8

engine = ReferenceEngine(load_mechanism(example_model("steel_fourbar")), ELEMENTS)
plain_laws = [LAW.stretched(float(time) / LAW.time) for time in TIMES]
laws = {"plain law": plain_laws}
for words, frequencies in (("ZV for the end", "end"), ("ZV along the path", "path")):
    shaping = Shaping("zv", frequencies=frequencies)
    shaper = LawShaper.of(engine, ResponseRequest(LAW, modes=2), shaping, modes=(1,))
    laws[words] = [shaper.shaped(law) for law in plain_laws]

# The first mode, in the link that shows it most.
curves = {
    words: (
        np.array([law.law_time for law in moves]),
        np.array([amplitudes_after_stop(engine, law, 2)[:, 0].max() for law in moves]),
    )
    for words, moves in laws.items()
}
plain = curves["plain law"][1]

left = {words: amplitude[-1] / plain[-1] for words, (_, amplitude) in curves.items()}
print(f"a move in {TIMES[-1]:g} s: the first mode rings by {1e3 * plain[-1]:.4f} mm")
for words, (time, _) in list(curves.items())[1:]:
    later = 1e3 * (time[-1] - TIMES[-1])
    print(f"  {words} leaves {100 * left[words]:.2f} % of it, {later:.1f} ms later")

with plots.sheet(plots.grid(1, 1, 3.0)) as drawn:
    for number, (time, amplitude) in enumerate(curves.values()):
        drawn.panels[0].semilogy(time, 1e3 * amplitude, **plots.series_line(number))
    drawn.label_x("Time until the stop (s)")
    drawn.label_y("Amplitude of the first mode (mm)")
    lines = [plots.series_handle(number, words) for number, words in enumerate(curves)]
    drawn.header(lines, "Steel four-bar, crank from 0 to 60 deg by the modified trapezoid")
drawn.figure.savefig("residual.png")
