"""Matrices of links of many elements are stored element by element, and act as whole ones."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg

from flexmech import ReferenceEngine, load_mechanism, moving_frequencies
from flexmech.beams import BEAM_SHAPES, build_chain
from flexmech.linear_system import (
    ChainMatrix,
    RotationTerms,
    SparsePositions,
    chain_matrix,
    link_matrices,
    summed,
    whole,
)
from flexmech.linear_system.links.chains import MOST_WHOLE, couples, diagonal, with_entries
from flexmech.linear_system.reduction.fixed_interface_modes import FixedInterfaceModes, Flexibility
from flexmech.linkages import LinkMass
from flexmech.mechanism import AttachedBody, Mechanism
from flexmech.threads import one_thread

RNG = np.random.default_rng(7)
COUNT, SIZE = 20, 3
ONE = ChainMatrix(RNG.normal(size=(COUNT, 2 * SIZE, 2 * SIZE)))
MANY = ChainMatrix(RNG.normal(size=(4, COUNT, 2 * SIZE, 2 * SIZE)))
ORDER = SIZE * (COUNT + 1)


@pytest.mark.parametrize("matrix", [ONE, MANY], ids=["one", "batch"])
def test_products_are_those_of_the_whole_matrix(matrix: ChainMatrix) -> None:
    full, columns = matrix.whole(), RNG.normal(size=(ORDER, 5))
    assert matrix.shape == full.shape
    assert matrix.ndim == full.ndim
    assert matrix @ columns == pytest.approx(full @ columns, rel=1e-13, abs=1e-13)
    assert columns.T @ matrix == pytest.approx(columns.T @ full, rel=1e-13, abs=1e-13)
    assert matrix @ columns[:, 0] == pytest.approx(full @ columns[:, 0], rel=1e-13, abs=1e-13)
    assert columns[:, 0] @ matrix == pytest.approx(columns[:, 0] @ full, rel=1e-13, abs=1e-13)
    several = RNG.normal(size=(4, ORDER, 2)) + 1j * RNG.normal(size=(4, ORDER, 2))
    assert matrix @ several == pytest.approx(full @ several, rel=1e-13, abs=1e-13)
    assert (matrix @ columns[:, :0]).shape == (full @ columns[:, :0]).shape
    assert matrix.T.whole() == pytest.approx(np.swapaxes(full, -1, -2))
    assert diagonal(matrix) == pytest.approx(np.diagonal(full, axis1=-2, axis2=-1))


def test_sums_entries_and_forms() -> None:
    full = ONE.whole()
    assert ONE.sparse().toarray() == pytest.approx(full)
    assert whole(summed(MANY, ONE)) == pytest.approx(MANY.whole() + full)
    assert MANY[1:3].whole() == pytest.approx(MANY.whole()[1:3])
    rows, columns = np.array([0, 31, ORDER - 1]), np.array([4, 31, ORDER - 2])
    values = RNG.normal(size=(4, 3))
    for matrix in (ONE, MANY):
        expected = with_entries(matrix.whole(), rows, columns, values)
        assert whole(with_entries(matrix, rows, columns, values)) == pytest.approx(expected)
        assert whole(expected)[:, rows, columns] - matrix.whole()[..., rows, columns] == (
            pytest.approx(values)
        )
    few = RNG.normal(size=(MOST_WHOLE, 2 * SIZE, 2 * SIZE))
    assert isinstance(chain_matrix(few), np.ndarray)
    assert isinstance(chain_matrix(ONE.elements), ChainMatrix)


def test_matrices_of_links_with_few_and_many_elements() -> None:
    random = np.random.default_rng(4)
    few, many = (random.normal(size=(3, n, 6, 6)) for n in (MOST_WHOLE, MOST_WHOLE + 1))
    found = link_matrices([few, many, 2 * few])
    assert [isinstance(each, ChainMatrix) for each in found] == [False, True, False]
    for own, elements in zip(found, (few, many, 2 * few), strict=True):
        np.testing.assert_array_equal(whole(own), ChainMatrix(elements).whole())
    # Neighbouring elements share a node, whose entries are added.
    np.testing.assert_array_equal(
        whole(found[0])[:, 3:6, 3:6], few[:, 0, 3:, 3:] + few[:, 1, :3, :3]
    )


def test_couplings_are_found() -> None:
    along = np.arange(ORDER) % SIZE == 0
    apart = np.zeros_like(ONE.elements)
    apart[:, ::SIZE, ::SIZE] = 1.0
    matrix = ChainMatrix(apart)
    assert not couples(matrix, along, ~along)
    apart[7, 0, 4] = 1.0
    assert couples(matrix, along, ~along)
    assert couples(matrix.whole(), along, ~along)


def test_flexibility_is_the_inverse() -> None:
    elements = ONE.elements @ np.swapaxes(ONE.elements, 1, 2)
    matrix, free = ChainMatrix(elements), np.setdiff1d(np.arange(ORDER), [0, 1, 2, 40])
    other = ChainMatrix(MANY.elements[0] + np.swapaxes(MANY.elements[0], 1, 2))
    inverse = np.linalg.inv(matrix.whole()[np.ix_(free, free)])
    forces = RNG.normal(size=(len(free), 3))
    for form in (matrix, matrix.whole()):
        flexibility = Flexibility(form, free)
        assert flexibility.displacements(forces) == pytest.approx(
            inverse @ forces, rel=1e-9, abs=1e-9
        )
        trace = float(np.sum(inverse * other.whole()[np.ix_(free, free)]))
        assert flexibility.trace_with(other) == pytest.approx(trace, rel=1e-9)


def test_links_of_many_elements_are_whole_links(
    aluminium: Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Frequencies, their errors and damping ratios do not depend on how matrices are stored."""
    sections = {n: s.with_damping_time(1e-5) for n, s in aluminium.sections.items()}
    body = AttachedBody("coupler", 0.1, 0.02, 1e-5, (0.01, 0.005))
    mechanism = replace(aluminium, sections=sections, bodies=(body,))

    def results() -> list[np.ndarray]:
        found = moving_frequencies(ReferenceEngine(mechanism, 18), [0.5, 2.0], [15.0]).dataset
        return [found[name].values for name in ("frequency", "damping_ratio")]

    stored = results()
    monkeypatch.setattr("flexmech.linear_system.links.chains.MOST_WHOLE", 1000)
    for found, expected in zip(stored, results(), strict=True):
        assert found == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("model", ["aluminium_fourbar", "slider_crank", "rotating_l_beam"])
@pytest.mark.parametrize("terms", [True, False], ids=["rotation terms", "inertial form"])
def test_sparse_matrices_are_the_unreduced_ones(models: Path, model: str, terms: bool) -> None:
    mechanism = load_mechanism(models / f"{model}.toml")
    sections = {n: s.with_damping_time(1e-5) for n, s in mechanism.sections.items()}
    engine = ReferenceEngine(replace(mechanism, sections=sections), 18, component_modes=False)
    angles, speed = np.array([0.4, 1.9]), np.full(2, 5.0)
    motion = mechanism.linkage.motion(angles, speed)
    stressed = engine.stressed_links(motion, "equilibrium")
    full = engine.linear_system(angles, speed, rotation_terms=terms, stressed=stressed)
    sparse = SparsePositions(engine.frames, motion, stressed, RotationTerms.all_or_none(terms))
    for position in range(2):
        found = sparse.at(position)
        for name in ("mass", "damping", "stiffness"):
            expected = getattr(full, name)[position]
            size = np.abs(expected).max()
            assert getattr(found, name).toarray() == pytest.approx(expected, abs=1e-14 * size)


@pytest.mark.parametrize("neutral_axis", [0.0, 6e-4], ids=["centred", "off the pins' axis"])
def test_lowest_modes_of_many_elements_are_those_of_all(
    aluminium: Mechanism, neutral_axis: float
) -> None:
    section = replace(aluminium.sections["coupler"], neutral_axis=neutral_axis)
    link = build_chain("coupler", section, LinkMass(0.3, 0.2), 100, BEAM_SHAPES["euler"]).model
    mass, stiffness = whole(link.mass), whole(link.stiffness)
    dense = replace(link, mass=mass, stiffness=stiffness)
    inner = np.setdiff1d(np.arange(link.size), [*link.start, *link.end])
    stretching, turning = inner[link.is_axial[inner]], inner[~link.is_axial[inner]]
    for which, following in ((turning, stretching), (stretching, None)):
        few, every = (FixedInterfaceModes(each, which, following) for each in (link, dense))
        shapes = np.zeros((link.size, len(which)))
        shapes[which, np.arange(len(which))] = 1.0
        if following is not None:
            held, forces = stiffness[np.ix_(following, following)], stiffness[following] @ shapes
            shapes[following] = -np.linalg.solve(held, forces)
        squares = scipy.linalg.eigh(
            shapes.T @ stiffness @ shapes, shapes.T @ mass @ shapes, eigvals_only=True
        )
        assert few.lowest(10) ** 2 == pytest.approx(squares[:10], rel=1e-7)
        assert every.lowest(10) ** 2 == pytest.approx(squares[:10], rel=1e-7)
        assert few.below(float(every.lowest(40)[-1]) * 1.001) == 40
        kept, expected = few.shapes(2, 6), every.shapes(2, 6)
        alike = kept.T @ (link.mass @ expected)
        assert np.abs(alike) == pytest.approx(np.eye(4), abs=1e-6)


def test_memory_grows_with_elements_and_not_with_their_square(aluminium: Mechanism) -> None:
    """Component modes of great detail and the stress of a position, as of a compared mesh."""
    angles = np.array([0.3])

    def peak(elements: int) -> float:
        engine = ReferenceEngine(aluminium, elements)
        tracemalloc.start()
        engine.linear_system(angles, 20.0, detail=4.0)
        greatest = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return greatest

    with one_thread():
        first, twice = peak(64), peak(128)
    # Whole matrices took 11 and 35 MB.
    assert twice < 1.8 * first


@pytest.mark.thorough
def test_map_of_many_elements_takes_little_memory(aluminium: Mechanism) -> None:
    """The greatest memory that is alive at a time above the start, with a mesh of 128 beside."""
    engine = ReferenceEngine(aluminium, 64)
    angles = np.linspace(0, 2 * np.pi, 13)
    moving_frequencies(ReferenceEngine(aluminium, 2), angles[:2], [20.0])
    with one_thread():
        tracemalloc.start()
        moving_frequencies(engine, angles, [20.0])
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert peak < 20e6
