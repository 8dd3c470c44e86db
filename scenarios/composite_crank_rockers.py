"""Does the link size that has to be assumed decide what the composite crank-rockers do?

Elamy et al. 2023 print no link size. Beams that only bend do not care: every ratio of
frequencies and of damping is the same for any size. With shear, which the printed moduli make
large, ratios depend on how thick the links are. Over the thickness: the frequency of C6 over
that of C1, the damping of C1 over that of C6, and by how much C1 in its cases and positions
misses the printed values at the best common scale.

    python scenarios/composite_crank_rockers.py [--out results/composite_crank_rockers]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from _common import output_folder, save_pictures
from matplotlib.figure import Figure
from papers._elamy_linkages import (
    crank_rocker,
    deviation_at_best_scale,
    laminate_factors,
    position_angles,
    published_case,
    published_tables,
)

from flexmech import ReferenceEngine, natural_frequencies, plots, strain_energy_damping
from flexmech.arrays import FloatArray

# Links of five plies, which are one material in C1 and in C6: it does not matter whether they are
# stacked in the plane of motion or parallel to it. The ground is 0.4 m; the study assumes 1 mm.
PLIES = 5
PLY_THICKNESS = np.array([0.1, 0.2, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 3.0]) * 1e-3
ELEMENTS = {"euler": "bending alone", "timoshenko": "with shear"}
WORDS = {
    "factor": "frequency, C6 over C1",
    "damping": "damping, C1 over C6",
    "deviation": "printed shape missed by",
}


@dataclass(frozen=True)
class SizeAnswer:
    """Ratios over the thickness of the plies, by element.

    Parameters
    ----------
    thickness : ndarray, shape (T,)
        Of one ply in m.
    ratios : dict of str to dict of str to ndarray, shape (T,)
        ``"factor"``, ``"damping"`` and ``"deviation"`` of ``"euler"`` and ``"timoshenko"``.
    """

    thickness: FloatArray
    ratios: dict[str, dict[str, FloatArray]]


def main(out: Path, *, thickness: FloatArray = PLY_THICKNESS, elements: int = 8) -> SizeAnswer:
    """Vary the thickness, print the ratios, draw them.

    Parameters
    ----------
    out : Path
        Folder for the picture.
    thickness : ndarray, shape (T,)
        Of one ply in m.
    elements : int
        Elements a link.

    Returns
    -------
    SizeAnswer
    """
    ratios: dict[str, dict[str, FloatArray]] = {}
    for element in ELEMENTS:
        found = [ratios_of(element, float(size), elements) for size in thickness]
        ratios[element] = {name: np.array([each[name] for each in found]) for name in WORDS}
        for name, words in WORDS.items():
            values = ratios[element][name]
            print(f"{element}: {words}: {values.min():.3f} to {values.max():.3f}")
    answer = SizeAnswer(thickness, ratios)
    save_pictures({"link_size": _draw(answer)}, out)
    return answer


def ratios_of(element: str, thickness: float, elements: int) -> dict[str, float]:
    """The three ratios of one element and thickness."""
    published = published_tables()["finite_element"]
    cases = published["case"].values.tolist()
    frequency = published.sel(laminate=["C1", "C6"]).copy(deep=True)
    damping = frequency.copy(deep=True)
    for laminate in ("C1", "C6"):
        for case in cases:
            mechanism = crank_rocker(
                case, laminate, "unidirectional", in_plane_thickness=PLIES * thickness
            )
            engine = ReferenceEngine(mechanism, elements, element)
            angles = position_angles(published_case(case))[:3]
            at = {"laminate": laminate, "case": case}
            frequency.loc[at] = natural_frequencies(engine, angles, modes=1)[:, 0]
            damping.loc[at] = strain_energy_damping(engine, angles, modes=1)[:, 0]
    lost = damping.sel(laminate="C1") / damping.sel(laminate="C6")
    first, printed = (values.sel(laminate="C1") for values in (frequency, published))
    return {
        "factor": float(laminate_factors(frequency).sel(laminate="C6")),
        "damping": float(np.exp(np.log(lost).mean())),
        "deviation": deviation_at_best_scale(first, printed),
    }


def _draw(answer: SizeAnswer) -> Figure:
    marks = [
        {"marker": plots.series_style(n).marker, "markersize": 4} for n in range(len(ELEMENTS))
    ]
    with plots.sheet(plots.grid(1, len(WORDS), 2.5)) as drawn:
        for axes, (name, heading) in zip(drawn.panels, WORDS.items(), strict=True):
            curves = [answer.ratios[element][name] for element in ELEMENTS]
            for number, values in enumerate(curves):
                axes.plot(
                    1e3 * PLIES * answer.thickness,
                    values,
                    **(plots.series_line(number) | marks[number]),
                )
            axes.set_title(heading[0].upper() + heading[1:], fontsize=8)
            axes.set_xscale("log")
            axes.set_xticks([0.5, 1, 2, 5, 10], ["0.5", "1", "2", "5", "10"])
            axes.minorticks_off()
            axes.set_ylim(0.0, 1.1 * np.max(curves))
        drawn.label_x("Link thickness (mm)")
        drawn.panels[0].set_ylabel("Ratio (-)")
        drawn.header(
            [
                plots.series_handle(n, words, **marks[n])
                for n, words in enumerate(ELEMENTS.values())
            ],
            "Composite crank-rockers: ratios over the thickness assumed",
        )
    return drawn.figure


if __name__ == "__main__":
    main(output_folder(__doc__, "results/composite_crank_rockers"))
