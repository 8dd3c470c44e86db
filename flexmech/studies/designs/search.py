"""The search for the best designs: of one goal from many starts, of several by NSGA-II."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError
from typing import Any

import numpy as np
import scipy

from flexmech.analyses.datasets import versions
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.studies.designs.evaluation import Evaluated
from flexmech.studies.designs.kept import KeptDesigns
from flexmech.studies.designs.result import violations
from flexmech.studies.designs.scatter import Scatter
from flexmech.studies.designs.study import Study, sobol_points
from flexmech.studies.designs.variables import Variable

INSTALL = "several goals need the extra packages of [study]: pip install 'flexmech[study]'"
# Starts of the search for one goal: the best designs of a sample of so many for each variable.
_STARTS, _SAMPLE = 4, 16
# Where every design is a sample of runs, and how far, in parts of the ranges, the search goes then:
# percentiles of a sample are not known to more.
_UNCERTAIN_STARTS, _UNCERTAIN_STEP, _STEP = 2, 1e-4, 1e-7
_POPULATION, _GENERATIONS = 64, 40
# Of a local search, for each variable: what SciPy takes where nothing is said.
_MOST_STEPS = 500
# What a violated limit and a design that fails cost, in ranges of the goal.
_PENALTY = 10.0


@dataclass
class Search:
    """Designs that were computed on the way, with the best so far.

    Parameters
    ----------
    study : Study
    computed : KeptDesigns
        Gives the outputs of designs.
    scatter : Scatter
        Of what is uncertain, around every design.
    count : int
        Designs computed.
    steps : list of (int, ndarray)
        The count, and the best of every goal then.
    best : ndarray or None
        Least of every goal, with the sign that makes less the better.
    design : ndarray or None
        Of the first goal's best design within every limit.
    nearest : ndarray or None
        Design that violates the limits least.
    violation : float
        Its own.
    """

    study: Study
    computed: KeptDesigns
    scatter: Scatter
    count: int = 0
    steps: list[tuple[int, FloatArray]] = field(default_factory=list)
    best: FloatArray | None = None
    design: FloatArray | None = None
    nearest: FloatArray | None = None
    violation: float = np.inf

    def keep(self, designs: FloatArray, goals: FloatArray, violation: FloatArray) -> None:
        """Count designs, and note the best of those that keep every limit.

        Parameters
        ----------
        designs : ndarray, shape (n, k)
        goals : ndarray, shape (n, g)
            All to be made small.
        violation : ndarray, shape (n,)
        """
        self.count += len(designs)
        if self.nearest is None or violation.min() < self.violation:
            number = int(violation.argmin())
            self.nearest, self.violation = designs[number], float(violation[number])
        within = np.flatnonzero(violation <= 0)
        if not len(within):
            return
        first = within[int(goals[within, 0].argmin())]
        if self.best is None or goals[first, 0] < self.best[0]:
            self.design = designs[first]
        least = goals[within].min(axis=0)
        self.best = least if self.best is None else np.minimum(self.best, least)
        self.steps.append((self.count, self.best.copy()))

    def __call__(self, designs: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Goals (n, g), all to be made small, and violations (n,); infinite of failures."""
        goals, violation = self.judged(self.found(designs))
        self.keep(designs, goals, violation)
        return goals, violation

    def found(self, designs: FloatArray) -> Evaluated:
        """Outputs of designs (n, k): of uncertain ones their percentiles and means."""
        return self.scatter.evaluated(designs, self.computed)

    def judged(self, found: Evaluated) -> tuple[FloatArray, FloatArray]:
        """Goals and violations of computed designs."""
        outputs = list(self.study.outputs)
        signs = np.array([goal.sign for goal in self.study.goals])
        goals = found.values[:, [outputs.index(goal.output) for goal in self.study.goals]] * signs
        violation = np.where(found.status == 0, violations(self.study, found.values), np.inf)
        return np.nan_to_num(goals, nan=np.inf), violation


def most_of_one_goal(study: Study) -> int:
    """Designs that :func:`one_goal` can ask for.

    Parameters
    ----------
    study : Study

    Returns
    -------
    int
    """
    return _sample_size(study) + _STARTS * (_MOST_STEPS * _chosen(study) + 1)


def most_of_several_goals() -> int:
    """Designs that :func:`several_goals` can ask for.

    Returns
    -------
    int
    """
    return _POPULATION * _GENERATIONS


def search_content(study: Study) -> dict[str, str]:
    """What besides the study's designs and outputs a search depends on, for its store.

    Parameters
    ----------
    study : Study

    Returns
    -------
    dict
        Limits, goals, and the version of the library that searches for several.

    Raises
    ------
    InputError
        If the library is not installed.
    """
    try:
        library = versions("pymoo") if len(study.goals) > 1 else {}
    except PackageNotFoundError as error:
        raise InputError(INSTALL) from error
    content = {"limits": repr(study.limits), "goals": repr(study.goals), **library}
    if study.uncertain:
        content["percentile_samples"] = str(study.percentile_samples)
    return content


def chosen_variables(study: Study) -> list[Variable]:
    """Variables that the search chooses.

    Parameters
    ----------
    study : Study

    Returns
    -------
    list of Variable
    """
    return [variable for variable in study.variables if not variable.is_random]


def _chosen(study: Study) -> int:
    """Number of the variables that the search chooses."""
    return len(chosen_variables(study))


def _sample_size(study: Study) -> int:
    return max(_SAMPLE * _chosen(study), 32)


def one_goal(search: Search) -> FloatArray:
    """The best design for one goal, by local searches from the best of a sample.

    Parameters
    ----------
    search : Search

    Returns
    -------
    ndarray, shape (1, k)
        The nearest where none keeps every limit.
    """
    study, designs = search.study, search.scatter.designs
    points = sobol_points(_sample_size(study), _chosen(study), study.seed)
    # Listed values have no neighbours to move to: the search goes over the others alone.
    fixed = np.array(
        [each.distribution == "values" for each in study.variables if not each.is_random]
    )
    starts = _STARTS
    if study.uncertain and not fixed.all():
        # At the medians of what is uncertain good starts are found by one run each.
        starts = _UNCERTAIN_STARTS
        goals, violation = search.judged(search.computed(designs(points)))
    else:
        goals, violation = search(designs(points))
    if not fixed.all():
        size = _size(goals[:, 0])
        order = np.lexsort([goals[:, 0], violation])
        ends = [_descend(search, start, fixed, size) for start in points[order[:starts]]]
        search(designs(np.array(ends)))
    best = search.nearest if search.design is None else search.design
    assert best is not None
    return best[None]


def _size(goals: FloatArray) -> float:
    known = goals[np.isfinite(goals)]
    return float(np.ptp(known)) or 1.0 if len(known) else 1.0


def _descend(search: Search, start: FloatArray, fixed: Any, size: float) -> FloatArray:
    """Local search in the unit cube with every limit as a constraint."""
    study, free = search.study, ~fixed
    known: dict[bytes, tuple[float, FloatArray]] = {}

    def computed(free_point: FloatArray) -> tuple[float, FloatArray]:
        key = free_point.tobytes()
        if key not in known:
            point = start.copy()
            point[free] = np.clip(free_point, 0.0, 1.0)
            designs = search.scatter.designs(point[None])
            found = search.found(designs)
            goals, violation = search.judged(found)
            search.keep(designs, goals, violation)
            if found.status[0] == 0:
                known[key] = float(goals[0, 0]) / size, margins_of(study, found.values[0])
            else:
                known[key] = _PENALTY, np.full(len(study.limits), -_PENALTY)
        return known[key]

    constraints = []
    if study.limits:
        margin: Callable[[FloatArray], FloatArray] = lambda x: computed(x)[1]  # noqa: E731
        constraints = [scipy.optimize.NonlinearConstraint(margin, 0.0, np.inf)]
    found = scipy.optimize.minimize(
        lambda x: computed(x)[0],
        start[free],
        method="COBYQA",
        bounds=[(0.0, 1.0)] * int(free.sum()),
        constraints=constraints,
        options={
            "initial_tr_radius": 0.1,
            "final_tr_radius": _UNCERTAIN_STEP if study.uncertain else _STEP,
            "maxfev": _MOST_STEPS * int(free.sum()),
        },
    )
    end = start.copy()
    end[free] = np.clip(found.x, 0.0, 1.0)
    return end


def margins_of(study: Study, values: FloatArray) -> FloatArray:
    """By how much each limit is kept, over its size; negative where it is not.

    Parameters
    ----------
    study : Study
    values : ndarray, shape (m,)
        Outputs of one design.

    Returns
    -------
    ndarray, shape (number of limits,)
    """
    names = list(study.outputs)
    return np.array([limit.margin(values[names.index(limit.output)]) for limit in study.limits])


def several_goals(search: Search) -> FloatArray:
    """Designs that no other is better than in every goal, by NSGA-II.

    Parameters
    ----------
    search : Search

    Returns
    -------
    ndarray, shape (n, k)
        The nearest where none keeps every limit.
    """
    from pymoo.algorithms.moo.nsga2 import NSGA2
    from pymoo.core.problem import Problem
    from pymoo.optimize import minimize

    study, designs = search.study, search.scatter.designs
    count = _chosen(study)

    class Designs(Problem):  # type: ignore[misc]
        """Goals and violations over the unit cube."""

        def __init__(self) -> None:
            goals = len(study.goals)
            super().__init__(n_var=count, n_obj=goals, n_ieq_constr=1, xl=0.0, xu=1.0)

        def _evaluate(self, x: FloatArray, out: dict[str, Any], *args: Any, **more: Any) -> None:
            del args, more
            goals, violation = search(designs(x))
            # Of a design that fails no goal is known: it is farther off than any that does not.
            out["F"] = np.where(np.isfinite(goals), goals, np.finfo(np.float32).max)
            out["G"] = np.where(np.isfinite(violation), violation, np.finfo(np.float32).max)[
                :, None
            ]

    start = sobol_points(_POPULATION, count, study.seed)
    found = minimize(
        Designs(), NSGA2(_POPULATION, sampling=start), ("n_gen", _GENERATIONS), seed=study.seed
    )
    if found.X is None:
        assert search.nearest is not None
        return search.nearest[None]
    # Points of a list's value are many, and the design is one.
    return np.unique(designs(np.atleast_2d(found.X)), axis=0)
