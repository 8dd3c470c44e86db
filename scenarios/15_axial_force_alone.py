"""How much of the effect of crank speed does the classical axial force miss?

Turcic & Midha (as in Kumar & Chandrakar, eq. 1.58) stiffen each element by the axial force of
the rigid motion's inertia forces. The same forces also bend the links, which turns the pinned
neighbours and bows the links themselves; at first order in the load that weighs as much. Both
forms are set side by side, without rotation terms, for the steel and the aluminium four-bar:
against crank speed at two crank angles, and over the turn. OpenSees is the third opinion:
corotational beams at the equilibrium (64 elements a link), P-Delta for the axial forces.

    python scenarios/15_axial_force_alone.py
"""  # noqa: D400 - a scenario asks a question

import numpy as np
import xarray as xr

from flexmech import (
    ComputationError,
    ReferenceEngine,
    example_model,
    load_mechanism,
    natural_frequencies,
    plots,
)
from flexmech.verification import verification_cases

ELEMENTS = 16
ANGLES, SPEEDS = np.radians([0.0, 60.0]), np.arange(0.0, 41.0)
TURN, TURN_SPEEDS = np.radians(np.arange(0.0, 361.0)), np.array([0.0, 20.0, 40.0])
# Equilibrium first: the whole effect, of which the other is a part.
FORMS = {"equilibrium": "equilibrium", "axial": "axial forces alone"}
SUBJECTS = {
    "equilibrium": "Four-bars at equilibrium under their inertia forces",
    "axial": "Four-bars with axial forces alone",
}

opensees = {}
for case in verification_cases():
    for form, subject in SUBJECTS.items():
        if case.subject == subject:
            name, angle, speed, _ = case.name.split(", ")
            place = name, form, int(angle.split()[0]), int(speed.split()[0])
            opensees[place] = case.expected_values()


def frequencies(engine, angles, speeds, without):
    """Hz over form, speed, angle and mode; nan where there is no stable equilibrium."""
    values = np.full((len(FORMS), len(speeds), len(angles), 3), np.nan)
    for number, form in enumerate(FORMS):
        options = {"modes": 3, "prestress": form, "rotation_terms": False}
        try:
            values[number] = natural_frequencies(engine, angles, speeds[:, None], **options)
        except ComputationError:  # in one position at least: each one apart shows in which
            for s, a in np.ndindex(len(speeds), len(angles)):
                try:
                    found = natural_frequencies(engine, angles[a], speeds[s], **options)
                    values[number, s, a] = found
                except ComputationError as error:
                    without.append(str(error))
    places = {"form": list(FORMS), "speed": speeds, "angle": np.degrees(angles).round(9)}
    return xr.DataArray(values, places | {"mode": [1, 2, 3]}, ("form", "speed", "angle", "mode"))


def told(values):
    """Numbers in a row, to seven digits."""
    return ", ".join(f"{value:.7g}" for value in np.atleast_1d(values))


caught, without = {}, []
for name in ("steel", "aluminium"):
    engine = ReferenceEngine(load_mechanism(example_model(f"{name}_fourbar")), ELEMENTS)
    by_speed = frequencies(engine, ANGLES, SPEEDS, without)
    over_turn = frequencies(engine, TURN, TURN_SPEEDS, without)
    rest = by_speed.sel(form="axial", speed=0.0)
    effect = by_speed - rest
    caught[name] = effect.sel(form="axial") / effect.sel(form="equilibrium")
    print(f"{name} four-bar, no rotation terms (Hz; in brackets OpenSees)")
    for angle in (0, 60):
        print(f"  crank angle {angle} deg, at rest: {told(rest.sel(angle=angle))}")
        for speed in (20, 40):
            at = {"angle": angle, "speed": speed}
            for form, words in FORMS.items():
                known = opensees.get((name, form, angle, speed))
                beside = "" if known is None else f"  [{told(known)}]"
                values = told(by_speed.sel(at | {"form": form}))
                print(f"    {speed} rad/s, {words:18s}: {values}{beside}")
            part = caught[name].sel(at).round(2)
            print(f"    {speed} rad/s, part of the effect by axial forces alone: {told(part)}")
    whole = over_turn.sel(form="equilibrium")
    missed = over_turn.sel(form="axial") / whole - 1
    share = (missed**2).mean("angle") / ((whole / whole.sel(speed=0.0) - 1) ** 2).mean("angle")
    for speed in TURN_SPEEDS[1:]:
        for mode in (1, 2, 3):
            off = missed.sel(speed=speed, mode=mode)
            worst = off[int(abs(off).argmax("angle"))]
            print(
                f"  over the turn, {speed:g} rad/s, mode {mode}: axial forces alone are off by up "
                f"to {100 * float(worst):+.2f} %, at {float(worst['angle']):.0f} deg; root mean "
                f"square {float(share.sel(speed=speed, mode=mode)) ** 0.5:.2f} of the whole effect"
            )

    change = 100 * (by_speed / rest - 1)
    with plots.sheet(plots.grid(3, 2, 5.2, sharex=True, sharey="row")) as drawn:
        places = [(mode, angle) for mode in (1, 2, 3) for angle in (0, 60)]
        for axes, (mode, angle) in zip(drawn.panels, places, strict=True):
            for number, form in enumerate(FORMS):
                line = change.sel(form=form, mode=mode, angle=angle)
                axes.plot(SPEEDS, line, **plots.series_line(number))
                for speed in (20, 40):
                    if (name, form, angle, speed) in opensees:
                        value = opensees[name, form, angle, speed][mode - 1]
                        ratio = value / float(rest.sel(mode=mode, angle=angle))
                        look = {"mfc": "white", "mec": plots.series_style(number).color}
                        axes.plot(speed, 100 * (ratio - 1), "o", **look)
            axes.set_title(f"{plots.mode_label([mode])}, crank angle {angle}°")
            plots.plain_numbers(axes)
        drawn.label_x("Crank speed (rad/s)")
        drawn.label_y("Change of frequency (%)")
        lines = [plots.series_handle(number, words) for number, words in enumerate(FORMS.values())]
        opinion = plots.line_handle("OpenSees", marker="o", ls="", mfc="white", mec="black")
        drawn.header([*lines, opinion], f"{name.title()} four-bar: change with crank speed")
    drawn.figure.savefig(f"{name}_by_speed.png")

    change = 100 * (over_turn.sel(speed=TURN_SPEEDS[1]) / over_turn.sel(speed=0.0) - 1)
    with plots.sheet(plots.grid(3, 1, 4.7, sharex=True)) as drawn:
        for mode, axes in enumerate(drawn.panels, start=1):
            both = change.sel(mode=mode).values
            axes.fill_between(change["angle"], *both, color=plots.LIGHT_GREY, lw=0)
            for number, values in enumerate(both):
                axes.plot(change["angle"], values, **plots.series_line(number))
            axes.set_title(plots.mode_label([mode]))
            plots.plain_numbers(axes)
        plots.crank_angle_axis(drawn.panels[-1], change["angle"].values)
        drawn.label_x("Crank angle (deg)")
        drawn.label_y("Change of frequency (%)")
        title = f"{name.title()} four-bar: change from rest to {TURN_SPEEDS[1]:g} rad/s"
        drawn.header(lines, title)
    drawn.figure.savefig(f"{name}_over_turn.png")
print("no equilibrium: " + ("; ".join(without) or "in no position and at no speed"))
