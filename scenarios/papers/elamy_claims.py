"""What Elamy et al. 2023 claim of their crank-rockers, put to the test claim by claim.

Numbers of the text are first computed from the paper's own tables, then from ours: from
converged bending beams of woven plies that lie parallel to the plane of motion, and from every
other model of the study, so that a verdict does not hang on the choice of one. Ours are held
against what is printed, or, where the text prints no number, against the tables. A number of ours
has the uncertainty that Table 1 gives it; where the band around the printed number is then not
narrower than the effect claimed, the claim is undecidable. The claims are in
``data/elamy_2023_claims.toml``, each with the name of the method that tests it here and its
arguments.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations

import numpy as np
import xarray as xr
from elamy_linkages import (
    CASES,
    deviation_at_best_scale,
    geometric_mean,
    laminate_factors,
    published_case,
    stored,
)
from elamy_study import (
    CONVERGED,
    CRANK_SPEED,
    PAPERS_MESH,
    STEEL,
    THIRD_ORDER,
    TURN,
    all_models,
    in_both_configurations,
    relative_change,
    spread_of,
)
from paper_claims import (
    REPRODUCED_WITHIN,
    Band,
    Claim,
    Found,
    judged_by,
    judged_by_order,
    numbers_in,
    span,
    verdict_on,
)

from flexmech import FourBar, synthesize_crank_rocker
from flexmech.arrays import ROUND_OFF, FloatArray

PEAKS: dict[str, tuple[float, str, float, float]] = {
    "peak_torque": (1.0, "N m", 0.0, 1.0),
    "peak_power": (1.0, "W", 0.0, 1.0),
    "peak_joint_force": (1.0, "N", 0.0, 1.0),
    "peak_deflection": (1e3, "mm", -1.0, 1.0),
}
"""Peaks of a running linkage, their units, and how they follow from modulus and density: inertia
forces bend a link by rho A over E I, vibration left out."""
# Unit and decimals of the properties in Table 2.
_UNITS = {"modulus": (1e9, "GPa", 1), "density": (1.0, "kg/m^3", 0), "poisson_ratio": (1.0, "", 3)}
# What is assumed of the running linkages: speed, and modulus and density of steel.
_ASSUMED = (CRANK_SPEED, STEEL.youngs_modulus / 1e9, STEEL.density)
# Deviation of Tables 5 and 6 against ours, in percent: as separable as the rounding of the printed
# digits leaves them.
_SEPARABLE_WITHIN = 1.0
# In bending all linkages of one laminate lose the same part: differences below this are the
# mesh's error.
_MARGIN, EPSILON = 1e-3, float(np.finfo(float).eps)
# Printed limits of the transmission angle are held to half a degree.
_LIMIT_TOLERANCE = 0.5
# Numbers of claims are taken over these; other dimensions are models, or what is uncertain.
_OVER = ("position", "laminate", "case")
Number = Callable[[xr.DataArray], xr.DataArray]


def composite_claims(study: xr.Dataset) -> list[Claim]:
    """Claims of the paper against a study.

    Parameters
    ----------
    study : Dataset
        Of :func:`elamy_study.study_composites`.

    Returns
    -------
    list of Claim
        Ours are the converged frequencies with woven plies, parallel to the plane of motion.
    """
    known, tests, claims = stored("elamy_2023_claims"), Tests(study), []
    for place, statement, printed, (test, *arguments), why in known["claims"]:
        found = getattr(tests, test)(printed, *arguments)
        holds, numbers = found.pop("holds", None), found.pop("numbers", ())
        verdict = verdict_on(holds, decidable=found.pop("decidable", True))
        reasons = known["reasons"] | (known["reasons_of_misses"] if holds is False else {})
        texts = {"from_tables": "", "computed": "", "other_models": ""} | found
        texts["fails_if"] = texts.get("fails_if") or known["fails_if"].get(test, "")
        reason = reasons.get(why, "").format(*numbers)
        claims.append(Claim(place, statement, printed, verdict=verdict, reason=reason, **texts))
    return claims


class Tests:
    """Tests by the names that the claims have for them; the first argument is what is printed.

    A ``quantity`` is ``"frequency"`` or ``"damping"``.
    """

    def __init__(self, study: xr.Dataset) -> None:
        self.study, self.tables = study, study["finite_element"]
        self.models = all_models(study)
        self.ours, self.stacked = self.models[0], xr.concat(self.models, "model")
        self.angle = np.degrees(study["transmission_angle"])
        # Ours with one more of each uncertainty of Table 1, in bending, by ``source``: frequency
        # = s(laminate) q(case, position), s the root of E I over rho A.
        self.first = study.isel(mixed_plies=0, layers=0, running_plies=0, drop=True)
        self.spreads = self.ours * (1 + relative_change(self.first, 0.5, -0.5))

    # --- proportions: what the transmission angle does over the turn ------------------------------

    def limits(self, printed: str, case: int) -> Found:
        """Limits of the transmission angle."""
        limits = _limits(case)
        gap = np.abs(limits - numbers_in(printed))
        text = f"{span(limits)} deg"
        return {
            **dict.fromkeys(("from_tables", "computed"), text),
            "holds": bool(gap.max() <= _LIMIT_TOLERANCE),
            "numbers": gap,
        }

    def ranges(self, printed: str, *cases: int) -> Found:
        """How far the transmission angle reaches."""
        spans = {case: np.ptp(_limits(case)) for case in cases}
        text = ", ".join(f"case {case} {reach:.1f} deg" for case, reach in spans.items())
        least = numbers_in(printed)[0]
        return {
            **dict.fromkeys(("from_tables", "computed"), text),
            "holds": bool(min(spans.values()) >= least),
            "fails_if": f"one of these ranges is below {least:g} deg",
        }

    def sensitivity(self, printed: str) -> Found:
        """Error of the rocker's angle by one of the coupler's length, against that at 90 deg."""
        worst, holds = {}, True
        for case, angle in zip(CASES, self.angle.values, strict=True):
            crank, coupler, rocker = CASES[case]
            short, long = (
                FourBar(1.0, crank, coupler * (1 + change), rocker).motion(TURN, 0.0).angle[:, 2]
                for change in (-1e-5, 1e-5)
            )
            error, away = np.abs(long - short), np.abs(angle - 90)
            worst[case] = error.max() / error[away.argmin()], angle[error.argmax()]
            holds &= bool(abs(away[error.argmax()] - away.max()) < _LIMIT_TOLERANCE)
        times = (f"case {case} {ratio:.2f} at {at:.0f} deg" for case, (ratio, at) in worst.items())
        return {
            "computed": f"{', '.join(times)} times that at 90 deg",
            "holds": holds,
            "fails_if": "the error of a case is greatest nearer to 90 deg",
        }

    def design(self, printed: str, deviation: float, rocker_angle: float) -> Found:
        """Proportions by equations 11 to 17; angles in degrees."""
        found = synthesize_crank_rocker(*np.radians([deviation, rocker_angle]))
        lengths = (found.crank, found.coupler, found.rocker)
        text, rounded = (", ".join(f"{x:.{n}f}" for x in lengths) for n in (4, 2))
        return {
            **dict.fromkeys(("from_tables", "computed"), text),
            "holds": rounded == printed,
        }

    def suggested(self, printed: str) -> Found:
        """Which cases stay within limits that the paper quotes for a transmission angle."""
        low, high = numbers_in(printed)
        limits = {case: _limits(case) for case in CASES}
        within = [n for n, (least, most) in limits.items() if low <= least and most <= high]
        names = ", ".join(map(str, within)) or "none"
        return {
            "computed": f"cases {names} within; all cases {span(list(limits.values()))} deg",
            "holds": len(within) == len(limits),
            "fails_if": f"the transmission angle of a case is below {low:g} or above {high:g} deg",
        }

    def extreme(self, printed: str, which: str, case: int) -> Found:
        """Which case has the greatest, or the least, transmission angle of all."""
        sign = 1 if which == "highest" else -1
        angle = sign * self.angle
        best = angle.max("crank_angle")
        others = angle.drop_sel(case=case)
        everywhere = (angle.sel(case=case) > others).all("case").values[:-1]
        first = int(best.idxmax("case"))
        return {
            "computed": f"case {first} with {sign * float(best.max()):.2f} deg",
            "other_models": f"at {everywhere.sum()} of {everywhere.size} crank angles",
            "holds": first == case,
            "fails_if": f"another case reaches {sign * float(best.sel(case=case)):.2f} deg; the "
            f"next one reaches {sign * float(others.max()):.2f} deg",
        }

    def trend(self, printed: str, first: int, second: int) -> Found:
        """Whether the curves of two cases are nearer to each other than those of any other two."""
        apart = {
            (one, two): float(abs(self.angle.sel(case=one) - self.angle.sel(case=two)).max())
            for one, two in combinations(CASES, 2)
        }
        ours = apart.pop((first, second))
        one, two = min(apart, key=lambda pair: apart[pair])
        return {
            "computed": f"{ours:.1f} deg apart at most",
            "other_models": f"cases {one} and {two} {apart[one, two]:.1f} deg",
            "holds": ours < apart[one, two],
        }

    # --- laminates --------------------------------------------------------------------------------

    def table_2(self, printed: str, name: str, laminate: str) -> Found:
        """A property by the rule of mixtures from Table 1, of straight plies as Table 2 has it."""
        unit, words, decimals = _UNITS[name]
        of = self.study.sel(laminate=laminate).isel(layers=0)
        straight, woven = (
            float(of[name].sel(mixed_plies=p)) / unit for p in ("unidirectional", "woven")
        )
        change = of[f"{name}_change"].sel(mixed_plies="unidirectional") / unit
        # The effect is that of the stack: what Table 2 has at its other end.
        (other,) = {"C1", "C6"} - {laminate}
        opposite = float(self.study[f"printed_{name}"].sel(laminate=other)) / unit
        band = Band(numbers_in(printed.split()[0])[0], float(spread_of(change)), opposite)
        return {
            "computed": f"{straight:.{decimals}f} {words}".rstrip(),
            "other_models": f"woven {woven:.{decimals}f} {words}".rstrip(),
            **judged_by(band, straight, words, decimals),
        }

    def strength(self, printed: str) -> Found:
        """Strength of the laminates."""
        return {}

    def stiffer(self, printed: str) -> Found:
        """Whether the modulus in bending is above that of steel."""
        modulus, steel = self.first["modulus"], STEEL.youngs_modulus
        spread = spread_of(self.first["modulus_change"])
        worst = int(modulus.argmin("laminate"))
        words = "a laminate is no stiffer in bending than steel"
        judged = judged_by_order(
            float(modulus[worst]) / steel - 1, float(spread[worst]) / steel, words
        )
        return judged | {
            "computed": f"steel {steel / 1e9:g} GPa, laminates {span(modulus / 1e9, 1)} GPa",
            "other_models": f"all plies {span(self.study['modulus'] / 1e9, 1)} GPa",
            "spread": f"{span(spread / 1e9, 1)} GPa",
        }

    def outer_plies(self, printed: str) -> Found:
        """What two outer plies take of the modulus in bending, against two inner ones."""

        def ratio(modulus: xr.DataArray) -> xr.DataArray:
            of = {name: modulus.sel(laminate=name, drop=True) for name in ("C1", "C3", "C5")}
            return (of["C3"] - of["C5"]) / (of["C1"] - of["C3"])

        ours, every = float(ratio(self.first["modulus"])), ratio(self.study["modulus"])
        stacked = every.isel(layers=1)
        words = "the outer plies count no more than the inner ones"
        return judged_by_order(ours - 1, 0.0, words, _MARGIN) | {
            "from_tables": f"{float(ratio(self.study['printed_modulus'])):.2f} times (Table 2)",
            "computed": f"{ours:.2f} times",
            "other_models": f"stacked in the plane of motion {span(stacked)} times",
        }

    def damping_of_metal(self, printed: str) -> Found:
        """Damping of the composite linkages; none of metal is printed."""
        loss = 100 * self.first["strain_energy_damping"].sel(plies="woven", beams=CONVERGED)
        return {
            "from_tables": f"{span(self.study['damping'])}, metal not printed",
            "computed": f"{span(loss)} %",
        }

    def lighter(self, printed: str) -> Found:
        """How much weight links of the same size save against steel, at best."""
        saved = 100 * (1 - self.first["density"] / STEEL.density)
        best = int(saved.argmax("laminate"))
        spread = 100 * float(spread_of(self.first["density_change"])[best]) / STEEL.density
        return {
            "computed": f"{saved.max():.1f} %",
            "other_models": f"C1 to C6 {span(saved, 1)} %",
            "numbers": _ASSUMED,
            **judged_by(Band(*numbers_in(printed), spread), float(saved[best]), "%", 1),
        }

    # --- linkages in motion, beside steel of the same size ----------------------------------------

    def less_than_steel(self, printed: str, name: str, *laminates: str) -> Found:
        """Whether a peak is below that of steel in every case, of these laminates or of all."""
        unit, words, *powers = PEAKS[name]
        of = list(laminates or self.study["laminate"].values)
        peaks = self.study[name]
        ratio = (peaks / peaks.sel(material="steel", drop=True)).sel(material=of)
        ratio = ratio.rename(material="laminate")
        ours = ratio.isel(running_plies=0, drop=True)
        spread = ours * spread_of(relative_change(self.first, *powers).sel(laminate=of))
        worst = ours.where(ours == ours.max(), drop=True)
        at = {dim: worst[dim].values[0] for dim in ("laminate", "case")}
        of_case = unit * self.first[name].sel(case=1)
        one, steel = (float(of_case.sel(material=material)) for material in (of[0], "steel"))
        difference, known = 1 - float(ours.sel(at)), float(spread.sel(at))
        fails = "in a case it is as much as with links of steel of that size"
        return judged_by_order(difference, known, fails) | {
            "computed": f"case 1, {of[0]}: {one:.3f} against {steel:.3f} {words}; "
            f"{span(100 * ours, 1)} % of steel",
            "other_models": f"by Table 2 {span(100 * ratio.sel(running_plies='table 2'), 1)} %",
            "numbers": _ASSUMED,
            "spread": f"{span(100 * spread, 1)} %",
        }

    def lower_cases(self, printed: str, name: str, *cases: int) -> Found:
        """Whether a peak of the running linkage is lower in these cases than in all others."""
        unit, words, *_ = PEAKS[name]
        peaks = unit * self.first[name].sel(material="C1")
        chosen = peaks["case"].isin(cases)
        highest, lowest = float(peaks.where(chosen).max()), float(peaks.where(~chosen).min())
        told = ", ".join(f"case {int(n)} {float(peaks.sel(case=n)):.3f}" for n in peaks["case"])
        fails = "one of these cases needs as much as another one"
        judged = judged_by_order(1 - highest / lowest, 0.0, fails)
        return judged | {"computed": f"C1: {told} {words}", "numbers": _ASSUMED}

    # --- frequency and damping --------------------------------------------------------------------

    def fall(self, printed: str, quantity: str, dim: str, high: object, low: object) -> Found:
        """Mean decrease along a dimension."""

        def number(values: xr.DataArray) -> xr.DataArray:
            return _fall(values, dim, high, low)

        found = self._said_of(quantity, number)
        if quantity != "frequency":
            return found
        band = Band(*numbers_in(printed), self._spread(number))
        return found | judged_by(band, float(number(self.ours)), "%")

    def ordered(
        self, printed: str, quantity: str, order: str, dim: str, which: object = None
    ) -> Found:
        """At how many places values along a dimension have an order; claimed is: at all."""
        difference, least, words = {
            "falling": (lambda v: -_step(v, dim), 0.0, "it does not fall from one {} to the next"),
            # Equal ones do not fall.
            "rising": (lambda v: _step(v, dim), -EPSILON, "it falls from one {} to the next"),
            "lowest": (lambda v: 1 - _others(v, dim, which), _MARGIN, "another {} is as low"),
            "highest": (
                lambda v: _others(v, dim, which) - 1,
                _MARGIN,
                "another {} is as high",
            ),
        }[order]
        size = self.study["damping"].size // self.study.sizes[dim]

        def count(values: xr.DataArray) -> xr.DataArray:
            return (difference(values) > least).all(dim).sum(set(_OVER) - {dim})

        def smallest(values: xr.DataArray) -> xr.DataArray:
            return difference(values).min(_OVER)

        found = self._said_of(quantity, count, f"in {{}} of {size}", 0)
        if quantity != "frequency":
            return found
        words = f"somewhere {words.format(dim)}" + f", but for {100 * _MARGIN:g} %" * (least > 0)
        margin, spread = float(smallest(self.ours)), self._spread(smallest)
        return found | judged_by_order(margin, spread, words, least)

    def swapped(self, printed: str) -> Found:
        """Two numbers in the order of the abstract."""
        by_tables, ours = (
            [float(_fall(frequency, "position", high, "90")) for high in ("max", "min")]
            for frequency in (self.tables, self.ours)
        )
        texts = [" and ".join(f"{fall:.2f}" for fall in both) + " %" for both in (by_tables, ours)]
        bands = [Band(number) for number in numbers_in(printed)]
        edges = " and ".join("{:.2f} to {:.2f}".format(*band.edges) for band in bands)
        return {
            "from_tables": texts[0],
            "computed": texts[1],
            "holds": all(band.holds(one) for band, one in zip(bands, ours, strict=True)),
            "decidable": all(band.decides for band in bands),
            "fails_if": f"one of ours is outside {edges} %",
        }

    def separable(self, printed: str, position: str) -> Found:
        """Whether frequency is a factor of the laminate times one of the case."""

        def number(values: xr.DataArray) -> xr.DataArray:
            """Greatest deviation from that, in percent."""
            log = np.log(values.sel(position=position))
            rest = log - log.mean("laminate") - log.mean("case") + log.mean(["laminate", "case"])
            return 100 * abs(np.expm1(rest)).max(["laminate", "case"])

        at = self.tables.sel(position=position)
        ratio = at / at.sel(laminate="C1") / self.study["published_laminate_factor"]
        return self._said_of("frequency", number) | {
            "holds": abs(float(number(self.tables) - number(self.ours))) < _SEPARABLE_WITHIN,
            "numbers": 100 * abs(ratio - 1).max("laminate").values,
        }

    def factors(self, printed: str) -> Found:
        """How far the frequency falls from C1 to C6."""
        tables = self.study["published_laminate_factor"].values
        models = laminate_factors(self.stacked).transpose("model", "laminate").values
        ours = models[0]
        moved = laminate_factors(self.spreads).transpose("source", "laminate").values - ours
        spreads = np.sqrt((moved**2).sum(axis=0))[1:]
        # C1 has 1 by definition.
        bands = [Band(*pair, no_effect=1.0) for pair in zip(tables[1:], spreads, strict=True)]
        edges = ", ".join("{:.3f} to {:.3f}".format(*band.edges) for band in bands)
        return {
            "from_tables": _listed(tables),
            "computed": _listed(ours),
            "other_models": f"C6 {span(models[:, -1])}",
            "holds": all(band.holds(one) for band, one in zip(bands, ours[1:], strict=True)),
            "decidable": all(band.decides for band in bands),
            "spread": _listed(spreads),
            "fails_if": f"one of C2 to C6 is outside {edges}",
        }

    def moduli(self, printed: str) -> Found:
        """How far it falls with the moduli and densities of Table 2."""
        tables = float(self.study["published_laminate_factor"][-1])
        frequency = self.study["frequency"].isel(layers=0).sel(plies="table 2", beams=CONVERGED)
        ours = float(laminate_factors(frequency)[-1])
        judged = judged_by(Band(tables, no_effect=1.0), ours, "", 3)
        return {"from_tables": f"{tables:.3f}", "computed": f"{ours:.3f}", **judged}

    def shape(self, printed: str) -> Found:
        """Cases and positions against each other, whatever the scale."""
        tables, *models = (geometric_mean(v, "laminate") for v in (self.tables, *self.models))
        off = [100 * deviation_at_best_scale(one, tables) for one in models]
        return _missed_by(off[0], tables) | {
            "other_models": f"{span(off)} %, rigid joints {span(off[-2:])} %"
        }

    def literal_frame(self, printed: str) -> Found:
        """The same of a frame that only its two pivots hold, by the configuration with 90 deg."""
        frames = in_both_configurations(self.study, "literal_frame_")
        tables = geometric_mean(self.tables, "laminate")
        off = [
            100 * deviation_at_best_scale(geometric_mean(one, "laminate"), tables) for one in frames
        ]
        falls = sorted(float(_fall(one, "position", "max", "90")) for one in frames)
        least = float(_fall(frames[0], "position", "max", "min"))
        return _missed_by(min(off), tables) | {"numbers": (*falls, least)}

    def mesh(self, printed: str) -> Found:
        """One element a link, as the paper has it, against the converged frequencies."""
        frequency = self.study["frequency"]
        ratio = frequency.sel(beams=PAPERS_MESH) / frequency.sel(beams=CONVERGED)
        return {
            "computed": f"{span(100 * (ratio - 1), 1)} % high",
        }

    def measurement(self, printed: str) -> Found:
        """The paper's measured frequencies against those it computed."""
        gap = 100 * (self.study["measured"] / self.tables - 1)
        return {
            "from_tables": f"{span(gap, 1)} %, mean {float(gap.mean()):.1f} %",
        }

    def _spread(self, number: Number) -> float:
        """Standard uncertainty of a number that is taken of our frequencies."""
        ours = float(number(self.ours))
        spread = float(np.sqrt(((number(self.spreads) - ours) ** 2).sum()))
        # In bending positions and cases keep their ratios whatever the laminate.
        return spread if spread > 1e3 * ROUND_OFF * abs(ours) else 0.0

    def _said_of(
        self, quantity: str, number: Number, form: str = "{} %", decimals: int = 2
    ) -> Found:
        """A number that is taken of values over position, laminate and case, not yet judged."""

        def words(values: xr.DataArray) -> str:
            return form.format(span(number(values), decimals))

        if quantity == "frequency":
            coarse = self.study["frequency"].isel(plies=0, layers=0, drop=True)
            further = (self.stacked[-2:], coarse.sel(beams=PAPERS_MESH, drop=True))
            texts = [words(values) for values in (self.tables, self.ours, self.stacked)]
            numbers, fails = [words(values) for values in further], ""
        else:
            # What the materials lose is not printed, and theories disagree.
            printed = self.study["damping"]
            loss = self.study["strain_energy_damping"].sel(plies=["woven", "unidirectional"])
            first = loss.isel(plies=0, layers=0)
            bent, sheared = (words(first.sel(beams=name)) for name in (CONVERGED, THIRD_ORDER))
            texts = [words(printed), bent, f"{sheared} by third order"]
            numbers = [float(f()) for v in (100 * loss, printed) for f in (v.min, v.max)]
            fails = "nothing: ours follows from a loss that is assumed"
        named = dict(zip(("from_tables", "computed", "other_models"), texts, strict=True))
        return {**named, "numbers": numbers, "fails_if": fails}


def _missed_by(off: float, tables: xr.DataArray) -> Found:
    """Deviation in percent at the best common scale, against that of one frequency for all."""
    level = 100 * deviation_at_best_scale(xr.ones_like(tables), tables)
    within = 100 * REPRODUCED_WITHIN
    return {
        "computed": f"{off:.0f} %",
        "holds": off <= within,
        "decidable": within < level,
        "fails_if": f"ours is off by more than {within:g} %; one frequency for all would be by "
        f"{level:.0f} %",
    }


def _listed(numbers: FloatArray) -> str:
    return ", ".join(f"{number:.3f}" for number in numbers)


def _limits(case: int) -> FloatArray:
    """Least and greatest transmission angle of a linkage in degrees."""
    return np.degrees(published_case(case).transmission_angle_limits())


def _step(values: xr.DataArray, dim: str) -> xr.DataArray:
    """Relative change from each place along a dimension to the next."""
    return values.diff(dim) / values.shift({dim: 1})


def _others(values: xr.DataArray, dim: str, which: object) -> xr.DataArray:
    """Value at one place along a dimension over those at the others."""
    return values.sel({dim: which}) / values.drop_sel({dim: which})


def _fall(values: xr.DataArray, dim: str, high: object, low: object) -> xr.DataArray:
    """Mean decrease from one coordinate to another, in percent of the former."""
    ratio = values.sel({dim: low}, drop=True) / values.sel({dim: high}, drop=True)
    return 100 * (1 - ratio.mean(set(_OVER) - {dim}))
