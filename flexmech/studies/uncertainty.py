"""How uncertain the outputs are where properties are, and which property makes them so.

Over the crank angle, natural frequencies have medians and intervals. Sobol's indices are the share
of every input in the variance of an output:

Saltelli et al. 2010, *Computer Physics Communications* 181, 259-270, table 2 (b) and (f), with
intervals by the bootstrap (Efron 1987, *Journal of the American Statistical Association* 82,
171-185, BCa).
"""

from __future__ import annotations

import math
import warnings
from concurrent.futures import Executor
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import scipy
import xarray as xr

from flexmech import plots
from flexmech.analyses.default_engines import engine_kind
from flexmech.analyses.digits import Quantity, percent
from flexmech.analyses.frequencies.positions import frequencies_at
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary, Table
from flexmech.arrays import ROUND_OFF, FloatArray, LabelledProgress
from flexmech.errors import InputError
from flexmech.mechanics import Engine
from flexmech.solvers.formulation import Formulation
from flexmech.studies.campaign import evaluate_all
from flexmech.studies.design import turn
from flexmech.studies.evaluation import Evaluated, design_of, guarded
from flexmech.studies.outputs import OF_FREQUENCIES, Output
from flexmech.studies.result import (
    LEAST_ERROR,
    designs_dataset,
    designs_table,
    finer_errors,
    reason_lines,
    status_line,
)
from flexmech.studies.scatter import causes_of, with_failures
from flexmech.studies.study import Study, check_power_of_two, sobol_points
from flexmech.units import from_si

if TYPE_CHECKING:
    from matplotlib.figure import Figure


MOST_DESIGNS = 64
"""Most designs whose frequencies are drawn, the first of a sample: they too are spread evenly."""
DRAWN_PERCENTILES = (2.5, 50.0, 97.5)
# With fewer designs the interval of 95 % would be that of the outermost ones.
_LEAST_DESIGNS = 8


def frequency_bands(study: Study, designs: FloatArray) -> xr.Dataset:
    """Percentiles of the natural frequencies over the crank angle.

    They are of the speed, prestress and crank angles of the study's first output that is found
    from natural frequencies. Modes are in ascending order at every crank angle.

    Parameters
    ----------
    study : Study
    designs : ndarray, shape (n, k)
        Designs of a sample; the first :data:`MOST_DESIGNS` of them are taken.

    Returns
    -------
    xarray.Dataset
        ``frequency_percentile`` in Hz over (percentile, mode, crank_angle), with the number of
        designs in its attribute ``designs``; empty where no output is found from frequencies, or
        few designs can be computed.
    """
    asked = [output for output in study.outputs.values() if output.quantity in OF_FREQUENCIES]
    if not asked:
        return xr.Dataset()
    frequencies = _frequencies(study, asked[0], designs[:MOST_DESIGNS])
    if len(frequencies) < _LEAST_DESIGNS:
        return xr.Dataset()
    parts = np.percentile(np.array(frequencies), DRAWN_PERCENTILES, axis=0, method="hazen")
    # A turn ends where it begins.
    angles = np.append(turn(asked[0].angles), 2 * np.pi)
    parts = np.concatenate([parts, parts[:, :1]], axis=1)
    return xr.Dataset(
        {
            "frequency_percentile": (
                ("percentile", "crank_angle", "mode"),
                parts,
                {"units": "Hz", "long_name": "natural frequency", "designs": len(frequencies)},
            )
        },
        {
            "percentile": ("percentile", list(DRAWN_PERCENTILES), {"units": "%"}),
            "crank_angle": ("crank_angle", angles, {"units": "rad"}),
            "mode": np.arange(1, parts.shape[2] + 1),
        },
    ).transpose("percentile", "mode", "crank_angle")


def bands_table(bands: xr.DataArray) -> pd.DataFrame:
    """Percentiles of the natural frequencies as columns, modes one after the other.

    Parameters
    ----------
    bands : xarray.DataArray
        The ``frequency_percentile`` of :func:`frequency_bands`.

    Returns
    -------
    pandas.DataFrame
    """
    rows = bands.transpose("mode", "crank_angle", "percentile")
    modes, angles = (rows[name].values for name in ("mode", "crank_angle"))
    low, median, high = rows.values.reshape(-1, len(DRAWN_PERCENTILES)).T
    return pd.DataFrame(
        {
            "mode": np.repeat(modes, len(angles)),
            "crank_angle_rad": np.tile(angles, len(modes)),
            **{"p2_5_Hz": low, "p50_Hz": median, "p97_5_Hz": high},
        }
    )


def _frequencies(study: Study, output: Output, designs: FloatArray) -> list[FloatArray]:
    """Frequencies (angles, modes) of the designs that have some."""
    engine = engine_kind(study.engine)(study.mechanism)
    outcomes = (guarded(partial(_of_one, study, engine, output, row))[0] for row in designs)
    return [frequencies for frequencies in outcomes if frequencies is not None]


def _of_one(study: Study, engine: Engine, output: Output, row: FloatArray) -> FloatArray:
    """Frequencies (angles, modes) of one design."""
    modes, design = max(output.mode, 3), design_of(study, engine, row)
    formulation = Formulation(output.prestress, True, modes)
    angles, speed = turn(output.angles), output.speed_of(design)
    return frequencies_at(design.engine.fit_for(modes), angles, speed, formulation)


CONFIDENCE = 0.95
"""Confidence level of the intervals."""
INDICES = ("first_order", "total")
"""Sobol's indices of an input: alone, and together with others."""

_RESAMPLES = 1000
# Part of the outputs' size: an output that changes less has no variance to share.
_CHANGES = 1e-12
# Shares of the variance that are not known to this part of it say little about which input matters.
_POOR = 0.2


def sobol_shares(
    values: FloatArray, outputs: list[str], inputs: list[str], seed: int
) -> xr.Dataset:
    """Sobol's indices with their intervals over (output, input).

    Parameters
    ----------
    values : ndarray, shape (d + 2, n, m)
        Outputs of the samples A, B and A_B of each of d inputs.
    outputs, inputs : list of str
        m and d names.
    seed : int
        Seed of the resamples.

    Returns
    -------
    xarray.Dataset
        ``first_order`` and ``total`` with ``_low`` and ``_high`` ends; of outputs that never change
        not numbers, of inputs that change nothing zero.
    """
    parts = np.moveaxis(values, -1, 1)
    whole = values.reshape(-1, len(outputs))
    varies = np.ptp(whole, axis=0) > _CHANGES * np.abs(whole).max(axis=0)
    shape = len(outputs), len(inputs)
    indices: dict[str, Any] = {
        f"{name}{end}": np.full(shape, np.nan) for name in INDICES for end in ("", "_low", "_high")
    }
    if varies.any():
        first, second, mixed = parts[0, varies], parts[1, varies], parts[2:, varies]
        mean = np.stack([first, second]).mean(axis=(0, 2))[:, None]
        first, second, mixed = first - mean, second - mean, mixed - mean

        def estimates(sample: Any) -> FloatArray:
            return _estimates(first[..., sample], second[..., sample], mixed[..., sample])

        with np.errstate(invalid="ignore", divide="ignore"), warnings.catch_warnings():
            # An input that changes nothing has no interval: its share is zero.
            warnings.simplefilter("ignore", scipy.stats.DegenerateDataWarning)
            interval = scipy.stats.bootstrap(
                [np.arange(first.shape[1])],
                estimates,
                n_resamples=_RESAMPLES,
                confidence_level=CONFIDENCE,
                random_state=np.random.default_rng(seed),
            ).confidence_interval
        changes = (mixed != first).any(axis=-1).T
        estimated = estimates(np.arange(first.shape[1]))
        for end, both in (("", estimated), ("_low", interval.low), ("_high", interval.high)):
            for name, values in zip(INDICES, both, strict=True):
                indices[f"{name}{end}"][varies] = np.where(changes, values, 0.0)
    over = ("output", "input")
    return xr.Dataset(
        {name: (over, values) for name, values in indices.items()},
        {"output": outputs, "input": inputs},
    )


def _estimates(first: FloatArray, second: FloatArray, mixed: FloatArray) -> FloatArray:
    """First-order and total indices, (2, m, d).

    Parameters
    ----------
    first, second : ndarray, shape (m, n)
        Outputs at A and B.
    mixed : ndarray, shape (d, m, n)
        At A_B of each input.
    """
    variance = np.var(np.stack([first, second]), axis=(0, -1))
    alone = (second * (mixed - first)).mean(axis=-1) / variance
    total = ((first - mixed) ** 2).mean(axis=-1) / (2 * variance)
    return np.moveaxis(np.stack([alone, total]), 1, 2)


def share_text(share: xr.Dataset, name: str) -> str:
    """Total share of an input in words, in percent of the variance.

    An interval where it is known to little, and no more than all: estimates scatter about it.

    Parameters
    ----------
    share : xarray.Dataset
        Share of one output.
    name : str
        Name of the input.

    Returns
    -------
    str
    """
    one = share.sel(input=name)
    value, low, high = (float(one[f"total{end}"]) for end in ("", "_low", "_high"))
    within = 100 * np.clip([value, low, high], 0.0, 1.0)
    if high - low > 2 * _POOR:
        return f"{within[1]:.0f} to {within[2]:.0f} % of the variance"
    return f"{within[0]:.0f} % of the variance"


def poor_shares(data: xr.Dataset, samples: int) -> tuple[str, ...]:
    """A warning where shares are known to little, with how many samples would do.

    Parameters
    ----------
    data : xarray.Dataset
        Data of :func:`sobol_shares`, or without shares.
    samples : int
        N of the study.

    Returns
    -------
    tuple of str
        Empty where shares are known.
    """
    if "total" not in data:
        return ()
    widths = np.stack([(data[f"{name}_high"] - data[f"{name}_low"]).values for name in INDICES]) / 2
    apart = float(widths[np.isfinite(widths)].max(initial=0.0))
    if apart <= _POOR:
        return ()
    # Intervals shrink with the root of the number.
    enough = 1 << math.ceil(math.log2(samples * (apart / _POOR) ** 2))
    return (
        f"{samples} samples are few: shares of the variance are known to {100 * apart:.0f} % of it "
        f"only, and may add up to more than 100 %; take --samples {enough}",
    )


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
        Conventions, title, date and command line of the file that it was loaded from.
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
            table = data[shares].to_dataframe().reset_index()
            tables["sensitivity"] = table[["output", "input", *shares]]
        if _BANDS in data:
            tables["frequency_bands"] = bands_table(data[_BANDS])
        return tables

    def figures(self, *, details: bool = True) -> dict[str, Figure]:
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
            of_output = data.sel(output=output)
            unit = data[output].attrs["shown_unit"]
            stats = {
                name: from_si(float(of_output[name]), unit)
                for name in ("mean", "std", *PERCENTILES)
            }
            error = from_si(float(of_output["median_error"]), unit)
            median = Quantity("median", stats["p50"], unit, error, output)
            numbers.append(median)
            failing = float(of_output["failure_probability"])
            rows.append(
                (output, unit, *(f"{value:.4g}" for value in stats.values()), f"{failing:.3g}")
            )
            lines.append(
                f"{output} is {stats['p2_5']:.4g} to {stats['p97_5']:.4g} {unit} in 95 % of the "
                f"designs, its median {median}{_cause(of_output)}"
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
    model = f"each design to {percent(max(error, LEAST_ERROR))}"
    if not np.isfinite(error):
        model = "errors of the designs themselves are not estimated"
    return (
        f"medians are known to {100 * spread:.2g} % by {data.sizes['design']} designs, {model}; "
        f"the {data.attrs['engine']} engine alone ran"
    )


def _cause(of_output: xr.Dataset) -> str:
    """The input that an output depends on most."""
    if "total" not in of_output or not np.isfinite(of_output["total"]).all():
        return ""
    most = str(of_output["total"].idxmax().item())
    return f", most by {most} ({share_text(of_output, most)})"


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
        of_output = data.sel(output=output)
        shares = ", ".join(
            f"{name} {float(of_output['total'].sel(input=name)):.2f} "
            f"({float(of_output['total_low'].sel(input=name)):.2f} to "
            f"{float(of_output['total_high'].sel(input=name)):.2f})"
            for name in data["input"].values.tolist()
        )
        lines.append(f"total share in the variance of {output}: {shares}")
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
        return f"{count} designs are computed for correlated inputs"
    return (
        f"{count * (inputs + 2)} designs are computed: N (D + 2) for N = {count} samples and "
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
    evaluated = evaluate_all(
        study,
        designs,
        executor=executor,
        progress=progress,
        folder=folder,
        resume=resume,
        content={"samples": samples},
    )
    values = _complete(study, evaluated)
    # Only A and B count: the designs of A_B repeat their numbers.
    independent = slice(0, samples if study.correlations else 2 * samples)
    counted = Evaluated(
        evaluated.values[independent], evaluated.status[independent], evaluated.reasons[independent]
    )
    dataset = designs_dataset(study, designs[independent], counted)
    dataset = dataset.merge(_statistics(study, values[independent], dataset))
    dataset = dataset.assign(relative_error=_error_of_a_design(study, dataset, designs, executor))
    worth = [f"{name} {study.outputs[name].text(v)}" for name, v in study.failure_values.items()]
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
            exchanged = first.copy()
            exchanged[:, number] = second[:, number]
            mixed.append(exchanged)
        points = np.concatenate([first, second, *mixed])
    # A variable of one value takes it at any probability.
    whole = np.full((len(points), len(study.variables)), 0.5)
    whole[:, [study.names.index(name) for name in inputs]] = points
    return study.at(whole)


def _complete(study: Study, evaluated: Evaluated) -> FloatArray:
    """Outputs with what a failure is worth; refused where that is not said.

    One number that is missing makes every one of Sobol's indices zero, without a word.
    """
    values = with_failures(study, evaluated)
    if np.isnan(values).any():
        raise InputError(
            f"{100 * (evaluated.status != 0).mean():.2g} % of the designs cannot be computed "
            f"({causes_of(evaluated)}; the first: {next(filter(None, evaluated.reasons))}); narrow "
            "the ranges, or give the value of such outputs in failure_values"
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
    statistics: dict[str, Any] = {
        "mean": values.mean(axis=0),
        "std": values.std(axis=0, ddof=1),
        **{name: np.percentile(values, part, axis=0) for name, part in PERCENTILES.items()},
    }
    # Order statistics half a standard deviation of their binomial count away on either side.
    apart = 50.0 / np.sqrt(len(values))
    ends = np.percentile(values, [50.0 - apart, 50.0 + apart], axis=0)
    statistics["median_error"] = (ends[1] - ends[0]) / 2
    failing = []
    for name in outputs:
        beyond = dataset["status"].values != "ok"
        for limit in study.limits:
            if limit.output == name:
                column = values[:, outputs.index(name)]
                beyond = beyond | (limit.violation(column) > 0)
        failing.append(beyond.mean())
    statistics["failure_probability"] = np.array(failing)
    return xr.Dataset(
        {name: ("output", values) for name, values in statistics.items()}, {"output": outputs}
    )
