"""Has the running linkage sidebands that its frozen positions do not show?

The aluminium four-bar at 20 rad/s with a damping ratio of 1 %, a force on the middle of the coupler
and the displacement of the middle of the rocker, across both. The running linkage is a periodic
system: a force at f answers at f + n f_crank too. The harmonic transfer functions of its linear
equations stand beside the receptance of the frozen linkage.

    python scenarios/19_running_hammer_test.py
"""  # noqa: D400 - a scenario asks a question

import numpy as np

from flexmech import LinkPoint, ReferenceEngine, example_model, load_mechanism, running_hammer_test

ELEMENTS, DAMPING_RATIO = 4, 0.01

engine = ReferenceEngine(load_mechanism(example_model("aluminium_fourbar")), ELEMENTS)
hit, seen = LinkPoint("coupler", 0.5), LinkPoint("rocker", 0.5)
found = running_hammer_test(engine, 20.0, impact=hit, response=seen, damping_ratio=DAMPING_RATIO)
frozen = np.hypot(found.dataset["frozen_real"], found.dataset["frozen_imag"]).max("frequency")
for peak in found.peaks().itertuples():
    print(
        f"order {peak.order:+d}: {peak.peak_m_N:.3e} m/N at {peak.peak_frequency_Hz:.2f} Hz; the "
        f"frozen linkage has {float(frozen.sel(order=peak.order)) / peak.peak_m_N:.2f} times that"
    )
found.plot().savefig("harmonic_frf.png")
