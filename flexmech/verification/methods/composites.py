"""Laminates, beams of them, and linkages of such beams."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, cast

import numpy as np
import scipy.linalg

from flexmech.analyses import natural_frequencies
from flexmech.arrays import FloatArray
from flexmech.linkages import FourBar, LinkMass
from flexmech.materials import (
    Fibre,
    Laminate,
    Matrix,
    Ply,
    Rule,
    ply_from_constituents,
    published_constituents,
)
from flexmech.mechanics.beams import BEAM_SHAPES, build_chain
from flexmech.mechanism import Mechanism
from flexmech.reference import ReferenceEngine
from flexmech.sections import BeamSection, LaminateSection, SheetSection

# Khdeir & Reddy: E1 = 40 E2, G12 = G13 = 0.6 E2, G23 = 0.5 E2, nu12 = 0.25; their frequencies have
# no unit, so that E2 in Pa, the density in kg/m^3 and the thickness in m are any.
ACROSS, DENSITY, THICKNESS = 1e9, 1000.0, 0.02
KHDEIR_REDDY_PLY = Ply(40 * ACROSS, ACROSS, 0.6 * ACROSS, 0.6 * ACROSS, 0.5 * ACROSS, 0.25, DENSITY)
# Elements of a beam, by which the mesh is off by less than the last digit that is published.
ELEMENTS = 16


def laminate_stiffness(
    *,
    ply: Mapping[str, Any],
    ply_thickness: float,
    angles: Sequence[float],
    order: int,
) -> FloatArray:
    """One of the stiffness matrices A, B and D of a laminate.

    Parameters
    ----------
    ply : mapping of str to float
        Constants of :class:`flexmech.materials.Ply`.
    ply_thickness : float
        In m.
    angles : sequence of float
        Angles of the fibres in each layer, in deg.
    order : int
        0, 1 and 2 are A, B and D.

    Returns
    -------
    ndarray, shape (3, 3)
        In N/m, N and N m.
    """
    layers = [Ply(**ply)] * len(angles)
    laminate = Laminate.stacked(layers, ply_thickness, np.radians(angles).tolist())
    return laminate.stiffness_moment(order)


def flexural_moduli(
    *, stacks: Sequence[str], rule: Rule, fibre_volume_fraction: float
) -> FloatArray:
    """Flexural moduli of stacks of carbon (C) and glass (G) plies in polyester.

    Parameters
    ----------
    stacks : sequence of str
        Such as ``"CCGCC"``.
    rule : str
        Rule of micromechanics.
    fibre_volume_fraction : float

    Returns
    -------
    ndarray, shape (n_stacks,)
        In GPa.
    """
    plies, moduli = _polyester_plies(rule, fibre_volume_fraction), []
    for stack in stacks:
        laminate = Laminate.stacked([plies[letter] for letter in stack], 1e-3, [0.0] * len(stack))
        a, b, d = (laminate.stiffness_moment(order) for order in (0, 1, 2))
        flexibility = np.linalg.inv(np.block([[a, b], [b, d]]))
        moduli.append(12 / (laminate.thickness**3 * flexibility[3, 3]) / 1e9)
    return np.array(moduli)


def khdeir_reddy_beams(
    *, angles: Sequence[float], slenderness: Sequence[float], supports: Sequence[str], element: str
) -> FloatArray:
    """Fundamental frequencies of cross-ply beams, w L^2 / h sqrt(rho / E2).

    Parameters
    ----------
    angles : sequence of float
        Angles of the layers, in deg.
    slenderness : sequence of float
        Length over thickness.
    supports : sequence of {"SS", "CF", "CC"}
        Simple supports and free ends let the beam stretch.
    element : str
        Element of the reference engine.

    Returns
    -------
    ndarray, shape (n_slenderness, n_supports)
    """
    layers = [KHDEIR_REDDY_PLY] * len(angles)
    laminate = Laminate.stacked(layers, THICKNESS / len(angles), np.radians(angles).tolist())
    section = BeamSection.of_laminate(LaminateSection(laminate, THICKNESS / 2, "wide"))
    return np.array(
        [
            [_fundamental(section, ratio, ends, element) for ends in supports]
            for ratio in slenderness
        ]
    )


def _fundamental(section: BeamSection, slenderness: float, ends: str, element: str) -> float:
    length = slenderness * THICKNESS
    mass = LinkMass(length, section.mass_per_length)
    model = build_chain("beam", section, mass, ELEMENTS, BEAM_SHAPES[element]).model
    clamped = [*model.start, *model.start_rotation]
    fixed = {
        "SS": [model.start[1], model.end[1]],
        "CF": clamped,
        "CC": [*clamped, *model.end, *model.end_rotation],
    }[ends]
    free = np.setdiff1d(np.arange(model.size), fixed)
    grid = np.ix_(free, free)
    squares = scipy.linalg.eigvalsh(model.stiffness[grid], model.mass[grid])
    # A simply supported beam that may slide has a rigid motion first.
    square = squares[1 if ends == "SS" else 0]
    return float(np.sqrt(square) * length**2 / THICKNESS * np.sqrt(DENSITY / ACROSS))


def order_of_laminates(
    *, stacks: Sequence[str], proportions: Sequence[Sequence[float]]
) -> FloatArray:
    """Number of each stack, from the highest fundamental frequency to the lowest.

    Parameters
    ----------
    stacks : sequence of str
        Stacks of straight carbon and glass plies, parallel to the plane of motion.
    proportions : sequence of (float, float, float)
        Crank, coupler and rocker of each linkage over its ground; the transmission angle is 90
        deg.

    Returns
    -------
    ndarray, shape (n_linkages, n_stacks)
    """
    found = [1 + np.argsort(-_at_90_degrees(tuple(stacks), tuple(row))) for row in proportions]
    return np.array(found, float)


def lowest_case(*, stacks: Sequence[str], proportions: Sequence[Sequence[float]]) -> FloatArray:
    """Number of the linkage with the lowest fundamental frequency, for each stack; (n_stacks,).

    Parameters
    ----------
    stacks, proportions : sequence
        See :func:`order_of_laminates`.
    """
    by_case = np.array([_at_90_degrees(tuple(stacks), tuple(row)) for row in proportions])
    return np.asarray(1.0 + np.argmin(by_case, axis=0))


@cache
def _at_90_degrees(stacks: tuple[str, ...], proportions: tuple[float, ...]) -> FloatArray:
    """Fundamental frequencies of one crank-rocker with each of the stacks, (n_stacks,)."""
    crank, coupler, rocker = proportions
    # The size of a linkage does not matter in bending.
    linkage = FourBar(0.4, 0.4 * crank, 0.4 * coupler, 0.4 * rocker)
    right_angle = np.arccos((1 + crank**2 - coupler**2 - rocker**2) / (2 * crank))
    plies, found = _polyester_plies("rule-of-mixtures", 0.6), []
    for stack in stacks:
        laminate = Laminate.stacked([plies[letter] for letter in stack], 5e-3, [0.0] * len(stack))
        section = BeamSection.of_laminate(SheetSection(laminate, 5e-3))
        mechanism = Mechanism(linkage, dict.fromkeys(("crank", "coupler", "rocker"), section))
        engine = ReferenceEngine(mechanism, 8, "euler")
        found.append(natural_frequencies(engine, right_angle, modes=1)[0])
    return np.array(found)


def _polyester_plies(rule: Rule, fibre_volume_fraction: float) -> dict[str, Ply]:
    """Plies of carbon (C) and glass (G) in polyester."""
    known = published_constituents()
    matrix = cast(Matrix, known["polyester"])
    return {
        letter: ply_from_constituents(cast(Fibre, known[name]), matrix, fibre_volume_fraction, rule)
        for letter, name in (("C", "carbon"), ("G", "E-glass"))
    }
