"""Do the coupler curves of neat resin change their kind in heat and moisture, and where?

Singh & Sanyal 2022 draw ten figures of paths dry and in heat and moisture (saturated, at 80 K by
the text and at 95 K by the captions of Figures 3 and 4) and say of some that a crunode becomes a
cusp, or a cusp a crunode. Each figure is drawn again with the corrected equations, its claim is
judged, and by continuation the moisture is found at which the loop of a crunode is a cusp: there
alone the point stands still. A curve near to that has a bend too sharp to be told from a cusp in a
picture.

    python scenarios/coupler_curves.py [--out results/coupler_curves]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from _common import output_folder, save_pictures
from _coupler_pictures import distance, draw
from _cusp_transitions import CuspTransition
from _neat_resin import (
    CHANGING,
    FIGURES,
    MAIN_PATH,
    PATHS,
    RESINS,
    SAME_LINKAGE,
    coupler_curve,
    neat_resin,
    rise_of,
    saturated,
    transitions,
)
from _neat_resin import Path as StatePath
from _neat_resin_claims import (
    FigureClaim,
    PinPaths,
    Shape,
    judged,
    judged_pin,
    other_claims,
    shape_of,
)
from matplotlib.figure import Figure

from flexmech import (
    CouplerCurve,
    CouplerPoint,
    HygrothermalState,
    InputError,
    Mechanism,
    coupler_paths,
    mechanism_in_state,
)

Found = dict[str, list[tuple[StatePath, tuple[CuspTransition, ...]]]]

PIN_OF_FIGURE = {"3": "A", "4": "B"}


@dataclass(frozen=True)
class Answer:
    """What was found.

    Parameters
    ----------
    claims : list of FigureClaim
    transitions : dict of str to list
        By figure, each path with what happens along it.
    """

    claims: list[FigureClaim]
    transitions: Found


def main(
    out: Path, *, angles: int = 3600, steps: int = 64, drawn: Sequence[str] = FIGURES
) -> Answer:
    """Draw the figures, judge the claims, find the cusps; print, draw, write.

    Parameters
    ----------
    out : Path
        Folder for the pictures and tables.
    angles : int
        Points of a drawn curve.
    steps : int
        Of the continuation along each path.
    drawn : sequence of str
        Figures to draw; the claims of all are judged.

    Returns
    -------
    Answer
    """
    claims: list[FigureClaim] = []
    pictures: dict[str, Figure] = {}
    turn = np.linspace(0, 2 * np.pi, angles + 1)
    found: Found = {f: [(p, transitions(f, p, steps)) for p in PATHS] for f in CHANGING}
    for figure in FIGURES:
        curves = curves_of(figure)
        moved = {name: float(away.max()) for name, away in distance(curves, turn).items()}
        if figure in PIN_OF_FIGURE:
            shapes: dict[str, Shape] = {}
            claims.append(judged_pin(figure, _pin_paths(figure, angles)))
        else:
            shapes = {name: shape_of(curve, angles) for name, curve in curves.items()}
            claims.append(judged(figure, shapes, moved, _at_80_kelvin(found, figure)))
        if figure in drawn:
            pictures[f"figure_{figure}"] = draw(figure, curves, shapes, turn)
    claims += other_claims(refusal(neat_resin("5", "8551-7"), saturated(neat_resin("5"))))
    answer = Answer(claims, found)
    _report(answer)
    save_pictures(pictures, out)
    # Of objects, so that a count that is not known does not turn the others into fractions.
    pd.DataFrame(claims, dtype=object).to_csv(out / "claims.csv", index=False)
    pd.DataFrame(_cusp_rows(found)).to_csv(out / "cusps.csv", index=False)
    return answer


def _at_80_kelvin(found: Found, figure: str) -> Sequence[CuspTransition]:
    paths = found.get(SAME_LINKAGE.get(figure, figure), [])
    return next((changes for path, changes in paths if path is MAIN_PATH), ())


def curves_of(figure: str) -> dict[str, CouplerCurve]:
    """Curves dry and with the links of each resin saturated, hot as the figure has it."""
    models = {resin: neat_resin(figure, resin) for resin in RESINS}
    curves = {"dry": coupler_curve(figure, models["R-914"], HygrothermalState())}
    for resin, model in models.items():
        curves[resin] = coupler_curve(figure, model, saturated(model, rise_of(figure)))
    return curves


def refusal(mechanism: Mechanism, state: HygrothermalState) -> str:
    """What keeps a mechanism out of a state; empty if nothing does."""
    try:
        mechanism_in_state(mechanism, state)
    except InputError as error:
        return str(error)
    return ""


def _pin_paths(figure: str, angles: int) -> PinPaths:
    """Paths of a pin as ``flexmech coupler-curve`` has them, in the caption's state."""
    mechanism = neat_resin(figure)
    state = saturated(mechanism, rise_of(figure))
    turn = np.linspace(0, 2 * np.pi, angles + 1)
    paths = coupler_paths(mechanism, turn, CouplerPoint(0.0, 0.0), state).dataset["pin_position"]
    order = ("state", "crank_angle", "component")
    dry, wet = paths.sel(pin=PIN_OF_FIGURE[figure]).transpose(*order).values
    apart = max(float(np.hypot(*(dry - place).T).min()) for place in wet)
    moved, size = np.hypot(*(wet - dry).T).max(), np.ptp(dry, axis=0).max()
    return PinPaths(apart, float(moved), float(size), state.label, refusal(mechanism, state))


def _cusp_rows(found: Found) -> list[dict[str, object]]:
    rows: list[dict[str, object]] = []
    for figure, paths in found.items():
        for path, changes in paths:
            for change in changes:
                state = path.state(change.parameter)
                x, y = 1e3 * change.position
                rows.append(
                    {
                        "figures": CHANGING[figure],
                        "path": path.name,
                        "temperature_rise_K": f"{state.temperature_rise:.8g}",
                        "moisture_percent": f"{100 * state.moisture:.8g}",
                        "kind": change.kind,
                        "crank_angle_deg": f"{np.degrees(change.crank_angle):.7g}",
                        "x_mm": f"{x:.8g}",
                        "y_mm": f"{y:.8g}",
                        "crunodes_before": change.crunodes_before,
                        "crunodes_after": change.crunodes_after,
                    }
                )
    return rows


def _report(answer: Answer) -> None:
    print("figure   crunodes dry / R-914 / 8551-7   claim: verdict (reason)")
    for claim in answer.claims:
        counts = " / ".join(
            "-" if n is None else str(n) for n in (claim.dry, claim.wet, claim.other)
        )
        print(f"{claim.figure:8s} {counts:>9s}   {claim.claim}: {claim.verdict} ({claim.reason})")
    print("\nwhere the curve of R-914 has a cusp: figures, path, temperature rise, moisture, crank")
    print("angle, crunodes before and after")
    for figure, paths in answer.transitions.items():
        for path, changes in paths:
            print(f"  {CHANGING[figure]:8s} {path.name:33s} {_cusps_in_words(path, changes)}")


def _cusps_in_words(path: StatePath, changes: Sequence[CuspTransition]) -> str:
    words = []
    for change in changes:
        state = path.state(change.parameter)
        words.append(
            f"{state.temperature_rise:.6g} K, {100 * state.moisture:.6g} %, "
            f"{np.degrees(change.crank_angle):.3f} deg, "
            f"{change.crunodes_before} to {change.crunodes_after}"
        )
    return "; ".join(words) or "none"


if __name__ == "__main__":
    main(output_folder(__doc__, "results/coupler_curves"))
