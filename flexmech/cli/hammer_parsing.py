"""Points and quantities of ``flexmech hammer`` as they are typed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexmech import units
from flexmech.cli.arguments import parse_option
from flexmech.cli.failures import naming
from flexmech.errors import InputError

if TYPE_CHECKING:
    from flexmech.linear_system import LinkPoint
    from flexmech.mechanism import Mechanism


def parse_point(mechanism: Mechanism, option: str, text: str | None) -> LinkPoint:
    """Point of an option; the middle of the coupler, or of the last link, where it is left out.

    Parameters
    ----------
    mechanism : Mechanism
    option : str
    text : str, optional
        ``LINK:FRACTION``.

    Returns
    -------
    LinkPoint

    Raises
    ------
    InputError
        If it is no point of a link of the linkage; names the option.
    """
    from flexmech.linear_system import LinkPoint

    topology = mechanism.linkage.topology
    names = topology.link_names
    if text is None:
        return LinkPoint("coupler" if "coupler" in names else names[-1], 0.5)
    with naming(option):
        point = LinkPoint.parse(text)
        point.index(topology)
    return point


def parse_positive(option: str, text: str, dimension: units.Dimension) -> float:
    """Positive quantity of an option, in SI units.

    Parameters
    ----------
    option, text : str
    dimension : Dimension

    Returns
    -------
    float

    Raises
    ------
    InputError
        If it is no such quantity, or not positive; names the option.
    """
    value = parse_option(option, text, dimension, dimension.unit)
    if value <= 0:
        raise InputError(f"{option}: must be positive, got {text!r}")
    return value
