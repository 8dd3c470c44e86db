"""What can be fitted, by its name, and the mechanism with fitted values in it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from flexmech.analyses import damping_ratios
from flexmech.errors import InputError, suggestion
from flexmech.linear_system import Engine
from flexmech.sections import BeamSection

DAMPING, STIFFNESS, OFFSET, GAIN, NOTHING = "damping", "stiffness", "offset", "gain", "none"
# Beam elements whose stiffness is that of the layers, not that of the section as a whole.
LAYERED = ("zigzag", "reddy")


@dataclass(frozen=True)
class Fitted:
    """What is asked to be fitted.

    Parameters
    ----------
    damping : bool
        One Kelvin-Voigt time of all links that have none of their own here.
    damped_links, stiff_links : tuple of str
        Links with a damping time of their own, and those with a factor on the stiffness.
    offset : bool
        The gauge's zero.
    gain : bool
        Factor on the computed record: how far the gauge's calibration is off.
    """

    damping: bool
    damped_links: tuple[str, ...]
    stiff_links: tuple[str, ...]
    offset: bool
    gain: bool

    @property
    def damps(self) -> bool:
        """Whether a damping time is among them."""
        return self.damping or bool(self.damped_links)

    def times_of(self, links: Sequence[str], values: Mapping[str, float]) -> dict[str, float]:
        """Damping time of each link that has a fitted one, in s."""
        common = dict.fromkeys(links, values[DAMPING]) if self.damping else {}
        return common | {link: values[f"{DAMPING}:{link}"] for link in self.damped_links}

    def factors(self, values: Mapping[str, float]) -> dict[str, float]:
        """Stiffness factor of each link that has a fitted one."""
        return {link: values[f"{STIFFNESS}:{link}"] for link in self.stiff_links}


def known_names(links: Sequence[str]) -> list[str]:
    """All names that can be fitted, for links of these names."""
    own = [f"{what}:{link}" for what in (DAMPING, STIFFNESS) for link in links]
    return [DAMPING, *own, OFFSET, GAIN, NOTHING]


def fitted_names(names: Sequence[str], links: Sequence[str]) -> Fitted:
    """Read what is asked to be fitted.

    Parameters
    ----------
    names : sequence of str
        Such as ``("damping", "damping:coupler", "stiffness:coupler")``.
    links : sequence of str
        Names of the linkage's links.

    Returns
    -------
    Fitted

    Raises
    ------
    InputError
        If a name is unknown or stands twice, or ``none`` stands beside others.
    """
    known = known_names(links)
    for name in names:
        if name not in known:
            raise InputError(f"fit: {name!r} cannot be fitted; {suggestion(name, known)}")
        if names.count(name) > 1:
            raise InputError(f"fit: {name!r} stands twice; name each once")
    if NOTHING in names and len(names) > 1:
        raise InputError(f"fit: {NOTHING!r} stands beside others; write it alone, or leave it out")
    damped = tuple(link for link in links if f"{DAMPING}:{link}" in names)
    if DAMPING in names and len(damped) == len(links):
        raise InputError(
            "fit: every link has a damping time of its own, and none is left for 'damping'; leave "
            "that out, or one of the links"
        )
    return Fitted(
        damping=DAMPING in names,
        damped_links=damped,
        stiff_links=tuple(link for link in links if f"{STIFFNESS}:{link}" in names),
        offset=OFFSET in names,
        gain=GAIN in names,
    )


def with_damping_times(engine: Engine, times: Mapping[str, float]) -> Engine:
    """The engine with other damping times of some links; a fit keeps the element that it has."""
    return damping_ratios.with_damping_times(engine.with_(element=engine.element), times)


def with_stiffness(engine: Engine, factors: Mapping[str, float]) -> Engine:
    """The engine with the stiffness of some links times a factor.

    Parameters
    ----------
    engine : Engine
    factors : mapping of str to float
        Of the axial, bending and shear stiffness together.

    Returns
    -------
    Engine

    Raises
    ------
    InputError
        If the elements take their stiffness from the layers of a laminate.
    """
    if not factors:
        return engine
    if engine.element in LAYERED:
        raise InputError(
            f"fit: elements {engine.element} take their stiffness from the layers of the link; "
            "fit the stiffness with an element that takes it from the section, such as timoshenko"
        )
    mechanism = engine.mechanism
    sections = {
        name: _stiffened(section, factors[name]) if name in factors else section
        for name, section in mechanism.sections.items()
    }
    return engine.with_(mechanism=replace(mechanism, sections=sections), element=engine.element)


def _stiffened(section: BeamSection, factor: float) -> BeamSection:
    return replace(
        section,
        axial_stiffness=factor * section.axial_stiffness,
        bending_stiffness=factor * section.bending_stiffness,
        shear_stiffness=factor * section.shear_stiffness,
    )
