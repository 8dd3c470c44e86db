"""Counterweights that balance a linkage: fully, in part, or in a compromise."""

from __future__ import annotations

from collections.abc import Sequence

import xarray as xr

from flexmech.analyses.balance.compromise import WeighedSum, least_moments
from flexmech.analyses.balance.counterweights import Counterweight, balanced
from flexmech.analyses.balance.dataset import STATES, balance_dataset, elastic_variables
from flexmech.analyses.balance.elastic import elastic_shaking
from flexmech.analyses.balance.model_file import balanced_text
from flexmech.analyses.balance.peaks import elastic_peaks
from flexmech.analyses.balance.request import WEIGHED, BalanceRequest
from flexmech.analyses.balance.result import Balance
from flexmech.arrays import LabelledProgress, silent
from flexmech.errors import FlexmechError, InputError
from flexmech.linear_system import Engine, checked_mechanism
from flexmech.linkages.frame_forces import OneCouplerLinkage
from flexmech.mechanism import Mechanism

# Of a first moment, over masses times lengths: the last bits of sums of ten numbers. What is left
# out so does not shake the frame by more than the round-off of joint forces.
_NOISE = 1e-15
# And of one that is searched for: the sum that is weighed is flat about its least value.
_SEARCHED = 1e-8


def balance(
    mechanism: Mechanism | Engine,
    speed: BalanceRequest | float | None = None,
    *,
    speed_unit: str | None = None,
    progress: LabelledProgress | None = None,
) -> Balance:
    """Find counterweights on crank and follower that keep a linkage from shaking its frame.

    Of a four-bar they make the centre of all masses stand still (Berkof and Lowen, Journal of
    Engineering for Industry 91, 1969, 21-26), so that rigid links put no force of inertia on the
    frame at any crank angle and speed. Of a slider-crank the counterweight of the crank balances
    the rotating masses and a share of the reciprocating one. With weights the counterweights are a
    compromise between shaking force, shaking moment and driving torque.

    Parameters
    ----------
    mechanism : Mechanism or Engine
        A four-bar or a slider-crank; of an engine its mechanism counts.
    speed : float or BalanceRequest, optional
        Crank speed in ``speed_unit``, or all that can be asked for. Left out: the greatest speed at
        which the mechanism operates.
    speed_unit : str, optional
        Unit of the speed, such as ``"rpm"``, in which the result speaks of it. Left out: rad/s,
        that of the request, or that of the model file for the mechanism's speed.
    progress : callable, optional
        Called with a label, the runs done and the runs to do.

    Returns
    -------
    Balance

    Raises
    ------
    InputError
        If the linkage is neither a four-bar nor a slider-crank, or locks at a crank angle.
    ComputationError
        If a run of the elastic linkage does not converge.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> found = flexmech.balance(mechanism, flexmech.BalanceRequest(20.0, elastic=False))
    >>> [round(1e3 * float(mass), 2) for mass in found.dataset["counterweight_mass"]]  # g
    [62.83, 64.87]
    """
    own = mechanism.mechanism if isinstance(mechanism, Engine) else mechanism
    given, report = checked_mechanism(own), progress or silent
    if not isinstance(speed, BalanceRequest):
        request = BalanceRequest(speed, speed_unit=speed_unit)
    elif speed_unit is not None:
        raise InputError("speed_unit: the request has its own; give it there")
    else:
        request = speed
    weights, remark = counterweights(given, request)
    after = balanced(given, weights)
    dataset = balance_dataset((given, after), weights, request)
    dataset.attrs |= {
        "aim": remark,
        "balanced_model": balanced_text(after, given, weights, f"Counterweights: {remark}."),
    }
    if request.elastic and any(not link.rigid for link in given.linkage.topology.links):
        found = []
        for number, state in enumerate((given, after)):
            report("elastic links", number, len(STATES))
            omega = request.speed_of(given)
            try:
                found.append(elastic_shaking(state, omega, request.moment_point))
            except FlexmechError as error:
                text = f"elastic links: {error.message}; or ask for rigid ones alone (--rigid)"
                raise type(error)(text) from error
        report("elastic links", len(STATES), len(STATES))
        peaks = elastic_peaks(found).assign_coords(state=dataset["state"])
        dataset = xr.merge(
            [dataset, peaks, elastic_variables(found)],
            join="outer",
            compat="no_conflicts",
            combine_attrs="override",
        )
    return Balance(Balance.schema().labelled(dataset))


def counterweights(
    mechanism: Mechanism, request: BalanceRequest
) -> tuple[tuple[Counterweight, ...], str]:
    """Counterweights as asked for.

    Parameters
    ----------
    mechanism : Mechanism
    request : BalanceRequest

    Returns
    -------
    tuple of Counterweight
        Of the crank and, where there is one, of the follower; without mass where it gains nothing.
    str
        What they are for.

    Raises
    ------
    InputError
        If the linkage is none whose counterweights are found.
    """
    topology = mechanism.linkage.topology
    linkage = OneCouplerLinkage.of(topology)
    masses, radii = mechanism.link_masses_in_order, request.radii_of(linkage)
    lengths = [topology.links[link.number].length for link in linkage.turning]
    slides = linkage.follower is None
    if request.weights is None:
        moments: Sequence[complex] = linkage.balancing_moments(masses, request.share)
        remark = "full balance of the shaking force (Berkof and Lowen 1969)"
        if slides:
            part = f"{100 * request.share:.4g} %"
            remark = f"balance of the rotating masses and of {part} of the reciprocating mass"
    else:
        links = list(zip(linkage.turning, lengths, radii, strict=True))
        speed = request.speed_of(mechanism)
        motion = mechanism.linkage.motion(request.crank_angles, speed)
        asked = request.weights, request.moment_point
        weighed = WeighedSum.of(mechanism, motion, links, *asked)
        moments = least_moments(weighed, linkage.balancing_moments(masses))
        told = zip(WEIGHED, request.weights, strict=True)
        remark = "a compromise with weights of " + ", ".join(
            f"{weight:g} for {what}" for what, weight in told
        )
    noise = _NOISE if request.weights is None else _SEARCHED
    largest = sum(mass.moment(0) * mass.length for mass in masses)
    found = [
        Counterweight.of_moment(link, length, _clean(moment, noise * largest), radius)
        for link, length, moment, radius in zip(
            linkage.turning, lengths, moments, radii, strict=True
        )
    ]
    return tuple(found), remark


def _clean(moment: complex, noise: float) -> complex:
    """A first moment without what round-off or a search leaves of one that is zero."""
    parts = (part if abs(part) > noise else 0.0 for part in (moment.real, moment.imag))
    return complex(*parts)
