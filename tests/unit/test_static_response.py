"""Unreduced links without a matrix of the whole linkage: against that matrix."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import flexmech
from flexmech.analyses.frequencies.eigenproblem import solve_modes
from flexmech.analyses.frequencies.formulation import Formulation
from flexmech.analyses.frequencies.inverse_iteration import (
    Pencil,
    newton_values,
    projected_values,
    responding_values,
    ritz_values,
)
from flexmech.analyses.frequencies.positions import _systems
from flexmech.analyses.frequencies.reduction import UnreducedPositions
from flexmech.choices import Prestress
from flexmech.linear_system import LinkPencil, StaticResponse, whole

ANGLES = np.radians([0.0, 50.0, 110.0, 200.0, 310.0])
MODELS = ["aluminium_fourbar", "steel_fourbar", "stephenson_six_bar", "rotating_l_beam"]
UNDAMPED = ["aluminium_fourbar", "steel_fourbar", "rotating_l_beam", "turcic_midha_bosnik_fourbar"]
SPEED = 12.0


def positions(
    path: Path, prestress: Prestress, speed: float, *, terms: bool = True, damped: bool = False
) -> UnreducedPositions:
    mechanism = flexmech.load_mechanism(path)
    if damped:
        sections = {k: s.with_damping_ratio(0.02, 50.0) for k, s in mechanism.sections.items()}
        mechanism = replace(mechanism, sections=sections)
    engine = flexmech.ReferenceEngine(mechanism, element="euler")
    formulation = Formulation(prestress, terms, 3)
    angle, crank_speed, systems = _systems(engine, ANGLES, speed, formulation)
    stressed = systems.stressed(angle, crank_speed)
    unreduced = replace(systems, engine=engine.unreduced())
    return UnreducedPositions(unreduced, angle, crank_speed, stressed)


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("prestress", ["none", "equilibrium"])
def test_links_yield_as_the_whole_stiffness_says(
    models: Path, name: str, prestress: Prestress
) -> None:
    found = positions(models / f"{name}.toml", prestress, SPEED, terms=False)
    engine, chance = found.systems.engine, np.random.default_rng(1)
    frames = engine.frames
    motion = engine.mechanism.linkage.motion(ANGLES, np.full(len(ANGLES), SPEED))
    forces = [chance.normal(size=(len(ANGLES), link.size, 2)) for link in frames.links]
    stressed = found.stressed
    tangent = None if stressed.unstressed else stressed.tangent
    response = StaticResponse(engine.topology, engine.fixed_interface_links, motion, tangent)
    moved = response.displacements(forces)
    system = found.systems.at(found.crank_angle, found.crank_speed, stressed)
    z = np.linalg.solve(system.stiffness, frames.gather(motion, forces))
    for own, expected in zip(moved, frames.link_coordinates(motion, z), strict=True):
        scale = np.abs(expected).max()
        np.testing.assert_allclose(own, expected, rtol=0, atol=1e-7 * scale)


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("terms", ["all", "coriolis", "centripetal", "tangential"])
@pytest.mark.parametrize("damped", [False, True])
def test_projected_matrices_are_those_of_the_whole_system(
    models: Path, name: str, terms: str, damped: bool
) -> None:
    """With complex shapes, and with each of the rotation terms alone."""
    found = positions(models / f"{name}.toml", "equilibrium", SPEED, damped=damped)
    engine = found.systems.engine
    counted = flexmech.RotationTerms.parse(terms)
    formulation = replace(found.systems.formulation, rotation_terms=counted)
    found = replace(found, systems=replace(found.systems, formulation=formulation))
    motion = engine.mechanism.linkage.motion(ANGLES, np.full(len(ANGLES), SPEED))
    pencil = LinkPencil(engine.frames, motion, found.stressed, counted)
    assert not damped or found.moving is None
    chance = np.random.default_rng(2)
    system = found.systems.at(found.crank_angle, found.crank_speed, found.stressed)
    shape = (len(ANGLES), system.size, 3)
    shapes = chance.normal(size=shape) + 1j * chance.normal(size=shape)
    across = np.conj(np.swapaxes(shapes, 1, 2))
    whole_ones = system.mass, system.damping, system.stiffness
    for own, matrix in zip(
        pencil.projected(shapes, pencil.forces(shapes)), whole_ones, strict=True
    ):
        expected = across @ matrix @ shapes
        scale = np.abs(expected).max()
        np.testing.assert_allclose(own, expected, rtol=0, atol=1e-10 * scale)


@pytest.mark.parametrize("name", UNDAMPED)
def test_improved_eigenvalues_are_those_of_newton(models: Path, name: str) -> None:
    """The error that they tell of a reduction is the same to a tenth."""
    found = positions(models / f"{name}.toml", "equilibrium", SPEED)
    assert found.moving is not None
    reduced = replace(found.systems, engine=found.systems.engine.with_(component_modes=True))
    system = reduced.at(found.crank_angle, found.crank_speed)
    modes = solve_modes(system, 3)
    shapes = system.unreduced_vectors(modes.vectors, found.systems.engine.frames)
    own = projected_values(*found.moving, modes.eigenvalues, shapes)
    newton = newton_values(list(found.pencils()), modes.eigenvalues, shapes)
    told, expected = (np.abs(modes.eigenvalues / value - 1) for value in (own, newton))
    np.testing.assert_allclose(told, expected, rtol=0.1, atol=1e-7)


def test_ritz_values_without_matrices(models: Path) -> None:
    found = positions(models / "aluminium_fourbar.toml", "none", 0.0)
    engine = found.systems.engine
    reduced = replace(found.systems, engine=engine.with_(component_modes=True))
    system = reduced.at(found.crank_angle, found.crank_speed)
    modes = solve_modes(system, 3)
    assert found.response is not None
    masses = [whole(link.mass) for link in engine.links]
    own = responding_values(found.response, masses, system.unreduced_links(modes.vectors))
    unreduced = found.systems.at(found.crank_angle, found.crank_speed, found.stressed)
    shapes = system.unreduced_vectors(modes.vectors, engine.frames)
    np.testing.assert_allclose(own, ritz_values(Pencil.of_positions(unreduced), shapes), rtol=1e-9)


def test_a_shape_that_misses_nothing_stays(models: Path) -> None:
    """An eigenvalue of the unreduced system itself is left where it is."""
    found = positions(models / "aluminium_fourbar.toml", "equilibrium", SPEED)
    assert found.moving is not None
    system = found.systems.at(found.crank_angle, found.crank_speed, found.stressed)
    modes = solve_modes(system, 3)
    own = projected_values(*found.moving, modes.eigenvalues, modes.vectors)
    np.testing.assert_allclose(own, modes.eigenvalues, rtol=1e-8)
