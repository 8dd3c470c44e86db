"""Run a scenario as the pages show it, and keep the numbers that hold it.

Used as ``python -m making.scenario_numbers NAME FOLDER``: the scenario writes its pictures to the
folder, and ``numbers.json`` there has its numbers by the names of
``scenarios/expected_numbers.toml``; ``number`` is the one that its page states.
"""

from __future__ import annotations

import importlib
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

__all__ = ["COARSER", "KEPT", "NUMBERS"]

KEPT = "numbers.json"
"""File of the numbers, beside the pictures."""
COARSER: dict[str, dict[str, Any]] = {
    "composite_thresholds": {
        "cases": (3,),
        "checked_case": 3,
        "speeds": np.linspace(0.63, 0.67, 6),
    },
    "critical_speeds": {
        "names": ("aluminium",),
        "speeds": np.linspace(16.0, 24.0, 17),
        "compared": (20.0,),
        "elements": 4,
    },
    "damping_found_back": {"elements": 4},
    "flexible_slider_crank": {"small": (), "elements": 4, "step": 2e-5},
    "frames_and_stability": {"elements": 4},
    "hammer_noise": {"draws": 5},
    "hammer_twelve_positions": {"cases": (3,), "elements": 2},
    "hygrothermal_frequencies": {
        "crank_angles": np.radians(np.arange(0.0, 361.0, 15.0)),
        "moistures": np.linspace(0.0, 0.0425, 3),
        "times": 86400.0 * np.array([0.0, 1.0, 4.0, 9.0]),
        "positions": np.radians([0.0, 90.0, 180.0, 270.0]),
        "elements": 4,
    },
    "inertial_terms": {
        "names": ("moist_composite",),
        "turn": np.radians(np.arange(0.0, 361.0, 20.0)),
        "marks": np.radians([0.0, 20.0]),
        "elements": 12,
    },
    "moisture_and_stability": {"speeds": np.arange(152.0, 180.1, 0.5)},
    "quiet_stop": {"times": np.linspace(0.1, 0.3, 11), "elements": 4},
    "running_fourbars": {
        "names": ("aluminium", "moist_composite", "wet_composite"),
        "speeds": (20.0,),
        "revolutions": 2.0,
        "elements": 4,
        "samples": 180,
    },
    "running_hammer_test": {"elements": 2, "damping_ratio": 0.02},
    "soft_frame": {"frequencies": np.geomspace(1.0, 60.0, 9), "elements": 2},
    "six_bars": {"crank_angles": np.radians(np.arange(0.0, 361.0, 10.0)), "elements": 4},
    "stability_maps": {
        "names": ("aluminium",),
        "speeds": {"aluminium": np.arange(80.0, 90.1, 0.5)},
        "ratios": {"aluminium": np.array([0.0, 0.005, 0.01, 0.02, 0.03])},
        "elements": 4,
    },
}
"""Settings of scenarios that alone take finer ones and minutes."""


def best_stacking_under_scatter(best: Any) -> dict[str, Any]:
    wide, narrow = (one for (case, _), one in best.items() if case == 3)
    return {
        "number": 100 * wide.cost,
        "cost by standard deviations over that by limits": wide.cost / narrow.cost,
        "best stacking is carbon alone": wide.stacking == narrow.stacking == "[C/C/C/C/C]",
    }


def composite_thresholds(answer: Any) -> dict[str, Any]:
    (found,) = answer.maps
    across, through = answer.checks
    return {
        "number": found.threshold(0.001),
        "edges off their scale, across the width": across.edges,
        "edges off their scale, through the thickness": through.edges,
        "damping that closes the band": found.first(0.001)["closing"],
    }


def coupler_curves(answer: Any) -> dict[str, Any]:
    captions = [claim for claim in answer.claims if claim.figure.isdigit()]
    (cusp,) = {path.name: cusps for path, cusps in answer.transitions["5"]}[
        "moistened at +80 K, wet expansion"
    ]
    return {
        "number": [claim.verdict for claim in captions].count("reproduced"),
        "crunodes of figures 5 to 12, dry and wet": [
            [claim.dry, claim.wet] for claim in captions if int(claim.figure) > 4
        ],
        "moisture of the cusp of figure 5, %": 100 * cusp.parameter,
    }


def critical_speeds(answers: Any) -> dict[str, Any]:
    found = answers["aluminium"].diagram.critical_speeds().query("branch == 1 and order == 14")
    return {
        "number": float(found["from_rad_s"].iloc[0]),
        "difference of both engines": answers["aluminium"].gap,
    }


def damping_found_back(found: Any) -> dict[str, Any]:
    coupler, rocker = (each.comparison.fitted("damping") for each in found)
    return {
        "number": 1e6 * coupler.value,
        "of the rocker's record, us": 1e6 * rocker.value,
        "intervals hold the true value": all(each.is_held for each in found),
        "start angle, deg": found[0].comparison.fitted("start_angle").value,
        "unexplained": max(each.comparison.unexplained for each in found),
    }


def fickian_diffusion(answer: Any) -> dict[str, Any]:
    days = answer.days
    hot = days[(days["figure"] == "3") & (days["temperature_rise_K"] == 80)]
    return {
        "number": hot["days_to_90_percent"].item(),
        "uptake that goes with the root of time": answer.straight_to,
        "off the series": answer.off_series,
        "claims reproduced": [claim.verdict for claim in answer.claims].count("reproduced"),
    }


def four_bar_frequencies(answer: Any) -> dict[str, Any]:
    rest = answer.frequencies.dataset["frequency"].sel(engine="reference", crank_speed=0)
    return {
        "number": answer.third_to_others,
        "verdict": answer.verdict,
        "frequencies at rest and crank angle 0, Hz": rest.sel(crank_angle=0).values[:3],
        "difference of both engines": answer.frequencies.agreement().relative_difference,
    }


def flexible_slider_crank(answer: Any) -> dict[str, Any]:
    return {
        "number": 1e3 * answer.peak("reference"),
        "difference of both engines": answer.apart("exudyn", "reference"),
    }


def frames_and_stability(answers: Any) -> dict[str, Any]:
    below, inside = answers
    return {
        "number": inside.growth_rate,
        "growth rate at the lower speed, 1/s": below.growth_rate,
        "Floquet multipliers differ between frames by": max(one.floquet_gap for one in answers),
        "least frozen damping ratio": min(
            ratios.min() for one in answers for ratios in one.frozen.values()
        ),
    }


def hammer_noise(answer: Any) -> dict[str, Any]:
    table = answer.table()
    circles = table[(table["method"] == "circle-fit") & (table["noise"] == "1%")]
    return {
        "number": circles["damping scatter (%)"].iloc[1],
        "modes identified in every draw": bool((table["identified"] == "5 of 5").all()),
    }


def hammer_twelve_positions(answer: Any) -> dict[str, Any]:
    first, last = (answer.frequency.sel(laminate=name) for name in ("C1", "C6"))
    return {
        "number": 100 * (1 - (last / first).mean()),
        "frequencies off the eigen model": answer.difference("frequency"),
        "damping ratios off the eigen model": answer.difference("damping"),
    }


def hygrothermal_frequencies(answer: Any) -> dict[str, Any]:
    evenly, unevenly = answer.by_moisture, answer.by_time
    return {
        "number": 1e3 * unevenly.bend[-1],
        "first frequency, softened by 4.25 %": evenly.change["softening"][-1, 0],
        "first frequency, heavier by water": evenly.change["mass"][-1, 0],
        "first frequency, all": evenly.change["all"][-1, 0],
        "water of the first link": evenly.water[-1, 0],
        "engines on the finer mesh differ by": max(one.fine for one in answer.agreement),
        "water moves frequencies further than the speed": answer.water_leads,
    }


def instability_confirmed(answer: Any) -> dict[str, Any]:
    outside, *_, inside = answer.confirmations
    return {
        "number": inside.simulated,
        "predicted rate, 1/s": inside.predicted,
        "rate at the lowest speed, 1/s": outside.simulated,
        "edge, rad/s": answer.simulated_edge,
        "predicted edge, rad/s": answer.predicted_edge,
    }


def least_mass_fourbar(found: Any) -> dict[str, Any]:
    nominal, safe = found
    return {
        "number": 1e3 * nominal.mass,
        "guaranteed mass over that by mean properties": safe.mass / nominal.mass,
        "lowest frequency, Hz": nominal.optimum.dataset["f1"].values[0],
        "stacking": nominal.stacking,
        "part below the sixth order, guaranteed": safe.failing,
    }


def lightest_stable_fourbar(found: Any) -> dict[str, Any]:
    every, best = found
    return {
        "number": 1e3 * best.dataset["mass"].values[0],
        "sheet, mm": 1e3 * best.dataset["sheet"].values[0],
        "sheets that keep the limit": every.dataset["within"].values.tolist(),
        "least margin by either engine": best.dataset["checked"].sel(output="margin").min(),
    }


def lumped_masses(answer: Any) -> dict[str, Any]:
    return {
        "number": 100 * answer.force_excess[1],
        "twelve masses over twenty-four": answer.force_excess[1] / answer.force_excess[2],
        "of the torque": answer.torque_excess[1] / answer.torque_excess[2],
    }


def mode_shapes(answers: Any) -> dict[str, Any]:
    steel, aluminium = answers["steel"], answers["aluminium"]
    at_13_deg = aluminium.mac[-1, 13]
    return {
        "number": at_13_deg[1],
        "of the first mode": at_13_deg[0],
        "least of steel": steel.mac.min(),
        "verdicts": [steel.verdict, aluminium.verdict],
    }


def moisture_and_stability(answers: Any) -> dict[str, Any]:
    dry, *_, wet = answers.values()
    return {
        "number": 100 * (wet.edge / dry.edge - 1),
        "of the first frequency, %": 100 * (wet.first_frequency / dry.first_frequency - 1),
    }


def quiet_stop(found: Any) -> dict[str, Any]:
    at = found.sel(move_time=0.3, method="nearest")
    left = 100 * at / at.sel(law="plain")
    return {"number": left.sel(law="path"), "shaper for the end, %": left.sel(law="end")}


def running_fourbars(answers: Any) -> dict[str, Any]:
    aluminium, dry, wet = (answers[name, 20.0] for name in COARSER["running_fourbars"]["names"])
    return {
        "number": 1e3 * aluminium.peak,
        "composite over aluminium": dry.peak / aluminium.peak,
        "wet composite over dry": wet.peak / dry.peak,
        "linear and nonlinear differ by": max(aluminium.gap, dry.gap, wet.gap),
    }


def running_hammer_test(found: Any) -> dict[str, Any]:
    data, sideband = found.dataset, found.dataset["peak"].sel(order=1)
    frozen = np.hypot(data["frozen_real"], data["frozen_imag"]).sel(order=1).max()
    return {
        "number": 1e3 * float(sideband),
        "sideband over that of the frozen linkage": float(sideband / frozen),
        "harmonic balance differs by": float(data["balance_error"].max()),
    }


def six_bars(answers: Any) -> dict[str, Any]:
    return {
        "number": 100 * answers["watt"].swing[0],
        "engines at rest differ by": max(one.apart[0] for one in answers.values()),
        "engines at speed differ by": max(one.apart[1] for one in answers.values()),
    }


def soft_frame(found: Any) -> dict[str, Any]:
    return {"number": found.transmitted[0], "of the stiffest": found.transmitted[-1]}


def stability_maps(answers: Any) -> dict[str, Any]:
    bands = answers["aluminium"].bands()
    band = bands.loc[bands["largest_growth_rate_1_s"].idxmax()]
    damped = answers["aluminium"].against().query("damping_ratio == 0.03")
    return {
        "number": band["from_rad_s"],
        "largest growth rate, 1/s": band["largest_growth_rate_1_s"],
        "three percent of damping close it": bool((damped["unstable"] == "no").all()),
    }


def strength_of_a_fourbar(answer: Any) -> dict[str, Any]:
    part, kind, speed = answer.first
    return {"number": speed, "what fails first": [part, kind]}


def swollen_angles(answer: Any) -> dict[str, Any]:
    text = answer.change.sel(state="R-914, +80 K, 7 % moisture", link="coupler")
    ends = text.sel(crank_angle=[0.0, np.pi], method="nearest").values
    return {
        "number": ends[1],
        "at crank angle 0, deg": ends[0],
        "verdicts": [claim.verdict for claim in answer.claims],
    }


def turcic_midha_bosnik(answer: Any) -> dict[str, Any]:
    return {"number": 100 * answer.greatest, "verdicts": list(answer.verdicts)}


def axial_force_alone(answers: Any) -> dict[str, Any]:
    return {
        "number": answers["steel"].caught(0.0, 20.0)[0],
        "of aluminium": answers["aluminium"].caught(0.0, 20.0)[0],
        "positions without an equilibrium": sum(len(one.not_found) for one in answers.values()),
    }


def inertial_terms(answers: Any) -> dict[str, Any]:
    answer = answers["moist_composite"]
    change = 1e3 * answer.change.sel(angle=np.radians(20.0), mode=1, method="nearest")
    return {
        "number": change.sel(term="coriolis"),
        "by geometric stiffness, mHz": change.sel(term="geometric"),
        "by centripetal terms, mHz": change.sel(term="centripetal"),
        "all together, mHz": change.sel(term="together"),
        "geometric stiffness weighs most": answer.geometric_leads,
    }


def elamy_2023(answer: Any) -> dict[str, Any]:
    verdicts = [claim.verdict for claim in answer.claims]
    factors = answer.study["laminate_factor"].sel(layers="across width", beams="converged")
    return {
        "number": verdicts.count("reproduced"),
        "not reproduced, undecidable, not judged": [
            verdicts.count(verdict) for verdict in ("not reproduced", "undecidable", "not judged")
        ],
        "C6 over C1, woven, straight, Table 2": factors.sel(laminate="C6").values,
    }


NUMBERS: dict[str, Callable[[Any], dict[str, Any]]] = {
    "aluminium_fourbar_frequencies": four_bar_frequencies,
    "axial_force_alone": axial_force_alone,
    "best_stacking_under_scatter": best_stacking_under_scatter,
    "composite_crank_rockers": lambda answer: {
        "number": answer.ratios["euler"]["factor"][0],
        "of damping": answer.ratios["euler"]["damping"][0],
    },
    "composite_thresholds": composite_thresholds,
    "coupler_curves": coupler_curves,
    "critical_speeds": critical_speeds,
    "damping_found_back": damping_found_back,
    "elamy_2023": elamy_2023,
    "fickian_diffusion": fickian_diffusion,
    "flexible_slider_crank": flexible_slider_crank,
    "frames_and_stability": frames_and_stability,
    "hammer_noise": hammer_noise,
    "hammer_twelve_positions": hammer_twelve_positions,
    "hygrothermal_frequencies": hygrothermal_frequencies,
    "inertial_terms": inertial_terms,
    "instability_confirmed": instability_confirmed,
    "least_mass_fourbar": least_mass_fourbar,
    "lightest_stable_fourbar": lightest_stable_fourbar,
    "lumped_masses": lumped_masses,
    "mode_shapes": mode_shapes,
    "moisture_and_stability": moisture_and_stability,
    "motor_and_flywheel": lambda answer: {"number": 1e3 * answer.needed.sel(torque=1.5)},
    "quiet_stop": quiet_stop,
    "running_fourbars": running_fourbars,
    "running_hammer_test": running_hammer_test,
    "six_bars": six_bars,
    "soft_frame": soft_frame,
    "stability_maps": stability_maps,
    "steel_fourbar_frequencies": four_bar_frequencies,
    "strength_of_a_fourbar": strength_of_a_fourbar,
    "swollen_angles": swollen_angles,
    "transmission_angle": lambda answer: {
        "number": answer.largest_gap,
        "limits of case 3, deg": answer.limits["case 3 as designed"],
    },
    "turcic_midha_bosnik": turcic_midha_bosnik,
}


def plain(value: Any) -> Any:
    """A number, a word or a list of them."""
    if isinstance(value, tuple | list | np.ndarray):
        return [plain(one) for one in value]
    if isinstance(value, str | bool | int):
        return value
    return bool(value) if isinstance(value, np.bool_) else float(value)


def main(name: str, folder: Path) -> None:
    """Run a scenario with its coarser settings, if any, and keep its numbers."""
    answer = importlib.import_module(name).main(folder, **COARSER.get(name, {}))
    numbers = {words: plain(value) for words, value in NUMBERS[name](answer).items()}
    (folder / KEPT).write_text(json.dumps(numbers, indent=2))


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))
