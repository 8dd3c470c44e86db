"""Laminates: plies stacked through the thickness, and the integrals that theories need.

Laminate axes: x along the link, z across it in the plane of the plies, y through the
thickness from the mid-plane, first layer at the lowest y. In-plane strains are written in
the order x, z, xz (the textbooks' 1, 2, 6), shear through the thickness in the order
zy, xy (their 4, 5).

A stack is written as ``[C/G@45*2/C]s``, and a ply as a table of a model file: by its material, its
constituents, or its constants.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Self

import numpy as np

from flexmech import si
from flexmech.arrays import SAME_PLACE, FloatArray
from flexmech.errors import InputError
from flexmech.materials.composition import PlyComposition
from flexmech.materials.micromechanics import ply_of
from flexmech.materials.ply import Ply
from flexmech.model_text import SharedTables, TomlTable, quantity, short_repr, stated
from flexmech.units import (
    ANGLE,
    EXPANSION,
    LENGTH,
    MOISTURE_EXPANSION,
    NUMBER,
    RATIO,
    TEMPERATURE,
    parse_number,
)
from flexmech.validation import POSITIVE, check_angle, check_fields, check_instance, checked_tuple


def ply_table(ply: Ply, shared: SharedTables) -> TomlTable:
    """Table under ``[plies]`` of a model file, without the name.

    Parameters
    ----------
    ply : Ply
    shared : SharedTables
        Its material or its constituents are added.

    Returns
    -------
    dict
        By its material or its constituents where they give the same ply to the last bit, else
        by its constants.
    """
    material = ply.isotropic_material
    if material is not None:
        name = shared.name_of("materials", material.to_table(), ply.name or "material")
        return {"type": "isotropic", "material": name}
    origin = ply.origin
    if not isinstance(origin, PlyComposition):
        resin = {} if origin is None else {"resin": origin.to_table()}
        return {**_constants(ply), **resin, **_strength_table(ply)}
    constituents = origin.to_table(shared)
    # TOML wants a table's own tables after its values.
    strength = _strength_table(ply)
    if replace(ply_of(origin), name=ply.name, strength=ply.strength) == ply:
        return {"type": "constituents", **constituents, **strength}
    return {**_constants(ply), "constituents": constituents, **strength}


def _strength_table(ply: Ply) -> TomlTable:
    return {} if ply.strength is None else {"strength": ply.strength.to_table()}


def _constants(ply: Ply) -> TomlTable:
    damping = ply.specific_damping
    heat, water = ply.thermal_expansion, ply.moisture_expansion
    return {
        "type": "orthotropic",
        **si.table(ply, without={"thermal_expansion", "moisture_expansion", "yield_strength"}),
        **stated(
            longitudinal_damping=(damping.longitudinal or None, RATIO),
            transverse_damping=(damping.transverse or None, RATIO),
            shear_damping=(damping.shear or None, RATIO),
            longitudinal_thermal_expansion=(heat[0] or None, EXPANSION),
            transverse_thermal_expansion=(heat[1] or None, EXPANSION),
            longitudinal_moisture_expansion=(water[0] or None, MOISTURE_EXPANSION),
            transverse_moisture_expansion=(water[1] or None, MOISTURE_EXPANSION),
        ),
    }


_STACK = re.compile(r"\s*\[(?P<inside>[^\[\]]*)\]\s*(?P<mirror>[sS]?)\s*")
_ITEM = re.compile(
    rf"\s*(?P<ply>[^@*\s]+)\s*(?:@\s*(?P<angle>{NUMBER})\s*)?(?:\*\s*(?P<count>[0-9]+)\s*)?"
)
# What separates layers and their parts.
_OWN = re.compile(r"[\s/@*\[\]]+")
# A hundred times those of real laminates; each layer is a column of a section's profile.
MOST_LAYERS = 1000
_EXAMPLE = "write plies between slashes, as in '[C/G@45/C]', '[C@0/C@90*2]s'"


def parse_stacking(text: str) -> list[tuple[str, float | None]]:
    """Plies of a stack from the lowest up, with their angles in degrees where they are given.

    Parameters
    ----------
    text : str
        Ply names between slashes in square brackets; ``@`` gives the fibre angle in
        degrees, ``*`` repeats a layer, a final ``s`` mirrors the stack.

    Returns
    -------
    list of tuple
        Name and angle, or None, of each layer.

    Raises
    ------
    InputError
        If the text is no stack.
    """
    whole = _STACK.fullmatch(text)
    if whole is None:
        raise InputError(f"got {text!r}, which is no stack; {_EXAMPLE}")
    layers: list[tuple[str, float | None]] = []
    copies = 2 if whole["mirror"] else 1
    for item in whole["inside"].split("/"):
        match = _ITEM.fullmatch(item)
        if match is None:
            raise InputError(f"got {text!r}, where {item.strip()!r} is no layer; {_EXAMPLE}")
        count = int(match["count"] or 1)
        if count < 1 or copies * (len(layers) + count) > MOST_LAYERS:
            raise InputError(
                f"got {text!r}: a layer is repeated once or more, and a stack has at most "
                f"{MOST_LAYERS} layers; write fewer"
            )
        angle = None if match["angle"] is None else float(parse_number(match["angle"]))
        layers += [(match["ply"], angle)] * count
    return layers + layers[::-1] if whole["mirror"] else layers


def stacking_text(layers: Sequence[tuple[str, float]], digits: int = 6) -> str:
    """Write a stack in the notation that :func:`parse_stacking` reads.

    Parameters
    ----------
    layers : sequence of tuple
        Name and angle in degrees of each layer, from the lowest up.
    digits : int
        Significant digits of the angles.

    Returns
    -------
    str
        As short as the notation allows; angles of zero are left out. What the notation uses
        itself, such as a slash, becomes a low line in names.
    """
    half = len(layers) // 2
    mirrored = len(layers) % 2 == 0 and list(layers[:half]) == list(layers[half:])[::-1]
    runs = [
        _OWN.sub("_", name or "ply")
        + (f"@{angle:.{digits}g}" if angle else "")
        + (f"*{count}" if count > 1 else "")
        for (name, angle), count in (
            (layer, len(list(run))) for layer, run in groupby(layers[:half] if mirrored else layers)
        )
    ]
    return f"[{'/'.join(runs)}]{'s' * mirrored}"


# Digits of an angle in degrees that is read back to the same radians: more would show their
# rounding.
DIGITS = 12


@dataclass(frozen=True)
class Layer:
    """A ply in its place.

    Parameters
    ----------
    ply : Ply
    thickness : float
        In m.
    angle : float
        Angle of the fibres against the link's axis in rad, positive from x towards z.

    Raises
    ------
    InputError
        If the thickness is not positive or the angle not a number.
    """

    ply: Ply
    thickness: float
    angle: float = 0.0

    def __post_init__(self) -> None:
        check_instance(self.ply, Ply, "ply of a layer", "make one, as with Ply.isotropic(material)")
        check_fields(self, {"thickness": "m"}, POSITIVE, "of a layer")
        check_angle(self.angle, "angle of a layer")

    def __repr__(self) -> str:
        angle = f"{np.degrees(self.angle):.6g} deg"
        return short_repr(self, self.ply.name, f"{self.thickness * 1e3:.6g} mm", angle)

    @property
    def transformed_stiffness(self) -> FloatArray:
        """Plane-stress stiffness in laminate axes, (3, 3), in Pa.

        Elamy et al. 2023, eqs. 25-26, corrected: D11 has 2 U12 + 4 U33, and the second
        bracket of D13 is U12 - U22 + 2 U33.
        """
        turn = self.strain_turn
        return np.asarray(turn.T @ self.ply.reduced_stiffness @ turn)

    @property
    def transformed_shear_stiffness(self) -> FloatArray:
        """Stiffness against shear through the thickness in laminate axes, (2, 2), in Pa.

        Elamy et al. 2023, eq. 26, corrected: D45 = (U44 - U55) c s with U44 = G13, U55 = G23.
        """
        cosine, sine = np.cos(self.angle), np.sin(self.angle)
        turn = np.array([[cosine, -sine], [sine, cosine]])
        return np.asarray(turn.T @ self.ply.transverse_shear_stiffness @ turn)

    @property
    def strain_turn(self) -> FloatArray:
        """Strains in the ply's axes (1, 2, 12) from those in laminate axes, (3, 3).

        Shear strains are engineering ones.
        """
        c, s = np.cos(self.angle), np.sin(self.angle)
        return np.array(
            [
                [c**2, s**2, c * s],
                [s**2, c**2, -c * s],
                [-2 * c * s, 2 * c * s, c**2 - s**2],
            ]
        )


@dataclass(frozen=True)
class Laminate:
    """Layers from the lowest to the highest, the mid-plane at y = 0.

    Parameters
    ----------
    layers : tuple of Layer
    stress_free_temperature : float, optional
        In K: at which the dry layers do not strain each other, about that of their cure. Without
        it stresses of cure are not counted.

    Raises
    ------
    InputError
        If there is no layer, one is too thin against the others to compute with, or the
        temperature is not above 0 K.

    Examples
    --------
    >>> known = flexmech.published_constituents()
    >>> ply = flexmech.ply_from_constituents(known["carbon"], known["polyester"], 0.6)
    >>> flexmech.Laminate.stacked([ply] * 3, 0.5e-3, np.radians([0, 90, 0]))
    <Laminate: [carbon_polyester/carbon_polyester@90/carbon_polyester], 3 layers, 1.5 mm>
    """

    layers: tuple[Layer, ...]
    stress_free_temperature: float | None = None

    def __post_init__(self) -> None:
        check_fields(self, {"stress_free_temperature": "K"}, POSITIVE, optional=True)
        remedy = "give Layer(ply, thickness, angle) in a tuple"
        object.__setattr__(self, "layers", checked_tuple(self.layers, Layer, "layers", remedy))
        if not self.layers:
            raise InputError("a laminate needs one layer or more, got none")
        thinnest = min(layer.thickness for layer in self.layers)
        if thinnest < SAME_PLACE * self.thickness:
            raise InputError(
                f"the thinnest layer has {thinnest:g} m of {self.thickness:g} m, too little to "
                "compute with; check the units"
            )

    def __repr__(self) -> str:
        layers = f"{len(self.layers)} layers"
        return short_repr(self, self.stacking, layers, f"{self.thickness * 1e3:.6g} mm")

    @property
    def stacking(self) -> str:
        """The stack in the notation of model files, angles in degrees."""
        return stacking_text(
            [(layer.ply.name, float(np.degrees(layer.angle))) for layer in self.layers]
        )

    @classmethod
    def stacked(cls, plies: Sequence[Ply], thickness: float, angles: Sequence[float]) -> Self:
        """Laminate of equally thick layers.

        Parameters
        ----------
        plies : sequence of Ply
        thickness : float
            Thickness of each layer in m.
        angles : sequence of float
            In rad, one a ply.

        Returns
        -------
        Laminate

        Raises
        ------
        InputError
            If there is not one angle for each ply, or as of a new laminate.
        """
        plies = checked_tuple(plies, Ply, "plies", "give one flexmech.Ply for each layer")
        angles = checked_tuple(angles, object, "angles", "give one in rad for each ply")
        if len(plies) != len(angles):
            raise InputError(
                f"angles has {len(angles)} values and there are {len(plies)} plies; give one "
                "angle for each ply"
            )
        pairs = zip(plies, angles, strict=True)
        return cls(tuple(Layer(ply, thickness, angle) for ply, angle in pairs))

    @property
    def thickness(self) -> float:
        """Thickness of all layers together in m."""
        return float(sum(layer.thickness for layer in self.layers))

    @property
    def boundaries(self) -> FloatArray:
        """Faces of the layers in m, from -h/2 to h/2, shape (N + 1,)."""
        half = self.thickness / 2
        upper = np.cumsum([layer.thickness for layer in self.layers])
        faces = np.concatenate([[-half], upper - half])
        faces[-1] = half
        return faces

    @property
    def transformed_stiffness(self) -> FloatArray:
        """Plane-stress stiffness of each layer in laminate axes, (N, 3, 3), in Pa."""
        return np.stack([layer.transformed_stiffness for layer in self.layers])

    @property
    def transformed_shear_stiffness(self) -> FloatArray:
        """Stiffness of each layer against shear through the thickness, (N, 2, 2), in Pa."""
        return np.stack([layer.transformed_shear_stiffness for layer in self.layers])

    def stiffness_moment(self, order: int) -> FloatArray:
        """Integral of the plane-stress stiffness times ``y**order`` through the thickness.

        Orders 0, 1, 2, 3, 4 and 6 are A, B, D, E, F and H (Elamy et al. 2023, eqs. 29, 31;
        Reddy, *Mechanics of Laminated Composite Plates and Shells*, ch. 11).

        Parameters
        ----------
        order : int

        Returns
        -------
        ndarray, shape (3, 3)
            In N/m times m to the order.
        """
        return np.asarray(np.tensordot(self._weights(order), self.transformed_stiffness, axes=1))

    @property
    def plate_stiffness(self) -> FloatArray:
        """A, B and D of classical laminate theory, (6, 6).

        By the strains x, z and xz at the mid-plane, and by their gradients in y.
        """
        a, b, d = (self.stiffness_moment(order) for order in range(3))
        return np.block([[a, b], [b, d]])

    def shear_moment(self, order: int) -> FloatArray:
        """Integral of the shear stiffness times ``y**order``: orders 0, 2 and 4 (eq. 29).

        Parameters
        ----------
        order : int

        Returns
        -------
        ndarray, shape (2, 2)
            In N/m times m to the order.
        """
        return np.asarray(
            np.tensordot(self._weights(order), self.transformed_shear_stiffness, axes=1)
        )

    def mass_moment(self, order: int) -> float:
        """Integral of the density times ``y**order`` in kg/m^2 times m to the order."""
        density = np.array([layer.ply.density for layer in self.layers])
        return float(self._weights(order) @ density)

    def to_table(self, shared: SharedTables) -> TomlTable:
        """Table under ``[laminates]`` of a model file.

        Parameters
        ----------
        shared : SharedTables
            Its plies are added.

        Returns
        -------
        dict
        """
        names = [
            shared.name_of("plies", ply_table(ply, shared), ply.name or "ply", own_name=ply.name)
            for ply in (layer.ply for layer in self.layers)
        ]
        angles = [layer.angle for layer in self.layers]
        degrees = [float(f"{np.degrees(angle):.{DIGITS}g}") for angle in angles]
        # Not every angle in rad is a number of degrees to the last bit.
        whole = [float(np.radians(degree)) for degree in degrees] == angles
        pairs = zip(names, degrees if whole else [0.0] * len(names), strict=True)
        table: TomlTable = {"stacking": stacking_text(list(pairs), DIGITS)}
        if not whole:
            table["angles"] = [quantity(angle, ANGLE) for angle in angles]
        thicknesses = [quantity(layer.thickness, LENGTH) for layer in self.layers]
        alike = len(set(thicknesses)) == 1
        free = stated(stress_free_temperature=(self.stress_free_temperature, TEMPERATURE))
        return {**table, "ply_thickness": thicknesses[0] if alike else thicknesses, **free}

    def _weights(self, order: int) -> FloatArray:
        """Integral of ``y**order`` over each layer, (N,)."""
        return np.asarray(np.diff(self.boundaries ** (order + 1)) / (order + 1))


# Greatest ratio of Poisson's ratio across the fibres where G23 says more: a ply that is not alike
# in 2 and 3.
GREATEST_RATIO = 0.5
# Distance from incompressible, in the range that a ratio may have: at its ends the compliance has
# no inverse.
MARGIN = 0.02


def solid_stiffness(layer: Layer) -> FloatArray:
    """Stiffness by strains x, y, z, yz, xz and xy in laminate axes, (6, 6), in Pa.

    Through its thickness a ply is taken to be as stiff as across its fibres (``E3 = E2``,
    ``nu13 = nu12``), and ``nu23 = E2 / (2 G23) - 1``: transversely isotropic, as unidirectional
    plies are. In plane stress these assumed values cancel.

    Parameters
    ----------
    layer : Layer

    Returns
    -------
    ndarray, shape (6, 6)
    """
    c, s = np.cos(layer.angle), np.sin(layer.angle)
    turn = np.zeros((6, 6))
    in_plane = [0, 2, 4]
    turn[np.ix_(in_plane, in_plane)] = layer.strain_turn
    turn[1, 1] = 1.0
    through = [3, 5]
    turn[np.ix_(through, through)] = [[c, -s], [s, c]]
    return np.asarray(turn.T @ np.linalg.inv(_compliance(layer.ply)) @ turn)


def _compliance(ply: Ply) -> FloatArray:
    """By stresses 1, 3, 2, 23, 12 and 13 of the ply, (6, 6)."""
    along, across = ply.longitudinal_modulus, ply.transverse_modulus
    contraction = ply.poisson_ratio / along
    compliance = np.diag(
        1
        / np.array(
            [
                along,
                across,
                across,
                ply.transverse_shear_modulus,
                ply.in_plane_shear_modulus,
                ply.longitudinal_shear_modulus,
            ]
        )
    )
    compliance[0, 1:3] = compliance[1:3, 0] = -contraction
    compliance[1, 2] = compliance[2, 1] = -_ratio_across(ply) / across
    return compliance


def _ratio_across(ply: Ply) -> float:
    """Poisson's ratio nu23, for which no stress does negative work."""
    span = 2 * (1 - ply.poisson_ratio**2 * ply.transverse_modulus / ply.longitudinal_modulus)
    isotropic = ply.transverse_modulus / (2 * ply.transverse_shear_modulus) - 1
    upper = min(GREATEST_RATIO, -1 + (1 - MARGIN) * span)
    return float(np.clip(isotropic, -1 + MARGIN * span, upper))
