"""How does water get into a link of neat resin, and after what time is it saturated?

Singh & Sanyal 2022 show Fickian diffusion in their Figure 1 and take every link as saturated.
Here are profiles and uptake of the link of Figures 3 and 4 by their equations 1 to 4 (2
corrected): a plate, dry at first, both faces at once at the moisture of equilibrium, 80 K above the
reference. They are held against the exact series, and it is computed how long links as thick as
those of each figure take. The paper prints no diffusivity and no cross-section: those of the model
files are this project's choice, and times go with them.

    python scenarios/fickian_diffusion.py [--out results/fickian_diffusion]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
import pandas as pd
from _common import MODELS, output_folder, save_pictures
from _neat_resin import FIGURES, RISE
from _neat_resin_claims import NO_COUNTS, FigureClaim
from papers._claims import verdict_on

from flexmech import Mechanism, MoistureUptake, moisture_uptake
from flexmech.arrays import FloatArray
from flexmech.hygrothermal import link_diffusion
from flexmech.modelfile import mechanism_from_toml

FIGURE, LINK = "3", "coupler"
HUMID = 1.0
SHARES = (0.5, 0.9, 0.99)
PICTURED = 1.5
"""Time of the picture over that to 99 % of saturation."""
RISES = (0.0, 20.0, 40.0, 60.0, RISE)
# The uptake of Fickian diffusion begins as a straight line over the root of time. It counts as one
# if it is within a percent up to more than half of saturation.
STRAIGHT, HALF = 0.01, 0.5
# Of saturation, between the finite volumes and the series.
EXACT = 1e-3
TERMS = 100
DAY = 86400.0


@dataclass(frozen=True)
class Answer:
    """What was found.

    Parameters
    ----------
    uptake : MoistureUptake
        Of the link of Figures 3 and 4.
    off_series : float
        Greatest distance of a profile from the exact series, over saturation.
    straight_to : float
        Share of saturation up to which the uptake goes with the root of time.
    days : pandas.DataFrame
        Days to each share of saturation, by figure and temperature rise.
    claims : list of FigureClaim
    """

    uptake: MoistureUptake
    off_series: float
    straight_to: float
    days: pd.DataFrame
    claims: list[FigureClaim]


def main(out: Path, *, rises: Sequence[float] = RISES) -> Answer:
    """Diffuse, hold against the series, judge; print, draw, write.

    Parameters
    ----------
    out : Path
        Folder for the picture and the tables.
    rises : sequence of float
        Temperature rises in K, ascending, at which times are compared; the last one is pictured.

    Returns
    -------
    Answer
    """
    mechanism = plate(FIGURE)
    hot = mechanism.reference_temperature + rises[-1]
    end = PICTURED * times_to_shares(FIGURE, rises[-1])[-1]
    uptake = moisture_uptake(mechanism, HUMID, end, hot, LINK)
    days = pd.DataFrame(_days(rises))
    off_series, straight_to = _off_series(uptake, mechanism, hot), _straight_to(uptake)
    claims = [
        _of_figure(uptake, straight_to),
        _of_equations(off_series),
        _of_temperature(days),
    ]
    answer = Answer(uptake, off_series, straight_to, days, claims)
    _report(answer)
    save_pictures({"moisture": uptake.plot()}, out)
    days.to_csv(out / "days.csv", index=False)
    told = pd.DataFrame(claims)[["figure", "claim", "verdict", "reason"]]
    told.to_csv(out / "claims.csv", index=False)
    return answer


@lru_cache
def plate(figure: str) -> Mechanism:
    """Mechanism of a figure whose links take up water through both faces, as equation 4 has it."""
    file = MODELS / f"neat_resin_figure_{'3' if figure == '4' else figure}.toml"
    text = file.read_text(encoding="utf-8")
    return mechanism_from_toml(
        text.replace("exposed_sides = true", "exposed_sides = false"), file.name
    )


def slab(mechanism: Mechanism, temperature: float) -> tuple[float, float]:
    """Thickness of the coupler in m, and its diffusivity in m^2/s at a temperature in K."""
    (layer,) = link_diffusion(mechanism, LINK).layers
    return layer.thickness, float(layer.diffusivity.at(temperature))


@lru_cache
def times_to_shares(figure: str, rise: float) -> tuple[float, ...]:
    """Times in s after which the coupler of a figure has taken up shares of its water."""
    mechanism = plate(figure)
    # The exposure has no part in them.
    at = mechanism.reference_temperature + rise
    found = moisture_uptake(mechanism, HUMID, DAY, at, LINK).dataset.sel(link=LINK)
    return tuple(found["time_to_share"].sel(share=list(SHARES)).values.tolist())


def exact_profile(place: FloatArray, fourier: float) -> FloatArray:
    """Moisture over that at the faces, by the series that solves equations 2 to 4.

    Parameters
    ----------
    place : ndarray, shape (n,)
        From the middle, over half the thickness.
    fourier : float
        Time over ``l^2 / D``, above zero.

    Returns
    -------
    ndarray, shape (n,)
    """
    odd = 2 * np.arange(TERMS) + 1
    waves = odd * np.pi / 2
    amplitudes = 2 * (-1.0) ** np.arange(TERMS) / waves * np.exp(-(waves**2) * fourier)
    return 1 - np.cos(np.multiply.outer(place, waves)) @ amplitudes


def _off_series(uptake: MoistureUptake, mechanism: Mechanism, temperature: float) -> float:
    data, (thickness, diffusivity) = uptake.dataset.sel(link=LINK), slab(mechanism, temperature)
    saturation = link_diffusion(mechanism, LINK).saturation[0]
    place = data["place"].values / (thickness / 2)
    apart = [
        np.abs(
            data["profile"].sel(profile_time=time).values / saturation
            - exact_profile(place, time * diffusivity / (thickness / 2) ** 2)
        )
        for time in data["profile_time"].values
    ]
    return float(np.max(apart))


def _straight_to(uptake: MoistureUptake) -> float:
    """Greatest share of saturation up to which the uptake is the law of the root of time."""
    data = uptake.dataset.sel(link=LINK).isel(time=slice(1, None))
    bent = np.abs(data["uptake"] / data["short_time_uptake"] - 1).values > STRAIGHT
    first = int(np.argmax(bent)) if bent.any() else bent.size
    return float(data["uptake"].values[first - 1]) if first else 0.0


def _days(rises: Sequence[float]) -> list[dict[str, object]]:
    """Days of links as thick as those of each figure to shares of saturation, cold and hot."""
    rows: list[dict[str, object]] = []
    first: dict[float, str] = {}
    for figure in FIGURES:
        mechanism = plate(figure)
        for rise in rises:
            thickness, _ = slab(mechanism, mechanism.reference_temperature + rise)
            # Links that are equally thick take equally long.
            times = times_to_shares(first.setdefault(thickness, figure), rise)
            of_shares = {
                f"days_to_{100 * share:g}_percent": time / DAY
                for share, time in zip(SHARES, times, strict=True)
            }
            named = {"figure": figure, "thickness_mm": 1e3 * thickness, "temperature_rise_K": rise}
            rows.append({**named, **of_shares})
    return rows


def _of_figure(uptake: MoistureUptake, straight_to: float) -> FigureClaim:
    last = float(uptake.dataset["uptake"].sel(link=LINK)[-1])
    holds = straight_to > HALF and SHARES[-1] < last < 1 + EXACT
    reason = (
        f"the uptake goes with the root of time within {100 * STRAIGHT:g} % up to "
        f"{100 * straight_to:.0f} % of saturation, and reaches {100 * last:.2f} %"
    )
    return FigureClaim("1", "Fickian diffusion", *NO_COUNTS, verdict_on(holds), reason)


def _of_equations(off_series: float) -> FigureClaim:
    claim = "equations 1 to 4, 2 corrected, by finite volumes"
    reason = f"profiles are off the exact series by at most {off_series:.1e} of saturation"
    return FigureClaim("section 2", claim, *NO_COUNTS, verdict_on(off_series < EXACT), reason)


def _of_temperature(days: pd.DataFrame) -> FigureClaim:
    own = days[days["figure"] == FIGURE]
    times = own["days_to_90_percent"].to_numpy()
    reason = "; ".join(
        f"+{rise:g} K: 90 % after {time:.3g} d"
        for rise, time in zip(own["temperature_rise_K"], times, strict=True)
    )
    claim = "at higher temperature the rate of absorption is higher"
    holds = bool(np.all(np.diff(times) < 0))
    return FigureClaim("section 2", claim, *NO_COUNTS, verdict_on(holds), reason)


def _report(answer: Answer) -> None:
    print(answer.uptake.summary())
    print("time to 50, 90 and 99 % of saturation, water through both faces:")
    rises = answer.days["temperature_rise_K"]
    ends = answer.days[rises.isin((rises.min(), rises.max()))]
    for (thickness, rise), alike in ends.groupby(["thickness_mm", "temperature_rise_K"]):
        several = "s" if len(alike) > 1 else ""
        times = (alike[f"days_to_{100 * share:g}_percent"].iloc[0] for share in SHARES)
        print(
            f"  {thickness:g} mm (figure{several} {', '.join(alike['figure'])}), +{rise:g} K: "
            + " / ".join(map(_duration, times))
        )
    for claim in answer.claims:
        print(f"{claim.figure}: {claim.claim}: {claim.verdict} ({claim.reason})")


def _duration(days: float) -> str:
    return f"{days:.3g} d" if days < 1000 else f"{days / 365.25:.3g} years"


if __name__ == "__main__":
    main(output_folder(__doc__, "results/fickian_diffusion"))
