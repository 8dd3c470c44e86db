"""The hammer test of the locked linkage: records, frequency responses, and identified modes."""

from __future__ import annotations

from flexmech.analyses.beam_theory import theory_attributes
from flexmech.analyses.datasets import with_units
from flexmech.analyses.hammer.dataset import dataset_of
from flexmech.analyses.hammer.locked_linkage import LockedLinkage
from flexmech.analyses.hammer.measurement import measured
from flexmech.analyses.hammer.plan import planned_record
from flexmech.analyses.hammer.request import HammerRequest
from flexmech.analyses.hammer.result import HammerTest
from flexmech.analyses.remarks import left_out_attributes
from flexmech.analyses.requests import engine_of
from flexmech.linear_system import Engine
from flexmech.numbers import check_instance
from flexmech.threads import one_thread
from flexmech.types import LabelledProgress, silent


def hammer_test(
    engine: Engine,
    request: HammerRequest,
    *,
    progress: LabelledProgress | None = None,
) -> HammerTest:
    """Hit the linkage at locked crank angles, as a laboratory does with an impact hammer.

    An engine that simulates (Exudyn) runs its nonlinear transient under the pulse; the other's is
    the exact solution of its linear equations. Force and displacement are sampled and averaged,
    frequency responses estimated, and modes identified from them, beside the exact ones.

    Parameters
    ----------
    engine : Engine
        Whose links are damped.
    request : HammerRequest
    progress : callable, optional
        Called with a label, the steps done and the steps to do.

    Returns
    -------
    HammerTest

    Raises
    ------
    InputError
        If the linkage is not damped, a point is on no link or does not move, or band, pulse and
        duration do not belong together.
    ComputationError
        If there is no equilibrium, or a step of Exudyn does not converge.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/composite_fourbar.toml")
    >>> engine = flexmech.ReferenceEngine(mechanism, elements=4)
    >>> found = flexmech.hammer_test(engine, flexmech.HammerRequest(np.radians([96.9]), modes=3))
    >>> found.identified()["frequency_Hz"].round(-1).tolist()
    [880.0, 1020.0, 1420.0]
    """
    check_instance(request, HammerRequest, "request", "give a flexmech.HammerRequest")
    engine = engine_of(engine).fit_for(request.modes)
    report = progress or silent
    with one_thread():
        locked = [LockedLinkage.at(engine, float(a), request.prestress) for a in request.angles]
        plan = planned_record(request, locked)
        found = [
            measured(each, plan, request, number, report) for number, each in enumerate(locked)
        ]
        dataset = dataset_of(engine, request, plan, found)
    dataset.attrs |= theory_attributes([engine], request.modes)
    dataset.attrs |= left_out_attributes(engine.mechanism)
    return HammerTest(with_units(dataset, "hammer"))
