"""The paths of a coupler point, dry and in an environment, in one labelled dataset."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from flexmech.analyses.coupler_path.result import CouplerPaths
from flexmech.analyses.datasets import origin
from flexmech.analyses.extremes import extremes
from flexmech.analyses.remarks import environment_lines, state_name
from flexmech.analyses.requests import environment_of, in_radians
from flexmech.analyses.schema import Values
from flexmech.arrays import FloatArray
from flexmech.errors import InputError, suggestion
from flexmech.hygrothermal import (
    Environment,
    HygrothermalState,
    elongation_of,
    links_of_unknown_stiffness,
    rigid_linkage_in_state,
    without_softening,
)
from flexmech.linear_system import checked_mechanism
from flexmech.linkages import (
    CouplerPoint,
    DoublePoint,
    FourBar,
    Linkage,
    PlanarLinkage,
    RigidMotion,
    coupler_sextic,
    double_points,
    picture_crank_angle,
)
from flexmech.linkages.motion import direction
from flexmech.mechanism import Mechanism, drawing
from flexmech.validation import check_instance

# Points of a finely drawn loop: the straight lines between them leave the curve by a hundredth of a
# printer's dot.
_FINE = 400


@dataclass(frozen=True)
class _Path:
    """The path of a point of a link in one environment.

    Parameters
    ----------
    linkage : Linkage
    link : int
        That carries the point.
    point : CouplerPoint
        By its distance from the link's start and the angle from the link's line.
    is_curve : bool
        Whether it is the curve of a four-bar's coupler, in circuits that do not meet.
    double_points : tuple of DoublePoint
        All crunodes and cusps of such a curve; of other paths none are sought.
    """

    linkage: Linkage
    link: int
    point: CouplerPoint
    is_curve: bool = False
    double_points: tuple[DoublePoint, ...] = ()

    @property
    def passages(self) -> FloatArray:
        """Crank angles of both passages of each double point in rad, by the shorter way, (D, 2).

        The first is below zero where the way leads through crank angle zero.
        """
        angles = np.reshape([double.crank_angles for double in self.double_points], (-1, 2))
        through_zero = angles[:, 1] - angles[:, 0] > np.pi
        angles[through_zero] = angles[through_zero][:, ::-1] - [2 * np.pi, 0.0]
        return angles

    def position(self, crank_angles: ArrayLike) -> FloatArray:
        """Places of the point in m at crank angles (...); (..., 2)."""
        return self._position(self.linkage.motion(crank_angles))

    def _position(self, motion: RigidMotion) -> FloatArray:
        arm = self.point.distance * direction(motion.angle[..., self.link] + self.point.angle)
        return np.asarray(motion.origin[..., self.link, :] + arm)

    def _extent(self, crank_angles: FloatArray) -> FloatArray:
        """Least and greatest coordinates from the first crank angle to the last, (2, 2) in m."""
        angles = np.unique(crank_angles)
        try:
            found = extremes(self.position, angles)
        except InputError:
            # The linkage does not reach all angles between them.
            found = extremes(self.position, angles, between=False)
        return np.stack([found.least, found.greatest], axis=1)

    def values(self, crank_angles: FloatArray, windows: FloatArray) -> Values:
        """The path, and what it does between pairs of crank angles (W, 2), finely drawn."""
        topology, motion = self.linkage.topology, self.linkage.motion(crank_angles)
        body, position = topology.links[self.link], self._position(motion)
        pins = [motion.position(self.link, x) for x in (0.0, body.length)]
        # A four-bar's coupler is shown with the rocker, and with all members.
        members = slice(self.link, self.link + (2 if self.is_curve else 1))
        lengths = {own.name: own.length for own in topology.links}
        values: Values = {
            "position": position,
            "pin_position": np.stack(pins, axis=1),
            "angle": np.unwrap(motion.angle[:, members], axis=0),
            "coupler_point_distance": self.point.distance,
            "extent": self._extent(crank_angles),
            "crank_angle": crank_angles,
            "component": ["x", "y"],
            "bound": ["least", "greatest"],
            "pin": ["A", "B"] if self.is_curve else ["start", "end"],
            "link": list(topology.link_names[members]),
        }
        if isinstance(self.linkage, FourBar) and self.is_curve:
            lengths = dict(self.linkage.lengths)
            residual = np.abs(coupler_sextic(self.linkage, self.point, position)).max()
            values |= {
                "transmission_angle": self.linkage.transmission_angle(crank_angles),
                "transmission_angle_limit": [*self.linkage.transmission_angle_limits()],
                "sextic_residual": residual,
                "limit": ["least", "greatest"],
            }
        if windows.size:
            around = [np.linspace(a - (b - a), b + (b - a), _FINE) for a, b in windows]
            values["close_up"] = self.position(around)
        return values | {"length": [*lengths.values()], "member": list(lengths)}


def coupler_paths(
    mechanism: Mechanism,
    crank_angles: ArrayLike,
    point: CouplerPoint | None = None,
    environment: Environment | None = None,
    *,
    link: str = "coupler",
) -> CouplerPaths:
    """Path of a point of the coupler, or of another link, dry and in an environment.

    Crunodes, cusps and the check by the curve's equation are of the coupler of a four-bar without
    change points, where circuits meet; of other links and linkages the path itself is given.

    Parameters
    ----------
    mechanism : Mechanism
        Dry.
    crank_angles : array_like, shape (A,)
        In rad.
    point : CouplerPoint, optional
        On the dry link, from its first joint; that of the mechanism if left out.
    environment : HygrothermalState or Exposure, optional
        Compared with the dry linkage, if given. The path needs no modulus: above the wet glass
        transition of a resin it is drawn with a warning.
    link : str
        That the point is on; of a chain of beams the first one counts.

    Returns
    -------
    CouplerPaths

    Raises
    ------
    InputError
        If there is no point or no such link, the linkage cannot be assembled at a crank angle, or
        as :func:`flexmech.hygrothermal.swollen_links`.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/neat_resin_figure_8.toml")
    >>> wet = flexmech.HygrothermalState(temperature_rise=80.0, moisture=0.07)
    >>> paths = flexmech.coupler_paths(mechanism, np.radians(range(361)), environment=wet)
    >>> paths.dataset["double_point_state"].values.tolist()  # the wet curve has no loop
    ['dry']
    """
    mechanism, warning = checked_mechanism(mechanism), ""
    angles = in_radians("crank_angles", crank_angles)
    if angles.ndim != 1 or not angles.size:
        raise InputError(f"crank_angles must be a row of one or more, got shape {angles.shape}")
    point, link = _point_of(mechanism, point), _link_named(mechanism.linkage, link)

    def of(owner: Mechanism, state: Environment) -> _Path:
        return _path(owner, link, point, state, angles)

    paths = {"dry": of(mechanism, HygrothermalState())}
    if environment is not None:
        label = environment_of(environment).label
        try:
            rubber = links_of_unknown_stiffness(mechanism, environment)
            if rubber:
                warning = f"{label}: {_of_rubber(rubber)}"
                mechanism = without_softening(mechanism)
            found = of(mechanism, environment)
        except InputError as error:
            # The dry linkage has passed: the environment is the cause.
            raise error.within(label) from error
        paths[state_name(environment)] = found
    if not all(path.is_curve for path in paths.values()):
        # States are compared in what all of them have.
        paths = {name: replace(p, is_curve=False, double_points=()) for name, p in paths.items()}
    lines = environment_lines(mechanism, environment, lengths_alone=bool(warning))
    attributes = {
        **origin(mechanism),
        "drawing": drawing(mechanism, _picture_angle(mechanism, angles)),
        "environment_lines": "\n".join(lines),
        "warning": warning,
    }
    return CouplerPaths(_dataset(paths, angles).assign_attrs(attributes))


def _picture_angle(mechanism: Mechanism, angles: FloatArray) -> float:
    """The crank angle of the path at which a picture shows the linkage best."""
    best = picture_crank_angle(mechanism.linkage)
    return float(angles[np.argmin(np.abs(angles - best))])


def _of_rubber(links: Sequence[str]) -> str:
    """What a path is worth whose links are above their glass transition."""
    named = " and ".join(filter(None, [", ".join(links[:-1]), links[-1]]))
    return (
        f"the resin of {named} is above its wet glass transition, or moister than the rule of that "
        "transition holds for: its stiffness is not known. The path needs none: it is that of "
        "links that swell by the stated expansions, with fibres as at the reference temperature"
    )


def _point_of(mechanism: Mechanism, given: CouplerPoint | None) -> CouplerPoint:
    point = mechanism.coupler_point if given is None else given
    if point is None and not isinstance(mechanism.linkage, FourBar):
        raise InputError(
            "point: is left out; give one by its distance from the link's first joint and the "
            'angle from its line, as --point "33 mm,320 deg"'
        )
    if point is None:
        raise InputError(
            "linkage.coupler_point: is missing; add "
            'coupler_point = { distance = "33 mm", angle = "320 deg" }, or ask for a point'
        )
    if not isinstance(point, CouplerPoint):
        raise InputError(
            f"point must be a coupler point, got {point!r:.80}; write "
            "flexmech.CouplerPoint(0.033, np.radians(320))"
        )
    return point


def _path(
    mechanism: Mechanism,
    link: str,
    point: CouplerPoint,
    environment: Environment,
    crank_angles: FloatArray,
) -> _Path:
    """Path of a point of a dry link, with linkage and link as the environment has them."""
    linkage = rigid_linkage_in_state(mechanism, environment)
    if environment != HygrothermalState():
        point = point.scaled(1 + elongation_of(mechanism, link, environment))
    number = linkage.topology.index(link)
    linkage.motion(crank_angles)  # refuses angles that the linkage does not reach
    if link != "coupler" or not isinstance(linkage, FourBar) or linkage.change_angles.size:
        return _Path(linkage, number, point)
    doubles = double_points(linkage, point, float(crank_angles[0]))
    return _Path(linkage, number, point, True, doubles)


def _dataset(paths: Mapping[str, _Path], crank_angles: FloatArray) -> xr.Dataset:
    every = list(paths.values())
    windows = np.concatenate([path.passages for path in every])
    # Every state's curve is drawn around every state's loops: all must reach there.
    if not all(isinstance(p.linkage, FourBar) and p.linkage.crank_turns_fully for p in every):
        windows = windows[:0]
    doubles = [(state, double) for state, path in paths.items() for double in path.double_points]
    named = np.array([(state, double.kind) for state, double in doubles], dtype=str)
    values: Values = {
        "double_point_position": np.reshape([double.position for _, double in doubles], (-1, 2)),
        "double_point_crank_angle": np.reshape([one.crank_angles for _, one in doubles], (-1, 2)),
        "state": list(paths),
        "name": ["dry", "wet"][: len(every)],
        "double_point_state": named.reshape(-1, 2)[:, 0],
        "double_point_kind": named.reshape(-1, 2)[:, 1],
    }
    if windows.size:
        framed = [path.position(windows.mean(axis=1)) for path in every]
        framed += [p.position(np.linspace(a, b, _FINE)) for p in every for a, b in p.passages]
        values["framed"] = np.concatenate(framed)
    states = [path.values(crank_angles, windows) for path in every]
    return CouplerPaths.schema().dataset(values, parts=states, along="state")


def _link_named(linkage: Linkage, link: str) -> str:
    """Link of the topology by its name, or the first one of a chain of beams."""
    check_instance(link, str, "link", "give the name of a link, such as 'coupler'")
    chains = {}
    if isinstance(linkage, PlanarLinkage):
        chains = {drawn.name: drawn.beams[0].name for drawn in linkage.links}
    known = linkage.topology.link_names
    if link in known:
        return link
    if link not in chains:
        names = list(dict.fromkeys([*chains, *known]))
        raise InputError(f"the linkage has no link {link!r}; {suggestion(link, names)}")
    return chains[link]
