"""By how much do heat and moisture turn coupler and rocker?

Singh & Sanyal 2022 take the four-bar of their Figures 3 and 4 and say that the angles of links 3
and 4 change in heat and moisture; they print no value. Here are the changes over the turn of the
crank. Beside them stand the paper's own equations of section 3: corrected they give the same
angles, as printed that of the coupler has no root. Links of one resin swell alike, so that all of
the change comes from the frame, which is of metal and takes up no water.

    python scenarios/swollen_angles.py [--out results/swollen_angles]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from _common import output_folder, save_pictures
from _neat_resin import RISE, neat_resin, resin_of, rise_of, saturated
from _neat_resin_claims import NO_COUNTS, FigureClaim, deviates
from papers._claims import verdict_on

from flexmech import CouplerPoint, HygrothermalState, Mechanism, coupler_paths, plots
from flexmech.arrays import FloatArray

FIGURE, SECTION = "3", "section 3"
SHOWN = (0, 90, 180, 270)
PIN_A = CouplerPoint(0.0, 0.0)
"""Any point will do: the angles are asked for."""
EXACT = 1e-9
"""In deg, between two ways to the same angle."""


@dataclass(frozen=True)
class Answer:
    """What was found.

    Parameters
    ----------
    angles : xarray.Dataset
        ``angle`` (state, crank_angle, link) in rad, of the dry linkage first, and ``length``
        (state, member) in m.
    change : xarray.DataArray
        Against the dry linkage in deg, over (state, crank_angle, link).
    by_equal_frame : float
        Greatest change in deg where the frame swells as the links do.
    claims : list of FigureClaim
    """

    angles: xr.Dataset
    change: xr.DataArray
    by_equal_frame: float
    claims: list[FigureClaim]


def main(out: Path, *, angles: int = 720) -> Answer:
    """Compute the changes and judge what is said of them; print, draw, write.

    Parameters
    ----------
    out : Path
        Folder for the picture and the tables.
    angles : int
        Steps of the turn, a multiple of four.

    Returns
    -------
    Answer
    """
    turn = np.linspace(0, 2 * np.pi, angles + 1)
    found = xr.concat([*_each_state(turn)], "state", data_vars="minimal", join="exact")
    found.attrs["mechanism"] = "Four-bar of neat resin, Figures 3 and 4 of Singh & Sanyal 2022"
    change = _change(found["angle"])
    claims = [_of_angles(change), *(_of_equations(found, printed=p) for p in (False, True))]
    answer = Answer(found, change, _by_equal_frame(turn), claims)
    _report(answer)
    save_pictures({"angles": plots.plot_coupler_angles(found)}, out)
    _table(change).to_csv(out / "changes.csv", index=False)
    told = pd.DataFrame(claims)[["figure", "claim", "verdict", "reason"]]
    told.to_csv(out / "claims.csv", index=False)
    return answer


def _each_state(turn: FloatArray) -> list[xr.Dataset]:
    """Angles and lengths dry, and with saturated links of each resin, hot as text and caption."""
    hot = ("R-914", RISE), ("R-914", rise_of(FIGURE)), ("8551-7", RISE)
    states: list[xr.Dataset] = []
    for resin, rise in hot:
        mechanism = neat_resin(FIGURE, resin)
        state = saturated(mechanism, rise)
        dry, wet = in_state(mechanism, state, turn)
        states += [] if states else [dry]
        states.append(wet.assign_coords(state=f"{resin}, {state.label}"))
    return states


def in_state(
    mechanism: Mechanism, state: HygrothermalState, turn: FloatArray
) -> tuple[xr.Dataset, xr.Dataset]:
    """Angles of coupler and rocker, and lengths, dry and in a state."""
    paths = coupler_paths(mechanism, turn, PIN_A, state).dataset[["angle", "length"]]
    dry, wet = (paths.isel(state=number).drop_vars("name") for number in (0, 1))
    return dry, wet


def _change(angle: xr.DataArray) -> xr.DataArray:
    """In deg against the first state; none is near to half a turn."""
    change = np.degrees(angle - angle.isel(state=0, drop=True)).isel(state=slice(1, None))
    return (change + 180.0) % 360.0 - 180.0


def _of_angles(change: xr.DataArray) -> FigureClaim:
    """In every state, by more than a drawing hides: the end of a link over its length."""
    most = abs(change).max(["crank_angle", "link"])
    holds = all(deviates(float(np.radians(each)), 1.0) for each in most.values)
    words = (f"{name}: by up to {float(most.sel(state=name)):.4g} deg" for name in _of(most))
    claim = "theta3 and theta4 change in heat and moisture"
    return FigureClaim(SECTION, claim, *NO_COUNTS, verdict_on(holds), "; ".join(words))


def _of(over_states: xr.DataArray) -> list[str]:
    return [str(name) for name in over_states["state"].values]


def paper_angles(
    lengths: tuple[float, float, float, float], theta2: FloatArray, *, printed: bool
) -> FloatArray:
    """Angles of coupler and rocker by the equations of section 3.

    Parameters
    ----------
    lengths : tuple of float
        a, b, c and d in any unit.
    theta2 : ndarray, shape (A,)
        Crank angles in rad.
    printed : bool
        Whether as printed; else F ends with less b d, and D and F have K' = (a^2 + b^2 - c^2 +
        d^2) / 2 in place of K.

    Returns
    -------
    ndarray, shape (A, 2)
        In rad, of the open branch; not a number where a quadratic has no root.
    """
    a, b, c, d = lengths
    cosine, sine = np.cos(theta2), np.sin(theta2)
    k = (a**2 - b**2 + c**2 + d**2) / 2
    k_coupler = k if printed else (a**2 + b**2 - c**2 + d**2) / 2
    coupler = (
        k_coupler - a * (d + b) * cosine + b * d,
        2 * a * b * sine,
        k_coupler - a * (d - b) * cosine + (b * d if printed else -b * d),
    )
    rocker = k - a * (d - c) * cosine - c * d, -2 * a * c * sine, k - a * (d + c) * cosine + c * d
    return np.stack([_root(*coupler, +1), _root(*rocker, -1)], axis=-1)


def _root(first: FloatArray, second: FloatArray, third: FloatArray, sign: int) -> FloatArray:
    """Angle whose half has the tangent that a quadratic asks for."""
    under = second**2 - 4 * first * third
    root = np.sqrt(np.where(under >= 0, under, np.nan))
    return np.asarray(2 * np.arctan2(-second + sign * root, 2 * first))


def _of_equations(found: xr.Dataset, *, printed: bool) -> FigureClaim:
    """Whether the paper's equations give the angles, in all states and at all crank angles."""
    turn, apart = found["crank_angle"].values, []
    for name in _of(found["angle"]):
        length = found["length"].sel(state=name)
        lengths = [float(length.sel(member=m)) for m in ("crank", "coupler", "rocker", "ground")]
        own = found["angle"].sel(state=name).transpose("crank_angle", "link").values
        by_paper = paper_angles(tuple(lengths), turn, printed=printed)
        apart.append(np.abs(np.degrees(np.angle(np.exp(1j * (by_paper - own))))))
    gaps = np.array(apart)
    rootless = np.isnan(gaps).any(axis=0)
    words = []
    for number, link in enumerate(found["link"].values):
        if (count := int(rootless[:, number].sum())) > 0:
            words.append(f"{link}: no root at {count} of {len(turn)} crank angles")
        else:
            words.append(f"{link}: off by at most {gaps[..., number].max():.1e} deg")
    holds = bool(np.all(gaps <= EXACT))
    claim = f"equations of theta3 and theta4, {'as printed' if printed else 'corrected'}"
    return FigureClaim(SECTION, claim, *NO_COUNTS, verdict_on(holds), "; ".join(words))


def _by_equal_frame(turn: FloatArray) -> float:
    """What is left of the change, in deg, where the frame swells as the links do."""
    mechanism = neat_resin(FIGURE)
    state = saturated(mechanism)
    strain = resin_of(mechanism).free_strain(state.temperature_rise, state.moisture)
    alike = replace(mechanism, ground_thermal_expansion=strain / state.temperature_rise)
    change = _change(xr.concat([path["angle"] for path in in_state(alike, state, turn)], "state"))
    return float(abs(change).max())


def _table(change: xr.DataArray) -> pd.DataFrame:
    values = change.transpose("state", "crank_angle", "link").values.round(9)
    columns = {
        f"{link}_deg": values[..., n].ravel() for n, link in enumerate(change["link"].values)
    }
    angles = np.degrees(change["crank_angle"].values).round(9)
    first = {
        "state": np.repeat(_of(change), len(angles)),
        "crank_angle_deg": np.tile(angles, len(values)),
    }
    return pd.DataFrame(first | columns)


def _report(answer: Answer) -> None:
    change = answer.change
    print("change of the angles of coupler / rocker against the dry linkage, in deg")
    print(f"{'at crank angle':28s}" + "".join(f"{degrees:>21d} deg" for degrees in SHOWN))
    for name in _of(change):
        shown = change.sel(state=name).sel(crank_angle=np.radians(SHOWN), method="nearest")
        pairs = shown.transpose("crank_angle", "link").values
        print(f"{name:28s}" + "".join(f"{c:+13.5f} / {r:+.5f}" for c, r in pairs))
    for name in _of(change):
        for link in change["link"].values:
            own = change.sel(state=name, link=link)
            angles = np.degrees(own["crank_angle"].values)
            places = int(own.values.argmin()), int(own.values.argmax())
            ends = (f"{own.values[place]:+.4f} deg (at {angles[place]:g})" for place in places)
            words = " to ".join(ends)
            print(f"{name}, {link}: {words}")
    print(f"where the frame swells as the links do: at most {answer.by_equal_frame:.0e} deg")
    for claim in answer.claims:
        print(f"{claim.figure}: {claim.claim}: {claim.verdict} ({claim.reason})")


if __name__ == "__main__":
    main(output_folder(__doc__, "results/swollen_angles"))
