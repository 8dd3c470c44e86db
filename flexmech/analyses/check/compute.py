"""What is known of a mechanism: sections, masses, words, and natural frequencies at rest."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from itertools import pairwise

import numpy as np
import xarray as xr

from flexmech.analyses.check.in_short import linkage_in_short
from flexmech.analyses.check.remarks import USUAL_TRANSMISSION_ANGLE, remarks
from flexmech.analyses.check.result import ModelCheck
from flexmech.analyses.check.sections import LINK_PROPERTIES, section_properties
from flexmech.analyses.datasets import provenance
from flexmech.analyses.frequencies.discretisation import mesh_error
from flexmech.analyses.frequencies.flutter import flutter_at
from flexmech.analyses.frequencies.formulation import Formulation, Systems
from flexmech.analyses.frequencies.positions import natural_frequencies
from flexmech.analyses.requests import engine_of
from flexmech.arrays import FloatArray
from flexmech.choices import MODES
from flexmech.errors import ComputationError, InputError
from flexmech.hygrothermal import absorbing_links, inert_links
from flexmech.linear_system import Engine
from flexmech.linkages import (
    CouplerCurve,
    FourBar,
    assemblable,
    linkage_positions,
    moving_points,
    picture_crank_angle,
)
from flexmech.mechanism import Mechanism, drawing
from flexmech.modelfile import twofold_points
from flexmech.sections import BeamSection
from flexmech.threads import one_thread
from flexmech.units import ZERO_CELSIUS
from flexmech.validation import checked_number


def check_mechanism(engine: Engine | Mechanism, crank_angle: float | None = None) -> ModelCheck:
    """What is known of a mechanism, with its natural frequencies at rest and remarks on it.

    Parameters
    ----------
    engine : Engine or Mechanism
        It computes the frequencies; of a mechanism the reference engine is made.
    crank_angle : float, optional
        Of the frequencies and of the posture that is drawn, in rad. Left out: frequencies at 0,
        and a posture in which the links stand apart.

    Returns
    -------
    ModelCheck
        Without frequencies where the linkage cannot stand at crank angle 0 or has rigid links
        alone, and without a posture where it can be assembled at no angle that was tried.

    Raises
    ------
    InputError
        If the linkage cannot stand at the crank angle that is given.
    ComputationError
        As :func:`flexmech.natural_frequencies`.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> check = flexmech.check_mechanism(mechanism)
    >>> check.dataset["length"].values
    array([0.102 , 0.2794, 0.2667])
    >>> check.remarks[0].partition(":")[0]
    'transmission angle 32.21 to 81.33 deg leaves 40 to 140 deg'
    """
    engine = engine_of(engine, elastic=False)
    mechanism = engine.mechanism
    links = mechanism.linkage.topology.links
    sections = {link.name: mechanism.sections.get(link.name) for link in links}
    dataset = section_properties(sections).sel(coupling="with", drop=True)
    lengths = np.array([link.length for link in links])
    masses = lengths * dataset["mass_per_length"].values
    for number, link in enumerate(links):
        if sections[link.name] is None:
            own = (body.mass for body in mechanism.bodies if body.link == link.name)
            masses[number] = sum(own)
    of_links = (lengths, masses)
    for one, values in zip(LINK_PROPERTIES, of_links, strict=True):
        dataset[one.name] = ("link", values, one.attributes)
    lines = [*mechanism.described(), *_hygrothermal_lines(mechanism)]
    dataset = dataset.assign_attrs(
        provenance([engine]),
        engine=engine.name,
        linkage="\n".join([*mechanism.linkage.described(), *map(str, twofold_points(mechanism))]),
        mechanism_lines="\n".join(lines),
        linkage_in_short=linkage_in_short(mechanism.linkage),
        without_frequencies="",
    )
    at = 0.0 if crank_angle is None else checked_number(crank_angle, "crank_angle", "rad")
    dataset["frequency_angle"] = at
    frequency = None
    try:
        frequency, error, flutters = _oscillating(engine, at)
        dataset.attrs["flutter"] = flutters
        dataset["frequency"] = ("mode", frequency)
        dataset["discretisation_error"] = ("mode", error)
    except InputError as error:
        if crank_angle is not None and not all(link.rigid for link in links):
            raise
        # Not every linkage can stand at crank angle zero; what is known of it is right even so.
        dataset.attrs["without_frequencies"] = str(error)
    with suppress(InputError):  # assembled at no angle that is tried: there is nothing to draw
        posture = picture_crank_angle(mechanism.linkage) if crank_angle is None else at
        drawn = drawn_mechanism(mechanism, posture)
        dataset = dataset.merge(drawn).assign_attrs(drawn.attrs)
    dataset.attrs["remarks"] = "\n".join(remarks(mechanism, frequency))
    return ModelCheck(ModelCheck.schema().labelled(dataset))


def _oscillating(engine: Engine, crank_angle: float) -> tuple[FloatArray, FloatArray, str]:
    """Natural frequencies of as many modes as oscillate, their mesh error, and whether one grows.

    The last in words; empty where none does.
    """
    for modes in range(MODES, 1, -1):
        try:
            return _at_rest(engine, crank_angle, modes)
        except ComputationError:
            # Strongly damped links have few modes that oscillate.
            continue
    return _at_rest(engine, crank_angle, 1)


def _at_rest(engine: Engine, crank_angle: float, modes: int) -> tuple[FloatArray, FloatArray, str]:
    frequency = natural_frequencies(engine, crank_angle, modes=modes)
    systems, at = Systems(engine.fit_for(modes), Formulation(modes=modes)), np.array([crank_angle])
    with one_thread():
        error = mesh_error(systems, at, 0.0)
        flutters = flutter_at([systems], at, np.zeros(1), "rad/s")
    return frequency, error.frequency[0], flutters


def _hygrothermal_lines(mechanism: Mechanism) -> list[str]:
    """What heat and moisture change, if there is anything."""
    inert = inert_links(mechanism)
    changed = [name for name in mechanism.linkage.topology.link_names if name not in inert]
    if not changed:
        return []
    reference = f"{mechanism.reference_temperature - ZERO_CELSIUS:.4g} degC"
    return [
        f"heat and moisture change: {', '.join(changed)}; water enters: "
        f"{', '.join(absorbing_links(mechanism)) or 'none'}; reference temperature {reference}"
    ]


# Crank angles of paths and of the transmission angle: a degree is what a figure draws.
TURN = np.radians(np.arange(0.0, 361.0))
_COUPLER_POINT, _COUPLER_MIDDLE = "coupler point", "coupler's middle"


def drawn_mechanism(mechanism: Mechanism, crank_angle: float) -> xr.Dataset:
    """A mechanism in one posture, and over a turn of its crank.

    Parameters
    ----------
    mechanism : Mechanism
    crank_angle : float
        Of the posture in rad.

    Returns
    -------
    xarray.Dataset
        ``posture_angle``; ``rigid_position`` (link, station, component), ``joint_position``
        (joint, component), ``joint_mass`` (joint), ``point_mass`` and ``point_mass_position``
        (mass, component) where there are some, and ``path_position`` (path, component). Over the
        turn ``path`` (path, crank_angle, component) of the pins that move, an arm's tip and the
        coupler point, and of a four-bar ``transmission_angle`` (crank_angle), not a number where
        the linkage cannot stand, ``transmission_angle_limit`` and
        ``usual_transmission_angle`` (limit). Of the sections
        ``layer_low`` and ``layer_high`` in m, ``ply`` and ``ply_angle`` over (link, layer), and
        ``stacking`` and ``direction_of_layers`` (link), along whose direction the faces count.

    Raises
    ------
    InputError
        If the linkage cannot stand at the crank angle.
    """
    linkage = mechanism.linkage
    dataset = linkage_positions(linkage, crank_angle).assign_attrs(drawing=drawing(mechanism))
    joints = [float(mechanism.joint_masses.get(str(name), 0.0)) for name in dataset["joint"].values]
    dataset["joint_mass"] = ("joint", joints)
    dataset["posture_angle"] = crank_angle
    ends = dataset["rigid_position"]
    if masses := [point for point in mechanism.link_masses if point.mass > 0]:
        places = []
        for point in masses:
            link = ends.sel(link=point.link).values
            along = link[1] - link[0]
            places.append(link[0] + point.position * along / np.hypot(*along))
        dataset["point_mass"] = ("mass", [point.mass for point in masses])
        dataset["point_mass_position"] = (("mass", "component"), np.array(places))
    paths = _paths(mechanism, np.append(TURN, crank_angle))
    if paths:
        of_turn = np.stack(list(paths.values()))
        dataset = dataset.assign_coords(path_name=("path", list(paths)), crank_angle=TURN)
        dataset["path"] = (("path", "crank_angle", "component"), of_turn[:, :-1])
        dataset["path_position"] = (("path", "component"), of_turn[:, -1])
    if isinstance(linkage, FourBar):
        dataset["transmission_angle"] = ("crank_angle", _transmission_angle(linkage))
        limits = linkage.transmission_angle_limits()
        dataset["transmission_angle_limit"] = ("limit", np.array(limits))
        dataset["usual_transmission_angle"] = ("limit", np.radians(USUAL_TRANSMISSION_ANGLE))
    names = linkage.topology.link_names
    return dataset.merge(_stacks({name: mechanism.sections.get(name) for name in names}))


def _paths(mechanism: Mechanism, angles: FloatArray) -> dict[str, FloatArray]:
    """Places of what moves at crank angles, by name; shape (angle, 2) each."""
    linkage, topology = mechanism.linkage, mechanism.linkage.topology
    assembled = assemblable(linkage, angles)
    motion = linkage.motion(angles[assembled])
    found = {}
    joints = dict(zip(topology.joint_names, topology.joint_kinds, strict=True))
    for name, place in moving_points(linkage).items():
        # A slider's path is its line, and what is welded on a link is no joint of the motion.
        if joints.get(name, "tip") not in ("pin", "tip"):
            continue
        found[name] = motion.position(*topology.end_place(place))
    if (point := mechanism.coupler_point) is not None and isinstance(linkage, FourBar):
        found[_COUPLER_POINT] = CouplerCurve(linkage, point).position(angles[assembled])
    elif "coupler" in topology.link_names:
        number = topology.index("coupler")
        found[_COUPLER_MIDDLE] = motion.position(number, topology.links[number].length / 2)
    whole = {}
    for name, places in found.items():
        whole[name] = np.full((len(angles), 2), np.nan)
        whole[name][assembled] = places
    return whole


def _transmission_angle(linkage: FourBar) -> FloatArray:
    assembled = assemblable(linkage, TURN)
    angle = np.full(TURN.size, np.nan)
    angle[assembled] = linkage.transmission_angle(TURN[assembled])
    return angle


def _stacks(sections: Mapping[str, BeamSection | None]) -> xr.Dataset:
    """Layers of the sections from the lowest y up; one without a name where none is known."""
    most = max(len(_layers(section)) for section in sections.values())
    faces = np.full((2, len(sections), most), np.nan)
    plies, angles = np.full(faces.shape[1:], "", dtype=object), np.zeros(faces.shape[1:])
    texts, directions = [], []
    for row, section in enumerate(sections.values()):
        layers = _layers(section)
        for column, (ply, angle, low, high) in enumerate(layers):
            faces[:, row, column] = low, high
            plies[row, column], angles[row, column] = ply, angle
        stack = None if section is None or len(layers) == 1 else section.layers
        directions.append("through thickness" if stack is None else stack.direction)
        texts.append("" if stack is None else stack.laminate.stacking)
    over = ("link", "layer")
    return xr.Dataset(
        {
            "layer_low": (over, faces[0]),
            "layer_high": (over, faces[1]),
            "ply": (over, plies.astype(str)),
            "ply_angle": (over, angles),
            "stacking": ("link", texts),
            "direction_of_layers": ("link", directions),
        },
        coords={"link": list(sections)},
    )


def _layers(section: BeamSection | None) -> list[tuple[str, float, float, float]]:
    """Name, angle and faces in m of each layer of a section; not numbers where there is none."""
    if section is None:
        return [("", 0.0, np.nan, np.nan)]
    half = section.in_plane_thickness / 2
    if section.layers is None or len(section.layers.laminate.layers) == 1:
        return [("", 0.0, -half, half)]
    laminate = section.layers.laminate
    places = zip(laminate.layers, pairwise(laminate.boundaries.tolist()), strict=True)
    return [(layer.ply.name, layer.angle, *faces) for layer, faces in places]
