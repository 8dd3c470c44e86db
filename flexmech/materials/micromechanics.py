"""From fibre and resin to a ply: rule of mixtures, Halpin-Tsai, Chamis; woven plies; uncertainty.

Each modulus P of the ply is a function of the fibre's and the resin's. Three rules differ in
that function across the fibres and in shear; along the fibres all take the rule of mixtures.
The loss in a cycle follows by the correspondence principle (Hashin, *Int. J. Solids Struct.*
6 (1970) 797): a constituent holds the share ``d log P / d log P_c`` of the strain energy and
loses its specific damping capacity of it. With P of the rule of mixtures that is Adams &
Bacon's longitudinal damping (*J. Compos. Mater.* 7 (1973) 402), with Chamis' P Saravanos &
Chamis' (*J. Compos. Technol. Res.* 12 (1990) 31), and with Halpin-Tsai's G12, which is
Hashin's composite cylinders, Hashin's in shear.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.materials.composition import RULES, PlyComposition, Rule
from flexmech.materials.constituents import Fibre, Matrix
from flexmech.materials.ply import Ply, PlyDamping
from flexmech.validation import check_choice, check_instance, check_number, checked_tuple

# Round fibres in hexagonal array that touch.
PACKING_LIMIT = float(np.pi / (2 * np.sqrt(3)))

Number = TypeVar("Number", float, complex)
# Modulus of the ply from that of fibre and resin and the fibre volume fraction.
Mixing = Callable[[complex, complex, float], complex]


def ply_from_constituents(
    fibre: Fibre,
    matrix: Matrix,
    fibre_volume_fraction: float,
    rule: Rule = "chamis",
) -> Ply:
    """Unidirectional ply.

    Along the fibres, and for Poisson's ratio and density, the rule of mixtures (Jones,
    *Mechanics of Composite Materials*, 2nd ed., sec. 3.2). Across them and in shear:

    ``rule-of-mixtures``
        Flexibilities add (Jones, eqs. 3.13 and 3.27).
    ``halpin-tsai``
        Halpin & Kardos, *Polym. Eng. Sci.* 16 (1976) 344, with the factor 2 for E2, 1 for
        G12 and G13, and ``1 / (3 - 4 nu_m)`` for G23 (Tucker & Liang, *Compos. Sci. Technol.*
        59 (1999) 655), which is Hashin and Hill's lower bound for isotropic constituents.
    ``chamis``
        NASA TM-83320 (1983): resin in series with fibres as wide as the root of their share.
        Not for few fibres: if their modulus is r times the resin's, below the volume
        fraction ``1 / (r - 1)^2`` the ply comes out stiffer than layers in parallel.

    Expansion by Schapery (*J. Compos. Mater.* 2 (1968) 380), with Singh & Sanyal 2022, eq. 8,
    corrected; the moisture expansion is per unit of moisture in the dry fibre and resin each,
    so that of the ply is per unit of moisture in the resin where the fibres take none.
    Specific damping: see the module. No rule foresees slip, cracks or voids.

    Parameters
    ----------
    fibre : Fibre
    matrix : Matrix
    fibre_volume_fraction : float
        Above 0, up to that of touching round fibres (0.9069).
    rule : {"chamis", "halpin-tsai", "rule-of-mixtures"}

    Returns
    -------
    Ply

    Raises
    ------
    InputError
        If the volume fraction is out of bounds or the rule unknown.

    Examples
    --------
    >>> known = flexmech.published_constituents()
    >>> flexmech.ply_from_constituents(known["E-glass"], known["polyester"], 0.6)
    <Ply: E-glass/polyester, E1 42.972 GPa, E2 9.63166 GPa, G12 0.208163 GPa, density 2046.4 kg/m^3>
    """
    origin = PlyComposition(fibre, matrix, fibre_volume_fraction, rule)
    share = _checked_fraction(fibre_volume_fraction)
    check_choice(rule, RULES, "rule")
    across, shear, shear_across = _mixings(rule, matrix.poisson_ratio)
    young = (fibre.youngs_modulus, matrix.youngs_modulus)
    young_across = (fibre.modulus_across, matrix.youngs_modulus)
    shears = (fibre.shear_modulus, matrix.shear_modulus)
    shears_across = (fibre.shear_modulus_across, matrix.shear_modulus)
    poisson_ratio = _parallel(fibre.poisson_ratio, matrix.poisson_ratio, share)
    in_plane = _modulus(shear, shears, share)
    losses = (fibre.specific_damping, matrix.specific_damping)
    return Ply(
        longitudinal_modulus=_modulus(_parallel, young, share),
        transverse_modulus=_modulus(across, young_across, share),
        in_plane_shear_modulus=in_plane,
        longitudinal_shear_modulus=in_plane,
        transverse_shear_modulus=_modulus(shear_across, shears_across, share),
        poisson_ratio=poisson_ratio,
        density=_parallel(fibre.density, matrix.density, share),
        specific_damping=PlyDamping(
            longitudinal=_loss(_parallel, young, share, losses),
            transverse=_loss(across, young_across, share, losses),
            shear=_loss(shear, shears, share, losses),
        ),
        thermal_expansion=_expansion(
            fibre, matrix, share, (fibre.thermal_expansion, matrix.thermal_expansion)
        ),
        moisture_expansion=_expansion(
            fibre, matrix, share, (fibre.moisture_expansion, matrix.moisture_expansion)
        ),
        name=f"{fibre.name}/{matrix.name}",
        origin=origin,
    )


def ply_of(composition: PlyComposition) -> Ply:
    """Ply of a composition: unidirectional or woven."""
    ply = ply_from_constituents(
        composition.fibre, composition.matrix, composition.fibre_volume_fraction, composition.rule
    )
    return woven_ply(ply) if composition.woven else ply


def woven_ply(unidirectional: Ply) -> Ply:
    """Balanced fabric as crimp-free crossed layers, half of the fibres each way.

    Two layers at 0 and 90 degrees that stretch alike (Naik & Shembekar 1992, without
    undulation): the crimp of a real fabric makes it softer along its yarns. The ply is
    homogeneous through its thickness; that the two halves do not lie on each other in a
    real stack is part of the idea. Membrane stiffness and expansion are those of the pair;
    shear through the thickness is averaged as in the integrals of first-order theory; the
    loss is that of both halves by their strain energies.

    Parameters
    ----------
    unidirectional : Ply
        With the fabric's fibre volume fraction.

    Returns
    -------
    Ply
        Equal along and across.

    Examples
    --------
    >>> known = flexmech.published_constituents()
    >>> single = flexmech.ply_from_constituents(known["E-glass"], known["polyester"], 0.6)
    >>> woven = flexmech.woven_ply(single)
    >>> round(woven.longitudinal_modulus / 1e9, 2), round(woven.transverse_modulus / 1e9, 2)
    (26.46, 26.46)
    """
    check_instance(unidirectional, Ply, "unidirectional", "give a flexmech.Ply")
    stiffness, origin = unidirectional.reduced_stiffness, unidirectional.origin
    direct = (stiffness[0, 0] + stiffness[1, 1]) / 2
    cross = stiffness[0, 1]
    poisson_ratio = float(cross / direct)
    modulus = float(direct - cross * poisson_ratio)
    through = (
        unidirectional.longitudinal_shear_modulus + unidirectional.transverse_shear_modulus
    ) / 2
    # Both halves under a stress along the warp: strains 1 and -nu.
    strain = np.array([1.0, -poisson_ratio, 0.0])
    energy = np.zeros(3)
    for half in (strain, strain[[1, 0, 2]]):
        energy += half * (stiffness @ half)
    loss = unidirectional.specific_damping
    stretched = float((energy[0] * loss.longitudinal + energy[1] * loss.transverse) / energy.sum())

    def expanded(directions: tuple[float, float]) -> tuple[float, float]:
        pull = (stiffness[:2, :2] @ np.array(directions)).mean()
        both = float(pull / (direct + cross))
        return both, both

    return replace(
        unidirectional,
        longitudinal_modulus=modulus,
        transverse_modulus=modulus,
        poisson_ratio=poisson_ratio,
        longitudinal_shear_modulus=through,
        transverse_shear_modulus=through,
        specific_damping=PlyDamping(stretched, stretched, loss.shear),
        thermal_expansion=expanded(unidirectional.thermal_expansion),
        moisture_expansion=expanded(unidirectional.moisture_expansion),
        name=f"woven {unidirectional.name}".strip(),
        origin=replace(origin, woven=True) if isinstance(origin, PlyComposition) else origin,
    )


def _checked_fraction(value: float) -> float:
    check_number(value, "fibre_volume_fraction")
    if not 0 < value <= PACKING_LIMIT:
        raise InputError(
            f"fibre_volume_fraction must lie above 0 and not above {PACKING_LIMIT:.4f}, where "
            f"round fibres touch; got {value}"
        )
    return value


def _parallel(fibre: Number, matrix: Number, share: float) -> Number:
    return share * fibre + (1 - share) * matrix


def _series(fibre: complex, matrix: complex, share: float) -> complex:
    return 1 / (share / fibre + (1 - share) / matrix)


def _square_packed(fibre: complex, matrix: complex, share: float) -> complex:
    """Chamis: resin in series with a fibre strip as wide as the root of its share."""
    return matrix / (1 - float(np.sqrt(share)) * (1 - matrix / fibre))


def _halpin_tsai(factor: float) -> Mixing:
    def mixing(fibre: complex, matrix: complex, share: float) -> complex:
        ratio = fibre / matrix
        eta = (ratio - 1) / (ratio + factor)
        return matrix * (1 + factor * eta * share) / (1 - eta * share)

    return mixing


def _mixings(rule: Rule, matrix_poisson_ratio: float) -> tuple[Mixing, Mixing, Mixing]:
    """Mixing of E2, of G12 and G13, and of G23."""
    if rule == "halpin-tsai":
        return (
            _halpin_tsai(2.0),
            _halpin_tsai(1.0),
            _halpin_tsai(1 / (3 - 4 * matrix_poisson_ratio)),
        )
    mixing = _square_packed if rule == "chamis" else _series
    return mixing, mixing, mixing


def _modulus(mixing: Mixing, moduli: tuple[float, float], share: float) -> float:
    return complex(mixing(moduli[0], moduli[1], share)).real


def _loss(
    mixing: Mixing, moduli: tuple[float, float], share: float, losses: tuple[float, float]
) -> float:
    """Specific damping capacity: those of fibre and resin, weighted by their strain energy.

    The share of a constituent is ``d log P / d log P_c``, here by a complex step.
    """
    step, total = 1e-30, 0.0
    whole = _modulus(mixing, moduli, share)
    for place, loss in enumerate(losses):
        stepped: list[complex] = list(moduli)
        stepped[place] *= 1 + 1j * step
        total += loss * mixing(stepped[0], stepped[1], share).imag / step / whole
    return total


def _expansion(
    fibre: Fibre, matrix: Matrix, share: float, free: tuple[float, float]
) -> tuple[float, float]:
    """Along and across the fibres, from the free expansion of fibre and resin (Schapery)."""
    stiffness = (fibre.youngs_modulus * share, matrix.youngs_modulus * (1 - share))
    along = (stiffness[0] * free[0] + stiffness[1] * free[1]) / sum(stiffness)
    poisson_ratio = _parallel(fibre.poisson_ratio, matrix.poisson_ratio, share)
    across = (
        share * free[0] * (1 + fibre.poisson_ratio)
        + (1 - share) * free[1] * (1 + matrix.poisson_ratio)
        - along * poisson_ratio
    )
    return along, across


# Step of an uncertainty: central differences are off by its square, 1e-6 of the derivative, and
# rounding leaves 1e-12 of a number that an uncertainty changes by a tenth.
_STEP = 1e-3


def propagated_uncertainty(
    function: Callable[..., float], constituents: Sequence[Fibre | Matrix]
) -> float:
    """Uncertainty of a number computed from constituents, to first order.

    The uncertainties that the constituents carry are taken as independent: the root of the
    sum of squares of each one times the number's derivative, by central differences
    (JCGM 100:2008, *Guide to the expression of uncertainty in measurement*, eq. 10). First
    order is poor where an uncertainty is large: the printed one of the carbon fibre's shear
    modulus is 42 % of it.

    Parameters
    ----------
    function : callable
        Function of the constituents, in their order; gives the modulus of a ply, a stiffness of a
        laminate or any other number that follows from them.
    constituents : sequence of Fibre or Matrix
        Each once, so that it varies everywhere together.

    Returns
    -------
    float
        In the units of the number.

    Examples
    --------
    >>> import flexmech
    >>> table = flexmech.published_constituents()
    >>> def modulus(fibre, resin):
    ...     return flexmech.ply_from_constituents(fibre, resin, 0.6).longitudinal_modulus / 1e9
    >>> parts = table["carbon"], table["polyester"]
    >>> spread = flexmech.propagated_uncertainty(modulus, parts)
    >>> print(f"{modulus(*parts):.1f} +/- {spread:.1f} GPa")
    121.9 +/- 12.0 GPa
    """
    parts = uncertainty_parts(function, constituents)
    return float(np.sqrt(sum(float(contribution) ** 2 for contribution in parts.values())))


def uncertainty_parts(
    function: Callable[..., ArrayLike], constituents: Sequence[Fibre | Matrix]
) -> dict[tuple[str, str], FloatArray]:
    """Change of numbers by the uncertainty of each property of their constituents, to first order.

    Parameters
    ----------
    function : callable
        Function of the constituents, in their order; gives one number or an array of them.
    constituents : sequence of Fibre or Matrix
        Each once, so that it varies everywhere together.

    Returns
    -------
    dict of (str, str) to ndarray
        By constituent and property: what one uncertainty more of it adds, of the shape of the
        numbers and in their units. Without a stated uncertainty there is no entry.

    Raises
    ------
    InputError
        If the function cannot be called, or there are no constituents.

    Examples
    --------
    >>> from flexmech.materials import uncertainty_parts
    >>> table = flexmech.published_constituents()
    >>> parts = uncertainty_parts(
    ...     lambda carbon: np.array([carbon.density, carbon.density**2]), [table["carbon"]]
    ... )
    >>> parts["carbon", "density"].round(3)
    array([1.00e+01, 3.48e+04])
    """
    if not callable(function):
        raise InputError(f"function must be called with the constituents, got {function!r}")
    remedy = "give a Fibre and a Matrix in a tuple"
    constituents = checked_tuple(constituents, (Fibre, Matrix), "constituents", remedy)
    parts = {}
    for place, constituent in enumerate(constituents):
        for name, spread in constituent.uncertainty.items():
            ends = []
            for sign in (1.0, -1.0):
                moved: list[Any] = list(constituents)
                value = getattr(constituent, name) + sign * _STEP * spread
                moved[place] = replace(constituent, **{name: value})
                ends.append(np.asarray(function(*moved), dtype=float))
            parts[constituent.name, name] = (ends[0] - ends[1]) / (2 * _STEP)
    return parts
