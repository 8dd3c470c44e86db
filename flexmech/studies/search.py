"""The search for the best designs: of one goal from many starts, of several by NSGA-II.

Where a design costs a second or more, a model of the outputs says where to look. Radial basis
functions interpolate the outputs of the designs that are known (Gutmann 2001, *Journal of Global
Optimization* 19, 201-227). Round by round the design that is best by the model is computed, and one
far from all others that may be better (Regis and Shoemaker 2007, *INFORMS Journal on Computing* 19,
497-509). What is given back is computed itself, never the model's.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray
from scipy.interpolate import RBFInterpolator
from scipy.spatial.distance import cdist

from flexmech.analyses.datasets import versions
from flexmech.arrays import FloatArray, IntArray
from flexmech.errors import missing_extra
from flexmech.studies.campaign import KeptDesigns
from flexmech.studies.evaluation import Evaluated, joined
from flexmech.studies.result import violations
from flexmech.studies.scatter import Scatter
from flexmech.studies.study import Study, sobol_points
from flexmech.studies.variables import Variable

# Starts of the search for one goal: the best designs of a sample of so many for each variable.
_STARTS, _SAMPLE = 4, 16
# Where every design is a sample of runs, and how far, in parts of the ranges, the search goes then:
# percentiles of a sample are not known to more.
_UNCERTAIN_STARTS, _UNCERTAIN_STEP, _STEP = 2, 1e-4, 1e-7
_POPULATION, _GENERATIONS = 64, 40
# Most steps of a local search, for each variable: what SciPy takes where nothing is said.
_MOST_STEPS = 500
# Cost of a violated limit and of a design that fails, in ranges of the goal.
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
        Scatter of what is uncertain, around every design.
    count : int
        Designs computed.
    steps : list of (int, ndarray)
        The count, and the best of every goal then.
    trials : list of (ndarray, ndarray, ndarray)
        Designs (n, k), their goals (n, g), and whether they keep every limit.
    best : ndarray or None
        Least of every goal, with the sign that makes less the better.
    design : ndarray or None
        The first goal's best design within every limit.
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
    trials: list[tuple[FloatArray, FloatArray, NDArray[np.bool_]]] = field(default_factory=list)
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
        self.trials.append((designs, goals, violation <= 0))
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
    """Settings of a search besides the study's designs and outputs, for its store.

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
        raise missing_extra("a search for several goals", "pymoo", "study") from error
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
            # A design that fails has no known goal: it is farther off than any that does not fail.
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


# Designs nearer to each other than this part of their ranges are the same: an optimum is known to
# it, and a model of both is not singular.
_NEAR = 2e-4
# Rounds of one variable for one goal and for several, and more of each further variable. A round
# computes the best design by the model and one far from all, or so many of a front.
_ROUNDS, _ROUNDS_OF_FRONT, _MORE_ROUNDS, _BATCH, _OF_FRONT = 8, 6, 2, 2, 3
# A search for one goal ends after more rounds in a row than these in which the best design by the
# model is known already.
_IDLE = 1
# Points at which the model is asked: all over the ranges for each variable, and in boxes around the
# best of them, of which each is a quarter of the one before.
_EVERYWHERE, _AROUND, _BOXES = 2048, 64, 6
# By how much of its bound the best design by the model keeps a limit: as much as the model was off
# at the one before, between these.
_LEAST_MARGIN, _MARGIN = 1e-5, 1e-3


@dataclass(frozen=True)
class OutputModel:
    """Outputs between designs that are known, by cubic radial basis functions.

    Parameters
    ----------
    interpolator : RBFInterpolator
    logarithmic : ndarray of bool, shape (m,)
        Outputs that are positive, whose logarithms are interpolated: peaks of
        resonances are less steep in them.
    varying : ndarray of bool, shape (c,)
        Coordinates that differ among the designs that are known.
    known : ndarray, shape (n, c)
        All points that were computed.
    failed : ndarray of bool, shape (n,)
    """

    interpolator: RBFInterpolator
    logarithmic: NDArray[np.bool_]
    varying: NDArray[np.bool_]
    known: FloatArray
    failed: NDArray[np.bool_]

    @classmethod
    def of(cls, points: FloatArray, found: Evaluated) -> OutputModel | None:
        """Model of designs that are computed; None where too few of them are known.

        Parameters
        ----------
        points : ndarray, shape (n, c)
            In the unit cube.
        found : Evaluated
            Their outputs.

        Returns
        -------
        OutputModel or None
        """
        failed = found.status != 0
        known, values = points[~failed], found.values[~failed]
        varying = np.ptp(known, axis=0) > 0 if len(known) else np.zeros(points.shape[1], dtype=bool)
        if not varying.any() or len(known) <= varying.sum() + 1:
            return None
        logarithmic = (values > 0).all(axis=0)
        values = np.where(logarithmic, np.log(np.where(logarithmic, values, 1.0)), values)
        try:
            between = RBFInterpolator(known[:, varying], values, kernel="cubic")
        except np.linalg.LinAlgError:  # of points on one line or plane
            return None
        return cls(between, logarithmic, varying, points, failed)

    def at(self, points: FloatArray) -> Evaluated:
        """Outputs of points (n, c) by the model; where the nearest known design fails, so do they.

        Parameters
        ----------
        points : ndarray, shape (n, c)

        Returns
        -------
        Evaluated
        """
        values = self.interpolator(points[:, self.varying])
        values = np.where(self.logarithmic, np.exp(np.where(self.logarithmic, values, 0.0)), values)
        nearest = cdist(points, self.known).argmin(axis=1)
        return Evaluated(values, self.failed[nearest].astype(np.intp), [""] * len(points))


class _KnownDesigns:
    """Points of the unit cube whose designs are computed.

    Parameters
    ----------
    search : Search
    """

    def __init__(self, search: Search) -> None:
        self.search = search
        self.variables = chosen_variables(search.study)
        self.points = np.empty((0, len(self.variables)))
        self.found = Evaluated(np.empty((0, len(search.study.outputs))), np.empty(0, np.intp), [])

    def add(self, points: FloatArray) -> Evaluated:
        """Compute points (n, c), and keep them."""
        designs = self.search.scatter.designs
        self.search(designs(points))
        self.points = np.concatenate([self.points, points])
        found = self.search.found(designs(points))
        self.found = joined([self.found, found])
        return found

    def cells(self, points: FloatArray) -> FloatArray:
        """Points whose coordinates of listed values are the middles of these."""
        cells = points.copy()
        for number, variable in enumerate(self.variables):
            if variable.distribution == "values":
                count = len(variable.numbers)
                cells[:, number] = (
                    np.clip(points[:, number] * count, 0, count - 1) // 1 + 0.5
                ) / count
        return cells

    def distance(self, points: FloatArray) -> FloatArray:
        """From each point (n, c) to the nearest known one, (n,)."""
        return np.asarray(cdist(points, self.points).min(axis=1))

    def around(self, point: FloatArray, width: float, random: np.random.Generator) -> FloatArray:
        """A point and others in a box of a half width about it, within the unit cube."""
        away = width * (2 * random.random((_AROUND, len(point))) - 1)
        return self.cells(np.clip(np.concatenate([point[None], point + away]), 0.0, 1.0))


def start_size(study: Study) -> int:
    """Designs with which a search by a model begins, besides the ends of the ranges.

    Parameters
    ----------
    study : Study

    Returns
    -------
    int
    """
    return 1 << math.ceil(math.log2(4 * (len(chosen_variables(study)) + 1)))


def most_by_model(study: Study) -> int:
    """Designs that a search by a model computes at most.

    Parameters
    ----------
    study : Study

    Returns
    -------
    int
    """
    count = len(chosen_variables(study))
    batch = _BATCH if len(study.goals) == 1 else _OF_FRONT
    return start_size(study) + 2 * count + _rounds(study, count) * batch


def _rounds(study: Study, count: int) -> int:
    first = _ROUNDS if len(study.goals) == 1 else _ROUNDS_OF_FRONT
    return first + _MORE_ROUNDS * (count - 1)


def by_model(search: Search) -> FloatArray:
    """The best designs: one of one goal, or those of several that no other is better than in all.

    Parameters
    ----------
    search : Search

    Returns
    -------
    ndarray, shape (n, k)
        The nearest where none keeps every limit.
    """
    study, known = search.study, _KnownDesigns(search)
    count = len(known.variables)
    # The ends of each range too, beyond which the model need not go, all others in their middle.
    ends = np.full((2 * count, count), 0.5)
    for number in range(count):
        ends[2 * number : 2 * number + 2, number] = 0.0, 1.0
    start = np.concatenate([sobol_points(start_size(study), count, study.seed), ends])
    known.add(np.unique(known.cells(start), axis=0))
    everywhere = known.cells(sobol_points(_EVERYWHERE, count, study.seed))
    random = np.random.default_rng(study.seed)
    if len(study.goals) > 1:
        return _front(known, everywhere, random)
    idle, margin = 0, _MARGIN
    for _ in range(_rounds(study, count)):
        model = OutputModel.of(known.points, known.found)
        best = np.empty((0, count))
        if model is not None:
            best = _best(known, model, everywhere, random, margin)[None]
            best = best[known.distance(best) > _NEAR]
        idle = 0 if len(best) else idle + 1
        if idle > _IDLE and search.design is not None:
            break
        points = np.concatenate([best, _far(known, model, everywhere, best)])
        if not len(points):
            break
        found = known.add(points)
        if len(best) and model is not None and study.limits and found.status[0] == 0:
            off = np.abs(
                margins_of(study, model.at(best).values[0]) - margins_of(study, found.values[0])
            )
            margin = float(np.clip(off.max(), _LEAST_MARGIN, _MARGIN))
    chosen = search.nearest if search.design is None else search.design
    assert chosen is not None
    return chosen[None]


def _best(
    known: _KnownDesigns,
    model: OutputModel,
    everywhere: FloatArray,
    random: np.random.Generator,
    margin: float,
) -> FloatArray:
    """The best point by the model: first all over the ranges, then in ever smaller boxes, (c,)."""
    search, asked = known.search, everywhere
    for box in range(_BOXES + 1):
        found = model.at(asked)
        goals, violation = search.judged(found)
        short = violation
        for limit in search.study.limits:
            column = list(search.study.outputs).index(limit.output)
            short = short + np.maximum(margin - limit.margin(found.values[:, column]), 0.0)
        best = asked[np.lexsort([goals[:, 0], short])[0]]
        if box < _BOXES:
            asked = known.around(best, 4.0 ** -(box + 1), random)
    return np.asarray(best)


def _far(
    known: _KnownDesigns, model: OutputModel | None, everywhere: FloatArray, besides: FloatArray
) -> FloatArray:
    """The point farthest from all known ones that may be better than the best, (1, c) or (0, c)."""
    asked, search = everywhere, known.search
    if model is not None and search.best is not None:
        goals, _ = search.judged(model.at(everywhere))
        asked = everywhere[goals[:, 0] < search.best[0]]
    if not len(asked):
        return asked
    distance = cdist(asked, np.concatenate([known.points, besides])).min(axis=1)
    farthest = distance.argmax()
    return np.asarray(asked[farthest : farthest + int(distance[farthest] > _NEAR)])


def _front(known: _KnownDesigns, everywhere: FloatArray, random: np.random.Generator) -> FloatArray:
    """Designs that no other is better than in every goal, filled up where they are far apart."""
    search, count = known.search, len(known.variables)
    for _ in range(_rounds(search.study, count)):
        model = OutputModel.of(known.points, known.found)
        if model is None:
            points = _far(known, None, everywhere, np.empty((0, count)))
        else:
            points = _gaps(known, model, everywhere, random)
        if not len(points):
            break
        known.add(points)
    goals, violation = search.judged(known.found)
    within = np.flatnonzero(violation <= 0)
    if not len(within):
        assert search.nearest is not None
        return search.nearest[None]
    front = within[_not_dominated(goals[within])]
    return np.unique(search.scatter.designs(known.points[front]), axis=0)


def _gaps(
    known: _KnownDesigns, model: OutputModel, everywhere: FloatArray, random: np.random.Generator
) -> FloatArray:
    """Points of the front by the model whose goals are farthest from known ones, (n, c)."""
    goals, violation = known.search.judged(known.found)
    best = np.lexsort([goals[:, 0], violation])[:1]
    within = np.flatnonzero(violation <= 0)
    front = within[_not_dominated(goals[within])] if len(within) else best
    boxes = [known.around(point, 4.0**-2, random) for point in known.points[front]]
    asked = np.concatenate([everywhere, *boxes])
    asked = asked[known.distance(asked) > _NEAR]
    if not len(asked):
        return asked
    expected, short = known.search.judged(model.at(asked))
    keeps = short <= 0
    if not keeps.any():
        return asked[short.argsort()[:1]]
    asked, expected = asked[keeps], expected[keeps]
    # Beside what is known already, which no design by the model is to be worse than.
    compared = np.concatenate([expected, goals[front]])
    better = _not_dominated(compared)
    better = better[better < len(asked)]
    size = np.ptp(compared[np.isfinite(compared).all(axis=1)], axis=0)
    scale = np.where(size > 0, size, 1.0)
    places, taken = expected[better] / scale, goals[front] / scale
    chosen: list[int] = []
    for _ in range(min(_OF_FRONT, len(better))):
        gap = cdist(places, taken).min(axis=1)
        chosen.append(int(gap.argmax()))
        taken = np.concatenate([taken, places[chosen[-1:]]])
    return np.asarray(asked[better[np.unique(chosen)]])


def _not_dominated(goals: FloatArray) -> IntArray:
    """Numbers of the rows of goals (n, g) that no other is better than in every goal."""
    no_worse = (goals[:, None] <= goals[None]).all(axis=2)
    better = (goals[:, None] < goals[None]).any(axis=2)
    return np.flatnonzero(~(no_worse & better).any(axis=0))
