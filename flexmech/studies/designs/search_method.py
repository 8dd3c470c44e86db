"""Which search a study has: by its goals, and by what its designs cost."""

from __future__ import annotations

from collections.abc import Callable

from flexmech.arrays import FloatArray
from flexmech.studies.designs.model_search import by_model, most_by_model
from flexmech.studies.designs.outputs import COSTLY
from flexmech.studies.designs.search import (
    Search,
    most_of_one_goal,
    most_of_several_goals,
    one_goal,
    several_goals,
)
from flexmech.studies.designs.study import Study

Find = Callable[[Search], FloatArray]
"""From a search to the best designs (n, k)."""


def search_method(study: Study) -> tuple[Find, int]:
    """The search for the best designs of a study, and how many runs it can ask for.

    Parameters
    ----------
    study : Study

    Returns
    -------
    callable
    int
    """
    samples = study.percentile_samples if study.uncertain else 1
    if any(output.quantity in COSTLY for output in study.outputs.values()):
        return by_model, samples * most_by_model(study)
    if len(study.goals) > 1:
        return several_goals, samples * most_of_several_goals()
    # One more of each of the first sample, at the medians of what is uncertain.
    return one_goal, (samples + 1) * most_of_one_goal(study)
