"""Beam theory that the engines follow, its reason and its error: in words, for results."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from flexmech.linkages import LinkEnd
from flexmech.mechanics import (
    COMPRESSED,
    NEGLIGIBLE,
    RESTRAINED_ENDS,
    Engine,
    TheoryComparison,
    TheoryDifference,
)
from flexmech.mechanics.beams.restrained_ends import RestrainedEnds, restrained_beam
from flexmech.sections import TWISTS, BeamSection, LaminateSection

LINES, WARNINGS, REASON = "beam_theory", "beam_theory_warnings", "beam_theory_difference"
# Theories from the coarsest on. Either of the two that shear as a whole may be the closer one.
LEAVES_OUT_LESS = ("euler", "timoshenko", "reddy", "zigzag")
SHEARS = {"timoshenko", "reddy"}
LEFT_OUT = {
    "euler": "shear",
    "timoshenko": "the warping of cross-sections",
    "reddy": "how layers shear, each by its own stiffness",
}

# Lengths over the width of links whose off-axis plies couple bending and twist: against
# three-dimensional elements with rigid end faces, beams were 10 % low at 3, 5 % at 5 and 2 % at 8.
SHORT, LONG = 3, 5
LOW_BY = 10
# Change of frequencies: less does not tell why two engines differ by more than their errors.
NOTICED = 1e-4


def theory_attributes(engines: Sequence[Engine], modes: int) -> dict[str, str]:
    """Attributes of a result: the theories chosen, what they leave out, and how they differ.

    Parameters
    ----------
    engines : sequence of Engine
        All of one mechanism.
    modes : int
        Natural frequencies that were asked for.

    Returns
    -------
    dict of str to str
        Empty texts where there is nothing to say.
    """
    first = engines[0]
    comparison = first.compare_theories(first.mechanism, modes)
    warnings = [*(_left_out(engine, comparison) for engine in engines), _compressed(comparison)]
    for engine in engines:
        warnings += [*_off_axis(engine), _one_stiffness(engine, comparison)]
    reasons = []
    if len(engines) > 1 and first.theory != engines[1].theory:
        apart = comparison.difference(engines[1].theory, first.theory)
        reasons.append(
            f"their beam theories differ, {first.theory} and {engines[1].theory}: "
            f"by up to {_percent(apart)} at rest{_more_complete(first, engines[1])}"
        )
    if len(engines) > 1:
        reasons += _ends_apart(engines, comparison)
    return {
        LINES: _choice([engine for engine in engines if engine.chooses_element], comparison),
        WARNINGS: "\n".join(filter(None, warnings)),
        REASON: "; ".join(reasons),
    }


def theory_lines(attributes: Mapping[Any, Any]) -> list[str]:
    """Lines of a summary on the choice of the beam theory; none for slender links."""
    return str(attributes.get(LINES, "")).splitlines()


def theory_warnings(attributes: Mapping[Any, Any]) -> tuple[str, ...]:
    """Warnings of what the beam theories leave out, a line an engine."""
    return tuple(str(attributes.get(WARNINGS, "")).splitlines())


def theory_reason(attributes: Mapping[Any, Any]) -> str:
    """End of an agreement of the engines where their theories differ, else empty."""
    reason = attributes.get(REASON, "")
    return f"; {reason}" if reason else ""


def _choice(engines: Sequence[Engine], comparison: TheoryComparison) -> str:
    """Why a beam that shears has been chosen; nothing where none has."""
    if not engines or comparison.suitable == "euler":
        return ""
    shear = comparison.difference("euler", "timoshenko")
    why = f"shear changes frequencies at rest by up to {_percent(shear)}"
    if shear.value <= NEGLIGIBLE:
        why = "the neutral axis or the centre of mass of a link is off its pins"
    if comparison.suitable == "zigzag":
        warping = comparison.difference("timoshenko", "zigzag")
        why += f", the warping of cross-sections by up to {_percent(warping)}"
    elements = ", ".join(f"{engine.element} ({engine.name})" for engine in engines)
    return f"elements chosen: {elements}; {why}"


def _left_out(engine: Engine, comparison: TheoryComparison) -> str:
    """Bound of what an engine's theory leaves out; nothing where that is negligible."""
    if comparison.difference("euler", "timoshenko").value <= NEGLIGIBLE:
        return ""
    found = comparison.difference(engine.theory, "zigzag")
    if found.value <= NEGLIGIBLE:
        return ""
    bound = 100 * (found.value + NEGLIGIBLE)
    return (
        f"element {engine.element} ({engine.name}) leaves out {LEFT_OUT[engine.theory]}: its "
        f"frequencies may be off by {bound:.3g} % (at rest {_percent(found)} from zigzag beams, "
        f"and {100 * NEGLIGIBLE:g} % for what those leave out)"
    )


def _compressed(comparison: TheoryComparison) -> str:
    """First mode for which soft layers are compressed, which no beam knows; empty if in none."""
    if comparison.difference("euler", "timoshenko").value <= NEGLIGIBLE:
        return ""
    mode, compression = comparison.compressed_from, comparison.compression()
    if not mode:
        return ""
    return (
        f"soft layers are compressed at {compression:.3g} Hz, which no beam knows: from mode "
        f"{mode} on, above {100 * COMPRESSED:g} % of that, frequencies may be several times too "
        f"high (below, by {100 * NEGLIGIBLE:g} %)"
    )


def _off_axis(engine: Engine) -> list[str]:
    """Effects of off-axis plies that an engine's beams leave out, in all modes or in some."""
    mechanism = engine.mechanism
    warnings, joined = [], mechanism.linkage.topology.joined_ends
    for name, section in mechanism.sections.items():
        restrained = restrained_beam(mechanism, name)[1]
        holds = engine.restrains_ends and restrained is not None
        own = [_restrained_line(name, section, restrained) if holds else _twist(name, section)]
        between_joints = {LinkEnd(name, "start"), LinkEnd(name, "end")} <= joined
        if between_joints and not (restrained is not None and restrained.solid):
            own.append(_short(name, section, mechanism.link_mass(name).length))
        warnings += [f"{text} ({engine.name})" for text in own if text]
    return warnings


def _restrained_line(link: str, section: BeamSection, restrained: RestrainedEnds | None) -> str:
    """End condition of a link that bends and twists as in three dimensions."""
    assert section.layers is not None
    assert restrained is not None
    free = replace(section.layers.smeared, twist="free")
    gain = float(np.sqrt(1 + restrained.of_half_sine / free.bending_stiffness)) - 1
    if gain <= NEGLIGIBLE:
        return ""
    by = "in three dimensions" if restrained.solid else "as a beam whose ends hold its twist"
    return (
        f"{link}: its off-axis plies bend and twist {by} between end faces that its joints hold "
        f"flat over the whole width; with these free to twist and warp, its first bending "
        f"frequency is {100 * (1 - 1 / (1 + gain)):.2g} % lower"
    )


def _one_stiffness(engine: Engine, comparison: TheoryComparison) -> str:
    """Effect of one stiffness of off-axis plies on the linkage; empty if negligible."""
    if engine.restrains_ends or not _restrained_links(engine):
        return ""
    found = comparison.difference("timoshenko", RESTRAINED_ENDS)
    if found.value <= NEGLIGIBLE:
        return ""
    return (
        f"off-axis plies bend and twist by one stiffness: frequencies of the linkage may be off by "
        f"{_percent(found)} at rest ({engine.name})"
    )


def _restrained_links(engine: Engine) -> list[str]:
    """Links whose off-axis plies bend and twist otherwise than by one stiffness."""
    mechanism = engine.mechanism
    sections = mechanism.sections.items()
    layered = [name for name, section in sections if section.layers is not None]
    return [name for name in layered if restrained_beam(mechanism, name)[1] is not None]


def _ends_apart(engines: Sequence[Engine], comparison: TheoryComparison) -> list[str]:
    """How links of off-axis plies keep two engines apart, if only one of them holds the ends."""
    coarse = [engine for engine in engines if not engine.restrains_ends]
    fine = [engine for engine in engines if engine.restrains_ends]
    if not coarse or not fine or not _restrained_links(fine[0]):
        return []
    apart = comparison.difference("timoshenko", RESTRAINED_ENDS)
    if apart.value <= NOTICED:
        return []
    return [
        f"off-axis plies bend and twist by one stiffness in {coarse[0].name}, which changes "
        f"frequencies at rest by up to {_percent(apart)}; trust {fine[0].name}"
    ]


def _short(link: str, section: BeamSection, length: float) -> str:
    """Effect of rigid end faces on a short link that twists as it bends; empty if it is long."""
    layers = _smeared(section)
    if layers is None or layers.twist != "held" or _gain_by_twist(layers) <= NEGLIGIBLE:
        return ""
    widths = length / layers.width
    if widths >= LONG:
        return ""
    bound = f"up to {LOW_BY} %" if widths >= SHORT else f"more than {LOW_BY} %"
    return (
        f"{link}: {widths:.2g} widths long, of off-axis plies; where joints hold whole end faces "
        f"flat, its first frequency may be {bound} too low (within 5 % from {LONG} widths on)"
    )


def _smeared(section: BeamSection) -> LaminateSection | None:
    """Layers of a section as they bend in the plane; None where they are not known."""
    return None if section.layers is None else section.layers.smeared


def _gain_by_twist(layers: LaminateSection) -> float:
    """Relative rise of the first bending frequency by holding the twist."""
    free, restrained = (replace(layers, twist=twist).bending_stiffness for twist in TWISTS)
    return float(np.sqrt(restrained / free)) - 1


def _twist(link: str, section: BeamSection) -> str:
    """Effect of a held twist on a link of off-axis plies; empty where it is negligible."""
    layers = _smeared(section)
    if layers is None or not layers.twists:
        return ""
    free, restrained = (replace(layers, twist=twist).bending_stiffness for twist in TWISTS)
    gain = _gain_by_twist(layers)
    if gain <= NEGLIGIBLE:
        return ""
    between = (
        f"{free:.4g} N m^2 with its twist free and {restrained:.4g} with it held by both joints"
    )
    if layers.twist == "held":
        return (
            f"{link}: off-axis plies twist as they bend; of EI between {between}, the latter is "
            "taken, which is right for the first bending mode of a long link; modes that turn both "
            f"ends alike, as the second, may be {100 * gain:.3g} % too high"
        )
    return (
        f"{link}: off-axis plies twist as they bend; of EI between {between}, the former is "
        f"taken; where its ends cannot twist, its first mode is {100 * gain:.3g} % too low"
    )


def _more_complete(first: Engine, second: Engine) -> str:
    """The engine to trust: that whose theory leaves out less."""
    coarse, fine = sorted((first, second), key=lambda engine: LEAVES_OUT_LESS.index(engine.theory))
    if {coarse.theory, fine.theory} == SHEARS:
        return ""
    return f"; trust {fine.name}, whose beams do not leave out {LEFT_OUT[coarse.theory]}"


def _percent(found: TheoryDifference) -> str:
    return f"{100 * found.value:.3g} % (mode {found.mode})"
