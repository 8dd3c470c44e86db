"""What Elamy et al. 2023 claim of their crank-rockers, put to the test claim by claim.

Numbers of the text are first computed from the paper's own tables, then from ours: from
converged bending beams of woven plies that lie parallel to the plane of motion, and from every
other model of the study, so that a verdict does not hang on the choice of one. Ours are held
against what is printed, or, where the text prints no number, against the tables. A number of ours
has the uncertainty that Table 1 gives it; where the band around the printed number is then not
narrower than the effect claimed, the claim is undecidable. The claims are in ``data/claims.toml``,
each with the name of the method that tests it here and its arguments.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np
import xarray as xr

from flexmech.arrays import ROUND_OFF
from flexmech.studies.claim import REPRODUCED_WITHIN, Band, Claim, verdict_on
from flexmech.studies.composite_crank_rockers import linkages
from flexmech.studies.composite_crank_rockers.findings import Finding, numbers_in, span
from flexmech.studies.composite_crank_rockers.properties import relative_change
from flexmech.studies.composite_crank_rockers.proportion_claims import ProportionTests
from flexmech.studies.composite_crank_rockers.ratios import (
    deviation_at_best_scale,
    geometric_mean,
    laminate_factors,
    separable_error,
)
from flexmech.studies.composite_crank_rockers.running_claims import RunningTests

# Of Tables 5 and 6 against ours, in percent: as near to separable as the rounding of the printed
# digits leaves them.
_SEPARABLE_WITHIN = 1.0
# In bending all linkages of one laminate lose the same part: differences below this are the
# mesh's error.
_MARGIN = 1e-3
# Numbers of claims are taken over these; other dimensions are models, or what is uncertain.
_OVER = ("position", "laminate", "case")


def composite_claims(study: xr.Dataset) -> list[Claim]:
    """Claims of the paper against a study.

    Parameters
    ----------
    study : Dataset
        Of :class:`flexmech.studies.CompositeStudy`.

    Returns
    -------
    list of Claim
        Ours are the converged frequencies with woven plies, parallel to the plane of motion.
    """
    stored, tests = linkages.stored_table("claims.toml"), _Tests(study)
    return [_tested(row, tests, stored) for row in stored["claims"]]


def _tested(row: list[Any], tests: _Tests, stored: dict[str, Any]) -> Claim:
    """A claim as it is stored, with what was found of it."""
    place, statement, printed, (test, *arguments), reason = row
    found: Finding = getattr(tests, test)(printed, *arguments)
    reasons = stored["reasons"] | (stored["reasons_of_misses"] if found.holds is False else {})
    return Claim(
        place,
        statement,
        printed,
        found.from_tables,
        found.computed,
        found.other_models,
        verdict_on(found.holds, decidable=found.decidable),
        reasons.get(reason, "").format(*found.numbers),
        found.spread,
        found.fails_if,
    )


def all_models(study: xr.Dataset) -> list[xr.DataArray]:
    """Frequencies over position, laminate and case by each model, the first one ours.

    Every model comes twice: in both configurations with a right transmission angle. The last is
    that of rigid joints.

    Parameters
    ----------
    study : Dataset

    Returns
    -------
    list of DataArray
    """
    models = []
    for kind in ("", "rigid_joints_"):
        frequency = study[f"{kind}frequency"]
        other = frequency.where(frequency["position"] != "90", study[f"{kind}other_configuration"])
        for each in (frequency, other.transpose(*frequency.dims)):
            if kind:
                models.append(each)
                continue
            models += [
                each.sel(plies=plies, layers=layers, beams=beams, drop=True)
                for (plies, layers), beams in product(linkages.each_model(), linkages.BEAMS)
            ]
    return models


class _Tests(ProportionTests, RunningTests):
    """Tests by the names that the claims have for them; the first argument is what is printed.

    A ``quantity`` is ``"frequency"`` or ``"damping"``.
    """

    @cached_property
    def models(self) -> list[xr.DataArray]:
        """Frequencies by all models, ours first."""
        return all_models(self.study)

    @cached_property
    def stacked(self) -> xr.DataArray:
        """The same over ``model`` as well."""
        return xr.concat(self.models, "model")

    @cached_property
    def spreads(self) -> xr.DataArray:
        """Our frequencies with one more of each uncertainty of Table 1, in bending; by ``source``.

        Frequency = s(laminate) q(case, position), s the root of E I over rho A.
        """
        change = relative_change(self.study, 0.5, -0.5).isel(mixed_plies=0, layers=0, drop=True)
        return self.models[0] * (1 + change)

    def fall(self, printed: str, quantity: str, dim: str, high: object, low: object) -> Finding:
        """Mean decrease along a dimension."""

        def number(values: xr.DataArray) -> xr.DataArray:
            return _fall(values, dim, high, low)

        found = self._said_of(quantity, number)
        if quantity != "frequency":
            return found
        (claimed,) = numbers_in(printed)
        band = Band(claimed, self._spread(number))
        return found.judged_by(band, float(number(self.models[0])), "%")

    def falling(self, printed: str, quantity: str, dim: str) -> Finding:
        """Where each value along a dimension is below the one before."""
        words = f"somewhere it does not fall from one {dim} to the next"
        return self._ordered(quantity, dim, lambda v: -_step(v, dim), words)

    def rising(self, printed: str, quantity: str, dim: str) -> Finding:
        """Where no value along a dimension is below the one before."""
        words = f"somewhere it falls from one {dim} to the next"
        # Equal ones do not fall.
        return self._ordered(quantity, dim, lambda v: _step(v, dim), words, -np.finfo(float).eps)

    def lowest(self, printed: str, quantity: str, dim: str, which: object) -> Finding:
        """Where one place along a dimension has the lowest value."""
        words = f"somewhere another {dim} is as low, but for {100 * _MARGIN:g} %"
        return self._ordered(
            quantity, dim, lambda v: 1 - _over_others(v, dim, which), words, _MARGIN
        )

    def highest(self, printed: str, quantity: str, dim: str, which: object) -> Finding:
        """Where one place along a dimension has the highest value."""
        words = f"somewhere another {dim} is as high, but for {100 * _MARGIN:g} %"
        return self._ordered(
            quantity, dim, lambda v: _over_others(v, dim, which) - 1, words, _MARGIN
        )

    def swapped(self, printed: str) -> Finding:
        """Two numbers in the order of the abstract."""
        by_tables, ours = (
            [float(_fall(frequency, "position", high, "90")) for high in ("max", "min")]
            for frequency in (self.study["finite_element"], self.models[0])
        )
        texts = [" and ".join(f"{fall:.2f}" for fall in both) for both in (by_tables, ours)]
        bands = [Band(number) for number in numbers_in(printed)]
        edges = " and ".join("{:.2f} to {:.2f}".format(*band.edges) for band in bands)
        return Finding(
            f"{texts[0]} %",
            f"{texts[1]} %",
            holds=all(band.holds(own) for band, own in zip(bands, ours, strict=True)),
            decidable=all(band.decides for band in bands),
            fails_if=f"one of ours is outside {edges} %",
        )

    def separable(self, printed: str, position: str) -> Finding:
        """Whether frequency is a factor of the laminate times one of the case."""

        def number(values: xr.DataArray) -> xr.DataArray:
            at = values.sel(position=position)
            if "model" in at.dims:
                return xr.concat([xr.DataArray(100 * separable_error(a)) for a in at], "model")
            return xr.DataArray(100 * separable_error(at))

        tables = self.study["finite_element"].sel(position=position)
        ratio = tables / tables.sel(laminate="C1") / self.study["published_laminate_factor"]
        gap = float(number(self.study["finite_element"]) - number(self.models[0]))
        return self._said_of("frequency", number)._replace(
            holds=abs(gap) < _SEPARABLE_WITHIN,
            numbers=100 * abs(ratio - 1).max("laminate").values,
            fails_if=f"the table's deviation and ours differ by {_SEPARABLE_WITHIN:g} % or more",
        )

    def factors(self, printed: str) -> Finding:
        """How far the frequency falls from C1 to C6."""
        tables = self.study["published_laminate_factor"].values
        found = laminate_factors(self.stacked).transpose("model", "laminate").values
        moved = laminate_factors(self.spreads).transpose("source", "laminate").values - found[0]
        spreads = np.sqrt((moved**2).sum(axis=0))
        # C1 has 1 by definition.
        bands = [Band(*each, no_effect=1.0) for each in zip(tables[1:], spreads[1:], strict=True)]
        by_tables, ours = (", ".join(f"{v:.3f}" for v in row) for row in (tables, found[0]))
        edges = ", ".join("{:.3f} to {:.3f}".format(*band.edges) for band in bands)
        return Finding(
            by_tables,
            ours,
            f"C6 {span(found[:, -1])}",
            holds=all(b.holds(own) for b, own in zip(bands, found[0, 1:], strict=True)),
            spread=", ".join(f"{each:.3f}" for each in spreads[1:]),
            decidable=all(band.decides for band in bands),
            fails_if=f"one of C2 to C6 is outside {edges}",
        )

    def moduli(self, printed: str) -> Finding:
        """How far it falls with the moduli and densities of Table 2."""
        printed_factor = float(self.study["published_laminate_factor"][-1])
        by_table_2 = self.study["frequency"].isel(layers=0)
        by_table_2 = by_table_2.sel(plies="table 2", beams=linkages.CONVERGED)
        found = float(laminate_factors(by_table_2)[-1])
        texts = Finding(f"{printed_factor:.3f}", f"{found:.3f}")
        return texts.judged_by(Band(printed_factor, no_effect=1.0), found, "", 3)

    def shape(self, printed: str) -> Finding:
        """Cases and positions against each other, whatever the scale."""
        tables, *found = (
            geometric_mean(frequency, "laminate")
            for frequency in (self.study["finite_element"], *self.models)
        )
        off = [100 * deviation_at_best_scale(each, tables) for each in found]
        level = 100 * deviation_at_best_scale(xr.ones_like(tables), tables)
        within = 100 * REPRODUCED_WITHIN
        return Finding(
            "",
            f"{off[0]:.0f} %",
            f"{span(off)} %, rigid joints {span(off[-2:])} %",
            holds=off[0] <= within,
            decidable=within < level,
            fails_if=(
                f"ours is off by more than {within:g} %; one frequency for all would be by "
                f"{level:.0f} %"
            ),
        )

    def mesh(self, printed: str) -> Finding:
        """One element a link, as the paper has it, against the converged frequencies."""
        found = self.study["frequency"]
        ratio = found.sel(beams=linkages.PAPERS_MESH) / found.sel(beams=linkages.CONVERGED)
        why = "nothing: it is what the paper does, and no claim of its outcome"
        return Finding("", f"{span(100 * (ratio - 1), 1)} % high", fails_if=why)

    def measurement(self, printed: str) -> Finding:
        """The paper's measured frequencies against those it computed."""
        gap = 100 * (self.study["measured"] / self.study["finite_element"] - 1)
        text = f"{span(gap, 1)} %, mean {float(gap.mean()):.1f} %"
        return Finding(text, "", fails_if="nothing: no number of ours stands beside them")

    def _ordered(
        self,
        quantity: str,
        dim: str,
        difference: Callable[[xr.DataArray], xr.DataArray],
        words: str,
        least: float = 0.0,
    ) -> Finding:
        """At how many places differences along a dimension have one sign; claimed is: at all."""
        size = self.study["damping"].size // self.study.sizes[dim]

        def count(values: xr.DataArray) -> xr.DataArray:
            holds = (difference(values) > least).all(dim)
            return holds.sum(set(_OVER) - {dim})

        def smallest(values: xr.DataArray) -> xr.DataArray:
            return difference(values).min(_OVER)

        found = self._said_of(quantity, count, f"in {{}} of {size}", 0)
        if quantity != "frequency":
            return found
        margin, spread = float(smallest(self.models[0])), self._spread(smallest)
        return found.judged_by_order(margin, spread, words, least)

    def _spread(self, number: Callable[[xr.DataArray], xr.DataArray]) -> float:
        """Standard uncertainty of a number that is taken of our frequencies."""
        own = float(number(self.models[0]))
        spread = float(np.sqrt(((number(self.spreads) - own) ** 2).sum()))
        # In bending positions and cases keep their ratios whatever the laminate.
        return spread if spread > 1e3 * ROUND_OFF * abs(own) else 0.0

    def _said_of(
        self,
        quantity: str,
        number: Callable[[xr.DataArray], xr.DataArray],
        form: str = "{} %",
        decimals: int = 2,
    ) -> Finding:
        """A number that is taken of values over position, laminate and case, not yet judged."""

        def words(values: xr.DataArray) -> str:
            return form.format(span(number(values), decimals))

        if quantity == "frequency":
            coarse = self.study["frequency"].isel(plies=0, layers=0, drop=True)
            further = (self.stacked[-2:], coarse.sel(beams=linkages.PAPERS_MESH, drop=True))
            return Finding(
                words(self.study["finite_element"]),
                words(self.models[0]),
                words(self.stacked),
                numbers=[words(each) for each in further],
            )
        # What the materials lose is not printed, and theories disagree.
        loss = self.study["strain_energy_damping"].sel(plies=["woven", "unidirectional"])
        first = loss.isel(plies=0, layers=0)
        bent, sheared = (first.sel(beams=b) for b in (linkages.CONVERGED, linkages.THIRD_ORDER))
        texts = (words(self.study["damping"]), words(bent), f"{words(sheared)} by third order")
        ranges = (100 * loss, self.study["damping"])
        return Finding(
            *texts,
            numbers=[float(f()) for each in ranges for f in (each.min, each.max)],
            fails_if="nothing: ours follows from a loss that is assumed",
        )


def _step(values: xr.DataArray, dim: str) -> xr.DataArray:
    """Relative change from each place along a dimension to the next."""
    return values.diff(dim) / values.shift({dim: 1})


def _over_others(values: xr.DataArray, dim: str, which: object) -> xr.DataArray:
    """Value at one place along a dimension over those at the others."""
    return values.sel({dim: which}) / values.drop_sel({dim: which})


def _fall(values: xr.DataArray, dim: str, high: object, low: object) -> xr.DataArray:
    """Mean decrease from one coordinate to another, in percent of the former."""
    ratio = values.sel({dim: low}, drop=True) / values.sel({dim: high}, drop=True)
    return 100 * (1 - ratio.mean(set(_OVER) - {dim}))
