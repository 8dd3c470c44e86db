"""How much of the effect of crank speed does the classical axial force miss?

Turcic & Midha (as in Kumar & Chandrakar, eq. 1.58) stiffen each element by the axial force of
the rigid motion's inertia forces. The same forces also bend the links, which turns the pinned
neighbours and bows the links themselves; at first order in the load that weighs as much. Both
forms are set side by side, without rotation terms, for the steel and the aluminium four-bar:
over the turn, and at two crank angles beside OpenSees as the third opinion: corotational beams at
the equilibrium (64 elements a link), P-Delta for the axial forces.

    python scenarios/15_axial_force_alone.py
"""  # noqa: D400 - a scenario asks a question

import numpy as np
import xarray as xr

import flexmech
from flexmech import plots
from flexmech.verification import verification_cases

ELEMENTS = 16
SPEEDS, TURN = np.array([0.0, 20.0, 40.0]), np.radians(np.arange(0.0, 361.0))
# Equilibrium first: the whole effect, of which the other is a part.
FORMS = {"equilibrium": "equilibrium", "axial": "axial forces alone"}
SUBJECTS = {
    "Four-bars at equilibrium under their inertia forces": "equilibrium",
    "Four-bars with axial forces alone": "axial",
}

opensees = {}
for case in verification_cases():
    if case.subject in SUBJECTS:
        name, angle, speed, _ = case.name.split(", ")
        place = name, SUBJECTS[case.subject], int(angle.split()[0]), int(speed.split()[0])
        opensees[place] = case.expected_values()


def told(values):
    """Numbers in a row, to seven digits."""
    return ", ".join(f"{value:.7g}" for value in np.atleast_1d(values))


caught = {}
for name in ("steel", "aluminium"):
    mechanism = flexmech.load_mechanism(flexmech.example_model(f"{name}_fourbar"))
    engine = flexmech.ReferenceEngine(mechanism, ELEMENTS)
    by_form = []
    for form in FORMS:
        options = {"modes": 3, "prestress": form, "rotation_terms": False}
        by_form.append(flexmech.natural_frequencies(engine, TURN, SPEEDS[:, None], **options))
    places = {"form": list(FORMS), "speed": SPEEDS, "angle": np.degrees(TURN).round(9)}
    places["mode"] = [1, 2, 3]
    frequency = xr.DataArray(by_form, places, tuple(places))
    effect = frequency - frequency.sel(speed=0.0)
    caught[name] = effect.sel(form="axial") / effect.sel(form="equilibrium")
    print(f"{name} four-bar, no rotation terms (Hz; in brackets OpenSees)")
    for angle in (0, 60):
        for speed in (20, 40):
            for form, words in FORMS.items():
                known = opensees.get((name, form, angle, speed))
                beside = "" if known is None else f"  [{told(known)}]"
                values = told(frequency.sel(form=form, angle=angle, speed=speed))
                print(f"  {angle} deg, {speed} rad/s, {words:18s}: {values}{beside}")
            part = told(caught[name].sel(angle=angle, speed=speed).round(2))
            print(f"    part of the effect by axial forces alone: {part}")
    missed = frequency.sel(form="axial") / frequency.sel(form="equilibrium") - 1
    for speed in SPEEDS[1:]:
        off = told(100 * abs(missed.sel(speed=speed)).max("angle").round(6))
        print(f"  over the turn, {speed:g} rad/s: axial forces alone are off by up to {off} %")

    change = 100 * (frequency.sel(speed=SPEEDS[1]) / frequency.sel(speed=0.0) - 1)
    with plots.sheet(plots.grid(3, 1, 4.7, sharex=True)) as drawn:
        for mode, axes in enumerate(drawn.panels, start=1):
            for number, values in enumerate(change.sel(mode=mode).values):
                axes.plot(change["angle"], values, **plots.series_line(number))
            axes.set_title(plots.mode_label([mode]))
            plots.plain_numbers(axes)
        plots.crank_angle_axis(drawn.panels[-1], change["angle"].values)
        drawn.label_x("Crank angle (deg)")
        drawn.label_y("Change of frequency (%)")
        lines = [plots.series_handle(number, words) for number, words in enumerate(FORMS.values())]
        drawn.header(lines, f"{name.title()} four-bar: change from rest to {SPEEDS[1]:g} rad/s")
    drawn.figure.savefig(f"{name}_over_turn.png")
