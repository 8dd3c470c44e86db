"""What Elamy et al. 2023 claim of their crank-rockers, put to the test claim by claim.

Numbers of the text are first computed from the paper's own tables, then from ours: from
converged bending beams of unidirectional plies, and from every other model of the study, so
that a verdict does not hang on the choice of one. Ours are held against what is printed, or,
where the text prints no number, against the tables. The claims are in ``data/claims.toml``, each
with the name of the method that tests it here and its arguments.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray
from flexmech.linkages import synthesize_crank_rocker
from flexmech.studies.claim import REPRODUCED_WITHIN, Claim, verdict_on, within_a_tenth
from flexmech.studies.composite_crank_rockers import linkages

# Printed limits are held to half a degree.
_LIMIT_TOLERANCE = 0.5
# Of Tables 5 and 6 against ours, in percent: as near to separable as the rounding of the printed
# digits leaves them.
_SEPARABLE_WITHIN = 1.0
# In bending all linkages of one laminate lose the same part: differences below this are the
# mesh's error.
_MARGIN = 1e-3


def composite_claims(study: xr.Dataset) -> list[Claim]:
    """Claims of the paper against a study.

    Parameters
    ----------
    study : Dataset
        Of :class:`flexmech.studies.CompositeStudy`.

    Returns
    -------
    list of Claim
        Ours are the converged frequencies with unidirectional plies.
    """
    stored, tests, claims = linkages.stored_table("claims.toml"), _Tests(study), []
    for place, statement, printed, (test, *arguments), reason in stored["claims"]:
        found: _Finding = getattr(tests, test)(printed, *arguments)
        reasons = stored["reasons"] | (stored["reasons_of_misses"] if found.holds is False else {})
        why = reasons.get(reason, "").format(*found.numbers)
        texts = (found.from_tables, found.computed, found.other_models)
        claims.append(Claim(place, statement, printed, *texts, verdict_on(found.holds), why))
    return claims


def all_models(study: xr.Dataset) -> list[xr.DataArray]:
    """Frequencies over position, laminate and case by each model, the converged one first.

    Every model comes twice: in both configurations with a right transmission angle.

    Parameters
    ----------
    study : Dataset

    Returns
    -------
    list of DataArray
    """
    frequency = study["frequency"]
    other = frequency.where(frequency["position"] != "90", study["other_configuration"])
    return [
        each.sel(plies=plies, beams=beams, drop=True)
        for each in (frequency, other.transpose(*frequency.dims))
        for plies, beams in product(linkages.PLY_MODELS, linkages.BEAMS)
    ]


class _Finding(NamedTuple):
    """Texts of a claim, whether it holds if that can be checked, and numbers for its reason."""

    from_tables: str
    computed: str
    other_models: str = ""
    holds: bool | None = None
    numbers: Iterable[float] = ()


@dataclass(frozen=True)
class _Tests:
    """Tests by the names that the claims have for them; the first argument is what is printed.

    A ``quantity`` is ``"frequency"`` or ``"damping"``.
    """

    study: xr.Dataset

    @cached_property
    def models(self) -> list[xr.DataArray]:
        """Frequencies by all models, ours first."""
        return all_models(self.study)

    def limits(self, printed: str, case: int) -> _Finding:
        """Limits of the transmission angle."""
        limits = _limits(case)
        gap = np.abs(limits - _numbers(printed))
        text = f"{_span(limits)} deg"
        return _Finding(text, text, holds=bool(gap.max() <= _LIMIT_TOLERANCE), numbers=gap)

    def ranges(self, printed: str, *cases: int) -> _Finding:
        """How far the transmission angle reaches."""
        spans = {case: np.ptp(_limits(case)) for case in cases}
        text = ", ".join(f"case {case} {span:.1f} deg" for case, span in spans.items())
        least = _numbers(printed)[0]
        return _Finding(text, text, holds=bool(min(spans.values()) >= least))

    def design(self, printed: str, deviation: float, rocker_angle: float) -> _Finding:
        """Proportions by equations 11 to 17."""
        found = synthesize_crank_rocker(*np.radians([deviation, rocker_angle]))
        lengths = (found.crank, found.coupler, found.rocker)
        text, rounded = (", ".join(f"{x:.{n}f}" for x in lengths) for n in (4, 2))
        return _Finding(text, text, holds=rounded == printed)

    def fall(self, printed: str, quantity: str, dim: str, high: object, low: object) -> _Finding:
        """Mean decrease along a dimension."""
        (claimed,) = _numbers(printed)
        return self._said_of(
            quantity,
            lambda values: _fall(values, dim, high, low),
            lambda from_tables, ours: within_a_tenth(claimed, ours),
        )

    def falling(self, printed: str, quantity: str, dim: str) -> _Finding:
        """Where each value along a dimension is below the one before."""
        return self._count_of(quantity, dim, lambda values: values.diff(dim) < 0)

    def rising(self, printed: str, quantity: str, dim: str) -> _Finding:
        """Where no value along a dimension is below the one before."""
        return self._count_of(quantity, dim, lambda values: values.diff(dim) >= 0)

    def lowest(self, printed: str, quantity: str, dim: str, which: object) -> _Finding:
        """Where one place along a dimension has the lowest value."""
        return self._count_of(quantity, dim, lambda v: _over_others(v, dim, which) < 1 - _MARGIN)

    def highest(self, printed: str, quantity: str, dim: str, which: object) -> _Finding:
        """Where one place along a dimension has the highest value."""
        return self._count_of(quantity, dim, lambda v: _over_others(v, dim, which) > 1 + _MARGIN)

    def swapped(self, printed: str) -> _Finding:
        """Two numbers in the order of the abstract."""
        by_tables, ours = (
            [_fall(frequency, "position", high, "90") for high in ("max", "min")]
            for frequency in (self.study["finite_element"], self.models[0])
        )
        texts = [" and ".join(f"{fall:.2f}" for fall in both) for both in (by_tables, ours)]
        near = all(map(within_a_tenth, _numbers(printed), ours))
        return _Finding(f"{texts[0]} %", f"{texts[1]} %", holds=near)

    def separable(self, printed: str, position: str) -> _Finding:
        """Whether frequency is a factor of the laminate times one of the case."""
        found = self._said_of(
            "frequency",
            lambda values: 100 * separable_error(values.sel(position=position)),
            lambda from_tables, ours: abs(from_tables - ours) < _SEPARABLE_WITHIN,
        )
        tables = self.study["finite_element"].sel(position=position)
        ratio = tables / tables.sel(laminate="C1") / self.study["published_laminate_factor"]
        return found._replace(numbers=100 * abs(ratio - 1).max("laminate").values)

    def factors(self, printed: str) -> _Finding:
        """How far the frequency falls from C1 to C6."""
        tables = self.study["published_laminate_factor"].values
        found = np.array([laminate_factors(frequency) for frequency in self.models])
        by_tables, ours = (", ".join(f"{v:.3f}" for v in row) for row in (tables, found[0]))
        near = np.allclose(found[0], tables, rtol=REPRODUCED_WITHIN)
        return _Finding(by_tables, ours, f"C6 {_span(found[:, -1])}", near)

    def moduli(self, printed: str) -> _Finding:
        """How far it falls with the moduli and densities of Table 2."""
        printed_factor = float(self.study["published_laminate_factor"][-1])
        by_table_2 = self.study["frequency"].sel(plies="table 2", beams=linkages.CONVERGED)
        found = float(laminate_factors(by_table_2)[-1])
        near = within_a_tenth(printed_factor, found)
        return _Finding(f"{printed_factor:.3f}", f"{found:.3f}", "", near)

    def shape(self, printed: str) -> _Finding:
        """Cases and positions against each other, whatever the scale."""
        tables, *found = (
            geometric_mean(frequency, "laminate")
            for frequency in (self.study["finite_element"], *self.models)
        )
        off = [100 * deviation_at_best_scale(each, tables) for each in found]
        near = off[0] <= 100 * REPRODUCED_WITHIN
        return _Finding("", f"{off[0]:.0f} %", f"{_span(off)} %", near)

    def mesh(self, printed: str) -> _Finding:
        """One element a link, as the paper has it, against the converged frequencies."""
        found = self.study["frequency"]
        ratio = found.sel(beams=linkages.PAPERS_MESH) / found.sel(beams=linkages.CONVERGED)
        return _Finding("", f"{_span(100 * (ratio - 1), 1)} % high")

    def measurement(self, printed: str) -> _Finding:
        """The paper's measured frequencies against those it computed."""
        gap = 100 * (self.study["measured"] / self.study["finite_element"] - 1)
        return _Finding(f"{_span(gap, 1)} %, mean {float(gap.mean()):.1f} %", "")

    def _count_of(
        self, quantity: str, dim: str, condition: Callable[[xr.DataArray], xr.DataArray]
    ) -> _Finding:
        """At how many places a condition holds all along a dimension; claimed is: at all."""
        size = self.study["damping"].size // self.study.sizes[dim]

        def count(values: xr.DataArray) -> int:
            return int(condition(values).all(dim).sum())

        found = self._said_of(
            quantity,
            count,
            lambda from_tables, ours: ours == size,
            form=f"in {{}} of {size}",
            decimals=0,
        )
        if quantity == "frequency":
            coarse = self.study["frequency"].sel(
                plies="unidirectional", beams=linkages.PAPERS_MESH, drop=True
            )
            return found._replace(numbers=[count(coarse), size])
        return found

    def _said_of(
        self,
        quantity: str,
        number: Callable[[xr.DataArray], float],
        holds: Callable[[float, float], bool],
        form: str = "{} %",
        decimals: int = 2,
    ) -> _Finding:
        """A number that is taken of values over position, laminate and case."""

        def words(*values: xr.DataArray) -> str:
            return form.format(_span([number(each) for each in values], decimals))

        if quantity == "frequency":
            tables, ours = self.study["finite_element"], self.models[0]
            right = holds(number(tables), number(ours))
            return _Finding(words(tables), words(ours), words(*self.models), right)
        # What the materials lose is not printed, and theories disagree.
        loss = self.study["strain_energy_damping"].sel(plies=["unidirectional", "woven"])
        straight = loss.sel(plies="unidirectional")
        bent, sheared = (straight.sel(beams=b) for b in (linkages.CONVERGED, linkages.WITH_SHEAR))
        texts = (words(self.study["damping"]), words(bent), f"{words(sheared)} with shear")
        ranges = (100 * loss, self.study["damping"])
        return _Finding(
            *texts, numbers=[float(f()) for each in ranges for f in (each.min, each.max)]
        )


def _numbers(printed: str) -> list[float]:
    """Numbers in what is printed."""
    return [float(number) for number in re.findall(r"[\d.]+", printed)]


def _limits(case: int) -> FloatArray:
    """Least and greatest transmission angle of a linkage in degrees."""
    return np.degrees(linkages.published_case(case).transmission_angle_limits())


def _span(numbers: ArrayLike, decimals: int = 2) -> str:
    """Least and greatest of numbers in words, or the one that both are."""
    ends = (f"{end:z.{decimals}f}" for end in (np.min(numbers), np.max(numbers)))
    return " to ".join(dict.fromkeys(ends))


def _over_others(values: xr.DataArray, dim: str, which: object) -> xr.DataArray:
    """Value at one place along a dimension over those at the others."""
    return values.sel({dim: which}) / values.drop_sel({dim: which})


def _fall(values: xr.DataArray, dim: str, high: object, low: object) -> float:
    """Mean decrease from one coordinate to another, in percent of the former."""
    ratio = values.sel({dim: low}).values / values.sel({dim: high}).values
    return float(100 * (1 - ratio.mean()))


def laminate_factors(frequency: xr.DataArray) -> xr.DataArray:
    """Factor s of each laminate against C1: geometric mean over cases and positions.

    Linear theory with one modulus and one density a laminate gives the same ratio of two
    laminates in every linkage and position: frequency = s(laminate) q(case, position).

    Parameters
    ----------
    frequency : DataArray
        Over ``laminate``, and ``position`` or ``case`` or both.

    Returns
    -------
    DataArray
        Over ``laminate`` and whatever other dimensions there are.
    """
    ratio = frequency / frequency.sel(laminate="C1")
    return geometric_mean(ratio, [d for d in frequency.dims if d in ("position", "case")])


def geometric_mean(values: xr.DataArray, dims: str | list[Hashable]) -> xr.DataArray:
    """Geometric mean over dimensions.

    Parameters
    ----------
    values : DataArray
        Positive.
    dims : str or list of str

    Returns
    -------
    DataArray
    """
    logarithm: xr.DataArray = xr.apply_ufunc(np.log, values)
    mean: xr.DataArray = xr.apply_ufunc(np.exp, logarithm.mean(dims))
    return mean


def separable_error(frequency: xr.DataArray) -> float:
    """Greatest deviation from a factor of the laminate times one of the rest, relative.

    Parameters
    ----------
    frequency : DataArray
        Over ``laminate`` and others.

    Returns
    -------
    float
    """
    whole = frequency.transpose("laminate", ...).values
    logarithm = np.log(whole.reshape(len(whole), -1))
    rest = logarithm - logarithm.mean(axis=0) - logarithm.mean(axis=1, keepdims=True)
    return float(np.abs(np.expm1(rest + logarithm.mean())).max())


def deviation_at_best_scale(computed: xr.DataArray, published: xr.DataArray) -> float:
    """Greatest relative deviation from published values, left by the scale that makes it least.

    With ratios of computed to published values from a to b that scale is 2 / (a + b), and
    what it leaves (b - a) / (a + b).

    Parameters
    ----------
    computed, published : DataArray
        Positive, of the same dimensions.

    Returns
    -------
    float
    """
    ratio = computed / published
    low, high = float(ratio.min()), float(ratio.max())
    return (high - low) / (high + low)
