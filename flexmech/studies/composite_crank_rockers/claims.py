"""What Elamy et al. 2023 claim of their crank-rockers, put to the test claim by claim.

Numbers of the text are first computed from the paper's own tables, then from ours: from
converged bending beams of unidirectional plies, and from every other model of the study, so
that a verdict does not hang on the choice of one. The claims are in ``data/claims.toml``, each
with the name of the method that tests it here and its arguments.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from importlib import resources

import numpy as np
import xarray as xr

from flexmech.linkages import synthesize_crank_rocker
from flexmech.studies.claim import REPRODUCED_WITHIN, Claim, Verdict, verdict_on, within_a_tenth
from flexmech.studies.composite_crank_rockers.linkages import CONVERGED, PAPERS_MESH, WITH_SHEAR
from flexmech.studies.composite_crank_rockers.published import LAMINATES, published_case
from flexmech.studies.composite_crank_rockers.structure import (
    deviation_at_best_scale,
    geometric_mean,
    laminate_factors,
    separable_error,
)

__all__ = ["all_models", "composite_claims"]

# Printed limits are held to half a degree.
LIMIT_TOLERANCE = 0.5
# Of Tables 5 and 6, in percent: so near to separable that rounding of the printed digits
# explains it.
SEPARABLE_WITHIN = 1.0
# In bending all linkages of one laminate lose the same part: differences below this are the
# mesh's error.
MARGIN = 1e-3


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
    file = resources.files("flexmech.studies") / "composite_crank_rockers/data/claims.toml"
    printed = tomllib.loads(file.read_text(encoding="utf-8"))
    tests, claims = _Tests(study), []
    for place, statement, said, test, reason in printed["claims"]:
        name, *arguments = test.split()
        found = getattr(tests, name)(said, *arguments)
        why = printed["reasons"][reason].format(*found.numbers) if reason else ""
        texts = (found.from_tables, found.computed, found.other_models)
        claims.append(Claim(place, statement, said, *texts, found.verdict, why))
    return claims


def all_models(study: xr.Dataset) -> list[xr.DataArray]:
    """Frequencies over position, laminate and case by each model, the converged one first.

    Every model comes twice: in both postures with a right transmission angle.

    Parameters
    ----------
    study : Dataset

    Returns
    -------
    list of DataArray
    """
    frequency = study["frequency"]
    other = frequency.where(frequency["position"] != "90", study["other_posture"])
    models = [
        {"plies": plies, "beams": beams}
        for plies in study["plies"].values
        for beams in study["beams"].values
    ]
    models.sort(key=lambda model: model != {"plies": "unidirectional", "beams": CONVERGED})
    postures = (frequency, other.transpose(*frequency.dims))
    return [each.sel(model, drop=True) for each in postures for model in models]


@dataclass(frozen=True)
class _Finding:
    """Texts of a claim and its verdict, and the numbers that its reason names."""

    from_tables: str
    computed: str
    other_models: str = ""
    verdict: Verdict = "not checkable"
    numbers: tuple[float, ...] = ()


@dataclass(frozen=True)
class _Test:
    """A number that is taken of values over position, laminate and case, and its words."""

    number: Callable[[xr.DataArray], float]
    holds: Callable[[float, float], bool] = within_a_tenth
    form: str = "{} %"
    decimals: int = 2

    def words(self, *values: xr.DataArray) -> str:
        """The number in words: of one set of values, or the least and greatest of several."""
        numbers = [self.number(each) for each in values]
        ends = (f"{end:.{self.decimals}f}" for end in (min(numbers), max(numbers)))
        # The same end twice is one number.
        return self.form.format(" to ".join(dict.fromkeys(ends))).replace("-0.00", "0.00")

    def verdict(self, published: xr.DataArray, ours: xr.DataArray) -> Verdict:
        """From the numbers of the printed tables and of ours."""
        return verdict_on(self.holds(self.number(published), self.number(ours)))


@dataclass(frozen=True)
class _Tests:
    """Tests by the names that the claims have for them; the first argument is what is printed."""

    study: xr.Dataset

    @cached_property
    def models(self) -> list[xr.DataArray]:
        """Frequencies by all models, ours first."""
        return all_models(self.study)

    def limits(self, printed: str, case: str) -> _Finding:
        """Limits of the transmission angle."""
        limits = np.degrees(published_case(int(case)).transmission_angle_limits())
        gap = np.abs(limits - [float(number) for number in re.findall(r"[\d.]+", printed)])
        text = "{:.2f} to {:.2f} deg".format(*limits)
        return _Finding(text, text, "", verdict_on(gap.max() <= LIMIT_TOLERANCE), tuple(gap))

    def ranges(self, printed: str, *cases: str) -> _Finding:
        """How far the transmission angle reaches."""
        spans = [np.ptp(published_case(int(case)).transmission_angle_limits()) for case in cases]
        degrees = np.degrees(spans)
        text = ", ".join(f"case {c} {v:.1f} deg" for c, v in zip(cases, degrees, strict=True))
        return _Finding(text, text, "", verdict_on(degrees.min() >= 60))

    def design(self, printed: str, deviation: str, rocker_angle: str) -> _Finding:
        """Proportions by equations 11 to 17."""
        found = synthesize_crank_rocker(*np.radians([float(deviation), float(rocker_angle)]))
        lengths = [float(length) for length in (found.crank, found.coupler, found.rocker)]
        text = ", ".join(f"{length:.4f}" for length in lengths)
        rounded = ", ".join(f"{length:.2f}" for length in lengths)
        return _Finding(text, text, "", verdict_on(rounded == printed))

    def frequency(self, printed: str, *test: str) -> _Finding:
        """What is said of frequencies."""
        return self._of_models(_test(self.models[0], *test), self.study["finite_element"])

    def damping(self, printed: str, *test: str) -> _Finding:
        """What is said of damping: what the materials lose is not printed, theories disagree."""
        loss = self.study["strain_energy_damping"].sel(plies=["unidirectional", "woven"])
        bent, sheared = (loss.sel(plies="unidirectional", beams=b) for b in (CONVERGED, WITH_SHEAR))
        words = _test(bent, *test).words
        texts = (words(self.study["damping"]), words(bent), f"{words(sheared)} with shear")
        return _Finding(*texts, numbers=(100 * float(loss.min()), 100 * float(loss.max())))

    def swapped(self, printed: str) -> _Finding:
        """Two numbers in the order of the abstract."""
        published = self.study["finite_element"]
        by_tables, ours = (
            " and ".join(f"{_fall(f, 'position', high, '90'):.2f}" for high in ("max", "min"))
            for f in (published, self.models[0])
        )
        return _Finding(f"{by_tables} %", f"{ours} %", "", "not reproduced")

    def separable(self, printed: str, position: str) -> _Finding:
        """Whether frequency is a factor of the laminate times one of the case."""
        published = self.study["finite_element"].sel(position=position)
        ratio = published / published.sel(laminate="C1") / self.study["published_laminate_factor"]
        return self._of_models(
            _Test(
                lambda values: 100 * separable_error(values),
                lambda from_tables, ours: from_tables < SEPARABLE_WITHIN,
            ),
            published,
            tuple(100 * abs(ratio - 1).max("laminate").values),
            position=position,
        )

    def factors(self, printed: str) -> _Finding:
        """How far the frequency falls from C1 to C6."""
        published = self.study["published_laminate_factor"].values
        found = np.array([laminate_factors(frequency).values for frequency in self.models])
        by_tables, ours = (", ".join(f"{v:.3f}" for v in row) for row in (published, found[0]))
        others = f"C6 {found[:, -1].min():.2f} to {found[:, -1].max():.2f}"
        near = np.allclose(found[0], published, rtol=REPRODUCED_WITHIN)
        return _Finding(by_tables, ours, others, verdict_on(near))

    def moduli(self, printed: str) -> _Finding:
        """How far it would fall by Table 2."""
        published = float(self.study["published_laminate_factor"][-1])
        first, *_, last = (each.youngs_modulus / each.density for each in LAMINATES.values())
        root = np.sqrt(last / first)
        verdict = verdict_on(within_a_tenth(published, root))
        return _Finding(f"{published:.3f}", f"{root:.3f}", "", verdict)

    def shape(self, printed: str) -> _Finding:
        """Cases and positions against each other, whatever the scale."""
        published = geometric_mean(self.study["finite_element"], "laminate")
        off = [
            100 * deviation_at_best_scale(geometric_mean(frequency, "laminate"), published)
            for frequency in self.models
        ]
        others = f"{min(off):.2f} to {max(off):.2f} %"
        near = verdict_on(off[0] <= 100 * REPRODUCED_WITHIN)
        return _Finding("0 %", f"{off[0]:.0f} %", others, near)

    def mesh(self, printed: str) -> _Finding:
        """One element a link, as the paper has it, against the converged frequencies."""
        one, many = (self.study["frequency"].sel(beams=b) for b in (PAPERS_MESH, CONVERGED))
        error = 100 * (one / many - 1)
        return _Finding("", f"{float(error.min()):.1f} to {float(error.max()):.1f} % high")

    def measurement(self, printed: str) -> _Finding:
        """The paper's measured frequencies against those it computed."""
        gap = 100 * (self.study["measured"] / self.study["finite_element"] - 1)
        least, greatest, mean = (float(each) for each in (gap.min(), gap.max(), gap.mean()))
        return _Finding(f"{least:.1f} to {greatest:.1f} %, mean {mean:.1f} %", "")

    def _of_models(
        self,
        test: _Test,
        published: xr.DataArray,
        numbers: tuple[float, ...] = (),
        **place: str,
    ) -> _Finding:
        models = [frequency.sel(place) for frequency in self.models]
        texts = (test.words(published), test.words(models[0]), test.words(*models))
        return _Finding(*texts, test.verdict(published, models[0]), numbers)


def _test(values: xr.DataArray, name: str, *words: str) -> _Test:
    """Test by its name and what it says of a dimension and coordinates along it."""
    dim = words[0] if words else "laminate"
    places = [values[dim].dtype.type(word) for word in words[1:]]
    if name == "fall":
        return _Test(lambda v: _fall(v, dim, *places))
    holds = CONDITIONS[name]
    size = values.size // values.sizes[dim]
    return _Test(
        lambda v: int(holds(v, dim, *places).sum()),
        lambda from_tables, ours: ours == size,
        f"in {{}} of {size}",
        0,
    )


def _fall(values: xr.DataArray, dim: str, high: object, low: object) -> float:
    """Mean decrease from one coordinate to another, in percent of the former."""
    ratio = values.sel({dim: low}).values / values.sel({dim: high}).values
    return float(100 * (1 - ratio.mean()))


def _falling(values: xr.DataArray, dim: str) -> xr.DataArray:
    return (values.diff(dim) < 0).all(dim)


def _rising(values: xr.DataArray, dim: str) -> xr.DataArray:
    return (values.diff(dim) >= 0).all(dim)


def _lowest(values: xr.DataArray, dim: str, which: object) -> xr.DataArray:
    one, others = values.sel({dim: which}), values.drop_sel({dim: which})
    return one < (1 - MARGIN) * others.min(dim)


def _highest(values: xr.DataArray, dim: str, which: object) -> xr.DataArray:
    one, others = values.sel({dim: which}), values.drop_sel({dim: which})
    return one > (1 + MARGIN) * others.max(dim)


CONDITIONS: dict[str, Callable[..., xr.DataArray]] = {
    "rising": _rising,
    "falling": _falling,
    "lowest": _lowest,
    "highest": _highest,
}
