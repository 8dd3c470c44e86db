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

from flexmech import (
    ExudynEngine,
    ReferenceEngine,
    RotationTerms,
    example_model,
    load_mechanism,
    natural_frequencies,
    plots,
)

NAMES = ("steel", "aluminium", "moist_composite")
SPEED, ELEMENTS = 20.0, 16
TURN = np.radians(np.arange(0.0, 361.0))
MARKS = np.radians(np.arange(0.0, 361.0, 30.0))  # of Exudyn and of the finer mesh
# Prestress and rotation terms.
TERMS = {
    "geometric": ("axial", "none"),
    "coriolis": ("none", "coriolis"),
    "centripetal": ("none", "centripetal"),
    "tangential": ("none", "tangential"),
    "together": ("axial", "all"),
}
ADDS_UP = 0.02  # of the greatest change by all terms together
RESOLVED = 0.1  # of a term's greatest change: beyond, the mesh decides more of it than the term


def changes(engine, angles, speed=SPEED):
    """Frequencies without the terms in Hz, and what each adds in mHz, over angle and mode."""

    def frequencies(prestress, terms):
        terms = RotationTerms.parse(terms)
        values = natural_frequencies(
            engine, angles, speed, modes=3, prestress=prestress, rotation_terms=terms
        )
        return xr.DataArray(values, {"angle": angles, "mode": [1, 2, 3]}, ("angle", "mode"))

    rest = frequencies("none", "none")
    added = [1e3 * (frequencies(*term) - rest) for term in TERMS.values()]
    return rest, xr.concat(added, xr.DataArray(list(TERMS), dims="term", name="term"))


found, geometric_leads = {}, {}
for name in NAMES:
    mechanism = load_mechanism(example_model(f"{name}_fourbar"))
    engine = ReferenceEngine(mechanism, ELEMENTS)
    rest, change = changes(engine, TURN)
    _, slower = changes(engine, TURN, SPEED / 2)
    (_, own), (_, finer), (_, exudyn) = (
        changes(one, MARKS)
        for one in (
            engine,
            ReferenceEngine(mechanism, 2 * ELEMENTS),
            ExudynEngine(mechanism, ELEMENTS),
        )
    )
    size, half_size = ((each.isel(angle=slice(-1)) ** 2).mean("angle") for each in (change, slower))
    worst = abs(change.isel(angle=slice(-1))).idxmax("angle")
    greatest, mesh = abs(change).max("angle"), abs(finer - own).max("angle")
    table = xr.Dataset(
        {
            "greatest mHz": change.sel(angle=worst),
            "at deg": np.degrees(worst),
            "%": 0.1 * change.sel(angle=worst) / rest.sel(angle=worst),
            "power of speed": np.log2(size / half_size) / 2,
            "mesh mHz": mesh,
            "engines mHz": abs(exudyn - own).max("angle"),
            "resolved": mesh < RESOLVED * greatest,
        }
    ).drop_vars("angle")
    print(f"{name} four-bar at {SPEED:g} rad/s, straight links, each term alone")
    print(table.to_dataframe().round(4).to_string())

    single, together = change.drop_sel(term="together"), change.sel(term="together")
    gap = 100 * abs(single.sum("term") - together) / abs(together).max("angle")
    angle, mode = np.unravel_index(int(gap.values.argmax()), gap.shape)
    below, above = rest.values[angle, :2]
    geometric_leads[name] = bool(
        (greatest.sel(term=list(TERMS)[1:-1]).max("term") < greatest.sel(term="geometric")).all()
    )
    print(
        f"  the single changes {'' if gap.max() < 100 * ADDS_UP else 'do not '}add up to that of "
        f"all terms within {100 * ADDS_UP:g} % of its greatest value: at most "
        f"{float(gap.max()):.2f} % apart, at {np.degrees(TURN[angle]):.0f} deg in mode {mode + 1}, "
        f"where modes 1 and 2 are {above - below:.2f} Hz apart\n"
        f"  the geometric stiffness weighs most in every mode: {geometric_leads[name]}"
    )
    found[name] = change, 100 * abs(change / (1e3 * rest)).max("angle"), table["resolved"]

    with plots.sheet(plots.grid(len(TERMS), 1, 7.6, sharex=True)) as drawn:
        for axes, term in zip(drawn.panels, TERMS, strict=True):
            for mode in (1, 2, 3):
                at, look = {"term": term, "mode": mode}, plots.series_line(mode - 1)
                axes.plot(np.degrees(TURN), change.sel(at), **look)
                mark = look | {"linestyle": "", "marker": "s", "markersize": 3.5, "mfc": "white"}
                axes.plot(np.degrees(MARKS), exudyn.sel(at), **mark)
            axes.set_title(term.title())
            plots.plain_numbers(axes)
        plots.crank_angle_axis(drawn.panels[-1], np.degrees(TURN))
        drawn.label_x("Crank angle (deg)")
        drawn.label_y("Change of frequency (mHz)")
        handles = [plots.series_handle(number, f"mode {number + 1}") for number in range(3)]
        handles.append(plots.line_handle("Exudyn, same elements", **mark))
        drawn.header(handles, f"{name} four-bar: change by each term at {SPEED:g} rad/s")
    drawn.figure.savefig(f"{name}.png")

with plots.sheet(plots.grid(1, 3, 2.9, sharey=True)) as drawn:
    for mode, axes in enumerate(drawn.panels, start=1):
        for number, (_, relative, resolved) in enumerate(found.values()):
            look = {"marker": plots.series_style(number).marker, "ls": "", "markersize": 5}
            look["color"] = plots.series_style(number).color
            for known, fill in ((True, look["color"]), (False, "white")):
                shown = relative.where(resolved == known).sel(mode=mode)
                axes.semilogy(np.arange(len(TERMS)) + 0.16 * (number - 1), shown, mfc=fill, **look)
        axes.set_xticks(np.arange(len(TERMS)), list(TERMS), rotation=35, ha="right")
        axes.set_title(plots.mode_label([mode]))
        axes.grid(axis="y", color=plots.LIGHT_GREY, lw=0.6)
    drawn.panels[0].set_ylabel("Greatest change of frequency (%)")
    handles = [
        plots.series_handle(n, name, linestyle="", marker="o") for n, name in enumerate(found)
    ]
    handles.append(plots.line_handle("not resolved by the mesh", ls="", marker="o", mfc="white"))
    drawn.header(handles, f"Greatest change over the turn by each term at {SPEED:g} rad/s")
drawn.figure.savefig("greatest_change.png")
