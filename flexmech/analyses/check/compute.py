"""Properties of a mechanism: sections, masses, words, and natural frequencies at rest."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr

from flexmech import plots
from flexmech.analyses.check.remarks import USUAL_TRANSMISSION_ANGLE, linkage_in_short, remarks
from flexmech.analyses.check.sections import LINK_PROPERTIES, PROPERTIES, section_properties
from flexmech.analyses.datasets import provenance
from flexmech.analyses.details import details_table
from flexmech.analyses.digits import Quantity, plain
from flexmech.analyses.frequencies.discretisation import mesh_error
from flexmech.analyses.frequencies.flutter import flutter_at
from flexmech.analyses.frequencies.positions import natural_frequencies
from flexmech.analyses.options import CheckOptions
from flexmech.analyses.requests import as_many_modes, asks, engine_of, fewer_modes_lines
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary, Table, trust_line
from flexmech.arrays import ROUND_OFF, FloatArray
from flexmech.errors import InputError
from flexmech.hygrothermal import absorbing_links, inert_links
from flexmech.linkages import (
    CouplerCurve,
    FourBar,
    assemblable,
    linkage_positions,
    moving_points,
    picture_crank_angle,
)
from flexmech.mechanics import Engine
from flexmech.mechanism import Mechanism, drawing
from flexmech.modelfile import twofold_points
from flexmech.sections import BeamSection
from flexmech.solvers.formulation import Formulation, Systems
from flexmech.threads import one_thread
from flexmech.units import ZERO_CELSIUS
from flexmech.validation import checked_number

if TYPE_CHECKING:
    from matplotlib.figure import Figure


ROWS = (*LINK_PROPERTIES, *PROPERTIES)

# What stands in the table of links: variable, heading, and factor from the SI unit.
IN_SHORT = (
    ("length", "length mm", 1e3),
    ("link_mass", "mass g", 1e3),
    ("in_plane_thickness", "thick mm", 1e3),
    ("out_of_plane_width", "wide mm", 1e3),
    ("axial_stiffness", "EA MN", 1e-6),
    ("bending_stiffness", "EI N m²", 1.0),
    ("damping_time_bending", "damping µs", 1e6),
)
_OF_ANY_LINK = ("length", "link_mass")


def _cell(value: float, rigid: bool) -> str:
    """A number of four digits; what is not known of a rigid link is rigid."""
    if np.isnan(value):
        return "rigid" if rigid else "-"
    return plain(value)


class ModelCheck(Result):
    """Properties of a mechanism, and its natural frequencies at rest.

    Parameters
    ----------
    dataset : xarray.Dataset
        ``length``, ``link_mass`` and the properties of the sections over (link); ``frequency`` and
        ``discretisation_error`` (mode) at ``frequency_angle``, if the linkage can stand there; and
        what the picture shows, if it can stand somewhere: at ``posture_angle`` ``rigid_position``
        (link, station, component), ``joint_position`` (joint, component) and masses, over the turn
        ``path`` and ``transmission_angle``, and the layers of the sections.
    stored_as : mapping of str to str, optional
        Conventions, title, date and command line of the file that it was loaded from.
    """

    stem = "check"
    subject = "check"
    hallmark = "link_mass"
    files = ("check.csv", "check.nc")

    def tables(self) -> dict[str, pd.DataFrame]:
        """Every number of a link or mode with its unit, a row for each."""
        known = self.dataset
        rows = [
            (link, one.name, float(known[one.name].sel(link=link)), one.unit)
            for one in ROWS
            for link in known["link"].values
        ]
        for name, unit in (("frequency", "Hz"), ("discretisation_error", "1")):
            values = known[name].values if name in known else ()
            rows += [(f"mode {n}", name, float(one), unit) for n, one in enumerate(values, start=1)]
        return {"check": pd.DataFrame(rows, columns=["of", "quantity", "value", "unit"])}

    @property
    def remarks(self) -> tuple[str, ...]:
        """Remarks of an engineer on numbers that are possible but unusual."""
        return tuple(str(self.dataset.attrs.get("remarks", "")).splitlines())

    def plot(self, *, ax: plots.AxesLike | None = None) -> Figure:
        """Draw the mechanism: posture and paths, sections to scale, and transmission angle.

        Parameters
        ----------
        ax : sequence of matplotlib.axes.Axes, optional
            Three, or two for an arm, which has no transmission angle; of a new figure by default.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            If the linkage can be assembled at no crank angle, or the axes are too few or too many.
        """
        if "rigid_position" not in self.dataset:
            reason = self.dataset.attrs["without_frequencies"]
            raise InputError(f"no picture of the linkage: {reason}")
        return plots.plot_mechanism(self.dataset, ax=ax)

    def summary(self) -> Summary:
        """The linkage, its frequencies and links; source, all properties and masses; remarks."""
        attributes = self.dataset.attrs
        return Summary(
            self._answer(),
            self._links_in_short(),
            self._trust(),
            (
                attributes["mechanism"],
                f"source: {attributes['source']}",
                f"file: {attributes['model_file']}, SHA-256 {attributes['model_sha256']}",
                *attributes["linkage"].splitlines(),
                self._link_table(),
                *attributes["mechanism_lines"].splitlines(),
                *details_table(self._numbers()),
                *fewer_modes_lines(attributes),
                self._mesh_line(),
            ),
            self.remarks,
            self._numbers(),
        )

    def _answer(self) -> tuple[str, ...]:
        attributes = self.dataset.attrs
        said = (
            attributes.get("flutter", ""),
            attributes.get("linkage_in_short", ""),
            self._vibration(),
            self._undamped(),
        )
        return tuple(filter(None, said))

    def _vibration(self) -> str:
        """Natural frequencies at rest in a sentence."""
        angle = f"crank angle {np.degrees(self.dataset['frequency_angle'].item()):.6g} deg"
        texts = [str(number).removesuffix(" Hz") for number in self._frequencies()]
        if not texts:
            return (
                f"No natural frequencies at {angle}: {self.dataset.attrs['without_frequencies']}."
            )
        listed = ", ".join(texts[:-1]) + (" and " if len(texts) > 1 else "") + texts[-1]
        many = "frequencies are" if len(texts) > 1 else "frequency is"
        return f"The first natural {many} {listed} Hz, at rest and {angle}."

    def _undamped(self) -> str:
        """Remark that no link damps, where none does."""
        times = self.dataset["damping_time_bending"].values
        if not np.isfinite(times).any() or np.nanmax(times) > 0:
            return ""
        return "Without damping, resonances are unbounded: add damping to the links."

    def _frequencies(self) -> list[Quantity]:
        known = self.dataset
        if "frequency" not in known:
            return []
        frequency = known["frequency"].values
        error = known["discretisation_error"].values * frequency
        pairs = enumerate(zip(frequency.tolist(), error.tolist(), strict=True), start=1)
        name, unit = "natural_frequency", "Hz"
        return [Quantity(name, hz, unit, own, f"mode {mode}") for mode, (hz, own) in pairs]

    def _numbers(self) -> tuple[Quantity, ...]:
        numbers = self._frequencies()
        if "transmission_angle_limit" in self.dataset:
            limits = np.degrees(self.dataset["transmission_angle_limit"].values).tolist()
            for name, value in zip(("least", "greatest"), limits, strict=True):
                numbers.append(
                    Quantity(f"{name}_transmission_angle", value, "deg", ROUND_OFF * value)
                )
        grams = 1e3 * float(self.dataset["total_mass"])
        return (*numbers, Quantity("total_mass", grams, "g", ROUND_OFF * grams))

    def _trust(self) -> str:
        """How far the frequencies are known; there is nothing to doubt in what was read."""
        numbers = self._frequencies()
        if not numbers:
            return ""
        error = max(number.error / number.value if number.value else 0.0 for number in numbers)
        return trust_line([str(self.dataset.attrs["engine"])], error)

    def _mesh_line(self) -> str:
        """Engine and mesh of the natural frequencies at rest, or why there are none."""
        attributes = self.dataset.attrs
        made = f"{attributes['engine']} engine, {attributes['elements']} elements a link"
        angle = f"{np.degrees(self.dataset['frequency_angle'].item()):.6g} deg"
        reason = attributes["without_frequencies"]
        return f"natural frequencies at rest, crank angle {angle}: {reason or made}"

    def _links_in_short(self) -> Table:
        """A row for each link with what a designer chooses: size, mass, stiffness, damping."""
        known, rows = self.dataset, []
        without = np.isnan(known["axial_stiffness"].values)
        for number, link in enumerate(known["link"].values.tolist()):
            own = known.isel(link=number)
            cells = [
                _cell(float(own[name]) * scale, bool(without[number]) and name not in _OF_ANY_LINK)
                for name, _, scale in IN_SHORT
            ]
            rows.append((link, *cells))
        headings = ("link", *(heading for _, heading, _ in IN_SHORT))
        return Table(f"links: {known.attrs['mechanism']}", headings, (tuple(rows),))

    def _link_table(self) -> Table:
        """Properties of the links, a column for each; what no link has is left out."""
        rows = []
        without = np.isnan(self.dataset["axial_stiffness"].values)
        for one in ROWS:
            values = self.dataset[one.name].values
            if np.nan_to_num(values).any() or one.name.startswith("damping"):
                words, *numbers = one.row(values)
                if one in PROPERTIES:
                    numbers = [
                        "rigid" if rigid else number
                        for rigid, number in zip(without, numbers, strict=True)
                    ]
                rows.append((words, *numbers))
        return Table("links", ("property", *self.dataset["link"].values), (tuple(rows),))


@asks(CheckOptions)
def check_mechanism(mechanism: Engine | Mechanism, asked: CheckOptions) -> ModelCheck:
    """Check a mechanism: properties, natural frequencies at rest, and remarks.

    Parameters
    ----------
    mechanism : Mechanism or Engine
        Its reference engine, or this one, computes the frequencies.

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
    'transmission angle 32.21 to 81.33 deg leaves the usual 40 to 140 deg'
    """
    engine = engine_of(mechanism, elastic=False)
    mechanism, crank_angle = engine.mechanism, asked.crank_angle
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
    dataset["total_mass"] = mechanism.total_mass
    at = 0.0 if crank_angle is None else checked_number(crank_angle, "crank_angle", "rad")
    dataset["frequency_angle"] = at
    frequency = None
    try:
        known, fewer = as_many_modes(partial(_at_rest, engine, at), None)
        frequency, error, flutters = known
        dataset.attrs |= {"flutter": flutters, **fewer}
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


def _at_rest(engine: Engine, crank_angle: float, modes: int) -> tuple[FloatArray, FloatArray, str]:
    """Natural frequencies, their mesh error, and flutter in words; empty where no mode grows."""
    frequency = natural_frequencies(engine, crank_angle, modes=modes)
    systems, at = Systems(engine.fit_for(modes), Formulation(modes=modes)), np.array([crank_angle])
    with one_thread():
        error = mesh_error(systems, at, 0.0)
        flutters = flutter_at([systems], at, np.zeros(1), "rad/s")
    return frequency, error.frequency[0], flutters


def _hygrothermal_lines(mechanism: Mechanism) -> list[str]:
    """Keys that heat and moisture change, if there are any."""
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
        Crank angle of the posture in rad.

    Returns
    -------
    xarray.Dataset
        ``posture_angle``; ``rigid_position`` (link, station, component), ``joint_position``
        (joint, component), ``joint_mass`` (joint), ``point_mass`` and ``point_mass_position``
        (mass, component) where there are some, and ``path_position`` (path, component). Over the
        turn ``path`` (path, crank_angle, component) of the pins that move, an arm's tip and the
        coupler point; for a four-bar ``transmission_angle`` (crank_angle), not a number where the
        linkage cannot stand, ``transmission_angle_limit`` and ``usual_transmission_angle`` (limit).
        For the sections ``layer_low`` and ``layer_high`` in m, ``ply`` and ``ply_angle`` over
        (link, layer), and ``stacking`` and ``direction_of_layers`` (link), along whose direction
        the faces count.

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
