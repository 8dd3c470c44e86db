"""The best design: several goals by a genetic algorithm, one goal from many starts."""

from __future__ import annotations

from concurrent.futures import Executor
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr

from flexmech import plots
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary
from flexmech.arrays import FloatArray, LabelledProgress
from flexmech.choices import EngineName
from flexmech.errors import ComputationError, InputError
from flexmech.linkages import linkage_positions, picture_crank_angle
from flexmech.mechanism import drawing
from flexmech.studies.designs.evaluation import evaluate
from flexmech.studies.designs.kept import KeptDesigns
from flexmech.studies.designs.result import (
    designs_dataset,
    designs_table,
    reason_lines,
    relative_changes,
    status_line,
)
from flexmech.studies.designs.search import (
    Search,
    margins_of,
    most_designs,
    one_goal,
    search_content,
    several_goals,
)
from flexmech.studies.designs.study import Study
from flexmech.studies.designs.sweep import designs_in_words, output_quantities, ranked
from flexmech.studies.designs.variables import CRANK_SPEED, as_values

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SLACK = 1e-3
"""Part of a limit by which the finer models may miss it: an optimum lies on its limits."""
# Rows of the table.
_ROWS = 8


class Optimum(Result):
    """The best designs of a study, and the search for them.

    Parameters
    ----------
    dataset : xarray.Dataset
        Best designs as of a ``DesignSweep``: of several goals all that no other design is better
        than, of one goal one. ``history`` of the best goal over (goal, step) with ``evaluations``;
        ``relative_error`` of the outputs of the best design, and of both engines ``checked`` over
        (checking_engine, output). Its attribute ``optimum`` is the best design as a model file.
    stored_as : mapping of str to str, optional
        Of the file that it was loaded from.
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

    def figures(self) -> dict[str, Figure]:
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
        told = ", ".join(f"{one.name} {one}" for one in numbers)
        count = int(data["evaluations"].values[-1])
        lines = [f"The best design has {told}; {count} designs were computed."]
        if data.sizes["goal"] > 1:
            lines = [
                f"{best.sizes['design']} designs are such that none is better in every goal.",
                f"With the best {data['goal'].values[0]}: {told}.",
            ]
        values = data["checked"].values
        apart = float(np.nanmax(np.abs(values[0] - values[1]) / np.abs(values).max(axis=0)))
        error = float(data["relative_error"].max())
        engines = " and ".join(data["checking_engine"].values.tolist())
        return Summary(
            tuple(lines),
            designs_in_words(best.isel(design=slice(_ROWS)), data.attrs["mechanism"]),
            f"numbers are known to {100 * max(error, apart):.2g} %; {engines}, computed anew with "
            f"twice the elements and crank angles, keep every limit to {100 * SLACK:g} %",
            details=(status_line(data), *reason_lines(data)),
            numbers=numbers,
        )


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
    2002; the library pymoo). The best design is computed anew by both engines with twice the
    elements and crank angles before it is given.

    Parameters
    ----------
    study : Study
        With a goal or more.
    executor : concurrent.futures.Executor, optional
    progress : callable, optional
        Called as ``progress(label, done, total)``.
    folder : Path, optional
        Where ``designs.zarr`` is kept, so that an interrupted search can be repeated from it.
    resume : bool
        Whether to go on with the store that is there.

    Returns
    -------
    Optimum

    Raises
    ------
    InputError
        If there is no goal, the extra is not installed, or the store is of another search.
    ComputationError
        If no design keeps the limits, or the best one does not hold in the finer model or with
        the other engine.
    """
    if not study.goals:
        raise InputError("goals: there is none; add [[goals]] with output = ... and sense = ...")
    computed = KeptDesigns.of(
        study,
        executor,
        folder,
        resume=resume,
        most=most_designs(study),
        content=search_content(study),
    )
    search = Search(study, computed, progress)
    with closing(computed):
        designs = one_goal(search) if len(study.goals) == 1 else several_goals(search)
    found = computed(designs)
    dataset = designs_dataset(study, designs, found)
    best = ranked(dataset)
    if not best.sizes["design"] or not bool(best["within"][0]):
        raise ComputationError(
            f"none of {search.count} designs keeps every limit; widen the ranges or loosen a limit"
        )
    number = int(best["design"][0]) - 1
    checked = _checked(study, designs[number], found.values[number])
    steps, history = zip(*search.steps, strict=True)
    signs = np.array([goal.sign for goal in study.goals])
    return Optimum(
        dataset.assign(checked)
        .merge(_drawn(study, designs), combine_attrs="no_conflicts")
        .assign_coords(evaluations=("step", np.array(steps)))
        .assign(history=(("goal", "step"), (np.array(history) * signs).T))
        .assign_coords(goal=[goal.output for goal in study.goals])
        .assign_attrs(optimum=_model(study, designs[number]))
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


def _checked(study: Study, design: FloatArray, values: FloatArray) -> xr.Dataset:
    """The best design computed anew by both engines, with twice the elements and crank angles."""
    engines: tuple[EngineName, ...] = ("reference", "exudyn")
    again = [evaluate(study.with_(engine=each), design[None], finer=2) for each in engines]
    errors = relative_changes(values, again[engines.index(study.engine)].values[0])
    for engine, found in zip(engines, again, strict=True):
        if found.status[0] != 0:
            raise ComputationError(
                f"the best design does not hold: with twice the elements and crank angles {engine} "
                f"finds {found.reasons[0]}; {_told(study, design)}"
            )
        margins = margins_of(study, found.values[0])
        worst = float(margins.min(initial=0.0))
        if worst < -SLACK:
            limit = study.limits[int(margins.argmin())]
            value = found.values[0][list(study.outputs).index(limit.output)]
            raise ComputationError(
                f"the best design does not hold: with twice the elements and crank angles {engine} "
                f"finds {limit.output} {study.outputs[limit.output].told(value)}; "
                f"{_told(study, design)}; give that output more angles, or tighten its limit by "
                f"{100 * -worst:.2g} %"
            )
    return xr.Dataset(
        {
            "relative_error": ("output", errors),
            "checked": (
                ("checking_engine", "output"),
                np.stack([found.values[0] for found in again]),
            ),
        },
        {"output": list(study.outputs), "checking_engine": list(engines)},
    )


def _told(study: Study, design: FloatArray) -> str:
    """A design in words."""
    return ", ".join(
        f"{variable.name} {variable.told(number)}"
        for variable, number in zip(study.variables, design.tolist(), strict=True)
    )


def _model(study: Study, design: FloatArray) -> str:
    """Model file of a design."""
    stated = {
        key: value
        for key, value in as_values(study.variables, design).items()
        if key in study.parameters.stated.quantities or key in study.parameters.texts
    }
    return study.parameters.stated.text_with(stated)
