"""What does each inertial term of the running linkage do to its frequencies, alone?

Turcic & Midha's equation (as in Kumar & Chandrakar, eq. 1.57) has four terms by the crank's speed:
the geometric stiffness of the axial forces, Coriolis, centripetal and tangential terms. Each is
counted alone at 20 rad/s, for the steel, the aluminium and a dry composite four-bar: how far it
moves the first three frequencies, at which crank angle most, and whether the single changes add up
to what all terms do together. The links are straight here; `15_axial_force_alone.py` shows what
their bending adds. Both engines on one mesh; twice the elements show what of it is known.

    python scenarios/14_inertial_terms.py
"""  # noqa: D400 - a scenario asks a question

import numpy as np
import xarray as xr

import flexmech
from flexmech import plots

NAMES = ("steel", "aluminium", "moist_composite")
SPEED, ELEMENTS = 20.0, 16
TURN = np.radians(np.arange(0.0, 361.0))
MARKS = np.radians(np.arange(0.0, 361.0, 30.0))  # of Exudyn and of the finer mesh
# Prestress and rotation terms.
TERMS = {
    "geometric": ("axial", "none"),
    **{term: ("none", term) for term in ("coriolis", "centripetal", "tangential")},
    "together": ("axial", "all"),
}


def changes(engine, angles):
    """Frequencies without the terms in Hz, and what each adds in mHz; (angle, mode) behind term."""

    def frequencies(level, terms):
        forms = {"prestress": level, "rotation_terms": flexmech.RotationTerms.parse(terms)}
        return flexmech.natural_frequencies(engine, angles, SPEED, modes=3, **forms)

    rest = frequencies("none", "none")
    added = [1e3 * (frequencies(*term) - rest) for term in TERMS.values()]
    places = {"term": list(TERMS), "angle": angles, "mode": [1, 2, 3]}
    return xr.DataArray(rest, dims=("angle", "mode")), xr.DataArray(added, places, tuple(places))


found, geometric_leads = {}, {}
for name in NAMES:
    mechanism = flexmech.load_mechanism(flexmech.example_model(f"{name}_fourbar"))
    rest, change = changes(flexmech.ReferenceEngine(mechanism, ELEMENTS), TURN)
    found[name] = change
    _, finer = changes(flexmech.ReferenceEngine(mechanism, 2 * ELEMENTS), MARKS)
    _, exudyn = changes(flexmech.ExudynEngine(mechanism, ELEMENTS), MARKS)
    greatest, at_marks = abs(change).max("angle"), change.sel(angle=MARKS)
    columns = {
        "greatest mHz": greatest,
        "at deg": np.degrees(abs(change).idxmax("angle")),
        "%": 0.1 * abs(change / rest).max("angle"),
        "mesh mHz": abs(finer - at_marks).max("angle"),
        "engines mHz": abs(exudyn - at_marks).max("angle"),
    }
    # Beyond a tenth of a term's greatest change the mesh decides more of it than the term.
    columns["resolved"] = columns["mesh mHz"] < 0.1 * greatest
    table = xr.Dataset(columns).to_dataframe().round(4).to_string()
    print(f"{name} four-bar at {SPEED:g} rad/s, straight links, each term alone\n{table}")
    together, (geometric, *others) = change.sel(term="together"), greatest[:-1]
    gap = abs(change[:-1].sum("term") - together).max() / abs(together).max()
    geometric_leads[name] = all(bool((other < geometric).all()) for other in others)
    print(f"  single changes add up within {100 * float(gap):.2f} % of the greatest of all terms")
    print(f"  the geometric stiffness weighs most in every mode: {geometric_leads[name]}")

    with plots.sheet(plots.grid(len(TERMS), 1, 7.6, sharex=True)) as drawn:
        for axes, term in zip(drawn.panels, TERMS, strict=True):
            for mode in (1, 2, 3):
                look = plots.series_line(mode - 1)
                axes.plot(np.degrees(TURN), change.sel(term=term, mode=mode), **look)
                mark = look | {"linestyle": "", "marker": "s", "markersize": 3.5, "mfc": "white"}
                axes.plot(np.degrees(MARKS), exudyn.sel(term=term, mode=mode), **mark)
            axes.set_title(term.title())
            plots.plain_numbers(axes)
        plots.crank_angle_axis(drawn.panels[-1], np.degrees(TURN))
        drawn.label_x("Crank angle (deg)")
        drawn.label_y("Change of frequency (mHz)")
        handles = [plots.series_handle(mode - 1, f"mode {mode}") for mode in (1, 2, 3)]
        handles.append(plots.line_handle("Exudyn, same elements", **mark))
        drawn.header(handles, f"{name} four-bar: change by each term at {SPEED:g} rad/s")
    drawn.figure.savefig(f"{name}.png")
