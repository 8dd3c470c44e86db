"""One crank-rocker for a wanted transmission angle, and what its lengths give computed back."""

from __future__ import annotations

import numpy as np

from flexmech.analyses.datasets import versions
from flexmech.analyses.synthesis.result import CrankRockerSynthesis
from flexmech.linkages import rocker_swing, synthesize_crank_rocker, time_ratio, transmission_design
from flexmech.validation import POSITIVE, checked_number

# A degree: what a figure draws, and a table lists.
TURN = np.radians(np.arange(361.0))


def crank_rocker_synthesis(
    deviation: float, rocker_angle: float, ground: float | None = None
) -> CrankRockerSynthesis:
    """Crank-rocker whose transmission angle stays within 90 degrees plus or minus a deviation.

    By the equations of Elamy et al. 2023; see :func:`flexmech.linkages.synthesize_crank_rocker`.

    Parameters
    ----------
    deviation : float
        Between 0 and pi/2, in rad.
    rocker_angle : float
        Angle of the rocker against the ground at crank angle zero, between pi/2 less the
        deviation and pi, in rad.
    ground : float, optional
        Distance of the ground pivots in m; proportions alone if left out.

    Returns
    -------
    CrankRockerSynthesis

    Raises
    ------
    InputError
        If an angle or the distance is out of its bounds.

    Examples
    --------
    >>> found = flexmech.crank_rocker_synthesis(*np.radians([30, 90]), ground=0.4)
    >>> found.dataset["length"].values.round(4)
    array([0.4   , 0.0835, 0.3655, 0.1827])
    """
    wanted = checked_number(deviation, "deviation", "rad")
    found = synthesize_crank_rocker(wanted, checked_number(rocker_angle, "rocker_angle", "rad"))
    size = 1.0 if ground is None else checked_number(ground, "ground", "m", POSITIVE)
    linkage = found.linkage(size)
    values = {
        "ratio": [1.0, found.crank, found.coupler, found.rocker],
        "transmission_angle": [linkage.transmission_angle(TURN)],
        "transmission_angle_limit": [*linkage.transmission_angle_limits()],
        "rocker_angle": transmission_design(linkage).rocker_angle,
        "rocker_swing": rocker_swing(linkage),
        "time_ratio": time_ratio(linkage),
        "linkage": ["this linkage"],
        "crank_angle": TURN,
        "member": list(linkage.lengths),
        "limit": ["least", "greatest"],
    }
    if ground is not None:
        values["length"] = [*linkage.lengths.values()]
    dataset = CrankRockerSynthesis.schema().dataset(values)
    return CrankRockerSynthesis(
        dataset.assign_attrs(
            mechanism="synthesized four-bar",
            grashof_class=linkage.grashof_class,
            wanted_least=np.pi / 2 - wanted,
            wanted_greatest=np.pi / 2 + wanted,
            wanted_label="wanted range",
            **versions(),
        )
    )
