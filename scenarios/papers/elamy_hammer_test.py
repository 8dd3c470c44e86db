"""What does a hammer test find at the paper's twelve positions, and which of its percentages hold?

Elamy et al. 2023 hit the coupler of their crank-rockers in the middle, looked there with a laser
vibrometer, averaged three impacts and read frequency and damping of the first mode from the
frequency-response function: four cases at three transmission angles, here with the laminates C1
(carbon) and C6 (glass). The same test is made on our models of these linkages. The paper prints no
link size and no loss of its materials: Hz and damping ratios depend on what is assumed for them,
so that its percentages are compared, and whether the test finds what the eigen model has.

    python scenarios/papers/elamy_hammer_test.py
"""  # noqa: D400 - a scenario asks a question

from dataclasses import replace
from itertools import product

import numpy as np
import pandas as pd
from elamy_linkages import crank_rocker, position_angles, published_case, published_tables
from paper_claims import verdict_on, within_a_tenth

from flexmech import (
    LinkPoint,
    ReferenceEngine,
    hammer_test,
    natural_frequencies,
    plots,
    strain_energy_damping,
)

CASES, ELEMENTS = (1, 2, 3, 4), 8
LAMINATES, POSITIONS = ("C1", "C6"), ("min", "90", "max")
MIDDLE = LinkPoint("coupler", 0.5)
# Mean decreases that the paper prints in percent: along a dimension, from one place to another.
PERCENTAGES = [
    ("frequency", "laminate", "C1", "C6", 62.22),
    ("frequency", "case", 3, 2, 41.55),
    ("frequency", "position", "max", "90", 26.17),
    ("frequency", "position", "max", "min", 15.93),
    ("frequency", "position", "min", "90", 11.19),
    ("damping", "laminate", "C6", "C1", 28.63),
    ("damping", "case", 2, 3, 15.78),
]


def hit(mechanism, angle):
    """Frequency and damping of the first mode: identified, and by the eigen model.

    The plies lose the same part of their strain energy at any frequency; a record in time needs
    damping times, which lose that part at one frequency: the first mode's at this position.
    """
    engine = ReferenceEngine(mechanism, ELEMENTS, "euler")
    frequency = natural_frequencies(engine, [angle], modes=1)[0, 0]
    damping = strain_energy_damping(engine, [angle], modes=1)[0, 0]
    damped = {
        name: replace(section, damping=section.specific_damping.times(2 * np.pi * frequency))
        for name, section in mechanism.sections.items()
    }
    engine = ReferenceEngine(replace(mechanism, sections=damped), ELEMENTS, "euler")
    test = hammer_test(engine, [angle], impact=MIDDLE, averages=3, modes=1)
    first = test.identified().iloc[0]
    return first["frequency_Hz"], first["damping_ratio"], frequency, damping


rows = []
for laminate, case in product(LAMINATES, CASES):
    mechanism = crank_rocker(case, laminate, "unidirectional")
    angles = position_angles(published_case(case))[:3]
    for position, angle in zip(POSITIONS, angles, strict=True):
        rows.append((laminate, case, position, *hit(mechanism, float(angle))))
names = ["frequency", "damping", "eigen_frequency", "eigen_damping"]
places = ["laminate", "case", "position"]
found = pd.DataFrame(rows, columns=[*places, *names]).set_index(places).to_xarray()
paper = published_tables().sel(laminate=list(LAMINATES))
together = found.merge(paper.rename(damping="printed_damping"), join="left")
print(together.to_dataframe().to_string(float_format="{:.6g}".format))

print("mean decrease in %: printed, by the paper's measured tables, by our test of straight plies")
print("(elamy_2023.py computes woven ones); reproduced if")
print("ours is within a tenth of the number printed; damping is not judged: no loss is printed")
measured = {"frequency": paper["measured"], "damping": paper["damping"]}
shown = {}
for quantity, dim, high, low, printed in PERCENTAGES:
    if not {high, low} <= set(found[dim].values.tolist()):
        continue
    theirs, ours = (
        100 * (1 - float((values.sel({dim: low}) / values.sel({dim: high})).mean()))
        for values in (measured[quantity], found[quantity])
    )
    judged = None if quantity == "damping" else within_a_tenth(printed, ours)
    words = f"{quantity}, {dim} {high} to {low}"
    shown[words] = printed, theirs, ours
    print(f"{words:>36}: {printed:6.2f} {theirs:6.2f} {ours:6.2f}  {verdict_on(judged)}")
difference = {
    name: float(abs(found[name] / found[f"eigen_{name}"] - 1).max()) for name in names[:2]
}
print(
    f"identified against eigen model: frequencies {difference['frequency']:.1e}, damping ratios "
    f"{difference['damping']:.1e} at most"
)

with plots.sheet(plots.grid(1, 1, 3.2)) as drawn:
    (axes,) = drawn.panels
    sources = ("printed in the paper", "its measured tables, C1 and C6", "our hammer test")
    for number, (source, values) in enumerate(
        zip(sources, zip(*shown.values(), strict=True), strict=True)
    ):
        places = np.arange(len(shown)) + 0.26 * (number - 1)
        axes.barh(places, values, 0.26, color=plots.series_style(number).color, label=source)
    axes.axvline(0.0, color=plots.MID_GREY, lw=0.8)
    axes.set_yticks(np.arange(len(shown)), list(shown))
    axes.invert_yaxis()
    axes.set_xlabel("Mean decrease (%)")
    title = "First mode of composite crank-rockers by hammer test"
    drawn.header(axes.containers, title)
drawn.figure.savefig("percentages.png")
