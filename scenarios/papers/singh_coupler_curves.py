"""Do the coupler curves of neat resin change their kind in heat and moisture, and where?

Singh & Sanyal 2022 draw ten figures of paths dry and in heat and moisture (saturated, at 80 K by
the text and at 95 K by the captions of Figures 3 and 4) and say of some that a crunode becomes a
cusp, or a cusp a crunode. Each figure is drawn again with the corrected equations, its claim is
judged, and by continuation the moisture is found at which the loop of a crunode is a cusp: there
alone the point stands still. A curve near to that has a bend too sharp to be told from a cusp in a
picture.

    python scenarios/papers/singh_coupler_curves.py
"""  # noqa: D400 - a scenario asks a question

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pandas as pd
from cusp_transitions import cusp_transitions
from paper_claims import verdict_on
from singh_linkages import (
    FIGURES,
    RESINS,
    RISE,
    FigureClaim,
    coupler_curve,
    deviates,
    neat_resin,
    rise_of,
    saturated,
)

from flexmech import (
    CouplerPoint,
    HygrothermalState,
    InputError,
    coupler_paths,
    double_points,
    mechanism_in_state,
    plots,
)

TURN = np.linspace(0, 2 * np.pi, 3601)
CLAIMS = {
    "3": "path of A in heat and moisture deviates",
    "4": "path of B in heat and moisture deviates",
    "5": "coupler curve deviates",
    "6": "figure-eight with a crunode",
    "7": "teardrop cusp",
    "8": "figure-eight crunode dry becomes a cusp wet",
    "9": "teardrop cusp",
    "10": "teardrop cusp dry becomes a figure-eight crunode wet",
    "11": "kidney bean",
    "12": "crescent",
}
# Looks dry and wet that the words claim. A caption with one word says it of every curve that it
# draws; that of Figure 5 has none.
LOOKS = {
    "6": ("crunode", "crunode"),
    "7": ("cusp", "cusp"),
    "8": ("crunode", "cusp"),
    "9": ("cusp", "cusp"),
    "10": ("cusp", "crunode"),
    "11": ("smooth", "smooth"),
    "12": ("cusp", "cusp"),
}
# A bend whose radius is a smaller part of the curve's extent looks like a cusp.
SHARP = 1e-3
# Concave stretch: kidney beans and crescents turn inward once.
CONCAVE_ONCE = ("11", "12")
# The caption of Figure 8 names no material, the others "different material": both resins. Figure
# 8 is judged on R-914, which alone takes up the 7 % that the paper works with.
JUDGED_ON = {"8": ("R-914",)}
PINS = {"3": "A", "4": "B"}
# Linkages whose number of crunodes changes, by one of the figures that show them.
CHANGING = {"5": "5", "8": "7 and 8", "10": "9 and 10"}
STEEL = 11.7e-6  # 1/K
MAIN_PATH = "moistened at +80 K"
# Rise in K, moisture reached, whether the resin has its wet expansion from the start, as the
# paper's equations do with one coefficient, and the frame's expansion (None: of the wet resin).
PATHS = {
    "heated dry": (RISE, 0.0, False, None),
    MAIN_PATH: (RISE, 0.07, False, None),
    "moistened at +80 K, wet expansion": (RISE, 0.07, True, None),
    "moistened, not heated": (0.0, 0.07, False, None),
    "heated dry, steel frame": (RISE, 0.0, False, STEEL),
    "moistened at +80 K, steel frame": (RISE, 0.07, False, STEEL),
}


class Shape(NamedTuple):
    """What a coupler curve looks like."""

    crunodes: tuple  # and cusps, if the curve has one to the last digit
    inflections: int
    bend_angle: float  # crank angle in rad of the sharpest bend
    bend_radius: float  # radius of curvature there in m
    size: float  # greater extent of the curve in m

    @property
    def look(self):
        """The shape in a word."""
        if self.crunodes:
            return "crunode"
        return "cusp" if self.bend_radius < SHARP * self.size else "smooth"

    def __str__(self):
        if self.crunodes:
            return f"{len(self.crunodes)} crunode{'s' * (len(self.crunodes) > 1)}"
        return (
            f"no crunode, {self.inflections} inflections, sharpest bend of radius "
            f"{1e3 * self.bend_radius:.2g} mm in {1e3 * self.size:.4g} mm"
        )


def shape_of(curve):
    """Shape of a curve over a full turn of the crank."""
    turn = TURN[:-1]
    curvature = curve.curvature(turn)
    turning = np.sign(curvature)
    step, middle = turn[1], turn[np.abs(curvature).argmax()]
    for _ in range(3):  # each search is fifty times as fine as the one before
        near = np.linspace(middle - step, middle + step, 101)
        bent = np.abs(curve.curvature(near))
        step, middle = near[1] - near[0], near[bent.argmax()]
    inflections = int(np.sum(turning != np.roll(turning, 1)))
    size = np.ptp(curve.position(turn), axis=0).max()
    crossings = double_points(curve.linkage, curve.point)
    return Shape(crossings, inflections, middle, 1 / bent.max(), size)


def refusal(mechanism, state):
    """What keeps a mechanism out of a state; empty if nothing does."""
    try:
        mechanism_in_state(mechanism, state)
    except InputError as error:
        return str(error)
    return ""


def cusps_on(figure, path):
    """States and cusps along a path, where the curve of a figure of R-914 has one."""
    rise, moisture, wet_expansion, frame = PATHS[path]
    mechanism = neat_resin(figure, wet_expansion=wet_expansion)
    if frame is not None:
        mechanism = replace(mechanism, ground_thermal_expansion=frame)

    def state(part):
        return HygrothermalState(rise if moisture else part * rise, part * moisture)

    def family(part):
        curve = coupler_curve(figure, mechanism, state(part))
        return curve.linkage, curve.point

    return [(state(cusp.parameter), cusp) for cusp in cusp_transitions(family, 0.0, 1.0)]


def curves_of(figure):
    """Curves dry and with the links of each resin saturated, hot as the figure has it."""
    curves = {"dry": coupler_curve(figure, neat_resin(figure), HygrothermalState())}
    for resin in RESINS:
        mechanism = neat_resin(figure, resin)
        state = saturated(mechanism, rise_of(figure))
        curves[resin] = coupler_curve(figure, mechanism, state)
    return curves


def judged_pin(figure):
    """Claim of Figure 3 or 4 in its caption's state.

    Along an arc a pin may move and its path not deviate: the distance of the paths counts.
    """
    mechanism = neat_resin(figure)
    state = saturated(mechanism, rise_of(figure))
    paths = coupler_paths(mechanism, TURN, CouplerPoint(0.0, 0.0), environment=state).dataset[
        "pin_position"
    ]
    dry, wet = paths.sel(pin=PINS[figure]).transpose("state", "crank_angle", "component").values
    apart = max(float(np.hypot(*(dry - place).T).min()) for place in wet)
    moved, size = np.hypot(*(wet - dry).T).max(), np.ptp(dry, axis=0).max()
    holds, unknown = deviates(apart, size), refusal(mechanism, state)
    reason = (
        f"R-914 at {state.label} {'deviates' if holds else 'does not deviate'}: its path is up to "
        f"{1e3 * apart:.4g} mm off the dry one of {1e3 * size:.4g} mm, the pin moves by up to "
        f"{1e3 * moved:.4g} mm"
    )
    if unknown:
        reason += f"; a path needs no stiffness, which is not known there: {unknown}"
    return FigureClaim(figure, CLAIMS[figure], verdict_on(holds), reason)


def judged(figure, shapes, moved, cusps):
    """Claim of a figure from 5 on: all that its caption says must hold for every curve it draws."""
    resins, failed = JUDGED_ON.get(figure, RESINS), []
    if figure in LOOKS:
        wet = {f"{resin} wet": shapes[resin] for resin in resins}
        said = dict.fromkeys(wet, LOOKS[figure][1]) | {"dry": LOOKS[figure][0]}
        for name, shape in {"dry": shapes["dry"], **wet}.items():
            if shape.look != said[name]:
                failed.append(f"{name} is no {said[name]} but a {shape.look}")
    for resin in resins:
        if not deviates(moved[resin], shapes["dry"].size):
            failed.append(f"{resin} does not deviate")
        turns = {shapes[name].inflections for name in ("dry", resin)}
        if figure in CONCAVE_ONCE and turns != {2}:
            failed.append(f"{resin} is not concave once")
    reasons = [f"against the caption: {', '.join(failed)}"] if failed else []
    reasons += ["judged on R-914: no material is named"] if figure in JUDGED_ON else []
    reasons.append(f"dry {shapes['dry']}")
    for resin, distance in moved.items():
        reasons.append(f"{resin} wet {shapes[resin]}, point moved by up to {1e3 * distance:.4g} mm")
    for state, _ in cusps:
        reasons.append(f"a cusp in the strict sense at {100 * state.moisture:.4g} % alone")
    counts = [len(shape.crunodes) for shape in shapes.values()]
    return FigureClaim(figure, CLAIMS[figure], verdict_on(not failed), "; ".join(reasons), *counts)


def loop(double):
    """Crank angles of the shorter way between the two passages of a crunode."""
    first, second = double.crank_angles
    if second - first > np.pi:
        first, second = second, first + 2 * np.pi
    return np.linspace(first, second, 181)


def draw(figure, curves, shapes, away):
    """Curves of a figure; beside them a close-up where crunodes come or go, or the distance."""
    close_up = len({len(shape.crunodes) for shape in shapes.values()}) > 1
    with plots.sheet(plots.grid(1, 2, 3.3)) as drawn:
        left, right = drawn.panels
        near = [shape.bend_angle + np.linspace(-0.05, 0.05, 801) for shape in shapes.values()]
        finer, seen = np.sort(np.concatenate([TURN, *near])), []
        for number, (name, curve) in enumerate(curves.items()):
            label = name if name == "dry" else f"{name}, +{rise_of(figure):g} K, saturated"
            line, colour = plots.series_line(number), plots.series_style(number).color
            for axes in (left, right) if close_up else (left,):
                axes.plot(*(1e3 * curve.position(finer).T), **line, label=label)
                for double in shapes[name].crunodes if shapes else ():
                    axes.plot(*(1e3 * double.position), "o", fillstyle="none", color=colour)
            if close_up:
                bend = np.array([shapes[name].bend_angle])
                if not shapes[name].crunodes:
                    right.plot(*(1e3 * curve.position(bend).T), "x", color=colour)
                spans = [loop(double) for double in shapes[name].crunodes] or [bend]
                seen += [1e3 * curve.position(span) for span in spans]
            elif name in away:
                right.plot(np.degrees(TURN), 1e3 * away[name], **line)
        left.set(
            title=f"Path of {'pin ' * (figure in PINS)}{PINS.get(figure, 'the coupler point')}"
        )
        left.set(xlabel="x (mm)", ylabel="y (mm)")
        left.set_aspect("equal", adjustable="datalim")
        if close_up:
            low, high = np.min(np.concatenate(seen), axis=0), np.max(np.concatenate(seen), axis=0)
            middle, half = (low + high) / 2, 0.7 * (high - low).max()
            right.set(xlim=(middle[0] - half, middle[0] + half), xlabel="x (mm)", title="Close-up")
            right.set(ylim=(middle[1] - half, middle[1] + half), ylabel="y (mm)", box_aspect=1)
        else:
            right.set(ylabel="Distance from the dry place (mm)", xlabel="Crank angle (deg)")
            right.set(title="Moved at the same crank angle", ylim=(0.0, None))
            plots.crank_angle_axis(right, np.degrees(TURN), narrow=True)
        handles = left.get_legend_handles_labels()[0]
        if shapes:
            handles.append(plots.line_handle("crunode", marker="o", ls="", fillstyle="none"))
        if close_up:
            handles.append(plots.line_handle("sharpest bend without one", marker="x", ls=""))
        drawn.header(handles, f"Figure {figure} of Singh & Sanyal 2022: {CLAIMS[figure]}")
    drawn.figure.savefig(f"figure_{figure}.png")


cusps = {figure: {path: cusps_on(figure, path) for path in PATHS} for figure in CHANGING}
of_linkage = {
    figure: cusps[first] for first, known in CHANGING.items() for figure in known.split(" and ")
}
claims = []
for figure in FIGURES:
    curves, shapes = curves_of(figure), {}
    places = {name: curve.position(TURN) for name, curve in curves.items()}
    away = {resin: np.hypot(*(places[resin] - places["dry"]).T) for resin in RESINS}
    if figure in PINS:
        claims.append(judged_pin(figure))
    else:
        shapes = {name: shape_of(curve) for name, curve in curves.items()}
        moved = {resin: float(distance.max()) for resin, distance in away.items()}
        claims.append(judged(figure, shapes, moved, of_linkage.get(figure, {}).get(MAIN_PATH, [])))
    draw(figure, curves, shapes, away)
unknown = "the paper prints no property of resin 3502"
claims.append(FigureClaim("3 and 4", "paths of A and B, 3502", verdict_on(None), unknown))
water = refusal(neat_resin("5", "8551-7"), saturated(neat_resin("5")))
reason = water or "8551-7 takes up as much"
claims.append(FigureClaim("all", "7 % moisture in 8551-7", verdict_on(not water), reason))

print("figure: claim: verdict (reason); crunodes dry / R-914 / 8551-7")
for claim in claims:
    counts = [claim.dry, claim.wet, claim.other]
    print(claim, "" if None in counts else " / ".join(map(str, counts)))
print(
    "\nwhere the curve of R-914 has a cusp: figures, path, temperature rise, moisture, crank angle,"
)
print("crunodes before and after")
rows = []
for figure, paths in cusps.items():
    for path, found in paths.items():
        print(f"  {CHANGING[figure]:8s} {path:33s} {'' if found else 'none'}", end="")
        for state, cusp in found:
            angle, (x, y) = np.degrees(cusp.crank_angle), 1e3 * cusp.position
            print(
                f"{state.temperature_rise:.6g} K, {100 * state.moisture:.6g} %, {angle:.3f} deg, "
                f"{cusp.crunodes_before} to {cusp.crunodes_after}",
                end="",
            )
            rows.append(
                {
                    "figures": CHANGING[figure],
                    "path": path,
                    "temperature_rise_K": state.temperature_rise,
                    "moisture_percent": 100 * state.moisture,
                    "crank_angle_deg": angle,
                    "x_mm": x,
                    "y_mm": y,
                    "crunodes_before": cusp.crunodes_before,
                    "crunodes_after": cusp.crunodes_after,
                }
            )
        print()
# Objects: a count that is not known does not turn the others into fractions.
pd.DataFrame(claims, dtype=object).to_csv("claims.csv", index=False)
pd.DataFrame(rows).to_csv("cusps.csv", index=False, float_format="%.8g")
