"""How uncertain the outputs are where properties are, and which property makes them so."""

from __future__ import annotations

from concurrent.futures import Executor
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import xarray as xr

from flexmech import plots
from flexmech.analyses.digits import Quantity, percent
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary, Table
from flexmech.arrays import ROUND_OFF, FloatArray, LabelledProgress
from flexmech.errors import InputError
from flexmech.studies.designs.bands import bands_table, frequency_bands
from flexmech.studies.designs.campaign import evaluate_all
from flexmech.studies.designs.evaluation import Evaluated
from flexmech.studies.designs.result import (
    TOLD,
    designs_dataset,
    designs_table,
    finer_errors,
    reason_lines,
    status_line,
)
from flexmech.studies.designs.scatter import causes_of, with_failures
from flexmech.studies.designs.sobol_indices import (
    INDICES,
    poor_shares,
    share_text,
    sobol_shares,
)
from flexmech.studies.designs.study import Study, check_power_of_two, sobol_points
from flexmech.units import from_si

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PERCENTILES = {"p2_5": 2.5, "p50": 50.0, "p97_5": 97.5}
_SAMPLES = 1024
_BANDS = "frequency_percentile"


class Uncertainty(Result):
    """Distribution of outputs, and the share of every input in their variance.

    Parameters
    ----------
    dataset : xarray.Dataset
        Designs as of a ``DesignSweep``; ``mean``, ``std``, ``p2_5``, ``p50``, ``p97_5``, their
        standard errors, ``failure_probability`` and ``relative_error`` of a design over
        ``output``; ``first_order`` and ``total`` with ``_low`` and ``_high`` ends of their 95 %
        intervals over (output, input), where inputs are not correlated; ``frequency_percentile``
        over (percentile, mode, crank_angle), where an output is found from natural frequencies.
    stored_as : mapping of str to str, optional
        Of the file that it was loaded from.
    """

    stem = "uncertainty"
    subject = "uncertainty"
    hallmark = "failure_probability"
    files = (
        "uncertainty.csv",
        "sensitivity.csv",
        "designs.csv",
        "frequency_bands.csv",
        "uncertainty.nc",
        "uncertainty.png",
        "sensitivity.png",
        "frequency_bands.png",
    )

    def tables(self) -> dict[str, pd.DataFrame]:
        """Statistics, sensitivities where there are some, and designs."""
        data = self.dataset
        names = ["mean", "std", *PERCENTILES, "failure_probability"]
        of_outputs = data[names].to_dataframe().reset_index()
        tables = {self.stem: of_outputs[["output", *names]], "designs": designs_table(data)}
        if "total" in data:
            shares = [f"{name}{end}" for name in INDICES for end in ("", "_low", "_high")]
            found = data[shares].to_dataframe().reset_index()
            tables["sensitivity"] = found[["output", "input", *shares]]
        if _BANDS in data:
            tables["frequency_bands"] = bands_table(data[_BANDS])
        return tables

    def figures(self) -> dict[str, Figure]:
        """Distributions, shares of the inputs where they are known, and bands of frequencies."""
        figures = {self.stem: self.plot()}
        if "total" in self.dataset:
            figures["sensitivity"] = plots.plot_sensitivity(self.dataset)
        if _BANDS in self.dataset:
            figures["frequency_bands"] = plots.plot_frequency_bands(self.dataset)
        return figures

    def plot(self, *, ax: plots.AxesLike | None = None) -> Figure:
        """Draw the distribution of every output.

        Parameters
        ----------
        ax : matplotlib.axes.Axes or sequence of them, optional

        Returns
        -------
        matplotlib.figure.Figure
        """
        return plots.plot_distributions(self.dataset, ax=ax)

    def summary(self) -> Summary:
        """How far outputs scatter, how often limits fail, and what does it most."""
        data = self.dataset
        lines, numbers, rows = [], [], []
        for output in data["output"].values.tolist():
            own = data.sel(output=output)
            unit = data[output].attrs["shown_unit"]
            told = {name: from_si(float(own[name]), unit) for name in ("mean", "std", *PERCENTILES)}
            error = from_si(float(own["median_error"]), unit)
            median = Quantity("median", told["p50"], unit, error, output)
            numbers.append(median)
            failing = float(own["failure_probability"])
            rows.append(
                (output, unit, *(f"{value:.4g}" for value in told.values()), f"{failing:.3g}")
            )
            lines.append(
                f"{output} is {told['p2_5']:.4g} to {told['p97_5']:.4g} {unit} in 95 % of the "
                f"designs, its median {median}{_cause(own)}"
            )
        share = float(1 - data["within"].mean())
        lines.append(f"{100 * share:.3g} % of the designs fail a limit or cannot be computed")
        table = Table(
            f"uncertainty, {data.attrs['mechanism']}",
            ("output", "unit", "mean", "std", "2.5 %", "median", "97.5 %", "fails"),
            (tuple(rows),),
            text_columns=2,
        )
        spread = max(abs(one.error / one.value) if one.value else 0.0 for one in numbers)
        return Summary(
            ("; ".join(lines) + ".",),
            table,
            _trust(data, spread),
            warnings=poor_shares(data, data.sizes["design"] // 2),
            details=(
                status_line(data),
                *reason_lines(data),
                *_failure_lines(data),
                *_share_lines(data),
            ),
            numbers=tuple(numbers),
        )


def _trust(data: xr.Dataset, spread: float) -> str:
    """How far medians are known by the number of designs, and the outputs of one of them."""
    error = float(data["relative_error"].max(skipna=False))
    model = f"each design to {percent(max(error, TOLD))}"
    if not np.isfinite(error):
        model = "errors of the designs themselves are not estimated"
    return (
        f"medians are known to {100 * spread:.2g} % by {data.sizes['design']} designs, {model}; "
        f"the {data.attrs['engine']} engine alone ran"
    )


def _cause(own: xr.Dataset) -> str:
    """What an output depends on most."""
    if "total" not in own or not np.isfinite(own["total"]).all():
        return ""
    most = str(own["total"].idxmax().item())
    return f", most by {most} ({share_text(own, most)})"


def _failure_lines(data: xr.Dataset) -> list[str]:
    """How designs that fail count, where there are some."""
    if (data["status"] == "ok").all():
        return []
    return [
        f"designs that cannot be computed count as {data.attrs['failures_count_as']} in moments, "
        "percentiles and shares, and as failing"
    ]


def _share_lines(data: xr.Dataset) -> list[str]:
    if "total" not in data:
        return [str(data.attrs["no_shares"])]
    lines = []
    for output in data["output"].values.tolist():
        own = data.sel(output=output)
        told = ", ".join(
            f"{name} {float(own['total'].sel(input=name)):.2f} "
            f"({float(own['total_low'].sel(input=name)):.2f} to "
            f"{float(own['total_high'].sel(input=name)):.2f})"
            for name in data["input"].values.tolist()
        )
        lines.append(f"total share in the variance of {output}: {told}")
    return lines


def runs_line(study: Study, samples: int | None = None) -> str:
    """How many designs are computed: N (D + 2) of D inputs, or N where they are correlated.

    Parameters
    ----------
    study : Study
    samples : int, optional
        N; 1024 if left out.

    Returns
    -------
    str

    Raises
    ------
    InputError
        If the number of samples is no power of two.
    """
    count, inputs = _SAMPLES if samples is None else samples, len(_inputs(study))
    check_power_of_two(count, "samples", least=8)
    if study.correlations:
        return f"{count} designs are computed, of inputs that are correlated"
    return (
        f"{count * (inputs + 2)} designs are computed: N (D + 2) of N = {count} samples and "
        f"D = {inputs} inputs"
    )


def uncertainty_study(
    study: Study,
    samples: int | None = None,
    *,
    executor: Executor | None = None,
    progress: LabelledProgress | None = None,
    folder: Path | None = None,
    resume: bool = False,
) -> Uncertainty:
    """Distribution of a study's outputs, and the share of every input in their variance.

    The designs are Saltelli's A, B and A_B of Sobol's method (Saltelli et al. 2010, *Computer
    Physics Communications* 181), whose indices have bootstrap intervals drawn by the study's seed.

    Parameters
    ----------
    study : Study
        Variables with distributions; a range counts as uniform.
    samples : int, optional
        N, a power of two; 1024 if left out.
    executor : concurrent.futures.Executor, optional
    progress : callable, optional
        Called as ``progress(label, done, total)``.
    folder : Path, optional
        Where ``designs.zarr`` is kept.
    resume : bool

    Returns
    -------
    Uncertainty

    Raises
    ------
    InputError
        If the number of samples is no power of two, or designs fail and the study does not say
        what a failure is worth.
    ComputationError
        If a worker was killed.
    """
    samples = _SAMPLES if samples is None else samples
    check_power_of_two(samples, "samples", least=8)
    inputs = _inputs(study)
    designs = _designs(study, inputs, samples)
    found = evaluate_all(
        study,
        designs,
        executor=executor,
        progress=progress,
        folder=folder,
        resume=resume,
        content={"samples": samples},
    )
    values = _complete(study, found)
    # Of A and B: the designs of A_B repeat their numbers.
    independent = slice(0, samples if study.correlations else 2 * samples)
    own = Evaluated(
        found.values[independent], found.status[independent], found.reasons[independent]
    )
    dataset = designs_dataset(study, designs[independent], own)
    dataset = dataset.merge(_statistics(study, values[independent], dataset))
    dataset = dataset.assign(relative_error=_error_of_a_design(study, dataset, designs, executor))
    worth = [f"{name} {study.outputs[name].told(v)}" for name, v in study.failure_values.items()]
    dataset = dataset.assign_attrs(failures_count_as=", ".join(worth))
    dataset = dataset.merge(frequency_bands(study, designs[independent]))
    if study.correlations:
        why = "inputs are correlated: shares in the variance are not defined (Sobol's method)"
        return Uncertainty(dataset.assign_attrs(no_shares=why))
    parts = values.reshape(len(inputs) + 2, samples, len(study.outputs))
    return Uncertainty(dataset.merge(sobol_shares(parts, list(study.outputs), inputs, study.seed)))


def _inputs(study: Study) -> list[str]:
    """Names of the variables that vary: one value has no share, and takes no runs."""
    names = [variable.name for variable in study.variables if not variable.is_fixed]
    if not names:
        raise InputError(
            "vary: every variable has one value, and nothing is uncertain; give one of them "
            "normal, lognormal, uniform or range = [...]"
        )
    return names


def _designs(study: Study, inputs: list[str], samples: int) -> FloatArray:
    """A, B and one A_B for each input, one after the other, or A alone."""
    count = len(inputs)
    if study.correlations:
        points = sobol_points(samples, count, study.seed)
    else:
        both = sobol_points(samples, 2 * count, study.seed)
        first, second = both[:, :count], both[:, count:]
        mixed = []
        for number in range(count):
            own = first.copy()
            own[:, number] = second[:, number]
            mixed.append(own)
        points = np.concatenate([first, second, *mixed])
    # Of what has one value any probability gives it.
    whole = np.full((len(points), len(study.variables)), 0.5)
    whole[:, [study.names.index(name) for name in inputs]] = points
    return study.at(whole)


def _complete(study: Study, found: Evaluated) -> FloatArray:
    """Outputs with what a failure is worth; refused where that is not said.

    One number that is missing makes every one of Sobol's indices zero, without a word.
    """
    values = with_failures(study, found)
    if np.isnan(values).any():
        raise InputError(
            f"{100 * (found.status != 0).mean():.2g} % of the designs cannot be computed "
            f"({causes_of(found)}; the first: {next(filter(None, found.reasons))}); narrow the "
            "ranges, or say in failure_values what each output counts as then"
        )
    return values


def _error_of_a_design(
    study: Study, dataset: xr.Dataset, designs: FloatArray, executor: Executor | None
) -> tuple[str, FloatArray]:
    """Relative errors of the outputs of the design that is nearest to all medians, (m,)."""
    known = np.flatnonzero(dataset["status"].values == "ok")
    values = np.stack([dataset[name].values[known] for name in study.outputs], axis=1)
    away = np.abs(values - dataset["p50"].values) / np.maximum(dataset["std"].values, ROUND_OFF)
    middle = int(away.max(axis=1).argmin())
    row = known[middle : middle + 1]
    return "output", finer_errors(study, designs[row], values[middle : middle + 1], executor)[0]


def _statistics(study: Study, values: FloatArray, dataset: xr.Dataset) -> xr.Dataset:
    """Moments, percentiles and failures over ``output``."""
    outputs = list(study.outputs)
    found: dict[str, Any] = {
        "mean": values.mean(axis=0),
        "std": values.std(axis=0, ddof=1),
        **{name: np.percentile(values, part, axis=0) for name, part in PERCENTILES.items()},
    }
    # Order statistics half a standard deviation of their binomial count away on either side.
    apart = 50.0 / np.sqrt(len(values))
    ends = np.percentile(values, [50.0 - apart, 50.0 + apart], axis=0)
    found["median_error"] = (ends[1] - ends[0]) / 2
    failing = []
    for name in outputs:
        beyond = dataset["status"].values != "ok"
        for limit in study.limits:
            if limit.output == name:
                column = values[:, outputs.index(name)]
                beyond = beyond | (limit.violation(column) > 0)
        failing.append(beyond.mean())
    found["failure_probability"] = np.array(failing)
    return xr.Dataset({name: ("output", each) for name, each in found.items()}, {"output": outputs})
