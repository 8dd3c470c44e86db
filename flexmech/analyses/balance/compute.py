"""Counterweights that balance a linkage: fully, in part or in a compromise; as a model file too.

The dataset holds the linkage as given and balanced, and beside a compromise the full balance.
"""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from flexmech import plots
from flexmech.analyses.aspects.shaking import harmonic_values
from flexmech.analyses.balance.compromise import (
    Counterweight,
    WeighedSum,
    balanced,
    inertia_loads,
    least_moments,
)
from flexmech.analyses.balance.elastic import (
    ElasticShaking,
    elastic_peaks,
    elastic_shaking,
    rigid_peaks,
)
from flexmech.analyses.balance.request import EQUAL, WEIGHED, BalanceRequest
from flexmech.analyses.balance.words import summary_of
from flexmech.analyses.datasets import origin
from flexmech.analyses.requests import asks
from flexmech.analyses.result import Result
from flexmech.analyses.schema import Values, schema_of
from flexmech.analyses.summary import Summary
from flexmech.arrays import silent
from flexmech.errors import FlexmechError, InputError
from flexmech.linkages.frame_forces import OneCouplerLinkage, ShakingForce, shaft_axis
from flexmech.mechanics import Engine, checked_mechanism
from flexmech.mechanism import Mechanism, drawing
from flexmech.modelfile.read import mechanism_from_toml

if TYPE_CHECKING:
    from matplotlib.figure import Figure


STATES = ("as given", "balanced", "full balance")
"""States of the linkage, along the dimension ``state``; the last one beside a compromise."""

SCHEMA = schema_of(__package__)
# Steps of a turn whose harmonics are given.
_STEPS = 720
_TURN = 2 * np.pi


def balance_dataset(
    states: Sequence[Mechanism], weights: Sequence[Counterweight], request: BalanceRequest
) -> xr.Dataset:
    """Loads of rigid links before and after, and the counterweights.

    Parameters
    ----------
    states : sequence of Mechanism
        As given, balanced, and fully balanced beside a compromise.
    weights : sequence of Counterweight
    request : BalanceRequest

    Returns
    -------
    xarray.Dataset
    """
    given, point = states[0], request.moment_point
    topology = given.linkage.topology
    if point is None:
        point = shaft_axis(topology, given.linkage.motion(request.crank_angles[:1]))
    values: Values = {
        "state": list(STATES[: len(states)]),
        "crank_angle": request.crank_angles,
        "component": ["x", "y"],
        "joint": list(topology.joint_names),
        "moment_point": np.array(point),
        "counterweight": [weight.link.name for weight in weights],
        "counterweight_mass": [weight.mass for weight in weights],
        "counterweight_radius": [weight.radius for weight in weights],
        "counterweight_angle": [weight.angle for weight in weights],
        "counterweight_place": [weight.place for weight in weights],
        "counterweight_about": [_joint_at(given, weight) for weight in weights],
    }
    parts = [_state(each, request) for each in states]
    dataset = SCHEMA.dataset(values, parts=parts, along="state")
    dataset = dataset.merge(rigid_peaks(states, request))
    return dataset.assign_attrs(
        {
            **origin(given),
            "crank_speed": request.speed_of(given),
            "drawing": drawing(given, float(request.crank_angles[0])),
            "speed_unit": request.shown_unit(given),
            "weight": float(np.linalg.norm(given.gravity)),
        }
    )


def _joint_at(mechanism: Mechanism, weight: Counterweight) -> str:
    """Joint about which the link of a counterweight rotates."""
    topology, link = mechanism.linkage.topology, weight.link
    fixed = {pivot.link_end: pivot.joint for pivot in topology.pivots}
    fixed |= {clamp.link_end: clamp.joint for clamp in topology.clamps}
    return next(joint for end, joint in fixed.items() if end.link == link.name)


def _state(mechanism: Mechanism, request: BalanceRequest) -> Values:
    """Loads of one state over the crank angles."""
    speed = request.speed_of(mechanism)
    motion = mechanism.linkage.motion(request.crank_angles, speed)
    loads = inertia_loads(mechanism, motion, request.moment_point)
    forces = mechanism.without_loads_over_time.inverse_dynamics(motion)
    joints = mechanism.linkage.topology.joint_names
    return {
        "shaking_force": loads.force,
        "shaking_moment": loads.moment,
        "driving_torque": loads.torque,
        "joint_force": np.stack([forces.joint_force[name] for name in joints], axis=1),
        "moving_mass": sum(mass.moment(0) for mass in mechanism.link_masses_in_order),
        **_harmonics(mechanism, speed, request),
    }


def _harmonics(mechanism: Mechanism, speed: float, request: BalanceRequest) -> Values:
    """Harmonics of the shaking force, where the angles asked for span a turn."""
    first, last = request.crank_angles[[0, -1]].tolist()
    if last - first < _TURN * (1 - 1e-9):
        return {}
    angles = first + _TURN * np.arange(_STEPS) / _STEPS
    loads = inertia_loads(mechanism, mechanism.linkage.motion(angles, speed), request.moment_point)
    return harmonic_values(ShakingForce(loads.force, loads.moment, (0.0, 0.0)), angles)


def elastic_variables(found: Sequence[ElasticShaking]) -> xr.Dataset:
    """Shaking force of elastic links in periodic motion, and the first natural frequency.

    Parameters
    ----------
    found : sequence of ElasticShaking
        Elastic shaking of each state.

    Returns
    -------
    xarray.Dataset
    """
    return SCHEMA.dataset(
        {
            "elastic_shaking_force": np.stack([each.force for each in found]),
            "elastic_shaking_moment": np.stack([each.moment for each in found]),
            "first_frequency": [each.first_frequency for each in found],
            "first_frequency_error": [
                each.first_frequency * each.frequency_error for each in found
            ],
            "state": list(STATES[: len(found)]),
            "elastic_angle": found[0].crank_angle,
            "component": ["x", "y"],
        }
    )


class Balance(Result):
    """Counterweights of a linkage, and its shaking force, torque and joint forces with them.

    Parameters
    ----------
    dataset : xarray.Dataset
        The variables of ``schema.toml``: counterweights over ``counterweight``, named by their
        links; loads before and after over ``state`` ("as given", "balanced", and beside a
        compromise "full balance"). The attribute
        ``balanced_model`` is the model file with the counterweights.
    stored_as : mapping of str to str, optional
        Conventions, title, date and command line of the file that it was loaded from.
    """

    stem = "balance"
    subject = "balance"
    hallmark = "counterweight_mass"
    files = ("balanced.toml",)

    def tabulated(self) -> xr.Dataset:
        """The dataset with sizes of joint forces."""
        force = self.dataset["joint_force"].transpose(..., "component")
        return self.dataset.assign(
            joint_force_size=(force.dims[:-1], np.linalg.norm(force.values, axis=-1))
        )

    def texts(self) -> dict[str, str]:
        """The balanced model file."""
        return {"balanced.toml": str(self.dataset.attrs["balanced_model"])}

    def plot(self, *, ax: plots.AxesLike | None = None) -> Figure:
        """Draw the counterweights; shaking force, shaking moment and torque before and after.

        Parameters
        ----------
        ax : sequence of matplotlib.axes.Axes, optional
            Four of the user's.
        """
        return plots.plot_balance(self.dataset, ax=ax)

    def summary(self) -> Summary:
        """The counterweights, the shaking force before and after, and what they cost."""
        return summary_of(self.dataset)


def balanced_text(
    mechanism: Mechanism, given: Mechanism, weights: Sequence[Counterweight], remark: str
) -> str:
    """Write a model file that loads back equal to the balanced mechanism.

    Parameters
    ----------
    mechanism : Mechanism
        With the counterweights.
    given : Mechanism
        Without them; its own file, comments included, is kept where it can be.
    weights : sequence of Counterweight
    remark : str
        What the counterweights are for, in a line.

    Returns
    -------
    str
        TOML.
    """
    tables = "".join(_table(weight) for weight in weights if weight.mass)
    name = f"name = {json.dumps(mechanism.provenance.name, ensure_ascii=False)}"
    own = re.sub(r"(?m)^name\s*=.*$", lambda _: name, given.provenance.text, count=1)
    text = f"{own.rstrip()}\n\n# {remark}{tables}"
    if given.provenance.text and _reads_as(text, mechanism):
        return text
    return f"# {remark}\n{mechanism.to_toml()}"


def _reads_as(text: str, mechanism: Mechanism) -> bool:
    """Whether a text is a model file of a mechanism.

    A file whose links stand in lines of their own takes no table at its end.
    """
    try:
        return mechanism_from_toml(text) == mechanism
    except InputError:
        return False


def _table(weight: Counterweight) -> str:
    """The counterweight as a table at the end of a model file."""
    name = weight.link.name
    key = name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else json.dumps(name, ensure_ascii=False)
    rows = (f"{key} = {json.dumps(value)}" for key, value in weight.body.to_table().items())
    return "\n".join([f"\n[[links.{key}.bodies]]", *rows, ""])


# Noise of a first moment, over masses times lengths: the last bits of sums of ten numbers. What is
# left out so does not shake the frame by more than the round-off of joint forces.
_NOISE = 1e-15
# And of one that is searched for: the sum that is weighed is flat about its least value.
_SEARCHED = 1e-8


@asks(BalanceRequest)
def balance(mechanism: Mechanism | Engine, request: BalanceRequest) -> Balance:
    """Find counterweights on crank and follower that keep a linkage from shaking its frame.

    The counterweights of a four-bar are a compromise between shaking force, shaking moment and
    driving torque, beside its limit: the full balance makes the centre of all masses stand still
    (Berkof and Lowen, Journal of Engineering for Industry 91, 1969, 21-26), so that rigid links put
    no force of inertia on the frame at any crank angle and speed. The counterweight of a
    slider-crank's crank balances the rotating masses and a share of the reciprocating one.

    Parameters
    ----------
    mechanism : Mechanism or Engine
        A four-bar or a slider-crank; of an engine its mechanism counts.

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
    >>> found = flexmech.balance(mechanism, 20.0, full=True, rigid=True)
    >>> [round(1e3 * float(mass), 2) for mass in found.dataset["counterweight_mass"]]  # g
    [62.83, 64.87]
    """
    own = mechanism.mechanism if isinstance(mechanism, Engine) else mechanism
    given, report = checked_mechanism(own), request.progress or silent
    weights, remark = counterweights(given, request)
    after = balanced(given, weights)
    states = [given, after]
    if not request.full and OneCouplerLinkage.of(given.linkage.topology).follower is not None:
        limit, _ = counterweights(given, replace(request, weights=None, full=True))
        states.append(balanced(given, limit))
    dataset = balance_dataset(states, weights, request)
    dataset.attrs |= {
        "aim": remark,
        "balanced_model": balanced_text(after, given, weights, f"Counterweights: {remark}."),
    }
    if not request.rigid and any(not link.rigid for link in given.linkage.topology.links):
        found = []
        for number, state in enumerate(states):
            report("elastic links", number, len(states))
            omega = request.speed_of(given)
            try:
                found.append(elastic_shaking(state, omega, request.moment_point))
            except FlexmechError as error:
                text = f"elastic links: {error.message}; or ask for rigid ones alone (--rigid)"
                raise type(error)(text) from error
        report("elastic links", len(states), len(states))
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
        Counterweights of the crank and, where there is one, of the follower; without mass where it
        gains nothing.
    str
        What they are for.

    Raises
    ------
    InputError
        If the linkage is none whose counterweights are found.
    """
    linkage = OneCouplerLinkage.of(mechanism.linkage.topology)
    masses, weights = mechanism.link_masses_in_order, request.weights_of(linkage)
    if weights is not None:
        moments, remark = _compromise(mechanism, linkage, weights, request)
        return _placed(mechanism, linkage, moments, request, _SEARCHED), remark
    remark = "full balance of the shaking force (Berkof and Lowen 1969)"
    if linkage.follower is None:
        part = f"{100 * request.share:.4g} %"
        remark = f"balance of the rotating masses and of {part} of the reciprocating mass"
    moments = linkage.balancing_moments(masses, request.share)
    return _placed(mechanism, linkage, moments, request, _NOISE), remark


def _compromise(
    mechanism: Mechanism,
    linkage: OneCouplerLinkage,
    weights: tuple[float, ...],
    request: BalanceRequest,
) -> tuple[Sequence[complex], str]:
    """First moments of the counterweights with the least weighed sum, and what it weighs."""
    links = list(
        zip(linkage.turning, _lengths(mechanism, linkage), request.radii_of(linkage), strict=True)
    )
    motion = mechanism.linkage.motion(request.crank_angles, request.speed_of(mechanism))
    weighed = WeighedSum.of(mechanism, motion, links, weights, request.moment_point)
    moments = least_moments(weighed, linkage.balancing_moments(mechanism.link_masses_in_order))
    if weights == EQUAL:
        *first, last = WEIGHED
        return moments, f"compromise with equal weights for {', '.join(first)} and {last}"
    parts = (f"{weight:g} for {what}" for what, weight in zip(WEIGHED, weights, strict=True))
    return moments, f"compromise with weights of {', '.join(parts)}"


def _placed(
    mechanism: Mechanism,
    linkage: OneCouplerLinkage,
    moments: Sequence[complex],
    request: BalanceRequest,
    noise: float,
) -> tuple[Counterweight, ...]:
    """Counterweights of first moments, at the radii asked for."""
    largest = sum(mass.moment(0) * mass.length for mass in mechanism.link_masses_in_order)
    return tuple(
        Counterweight.of_moment(link, length, _clean(moment, noise * largest), radius)
        for link, length, moment, radius in zip(
            linkage.turning,
            _lengths(mechanism, linkage),
            moments,
            request.radii_of(linkage),
            strict=True,
        )
    )


def _lengths(mechanism: Mechanism, linkage: OneCouplerLinkage) -> list[float]:
    """Lengths of the links that turn about the ground."""
    return [mechanism.linkage.topology.links[link.number].length for link in linkage.turning]


def _clean(moment: complex, noise: float) -> complex:
    """A first moment without what round-off or a search leaves of one that is zero."""
    parts = (part if abs(part) > noise else 0.0 for part in (moment.real, moment.imag))
    return complex(*parts)
