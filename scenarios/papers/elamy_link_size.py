"""Does the link size that has to be assumed decide what the composite crank-rockers do?

Elamy et al. 2023 print no link size. Beams that only bend do not care: every ratio of
frequencies and of damping is the same for any size. With shear, which the printed moduli make
large, ratios depend on how thick the links are. Over the thickness: the frequency of C6 over
that of C1, the damping of C1 over that of C6, and by how much C1 in its cases and positions
misses the printed values at the best common scale.

    python scenarios/papers/elamy_link_size.py
"""  # noqa: D400 - a scenario asks a question

import numpy as np
import xarray as xr
from elamy_linkages import (
    CASES,
    crank_rocker,
    deviation_at_best_scale,
    geometric_mean,
    laminate_factors,
    position_angles,
    published_case,
    published_tables,
)

from flexmech import ReferenceEngine, natural_frequencies, plots, strain_energy_damping

# Links of five plies, which are one material in C1 and in C6: it does not matter whether they are
# stacked in the plane of motion or parallel to it. The ground is 0.4 m; the study assumes 5 mm.
THICKNESS = 5e-3 * np.array([0.1, 0.2, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 3.0])  # m
ELEMENTS = {"euler": "bending alone", "timoshenko": "with shear"}

printed = published_tables()["finite_element"]
ratios = {}
for element in ELEMENTS:
    rows = []
    for thickness in THICKNESS:
        frequency = printed.sel(laminate=["C1", "C6"]).copy(deep=True)
        damping = frequency.copy(deep=True)
        for laminate in ("C1", "C6"):
            for case in CASES:
                mechanism = crank_rocker(
                    case, laminate, "unidirectional", in_plane_thickness=float(thickness)
                )
                engine = ReferenceEngine(mechanism, 8, element)
                angles = position_angles(published_case(case))[:3]
                at = {"laminate": laminate, "case": case}
                frequency.loc[at] = natural_frequencies(engine, angles, modes=1)[:, 0]
                damping.loc[at] = strain_energy_damping(engine, angles, modes=1)[:, 0]
        lost = damping.sel(laminate="C1", drop=True) / damping.sel(laminate="C6", drop=True)
        of_c1, of_paper = (values.sel(laminate="C1") for values in (frequency, printed))
        rows.append(
            {
                "frequency, C6 over C1": float(laminate_factors(frequency).sel(laminate="C6")),
                "damping, C1 over C6": float(geometric_mean(lost, list(lost.dims))),
                "printed shape missed by": deviation_at_best_scale(of_c1, of_paper),
            }
        )
    ratios[element] = xr.Dataset({name: ("size", [row[name] for row in rows]) for name in rows[0]})
    for name, values in ratios[element].items():
        print(f"{element}: {name}: {float(values.min()):.3f} to {float(values.max()):.3f}")

with plots.sheet(plots.grid(1, 3, 2.5)) as drawn:
    for axes, name in zip(drawn.panels, ratios["euler"], strict=True):
        for number, (element, words) in enumerate(ELEMENTS.items()):
            look = plots.series_line(number) | {"marker": plots.series_style(number).marker}
            axes.semilogx(1e3 * THICKNESS, ratios[element][name], **look, label=words)
        axes.set_title(f"{name[0].upper()}{name[1:]}", fontsize=8)
        axes.set_xticks([0.5, 1, 2, 5, 10], ["0.5", "1", "2", "5", "10"])
        axes.minorticks_off()
        axes.set_ylim(bottom=0.0)
    drawn.label_x("Link thickness (mm)")
    drawn.panels[0].set_ylabel("Ratio (-)")
    title = "Composite crank-rockers: ratios over the thickness assumed"
    drawn.header(drawn.panels[0].lines, title)
drawn.figure.savefig("link_size.png")
