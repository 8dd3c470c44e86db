"""The reference engine's elements against theory; validation V4 and errata K."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
import scipy.linalg
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from flexmech.beams.elements import BEAM_SHAPES, BeamElements
from flexmech.beams.link_matrices import build_chain
from flexmech.errors import ComputationError, InputError
from flexmech.linear_system import ChainMatrix, DeadMoments, LinkFrames
from flexmech.linkages import LinkMass, RigidMotion
from flexmech.mesh import STATIONS, node_positions, pieces
from flexmech.reference import banded
from flexmech.reference.corotational import CorotationalElements
from flexmech.reference.equilibrium import Equilibrium
from flexmech.sections import BeamSection
from tests.support.strategies import arm, numbers

FloatArray = NDArray[np.float64]
POINTS, WEIGHTS = np.polynomial.legendre.leggauss(8)
PLACES, WEIGHTS = (POINTS + 1) / 2, WEIGHTS / 2
PINNED = ("v0", "v1")
CANTILEVER = ("v0", "phi0")
CLAMPED_PINNED = ("v0", "phi0", "v1")
CLAMPED = ("v0", "phi0", "v1", "phi1")
EULER = BEAM_SHAPES["euler"]


def beams(
    length: FloatArray, axial: float = 1.0, bending: float = 1.0, mass: float = 1.0
) -> BeamElements:
    """Euler-Bernoulli elements."""
    return BeamElements(EULER, BeamSection(axial, bending, 1.0, mass, 1.0, 1.0), length)


def bending(elements: int, held: tuple[str, ...], tension: float = 0.0) -> tuple[FloatArray, ...]:
    """Mass, elastic and geometric stiffness of a beam with rho A = EI = L = 1."""
    lengths = np.full(elements, 1 / elements)
    constant = np.outer(np.ones(elements), [1.0, 0.0, 0.0])
    unit = beams(lengths)
    matrices = (unit.mass, unit.stiffness, unit.geometric_stiffness(constant))
    size = 3 * (elements + 1)
    names = {"v0": 1, "phi0": 2, "v1": size - 2, "phi1": size - 1}
    gone = {names[name] for name in held}
    free = [i for i in range(size) if i % 3 and i not in gone]
    mass, elastic, geometric = (ChainMatrix(m).whole()[np.ix_(free, free)] for m in matrices)
    return mass, elastic + tension * geometric, geometric


def frequencies(elements: int, held: tuple[str, ...], tension: float = 0.0) -> FloatArray:
    mass, stiffness, _ = bending(elements, held, tension)
    return np.sqrt(scipy.linalg.eigvalsh(stiffness, mass))


def buckling_load(elements: int, held: tuple[str, ...]) -> float:
    _, elastic, geometric = bending(elements, held)
    return float(1 / scipy.linalg.eigvalsh(geometric, elastic)[-1])


@pytest.mark.parametrize(
    ("elements", "omega", "load"),
    [(1, 10.9545, 12.000), (2, 9.9086, 9.9438), (4, 9.8722, 9.8747)],
)
def test_pinned_beam_of_few_elements(elements: int, omega: float, load: float) -> None:
    assert frequencies(elements, PINNED)[0] == pytest.approx(omega, abs=5e-5)
    assert buckling_load(elements, PINNED) == pytest.approx(load, abs=5e-4 * (elements == 1) + 5e-5)


def test_cantilever_of_one_element() -> None:
    assert frequencies(1, CANTILEVER) == pytest.approx([3.53273, 34.8069], rel=2e-6)


@pytest.mark.parametrize(
    ("held", "exact"),
    [
        (PINNED, np.pi**2),
        (CANTILEVER, np.pi**2 / 4),
        (CLAMPED_PINNED, 20.1907),
        (CLAMPED, 39.4784),
    ],
)
def test_buckling_loads(held: tuple[str, ...], exact: float) -> None:
    assert buckling_load(32, held) == pytest.approx(exact, rel=3e-6)


@pytest.mark.parametrize(
    ("compute", "exact"),
    [
        (lambda n: frequencies(n, PINNED)[0], np.pi**2),
        (lambda n: frequencies(n, PINNED)[2], 9 * np.pi**2),
        (lambda n: frequencies(n, CANTILEVER)[0], 1.8751040687119611**2),
        (lambda n: frequencies(n, PINNED, 30.0)[0], np.pi**2 * np.sqrt(1 + 30 / np.pi**2)),
        (lambda n: buckling_load(n, PINNED), np.pi**2),
        (lambda n: buckling_load(n, CLAMPED), 4 * np.pi**2),
    ],
)
def test_error_falls_with_the_fourth_power_of_the_mesh(
    compute: Callable[[int], float], exact: float
) -> None:
    coarse, fine = (compute(n) / exact - 1 for n in (8, 16))
    assert fine > 0
    assert np.log2(coarse / fine) == pytest.approx(4, abs=0.15)


@pytest.mark.parametrize("load", [-5.0, 0.0, 40.0])
def test_tension_raises_and_compression_lowers_the_frequencies(load: float) -> None:
    n = np.arange(1, 4)
    exact = (n * np.pi) ** 2 * np.sqrt(1 + load / (n * np.pi) ** 2)
    assert frequencies(24, PINNED, load)[:3] == pytest.approx(exact, rel=3e-5)


LENGTH = np.array([0.7, 1.3])
BEAMS = beams(LENGTH, axial=5.0, bending=3.0, mass=2.0)


def test_corrected_entries_of_the_element_matrices() -> None:
    assert BEAMS.mass[:, 1, 1] == pytest.approx(13 / 35 * 2.0 * LENGTH)
    assert BEAMS.stiffness[:, 2, 5] == pytest.approx(2 * 3.0 / LENGTH)


def test_element_matrices_of_equations_1_52_to_1_54() -> None:
    """Kumar & Chandrakar, with m22 = 13/35 and k36 = k63 = 2EI/L corrected."""
    for number, l in enumerate(LENGTH):  # noqa: E741
        one = np.array([[156, 22 * l, 54, -13 * l], [0, 4 * l**2, 13 * l, -3 * l**2]])
        two = np.array([[0, 0, 156, -22 * l], [0, 0, 0, 4 * l**2]])
        upper = np.triu(np.concatenate([one, two]))
        mass = 2.0 * l / 420 * (upper + np.triu(upper, 1).T)
        rows = [[12, 6 * l, -12, 6 * l], [0, 4 * l**2, -6 * l, 2 * l**2]]
        rest = [[0, 0, 12, -6 * l], [0, 0, 0, 4 * l**2]]
        upper = np.triu(np.array(rows + rest))
        stiffness = 3.0 / l**3 * (upper + np.triu(upper, 1).T)
        across = np.ix_([1, 2, 4, 5], [1, 2, 4, 5])
        assert BEAMS.mass[number][across] == pytest.approx(mass, rel=1e-13)
        assert BEAMS.stiffness[number][across] == pytest.approx(stiffness, rel=1e-13)
        turned = 2.0 * l / 60 * np.array([[21, 3 * l, 9, -2 * l], [9, 2 * l, 21, -3 * l]])
        gyroscopic = BEAMS.gyroscopic[number]
        assert gyroscopic[np.ix_([0, 3], [1, 2, 4, 5])] == pytest.approx(-turned, rel=1e-13)
        along = np.ix_([0, 3], [0, 3])
        unit = np.array([[1.0, -1], [-1, 1]])
        assert BEAMS.stiffness[number][along] == pytest.approx(5.0 / l * unit)
        assert BEAMS.mass[number][along] == pytest.approx(2.0 * l / 6 * np.array([[2, 1], [1, 2]]))


def rigid_motions(length: float) -> FloatArray:
    """Columns: along, across, small rotation about the first node."""
    return np.array([[1.0, 0, 0, 1, 0, 0], [0, 1, 0, 0, 1, 0], [0, 0, 1, 0, length, 1]]).T


def test_rigid_motion_gives_no_elastic_force() -> None:
    for length, stiffness in zip(LENGTH, BEAMS.stiffness, strict=True):
        assert np.abs(stiffness @ rigid_motions(length)).max() < 3e-14 * stiffness.max()
        assert np.linalg.matrix_rank(stiffness, tol=1e-12 * stiffness.max()) == 3


def test_rigid_motion_has_the_mass_and_inertia_of_a_bar() -> None:
    for length, mass in zip(LENGTH, BEAMS.mass, strict=True):
        moves = rigid_motions(length)
        total, first = 2.0 * length, 2.0 * length**2 / 2
        expected = [[total, 0, 0], [0, total, first], [0, first, 2.0 * length**3 / 3]]
        assert moves.T @ mass @ moves == pytest.approx(np.array(expected), rel=1e-13)


def displacement(length: float) -> FloatArray:
    """Shape functions at the Gauss points; (8, 2, 6)."""
    return BEAMS.displacement_shapes(PLACES, np.full(8, length))


def test_shape_functions_are_linear_along_and_cubic_across() -> None:
    s, length = PLACES, 1.3
    shape = displacement(length)
    for power in range(4):
        across = np.array([0, float(power == 0), float(power == 1), 0, 1.0, power]) * 1.0
        across[[2, 5]] /= length
        assert shape[:, 1] @ across == pytest.approx(s**power)
    assert shape[:, 0] @ [2.0, 0, 0, 5.0, 0, 0] == pytest.approx(2 + 3 * s)
    assert not shape[:, 0, [1, 2, 4, 5]].any()
    assert not shape[:, 1, [0, 3]].any()


def test_mass_and_gyroscopic_matrices_are_integrals_of_the_shape_functions() -> None:
    quarter_turn = np.array([[0.0, -1.0], [1.0, 0.0]])
    for number, length in enumerate(LENGTH):
        shape, weight = displacement(length), 2.0 * length * WEIGHTS
        mass = np.einsum("gci,gcj,g->ij", shape, shape, weight)
        gyroscopic = np.einsum("gci,cd,gdj,g->ij", shape, quarter_turn, shape, weight)
        assert BEAMS.mass[number] == pytest.approx(mass, abs=1e-15)
        assert BEAMS.gyroscopic[number] == pytest.approx(gyroscopic, abs=1e-15)


def hermite(length: float) -> list[Polynomial]:
    """v1, phi1, v2, phi2 shapes as polynomials of s = x / length."""
    return [
        Polynomial([1, 0, -3, 2]),
        length * Polynomial([0, 1, -2, 1]),
        Polynomial([0, 0, 3, -2]),
        length * Polynomial([0, 0, -1, 1]),
    ]


@given(st.tuples(*[numbers(-5, 5)] * 3))
def test_geometric_stiffness_of_a_varying_tension(tension: tuple[float, float, float]) -> None:
    matrices = BEAMS.geometric_stiffness(np.array([tension, tension]))
    force = np.polynomial.legendre.legval(POINTS, tension)
    for length, matrix in zip(LENGTH, matrices, strict=True):
        slopes = np.array([h.deriv()(PLACES) / length for h in hermite(length)])
        expected = np.einsum("ig,jg,g->ij", slopes, slopes, force * WEIGHTS * length)
        assert matrix[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] == pytest.approx(expected, abs=1e-12)
        assert not matrix[[0, 3]].any()


def test_geometric_stiffness_of_equation_1_58() -> None:
    l, p = 0.7, 3.0  # noqa: E741
    rows = [
        [6 / 5 / l, 1 / 10, -6 / 5 / l, 1 / 10],
        [1 / 10, 2 * l / 15, -1 / 10, -l / 30],
        [-6 / 5 / l, -1 / 10, 6 / 5 / l, -1 / 10],
        [1 / 10, -l / 30, -1 / 10, 2 * l / 15],
    ]
    matrix = beams(np.array([l])).geometric_stiffness(np.array([[p, 0.0, 0.0]]))[0]
    assert matrix[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] == pytest.approx(p * np.array(rows))


AXIAL, BENDING = 40.0, 0.3


@cache
def corotational(length: float) -> CorotationalElements:
    return CorotationalElements(beams(np.array([length]), AXIAL, BENDING))


def respond(q: FloatArray, length: float = 0.7) -> tuple[FloatArray, FloatArray]:
    force, tangent = corotational(length).response(q[None, None])
    return force[0, 0], tangent[0, 0]


def energy(q: FloatArray, length: float = 0.7) -> float:
    """Strain energy by quadrature along the chord: mean shallow-arch strain, linear curvature."""
    end = complex(length + q[3] - q[0], q[4] - q[1])
    ends = np.array([q[2], q[5]]) - np.angle(end)
    first, second = hermite(length)[1], hermite(length)[3]
    slope = (ends[0] * first.deriv()(PLACES) + ends[1] * second.deriv()(PLACES)) / length
    curvature = ends[0] * first.deriv(2)(PLACES) + ends[1] * second.deriv(2)(PLACES)
    strain = (abs(end) - length) / length + WEIGHTS @ slope**2 / 2
    bent = WEIGHTS @ (curvature / length**2) ** 2
    return float(length / 2 * (AXIAL * strain**2 + BENDING * bent))


# Chords that are neither folded over nor turned by more than half a turn.
deformations = st.tuples(*[numbers(-0.25, 0.25)] * 6).map(np.array)


def difference(function: Callable[[FloatArray], FloatArray], q: FloatArray) -> FloatArray:
    """Derivative by central differences of fourth order; along the last axis."""
    step, columns = 1e-3, []
    for unit in np.eye(6):
        near = function(q + step * unit) - function(q - step * unit)
        far = function(q + 2 * step * unit) - function(q - 2 * step * unit)
        columns.append((8 * near - far) / (12 * step))
    return np.stack(columns, axis=-1)


@given(deformations)
def test_corotational_force_is_the_gradient_of_the_strain_energy(q: FloatArray) -> None:
    gradient = difference(lambda x: np.array(energy(x)), q)
    assert respond(q)[0] == pytest.approx(gradient, abs=1e-7)


@given(deformations)
def test_corotational_tangent_is_the_derivative_of_the_force(q: FloatArray) -> None:
    tangent = respond(q)[1]
    assert tangent == pytest.approx(difference(lambda x: respond(x)[0], q), abs=1e-6)
    assert tangent == pytest.approx(tangent.T, abs=1e-12)


@given(deformations)
def test_linear_strain_is_the_mean_strain_and_its_gradient(
    q: FloatArray,
) -> None:
    """Of the shallow arch, about any state."""
    elements = corotational(0.7)
    relative = np.array([q[3] - q[0], q[4] - q[1], q[2], q[5]])[None, :, None]

    def stretched(x: FloatArray) -> float:
        chord = np.hypot(0.7 + x[0], x[1])
        ends = x[2:] - np.arctan2(x[1], 0.7 + x[0])
        return float(chord / 0.7 - 1 + (2 * ends @ ends - ends[0] * ends[1]) / 30)

    strain = elements.relative_response(relative).strain
    assert strain.at(relative)[0, 0] == pytest.approx(stretched(relative[0, :, 0]), abs=1e-12)
    step = 1e-6
    for place, unit in enumerate(np.eye(4)):
        ends = [stretched(relative[0, :, 0] + sign * step * unit) for sign in (1, -1)]
        slope = (ends[0] - ends[1]) / (2 * step)
        assert strain.gradient[0, place, 0] == pytest.approx(slope, abs=1e-8)


def turned(q: FloatArray, angle: float, length: float = 0.7) -> FloatArray:
    """The deformed element carried around its unloaded first node."""
    moves = np.array([complex(*q[:2]), complex(length + q[3], q[4])]) * np.exp(1j * angle)
    start, end = moves[0], moves[1] - length
    return np.array(
        [start.real, start.imag, q[2] + angle, end.real, end.imag, q[5] + angle], dtype=float
    )


@given(deformations, numbers(-2.5, 2.5))
def test_corotational_force_turns_with_the_element(q: FloatArray, angle: float) -> None:
    # An element turns by less than half a turn against its link's frame.
    assume(abs(angle + np.arctan2(q[4] - q[1], 0.7 + q[3] - q[0])) < 3.1)
    before, after = respond(q)[0], respond(turned(q, angle))[0]
    for u in (0, 3):
        expected = complex(*before[u : u + 2]) * np.exp(1j * angle)
        assert complex(*after[u : u + 2]) == pytest.approx(expected, abs=1e-10)
        assert after[u + 2] == pytest.approx(before[u + 2], abs=1e-11)


@given(numbers(-3.1, 3.1))
def test_a_large_rigid_rotation_gives_no_force(angle: float) -> None:
    assert np.abs(respond(turned(np.zeros(6), angle))[0]).max() < 1e-12


def test_corotational_tangent_of_a_straight_element_is_elastic_plus_geometric() -> None:
    stretch = 0.003
    force, tangent = respond(np.array([0, 0, 0, stretch * 0.7, 0, 0]))
    tension = AXIAL * stretch
    assert force == pytest.approx([-tension, 0, 0, tension, 0, 0], abs=1e-14)
    one = beams(np.array([0.7]), AXIAL, BENDING)
    expected = one.stiffness + one.geometric_stiffness(np.array([[tension, 0.0, 0.0]]))
    # The chord is 0.3 % longer than the element.
    assert tangent == pytest.approx(expected[0], rel=0.01, abs=1e-12)
    unloaded = respond(np.zeros(6))[1]
    assert unloaded == pytest.approx(one.stiffness[0], abs=1e-12)


def cantilever(
    elements: int, force: tuple[float, float, float]
) -> tuple[Equilibrium, FloatArray, RigidMotion]:
    """A cantilever of length 1 under a force and moment (in units of EI) at its tip."""
    mechanism = arm()
    section = mechanism.sections["arm"]
    mass = LinkMass(1.0, section.mass_per_length)
    chain = build_chain("arm", section, mass, elements, EULER)
    linkage = mechanism.linkage
    solver = Equilibrium(LinkFrames(linkage.topology, [chain.model]), {0: chain.elements})
    load = np.zeros((1, chain.model.size))
    load[0, -3:] = section.bending_stiffness * np.array(force)
    return solver, load, linkage.motion(np.array([0.0]), np.array([0.0]))


def tip(elements: int, force: tuple[float, float, float]) -> FloatArray:
    solver, load, motion = cantilever(elements, force)
    nothing = solver.by_relative_coordinates([np.zeros((1, elements, 6, 6))])
    dead = DeadMoments.of(solver.frames.links, motion, (0.0, 0.0), [load])
    return solver.solve(motion, [load], nothing, dead)[0][0, -3:]


@pytest.mark.parametrize("turn", [1 / 12, 1 / 4, 1 / 2])
def test_an_end_moment_rolls_a_cantilever_into_an_arc(turn: float) -> None:
    angle = 2 * np.pi * turn
    exact = [np.sin(angle) / angle - 1, (1 - np.cos(angle)) / angle, angle]
    coarse, fine = (np.abs(tip(n, (0, 0, angle)) - exact).max() for n in (8, 16))
    assert coarse < 1e-5
    assert np.log2(coarse / fine) == pytest.approx(4, abs=0.05)


def test_a_transverse_tip_force_bends_a_cantilever_like_the_elastica() -> None:
    # Mattiasson 1981, Table 1: P L^2 / EI = 1 gives 0.30172 across and 0.05643 along.
    along, across, _ = tip(16, (0, 1.0, 0))
    assert across == pytest.approx(0.30172, abs=2e-5)
    assert along == pytest.approx(-0.05643, abs=2e-5)


def test_a_compressed_cantilever_is_refused_beyond_eulers_load() -> None:
    euler = np.pi**2 / 4
    assert tip(8, (-0.99 * euler, 0, 0))[1] == 0.0
    with pytest.raises(ComputationError, match="buckles under its loads at crank angle 0"):
        tip(8, (-1.01 * euler, 0, 0))


def band_of(matrices: FloatArray, width: int) -> FloatArray:
    size = matrices.shape[-1]
    band = np.zeros((size, width + 1, len(matrices)))
    for k in range(width + 1):
        band[: size - k, k] = np.diagonal(matrices, -k, axis1=1, axis2=2).T
    return band


@pytest.mark.parametrize(("size", "width"), [(1, 0), (7, 2), (20, 5), (4, 3)])
def test_band_solver_agrees_with_scipy(size: int, width: int) -> None:
    random = np.random.default_rng(size)
    lower = np.tril(np.triu(random.normal(size=(3, size, size)), -width))
    lower[:, np.arange(size), np.arange(size)] += 3.0
    matrices = lower @ np.swapaxes(lower, 1, 2)
    right = random.normal(size=(size, 3))
    band = band_of(matrices, width)
    expected = np.stack(
        [scipy.linalg.solveh_banded(band[:, :, i].T, right[:, i], lower=True) for i in range(3)],
        axis=1,
    )
    factors = banded.factorize(band)
    assert banded.solve(factors, right) == pytest.approx(expected, rel=1e-10, abs=1e-12)
    assert (factors[:, 0] > 0).all()


def test_band_pivots_count_negative_eigenvalues() -> None:
    matrix = np.diag([2.0, -1.0, 3.0, -4.0]) + 0.3 * (np.eye(4, k=1) + np.eye(4, k=-1))
    pivots = banded.factorize(band_of(matrix[None], 1))[:, 0, 0]
    assert np.sum(pivots < 0) == np.sum(np.linalg.eigvalsh(matrix) < 0) == 2


def test_nodes_are_even_without_point_masses() -> None:
    assert node_positions(0.3, 4) == pytest.approx([0, 0.075, 0.15, 0.225, 0.3])
    assert node_positions(0.3, 4)[-1] == 0.3


@given(numbers(0.1, 5), st.lists(numbers(0.01, 0.99), max_size=3), st.integers(4, 20))
def test_each_point_mass_has_a_node(length: float, places: list[float], elements: int) -> None:
    positions = [length * p for p in places]
    nodes = node_positions(length, elements, positions)
    assert len(nodes) == elements + 1
    assert (np.diff(nodes) > 0).all()
    for x in positions:
        assert np.abs(nodes - x).min() < 1e-9 * length


def test_elements_go_to_the_longest_pieces() -> None:
    assert node_positions(1.0, 4, [0.25]) == pytest.approx([0, 0.25, 0.5, 0.75, 1.0])
    assert node_positions(1.0, 3, [0.0, 1.0, 0.5, 0.5]) == pytest.approx([0, 0.25, 0.5, 1.0])
    assert pieces(1.0, [0.4, 0.0, 1.0, 0.4]) == pytest.approx([0.4, 0.6])


def test_the_same_place_written_twice_makes_one_node() -> None:
    nodes = node_positions(1.0, 4, [0.3, 0.1 + 0.2])
    assert np.diff(nodes).min() > 0.1


def test_too_few_elements_for_the_point_masses_are_refused() -> None:
    with pytest.raises(InputError, match=r"2 elements cannot put a node.*ask for 3"):
        node_positions(1.0, 2, [0.3, 0.6])


def test_a_link_keeps_its_point_masses() -> None:
    section = arm().sections["arm"]
    mass = LinkMass(1.0, section.mass_per_length, (0.0, 0.37, 1.0), (0.1, 0.2, 0.3))
    chain = build_chain("arm", section, mass, 5, EULER)
    model, nodes = chain.model, chain.nodes
    fields = model.fields
    along, across, turn = fields.along, fields.across, fields.tangential
    assert along @ model.mass @ along == pytest.approx(mass.moment(0))
    assert across @ model.mass @ turn == pytest.approx(mass.moment(1))
    assert turn @ model.mass @ turn == pytest.approx(mass.moment(2))
    assert across @ model.gyroscopic @ along == pytest.approx(mass.moment(0))
    assert np.array_equal(model.gyroscopic, -model.gyroscopic.T)
    assert pytest.approx(nodes[np.argmin(np.abs(nodes - 0.37))], abs=1e-15) == 0.37


def test_stations_follow_a_cubic_exactly() -> None:
    section = arm().sections["arm"]
    chain = build_chain("arm", section, LinkMass(1.0, 1.0, (0.37,), (0.1,)), 3, EULER)
    model, nodes = chain.model, chain.nodes
    cubic = Polynomial([0.3, -1.0, 2.0, 0.5])
    q = np.stack([2 * nodes, cubic(nodes), cubic.deriv()(nodes)], axis=1).ravel()
    x = np.linspace(0, 1, STATIONS)
    assert model.shape @ q == pytest.approx(np.stack([2 * x, cubic(x)], axis=1), abs=1e-14)


def test_chain_assembly_adds_neighbours() -> None:
    blocks = np.random.default_rng(1).normal(size=(2, 3, 6, 6))
    total = ChainMatrix(blocks).whole()
    expected = np.zeros((2, 12, 12))
    for e in range(3):
        expected[:, 3 * e : 3 * e + 6, 3 * e : 3 * e + 6] += blocks[:, e]
    assert np.array_equal(total, expected)
