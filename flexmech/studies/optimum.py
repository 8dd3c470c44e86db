"""The best design: several goals by a genetic algorithm, one goal from many starts.

Both engines compute the best design of a search anew.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, get_args

import numpy as np
import pandas as pd
import xarray as xr

from flexmech import plots
from flexmech.analyses.digits import percent
from flexmech.analyses.result import Result, csv_text
from flexmech.analyses.summary import Summary
from flexmech.arrays import FloatArray, IntArray, LabelledProgress
from flexmech.choices import EngineName
from flexmech.errors import ComputationError, InputError, one_line
from flexmech.files import given_path, write_whole
from flexmech.linkages import linkage_positions, picture_crank_angle
from flexmech.mechanism import drawing
from flexmech.studies.campaign import KeptDesigns
from flexmech.studies.evaluation import MOST_LETTERS, Evaluated, evaluate
from flexmech.studies.outputs import COSTLY
from flexmech.studies.result import (
    LEAST_ERROR,
    designs_dataset,
    designs_table,
    reason_lines,
    relative_changes,
    status_line,
)
from flexmech.studies.scatter import Scatter
from flexmech.studies.search import (
    Search,
    by_model,
    margins_of,
    most_by_model,
    most_of_one_goal,
    most_of_several_goals,
    one_goal,
    search_content,
    several_goals,
)
from flexmech.studies.study import Study
from flexmech.studies.sweep import (
    ROWS,
    designs_in_words,
    output_quantities,
    outputs_text,
    ranked,
    with_governing,
)
from flexmech.studies.tasks import computed_tasks, gathered
from flexmech.studies.variables import CRANK_SPEED, as_values

if TYPE_CHECKING:
    from matplotlib.figure import Figure


SLACK = 1e-3
"""Part of a limit by which the finer models may miss it: an optimum lies on its limits."""
CANDIDATES = "pareto.csv"
"""File of the best designs, and of the candidate where there is none."""
_FINER = "with twice the elements and crank angles"


def confirmed(
    study: Study,
    scatter: Scatter,
    design: FloatArray,
    values: FloatArray,
    folder: Path | None,
) -> xr.Dataset:
    """The best design computed anew by both engines, with twice the elements and crank angles.

    Parameters
    ----------
    study : Study
    scatter : Scatter
        Scatter of what is uncertain around it.
    design : ndarray, shape (k,)
    values : ndarray, shape (m,)
        Its outputs.
    folder : Path or None
        For the row of a design that does not hold.

    Returns
    -------
    xarray.Dataset
        ``relative_error`` over ``output`` and ``checked`` over (checking_engine, output).

    Raises
    ------
    ComputationError
        If an engine cannot compute it, or finds it beyond a limit.
    """
    engines: tuple[EngineName, ...] = get_args(EngineName)
    again = []
    for engine in engines:
        of_engine = study.with_(engine=engine)
        evaluated = scatter.evaluated(design[None], lambda rows: evaluate(of_engine, rows, finer=2))  # noqa: B023
        if reason := _does_not_hold(study, evaluated):
            raise ComputationError(
                f"the best design does not hold: {_FINER} {engine} finds {reason}; "
                f"{_design_text(study, design)}{_remedy(study, evaluated)}"
                + candidate_kept(
                    study, design, evaluated, f"{_FINER} {engine} finds {reason}", folder
                )
            )
        again.append(evaluated.values[0])
    return xr.Dataset(
        {
            "relative_error": (
                "output",
                relative_changes(values, again[engines.index(study.engine)]),
            ),
            "checked": (("checking_engine", "output"), np.stack(again)),
        },
        {"output": list(study.outputs), "checking_engine": list(engines)},
    )


def errors_of(
    study: Study,
    scatter: Scatter,
    designs: FloatArray,
    values: FloatArray,
    computed: Callable[[FloatArray], Evaluated],
    executor: Executor | None,
) -> FloatArray:
    """Greatest relative errors of several designs, by a finer model and by the number of samples.

    Parameters
    ----------
    study : Study
    scatter : Scatter
    designs : ndarray, shape (n, k)
    values : ndarray, shape (n, m)
        Their outputs.
    computed : callable
        Gives the outputs of rows that were computed on the way.
    executor : concurrent.futures.Executor or None

    Returns
    -------
    ndarray, shape (m,)
        Not numbers where a finer model cannot be computed.
    """

    def finer(rows: FloatArray) -> Evaluated:
        every = np.arange(len(rows))
        return gathered(study, rows, computed_tasks(study, rows, every, executor, finer=2))

    changes = relative_changes(values, scatter.evaluated(designs, finer).values)
    sampling = np.stack([scatter.errors(design[None], computed) for design in designs])
    return np.asarray((changes + sampling).max(axis=0))


def _does_not_hold(study: Study, evaluated: Evaluated) -> str:
    """Why one design cannot be, if it cannot."""
    if evaluated.status[0] != 0:
        return evaluated.reasons[0]
    return beyond(study, evaluated.values[0], SLACK)


def _remedy(study: Study, evaluated: Evaluated) -> str:
    if evaluated.status[0] != 0 or not study.limits:
        return ""
    worst = float(margins_of(study, evaluated.values[0]).min())
    return f"; give that output more angles, or tighten its limit by {100 * -worst:.2g} %"


def beyond(study: Study, values: FloatArray, slack: float = 0.0) -> str:
    """Outputs of one design beyond a limit, in words; empty where all limits are kept.

    Parameters
    ----------
    study : Study
    values : ndarray, shape (m,)
    slack : float
        Part of a limit by which it may be missed.

    Returns
    -------
    str
    """
    names = list(study.outputs)
    margins = margins_of(study, values)
    missed: IntArray = np.flatnonzero(margins < -slack)
    texts = []
    for number in missed[np.argsort(margins[missed])].tolist():
        name = study.limits[number].output
        texts.append(f"{name} {study.outputs[name].text(values[names.index(name)])}")
    return ", ".join(texts)


def candidate_kept(
    study: Study, design: FloatArray, evaluated: Evaluated, reason: str, folder: Path | None
) -> str:
    """Keep the row of a design that is no optimum, and say where it is.

    Parameters
    ----------
    study : Study
    design : ndarray, shape (k,)
    evaluated : Evaluated
        Evaluation of that design alone.
    reason : str
        Why it is none.
    folder : Path or None
        Where the row is written, if anywhere.

    Returns
    -------
    str
        For the end of a message; empty where nothing is written.
    """
    if folder is None:
        return ""
    row = Evaluated(evaluated.values, evaluated.status, [one_line(reason, MOST_LETTERS)])
    table = designs_table(designs_dataset(study, design[None], row), {"violation": "violation"})
    file = given_path(folder) / CANDIDATES
    form = f"%.{Result.significant_digits}g"
    write_whole(file, csv_text(table, form))
    earlier = file.with_name("optimum.toml")
    stale = f"; {earlier} is of an earlier run" if earlier.exists() else ""
    return f"; its row is in {file}{stale}"


def _design_text(study: Study, design: FloatArray) -> str:
    """A design in words."""
    return ", ".join(
        f"{variable.name} {variable.text(number)}"
        for variable, number in zip(study.variables, design.tolist(), strict=True)
    )


class Optimum(Result):
    """The best designs of a study, and the search for them.

    Parameters
    ----------
    dataset : xarray.Dataset
        Best designs as of a ``DesignSweep``: of several goals all that no other design is better
        than, of one goal one. ``history`` of the best goal over (goal, step) with ``evaluations``.
        All designs of the search in SI units, texts by their numbers, as ``trial_value`` (variable,
        trial), with ``trial_goal`` (goal, trial) and ``trial_within`` every limit.
        ``relative_error`` over ``output``, the greatest of the designs of the table, and of both
        engines ``checked`` over (checking_engine, output). Its attribute ``optimum`` is the best
        design as a model file. Where variables are ``uncertain`` the outputs are their means or
        percentiles, as the attribute ``statistic`` of each says, ``relative_error`` is that by the
        number of ``samples`` too.
    stored_as : mapping of str to str, optional
        Conventions, title, date and command line of the file that it was loaded from.
    """

    stem = "optimum"
    subject = "optimum"
    hallmark = "history"
    files = (
        "pareto.csv",
        "history.csv",
        "optimum.toml",
        "optimum.nc",
        "pareto.png",
        "history.png",
    )

    def tables(self) -> dict[str, pd.DataFrame]:
        """Best designs, and the history of the search."""
        data = self.dataset
        history = {"evaluations": data["evaluations"].values}
        for goal in data["goal"].values.tolist():
            history[goal] = data["history"].sel(goal=goal).values
        return {
            "pareto": designs_table(data, {"violation": "violation"}),
            "history": pd.DataFrame(history),
        }

    def texts(self) -> dict[str, str]:
        """The best design as a model file."""
        return {"optimum.toml": str(self.dataset.attrs["optimum"])}

    def figures(self, *, details: bool = True) -> dict[str, Figure]:
        """The search, and of several goals what one costs of the other."""
        figures = {"history": plots.plot_search(self.dataset)}
        if self.dataset.sizes["goal"] > 1:
            figures["pareto"] = plots.plot_pareto(self.dataset)
        return figures

    def plot(self, *, ax: plots.AxesLike | None = None) -> Figure:
        """Draw what one goal costs of the other, or of one goal the search.

        Parameters
        ----------
        ax : matplotlib.axes.Axes or sequence of them, optional

        Returns
        -------
        matplotlib.figure.Figure
        """
        draw = plots.plot_pareto if self.dataset.sizes["goal"] > 1 else plots.plot_search
        return draw(self.dataset, ax=ax)

    def summary(self) -> Summary:
        """The best design, its outputs, and whether both engines and a finer model confirm it."""
        data = self.dataset
        best = ranked(data)
        first = best.isel(design=0)
        outputs = data.attrs["outputs"].split()
        numbers = output_quantities(first, outputs)
        listed = outputs_text(numbers)
        lines = [f"The best design has {listed}; {_runs(data)}."]
        if data.sizes["goal"] > 1:
            lines = [
                f"{best.sizes['design']} designs are such that none is better in every goal.",
                f"With the best {data['goal'].values[0]}: {listed}; {_runs(data)}.",
            ]
        lines += _statistics_lines(data)
        values = data["checked"].values
        apart = float(np.nanmax(np.abs(values[0] - values[1]) / np.abs(values).max(axis=0)))
        error = float(data["relative_error"].max(skipna=False))
        known = f"numbers are known to {percent(max(error, apart, LEAST_ERROR))}"
        if not np.isfinite(error):
            known = "errors of the numbers are not estimated"
        engines = " and ".join(data["checking_engine"].values.tolist())
        return Summary(
            tuple(lines),
            designs_in_words(best.isel(design=slice(ROWS)), data.attrs["mechanism"]),
            f"{known}; {engines}, computed anew with twice the elements and crank angles, keep "
            f"every limit to {100 * SLACK:g} %",
            details=(status_line(data), *reason_lines(data)),
            numbers=numbers,
        )


def _runs(data: xr.Dataset) -> str:
    """How many designs were computed, and how often each."""
    count = int(data["evaluations"].values[-1])
    if "uncertain" not in data.attrs:
        return f"{count} designs were computed"
    runs = int(data.attrs["runs"])
    names, samples = data.attrs["uncertain"].split("\n"), int(data.attrs["samples"])
    return (
        f"{count} designs were computed, each with {samples} samples of {', '.join(names)}: "
        f"{runs} runs"
    )


def _statistics_lines(data: xr.Dataset) -> list[str]:
    """Line on the statistic by which each output counts where properties are uncertain."""
    if "uncertain" not in data.attrs:
        return []
    outputs = data.attrs["outputs"].split()
    chosen = ", ".join(f"{name} by its {data[name].attrs['statistic']}" for name in outputs)
    return [f"Over the samples: {chosen}."]


def optimum_study(
    study: Study,
    *,
    executor: Executor | None = None,
    progress: LabelledProgress | None = None,
    folder: Path | None = None,
    resume: bool = False,
) -> Optimum:
    """The best design of a study's variables by its goals, within its limits.

    One goal is sought by SciPy's COBYQA from several starts, several goals by NSGA-II (Deb et al.
    2002; the library pymoo). Where an output costs a second or more a design, both are sought by a
    model of the outputs, radial basis functions between some twenty designs (Gutmann 2001; Regis
    and Shoemaker 2007). Around every design variables with distributions take a sample of
    values, the same for all: goals and limits are the percentiles of the outputs that they name,
    or their means. The best design is computed anew by both engines with twice the elements and
    crank angles before it is given.

    Parameters
    ----------
    study : Study
        With a goal or more.
    executor : concurrent.futures.Executor, optional
    progress : callable, optional
        Called as ``progress(label, done, total)``.
    folder : Path, optional
        Where ``designs.zarr`` is kept, so that an interrupted search can be repeated from it, and
        ``pareto.csv`` of a candidate that does not hold.
    resume : bool
        Whether to go on with the store that is there.

    Returns
    -------
    Optimum

    Raises
    ------
    InputError
        If there is no goal, nothing is left to choose, the extra is not installed, or the store
        is of another search.
    ComputationError
        If no design keeps the limits, or the best one does not hold in the finer model or with
        the other engine.
    """
    if not study.goals:
        raise InputError("goals: there is none; add [[goals]] with output = ... and sense = ...")
    scatter = Scatter.of(study)
    find, most = _search_method(study)
    computed = KeptDesigns.of(
        study,
        executor,
        folder,
        progress=progress,
        resume=resume,
        most=most,
        content=search_content(study),
    )
    search = Search(study, computed, scatter)
    with closing(computed):
        designs = find(search)
        evaluated = search.found(designs)
        dataset = designs_dataset(study, designs, evaluated)
        best = ranked(dataset)
        held = bool(best.sizes["design"]) and bool(best["within"][0])
        number = int(best["design"][0]) - 1 if held else 0
        sampling = scatter.errors(designs[number][None], computed)
    if not held:
        why = evaluated.reasons[0] or f"beyond a limit: {beyond(study, evaluated.values[0])}"
        raise ComputationError(
            f"none of {search.count} designs keeps every limit; widen the ranges or loosen a limit"
            + candidate_kept(study, designs[0], evaluated, why, folder)
        )
    checked = confirmed(study, scatter, designs[number], evaluated.values[number], folder)
    error = checked["relative_error"].values + sampling
    if len(others := best["design"].values[1:ROWS] - 1):
        rows = designs[others], evaluated.values[others]
        error = np.maximum(error, errors_of(study, scatter, *rows, computed, executor))
    checked["relative_error"] = "output", error
    steps, history = zip(*search.steps, strict=True)
    signs = np.array([goal.sign for goal in study.goals])
    tried, goals, within = (np.concatenate(one) for one in zip(*search.trials, strict=True))
    goals[~np.isfinite(goals)] = np.nan
    return Optimum(
        _with_statistics(study, with_governing(study, designs, dataset))
        .assign(checked)
        .merge(_drawn(study, designs), combine_attrs="no_conflicts")
        .assign_coords(evaluations=("step", np.array(steps)))
        .assign(
            history=(("goal", "step"), (np.array(history) * signs).T),
            trial_value=(("variable", "trial"), tried.T),
            trial_goal=(("goal", "trial"), (goals * signs).T),
            trial_within=("trial", within),
        )
        .assign_coords(
            goal=[goal.output for goal in study.goals],
            variable=[variable.name for variable in study.variables],
        )
        .assign_attrs(optimum=_model(study, designs[number]), runs=computed.count)
    )


def _with_statistics(study: Study, dataset: xr.Dataset) -> xr.Dataset:
    """Designs that say what their outputs are where properties are uncertain."""
    if not study.uncertain:
        return dataset
    for name in study.outputs:
        percentile = study.percentiles.get(name)
        dataset[name].attrs["statistic"] = (
            "mean" if percentile is None else f"{percentile:g} % percentile"
        )
    return dataset.assign_attrs(
        uncertain="\n".join(study.uncertain), samples=study.percentile_samples
    )


def _drawn(study: Study, designs: FloatArray) -> xr.Dataset:
    """Positions of the links of every design at one crank angle, for pictures."""
    angle = picture_crank_angle(study.mechanism.linkage)
    positions = []
    for design in designs:
        stated = dict(as_values(study.variables, design))
        stated.pop(CRANK_SPEED, None)
        linkage = study.parameters.mechanism_with(stated).linkage
        positions.append(linkage_positions(linkage, angle)["rigid_position"])
    joined = xr.concat(positions, "design").assign_coords(design=np.arange(1, len(designs) + 1))
    return xr.Dataset({"rigid_position": joined}, attrs={"drawing": drawing(study.mechanism)})


def _model(study: Study, design: FloatArray) -> str:
    """Model file of a design."""
    stated = {
        key: value
        for key, value in as_values(study.variables, design).items()
        if key in study.parameters.stated.quantities or key in study.parameters.texts
    }
    return study.parameters.stated.text_with(stated)


def _search_method(study: Study) -> tuple[Callable[[Search], FloatArray], int]:
    """The search for the best designs of a study, and how many runs it can ask for.

    Parameters
    ----------
    study : Study

    Returns
    -------
    callable
        From a search to the best designs (n, k).
    int
    """
    samples = study.percentile_samples if study.uncertain else 1
    if any(output.quantity in COSTLY for output in study.outputs.values()):
        return by_model, samples * most_by_model(study)
    if len(study.goals) > 1:
        return several_goals, samples * most_of_several_goals()
    # One more of each of the first sample, at the medians of what is uncertain.
    return one_goal, (samples + 1) * most_of_one_goal(study)
