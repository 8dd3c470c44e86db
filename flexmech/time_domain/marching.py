"""Which method takes a driven linkage through time.

Linear equations are integrated by the trapezoidal rule, those of links that stretch by the
square of their slopes by Lobatto's method of fourth order: what a step of them costs is spent
on the forces that are not linear, of which longer steps ask for fewer.
"""

from __future__ import annotations

from collections.abc import Sequence

from flexmech.time_domain.driven_linkage import DrivenLinkage
from flexmech.time_domain.linear_march import LinearMarch
from flexmech.time_domain.lobatto import STAGES
from flexmech.time_domain.stretch_march import StretchMarch
from flexmech.types import FloatArray


def marching(
    linkage: DrivenLinkage, step: float, load: Sequence[FloatArray] | None = None
) -> LinearMarch | StretchMarch:
    """The method for a linkage.

    Parameters
    ----------
    linkage : DrivenLinkage
    step : float
        Between recorded instants, in s.
    load : sequence of ndarray, shape (n_link,), optional
        Forces on the reduced links in their frames, of which a run can take any part at any
        time.

    Returns
    -------
    LinearMarch or StretchMarch
    """
    return (LinearMarch if linkage.stretch is None else StretchMarch)(linkage, step, load)


def step_lag(angle: float, *, stretches: bool) -> float:
    """By what part of itself steps lower the frequency of a free vibration, to leading order.

    Parameters
    ----------
    angle : float
        Of the vibration in one step, in rad.
    stretches : bool
        Whether the method is that of links that stretch.

    Returns
    -------
    float
    """
    return float((STAGES * angle) ** 4 / 720 if stretches else angle**2 / 12)
