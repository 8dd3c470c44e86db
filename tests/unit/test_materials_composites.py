"""Constituents, plies and laminates: values, refusals, and an independent library."""

from __future__ import annotations

import pickle
from dataclasses import FrozenInstanceError, replace
from typing import Any

import numpy as np
import pytest
from composites import laminated_plate
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from flexmech.errors import InputError
from flexmech.materials import (
    PACKING_LIMIT,
    Fibre,
    Laminate,
    Layer,
    Material,
    Matrix,
    Ply,
    PlyDamping,
    ply_from_constituents,
    published_constituents,
)
from tests.support.strategies import angles, numbers

FloatArray = NDArray[np.float64]
few = settings(max_examples=20)

PLY = Ply(140e9, 10e9, 5e9, 5e9, 3.5e9, 0.3, 1600.0)
TABLE = published_constituents()
ORDERS = {"A": 0, "B": 1, "D": 2, "E": 3, "F": 4, "H": 6}
SHEAR_ORDERS = {"Abar_ts": 0, "Dts": 2, "Fts": 4}
MASS_ORDERS = {"": 0, "z": 1, "z2": 2, "z3": 3, "z4": 4, "z6": 6}


@st.composite
def plies(draw: st.DrawFn) -> Ply:
    along, across = draw(numbers(1e9, 400e9)), draw(numbers(1e9, 50e9))
    bound = np.sqrt(along / across)
    return Ply(
        along,
        across,
        draw(numbers(0.1e9, 30e9)),
        draw(numbers(0.1e9, 30e9)),
        draw(numbers(0.1e9, 30e9)),
        draw(numbers(-0.9, 0.9)) * bound,
        draw(numbers(500.0, 8000.0)),
    )


@st.composite
def laminates(draw: st.DrawFn) -> Laminate:
    count = draw(st.integers(1, 8))
    return Laminate(
        tuple(Layer(draw(plies()), draw(numbers(5e-5, 5e-3)), draw(angles())) for _ in range(count))
    )


# ---- an independent library ------------------------------------------------------------------


def of_composites(laminate: Laminate) -> Any:
    layers = laminate.layers
    return laminated_plate(
        [np.degrees(layer.angle) for layer in layers],
        plyts=[layer.thickness for layer in layers],
        laminaprops=[
            (
                ply.longitudinal_modulus,
                ply.transverse_modulus,
                ply.poisson_ratio,
                ply.in_plane_shear_modulus,
                ply.longitudinal_shear_modulus,
                ply.transverse_shear_modulus,
            )
            for ply in (layer.ply for layer in layers)
        ],
        rhos=[layer.ply.density for layer in layers],
    )


def assert_close(found: Any, expected: Any, size: float) -> None:
    """To 1e-10 of what the integral of its size could be, whatever cancels in it."""
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10 * size)


def size(laminate: Laminate, modulus: float, order: int) -> float:
    half = laminate.thickness / 2
    return 2 * modulus * half ** (order + 1) / (order + 1)


@few
@given(laminates())
def test_matrices_are_those_of_composites(laminate: Laminate) -> None:
    other = of_composites(laminate)
    softest = np.abs(laminate.transformed_stiffness).max(axis=(1, 2)).min()
    for name, order in ORDERS.items():
        expected = np.asarray(getattr(other, name))
        assert expected.shape == (3, 3)
        assert_close(laminate.stiffness_moment(order), expected, size(laminate, softest, order))


@few
@given(laminates())
def test_shear_matrices_are_those_of_composites(laminate: Laminate) -> None:
    other = of_composites(laminate)
    softest = np.abs(laminate.transformed_shear_stiffness).max(axis=(1, 2)).min()
    for name, order in SHEAR_ORDERS.items():
        expected = np.asarray(getattr(other, name))
        assert expected.shape == (2, 2)
        assert_close(laminate.shear_moment(order), expected, size(laminate, softest, order))


@few
@given(laminates())
def test_moments_of_mass_are_those_of_composites(laminate: Laminate) -> None:
    other = of_composites(laminate)
    lightest = min(layer.ply.density for layer in laminate.layers)
    for name, order in MASS_ORDERS.items():
        expected = getattr(other, f"intrho{name}")
        assert_close(laminate.mass_moment(order), expected, size(laminate, lightest, order))


# ---- numerical quadrature, with stiffness turned as a tensor ---------------------------------


def turned(layer: Layer) -> tuple[FloatArray, FloatArray]:
    """In-plane and shear stiffness in laminate axes by the rotation of tensors."""
    q, shear = layer.ply.reduced_stiffness, layer.ply.transverse_shear_stiffness
    pairs = [(0, 0), (1, 1), (0, 1)]
    tensor = np.zeros((2, 2, 2, 2))
    for row, (i, j) in enumerate(pairs):
        for column, (k, m) in enumerate(pairs):
            for left in {(i, j), (j, i)}:
                for right in {(k, m), (m, k)}:
                    tensor[(*left, *right)] = q[row, column]
    cosine, sine = np.cos(layer.angle), np.sin(layer.angle)
    turn = np.array([[cosine, sine], [-sine, cosine]])  # components in the ply's axes
    tensor = np.einsum("abcd,ai,bj,ck,dm->ijkm", tensor, turn, turn, turn, turn)
    in_plane = np.array([[tensor[(*left, *right)] for right in pairs] for left in pairs])
    vector = turn.T @ shear[::-1, ::-1] @ turn  # planes x, z
    return in_plane, vector[::-1, ::-1]


@few
@given(laminates())
def test_integrals_are_those_of_quadrature(laminate: Laminate) -> None:
    points, weights = np.polynomial.legendre.leggauss(5)
    edges = np.cumsum([0.0, *(layer.thickness for layer in laminate.layers)])
    middle = edges[-1] / 2
    stiffest = np.abs(laminate.transformed_stiffness).max()
    stiffest_shear = np.abs(laminate.transformed_shear_stiffness).max()
    for order in range(7):
        expected, shear, mass = np.zeros((3, 3)), np.zeros((2, 2)), 0.0
        for layer, low, high in zip(laminate.layers, edges[:-1], edges[1:], strict=True):
            y = (low + high) / 2 - middle + points * (high - low) / 2
            part = float(weights @ y**order) * (high - low) / 2
            in_plane, across = turned(layer)
            expected += part * in_plane
            shear += part * across
            mass += part * layer.ply.density
        assert_close(laminate.stiffness_moment(order), expected, size(laminate, stiffest, order))
        assert_close(laminate.shear_moment(order), shear, size(laminate, stiffest_shear, order))
        assert_close(laminate.mass_moment(order), mass, size(laminate, 8e3, order))


# ---- plies and laminates ---------------------------------------------------------------------


@few
@given(plies(), angles())
def test_stiffness_keeps_its_invariants_and_is_positive(ply: Ply, angle: float) -> None:
    still, moved = ply.reduced_stiffness, Layer(ply, 1.0, angle).transformed_stiffness
    atol = 1e-12 * still.max()
    assert np.all(np.linalg.eigvalsh(still) > 0)
    np.testing.assert_allclose(moved, moved.T, atol=atol)
    for invariant in (
        lambda q: q[0, 0] + q[1, 1] + 2 * q[0, 1],
        lambda q: q[2, 2] - q[0, 1],
    ):
        assert invariant(moved) == pytest.approx(invariant(still), abs=atol)


@few
@given(plies())
def test_stiffness_is_the_inverse_of_the_engineering_flexibility(ply: Ply) -> None:
    flexibility = np.linalg.inv(ply.reduced_stiffness)
    assert 1 / flexibility[0, 0] == pytest.approx(ply.longitudinal_modulus)
    assert 1 / flexibility[1, 1] == pytest.approx(ply.transverse_modulus)
    assert 1 / flexibility[2, 2] == pytest.approx(ply.in_plane_shear_modulus)
    assert -flexibility[1, 0] / flexibility[0, 0] == pytest.approx(ply.poisson_ratio, abs=1e-12)


def test_a_quarter_turn_swaps_the_axes() -> None:
    layer = Layer(PLY, 1e-3, np.pi / 2)
    swapped = PLY.reduced_stiffness[np.ix_([1, 0, 2], [1, 0, 2])]
    np.testing.assert_allclose(layer.transformed_stiffness, swapped, atol=1e-12 * 140e9)
    np.testing.assert_allclose(layer.transformed_shear_stiffness, np.diag([5e9, 3.5e9]), atol=1e-3)


@few
@given(laminates())
def test_a_symmetric_stack_couples_nothing(laminate: Laminate) -> None:
    both = Laminate(laminate.layers + laminate.layers[::-1])
    stiffest = np.abs(both.transformed_stiffness).max()
    for order in (1, 3, 5):
        bound = 1e-14 * len(both.layers) * size(both, stiffest, order)
        assert np.abs(both.stiffness_moment(order)).max() <= bound


@few
@given(laminates(), st.integers(2, 4))
def test_layers_in_slices_are_the_same_laminate(laminate: Laminate, count: int) -> None:
    slices = tuple(
        replace(layer, thickness=layer.thickness / count)
        for layer in laminate.layers
        for _ in range(count)
    )
    stiffest = np.abs(laminate.transformed_stiffness).max()
    for order in range(7):
        assert_close(
            Laminate(slices).stiffness_moment(order),
            laminate.stiffness_moment(order),
            size(laminate, stiffest, order),
        )


def test_an_isotropic_ply_does_not_care_for_its_angle() -> None:
    material = Material(70e9, 2700.0, 0.33)
    ply = Ply.isotropic(material)
    assert ply.poisson_ratio == 0.33
    assert ply.density == 2700.0
    laminate = Laminate.stacked([ply] * 3, 1e-3, [0.0, 0.7, -1.2])
    plate = 70e9 / (1 - 0.33**2)
    expected = plate * np.array([[1, 0.33, 0], [0.33, 1, 0], [0, 0, (1 - 0.33) / 2]])
    bending = expected * 3e-3**3 / 12
    np.testing.assert_allclose(
        laminate.stiffness_moment(2), bending, rtol=1e-12, atol=1e-12 * bending[0, 0]
    )
    shear = material.shear_modulus * 3e-3 * np.eye(2)
    np.testing.assert_allclose(laminate.shear_moment(0), shear, rtol=1e-12, atol=1e-6)


def test_the_first_layer_lies_lowest() -> None:
    heavy = replace(PLY, density=3200.0)
    laminate = Laminate((Layer(heavy, 1e-3), Layer(PLY, 2e-3)))
    np.testing.assert_allclose(laminate.boundaries, [-1.5e-3, -0.5e-3, 1.5e-3])
    assert laminate.mass_moment(0) == pytest.approx(6.4)
    assert laminate.mass_moment(1) == pytest.approx(3.2 * -1e-3 + 3.2 * 0.5e-3)


def test_laminates_are_values() -> None:
    laminate = Laminate.stacked([PLY] * 2, 1e-3, [0.0, 0.5])
    same = Laminate((Layer(replace(PLY), 1e-3), Layer(replace(PLY), 1e-3, 0.5)))
    assert laminate == same == pickle.loads(pickle.dumps(laminate))
    assert hash(laminate) == hash(same)
    assert laminate != Laminate.stacked([PLY] * 2, 1e-3, [0.5, 0.0])
    with pytest.raises(FrozenInstanceError):
        laminate.layers = ()  # type: ignore[misc]


# ---- the published constituents --------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "kind", "values", "uncertainty"),
    [
        ("E-glass", Fibre, (70e9, 2.4e9, 2580.0, 0.2), (14e9, 4e6, None)),
        ("carbon", Fibre, (201.5e9, 1.5265e9, 1740.0, 0.21), (20e9, 642e6, 10.0)),
        ("polyester", Matrix, (2.43e9, 50.3e6, 1246.0, 0.35), (0.01e9, 0.2e6, 10.0)),
    ],
)
def test_table_1_as_printed(
    name: str,
    kind: type,
    values: tuple[float, ...],
    uncertainty: tuple[float | None, ...],
) -> None:
    row = TABLE[name]
    assert type(row) is kind
    properties = ("youngs_modulus", "shear_modulus", "density", "poisson_ratio")
    assert [getattr(row, p) for p in properties] == pytest.approx(list(values))
    printed = {p: u for p, u in zip(properties, uncertainty, strict=False) if u is not None}
    assert row.uncertainty == pytest.approx(printed)


@pytest.mark.parametrize("name", TABLE)
def test_every_constituent_names_its_source_and_claims_no_damping(name: str) -> None:
    assert TABLE[name].name == name
    assert TABLE[name].source.startswith("Elamy et al. 2023, Table 1")
    assert TABLE[name].specific_damping == 0


@pytest.mark.parametrize(
    ("name", "shear"), [("E-glass", 29.17e9), ("carbon", 83.26e9), ("polyester", 0.9e9)]
)
def test_isotropic_shear_is_offered_beside_the_printed_one(name: str, shear: float) -> None:
    printed, other = TABLE[name], TABLE[f"{name} (isotropic shear)"]
    assert other.shear_modulus == pytest.approx(shear, rel=1e-3)
    assert "shear_modulus" not in other.uncertainty
    changed = ("name", "shear_modulus", "source", "uncertainty")
    assert replace(printed, **{field: getattr(other, field) for field in changed}) == other
    assert other.source != printed.source


def test_the_table_is_the_callers_own() -> None:
    published_constituents().clear()
    assert published_constituents() == TABLE


def test_fibres_are_alike_in_all_directions_unless_told() -> None:
    glass = TABLE["E-glass"]
    assert isinstance(glass, Fibre)
    assert glass.modulus_across == glass.youngs_modulus
    assert glass.shear_modulus_across == glass.shear_modulus
    other = replace(glass, transverse_modulus=15e9, transverse_shear_modulus=7e9)
    assert (other.modulus_across, other.shear_modulus_across) == (15e9, 7e9)


# ---- refusals --------------------------------------------------------------------------------

NO_SIZE = [0.0, -1.0, np.nan, np.inf]


@pytest.mark.parametrize("value", NO_SIZE)
@pytest.mark.parametrize(
    "name",
    [
        "longitudinal_modulus",
        "transverse_modulus",
        "in_plane_shear_modulus",
        "longitudinal_shear_modulus",
        "transverse_shear_modulus",
        "density",
    ],
)
def test_a_ply_needs_positive_values(name: str, value: float) -> None:
    with pytest.raises(InputError, match=f"{name} of a ply must be positive, got {value}"):
        replace(PLY, **{name: value})


@pytest.mark.parametrize("value", [3.75, -3.75])
def test_poissons_ratio_must_leave_the_ply_stable(value: float) -> None:
    bound = np.sqrt(14.0)
    with pytest.raises(InputError, match=rf"between -{bound:.6g} and {bound:.6g} .*E1 / E2"):
        replace(PLY, poisson_ratio=value)
    with pytest.raises(InputError, match="poisson_ratio of a ply must be a number, got nan"):
        replace(PLY, poisson_ratio=np.nan)
    assert replace(PLY, poisson_ratio=3.74).reduced_stiffness[0, 0] > 0


@pytest.mark.parametrize("name", ["thermal_expansion", "moisture_expansion"])
@pytest.mark.parametrize("value", [(np.nan, 0.0), (0.0,), (0.0, np.inf), "12", 1.0])
def test_expansion_is_two_numbers(name: str, value: tuple[float, ...]) -> None:
    with pytest.raises(InputError, match=f"{name} of a ply must be (two numbers|a number)"):
        replace(PLY, **{name: value})


@pytest.mark.parametrize("name", ["longitudinal", "transverse", "shear"])
@pytest.mark.parametrize("value", [-0.01, np.nan, np.inf])
def test_a_ply_cannot_gain_energy(name: str, value: float) -> None:
    with pytest.raises(InputError, match=f"{name} specific damping must be zero or positive"):
        PlyDamping(**{name: value})


@pytest.mark.parametrize("value", NO_SIZE)
def test_a_layer_needs_a_thickness(value: float) -> None:
    with pytest.raises(InputError, match=f"thickness of a layer must be positive, got {value}"):
        Layer(PLY, value)


def test_a_layer_needs_an_angle() -> None:
    with pytest.raises(InputError, match="angle of a layer must be a number, got nan"):
        Layer(PLY, 1e-3, np.nan)


def test_a_laminate_needs_a_layer() -> None:
    with pytest.raises(InputError, match="needs one layer or more"):
        Laminate(())


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"youngs_modulus": -1.0}, "youngs_modulus of 'carbon' must be positive, got -1"),
        ({"shear_modulus": 0.0}, "shear_modulus of 'carbon' must be positive"),
        ({"density": np.nan}, "density of 'carbon' must be positive"),
        ({"poisson_ratio": 0.5}, "poisson_ratio of 'carbon' must be at least 0 and less than 0.5"),
        ({"poisson_ratio": np.nan}, "poisson_ratio of 'carbon' must be at least 0 and less than"),
        ({"specific_damping": -0.1}, "specific_damping of 'carbon' must be zero or positive"),
        ({"moisture_expansion": -0.1}, "moisture_expansion of 'carbon' must be zero or positive"),
        ({"thermal_expansion": np.inf}, "thermal_expansion of 'carbon' must be a number"),
        ({"transverse_modulus": 0.0}, "transverse_modulus of 'carbon' must be positive"),
        ({"transverse_shear_modulus": -1.0}, "transverse_shear_modulus of 'carbon' must be"),
        ({"uncertainty": {"density": -1.0}}, "uncertainty of density of 'carbon' must be zero"),
        ({"uncertainty": {"stiffness": 1.0}}, "'stiffness', which is no property .* density"),
        ({"uncertainty": {"name": 1.0}}, "'name', which is no property"),
        ({"uncertainty": {"transverse_modulus": 1.0}}, "'transverse_modulus', which is no"),
    ],
)
def test_a_constituent_that_cannot_be(change: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        replace(TABLE["carbon"], **change)


@pytest.mark.parametrize("share", [0.0, -0.1, 0.91, 1.0, 60.0])
def test_fibre_volume_fraction_above_the_packing_limit(share: float) -> None:
    fibre, resin = TABLE["carbon"], TABLE["polyester"]
    with pytest.raises(InputError, match=f"fibre_volume_fraction .* 0.9069.* got {share}"):
        ply_from_constituents(fibre, resin, share)  # type: ignore[arg-type]


def test_touching_fibres_are_the_limit() -> None:
    assert pytest.approx(np.pi / np.sqrt(12)) == PACKING_LIMIT
    fibre, resin = TABLE["carbon"], TABLE["polyester"]
    ply = ply_from_constituents(fibre, resin, PACKING_LIMIT)  # type: ignore[arg-type]
    assert ply.name == "carbon/polyester"


def test_an_unknown_rule() -> None:
    fibre, resin = TABLE["carbon"], TABLE["polyester"]
    with pytest.raises(InputError, match="chamis, halpin-tsai, rule-of-mixtures, got 'voigt'"):
        ply_from_constituents(fibre, resin, 0.6, "voigt")  # type: ignore[arg-type]
