"""The paths of a coupler point, dry and in an environment, in one labelled dataset."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from flexmech.analyses.coupler_path.any_link import link_named, path_of_link
from flexmech.analyses.coupler_path.result import CouplerPaths
from flexmech.analyses.datasets import origin
from flexmech.analyses.remarks import environment_lines, state_name
from flexmech.analyses.requests import environment_of, in_radians
from flexmech.errors import InputError
from flexmech.hygrothermal import (
    Environment,
    HygrothermalState,
    coupler_point_in_state,
    linkage_in_state,
    links_of_unknown_stiffness,
    without_softening,
)
from flexmech.linear_system import checked_mechanism
from flexmech.linkages import (
    CouplerCurve,
    CouplerPoint,
    DoublePoint,
    FourBar,
    coupler_sextic,
    double_points,
    shown_crank_angle,
)
from flexmech.mechanism import Mechanism, drawing
from flexmech.types import FloatArray

# Points of a finely drawn loop.
FINE = 400
METRE, RADIAN = {"units": "m"}, {"units": "rad"}


class Path(NamedTuple):
    """The curve of a coupler point in one environment, with all crunodes and cusps that it has."""

    curve: CouplerCurve
    double_points: tuple[DoublePoint, ...]

    @property
    def passages(self) -> FloatArray:
        """Crank angles of both passages of each double point in rad, by the shorter way, (D, 2).

        The first is below zero where the way leads through crank angle zero.
        """
        angles = np.reshape([double.crank_angles for double in self.double_points], (-1, 2))
        through_zero = angles[:, 1] - angles[:, 0] > np.pi
        angles[through_zero] = angles[through_zero][:, ::-1] - [2 * np.pi, 0.0]
        return angles


def coupler_paths(
    mechanism: Mechanism,
    crank_angles: ArrayLike,
    point: CouplerPoint | None = None,
    environment: Environment | None = None,
    *,
    link: str = "coupler",
) -> CouplerPaths:
    """Path of a point of the coupler, or of another link, dry and in an environment.

    Crunodes, cusps and the check by the curve's equation are of the coupler of a four-bar; of
    other links and linkages the path itself is given.

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
    point, link = _point_of(mechanism, point), link_named(mechanism.linkage, link)
    curve = link == "coupler" and isinstance(mechanism.linkage, FourBar)

    def of(owner: Mechanism, state: Environment) -> Path | xr.Dataset:
        if curve:
            return _path(owner, point, state, angles)
        return path_of_link(owner, link, point, state, angles)

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
    lines = environment_lines(mechanism, environment, lengths_alone=bool(warning))
    attributes = {
        **origin(mechanism),
        "drawing": drawing(mechanism, _shown(mechanism, angles)),
        "environment_lines": "\n".join(lines),
        "warning": warning,
    }
    curves = {state: path for state, path in paths.items() if isinstance(path, Path)}
    others = [path for path in paths.values() if not isinstance(path, Path)]
    dataset = _dataset(curves, angles) if curves else _without_double_points(others, list(paths))
    return CouplerPaths(dataset.assign_attrs(attributes))


def _shown(mechanism: Mechanism, angles: FloatArray) -> float:
    """The crank angle of the path at which a picture shows the linkage best."""
    best = shown_crank_angle(mechanism.linkage)
    return float(angles[np.argmin(np.abs(angles - best))])


def _without_double_points(states: Sequence[xr.Dataset], names: Sequence[str]) -> xr.Dataset:
    """Paths of a point whose crossings are not sought, in the form of those of a coupler."""
    empty: dict[str, Any] = {
        "double_point_position": (("double_point", "component"), np.empty((0, 2)), METRE),
        "double_point_crank_angle": (("double_point", "passage"), np.empty((0, 2)), RADIAN),
    }
    coordinates = {
        "state": list(names),
        "name": ("state", ["dry", "wet"][: len(states)]),
        "double_point_state": ("double_point", np.empty(0, dtype=str)),
        "double_point_kind": ("double_point", np.empty(0, dtype=str)),
    }
    return xr.concat(states, "state").assign(empty).assign_coords(coordinates)


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
    file = mechanism.provenance.file or "mechanism"
    if point is None and not isinstance(mechanism.linkage, FourBar):
        raise InputError(
            f"{file}: of what point is not said; ask for one by its distance from the link's first "
            'joint and the angle from its line, as --point "33 mm,320 deg"'
        )
    if point is None:
        raise InputError(
            f"{file}: linkage.coupler_point: is missing; add "
            'coupler_point = { distance = "33 mm", angle = "320 deg" }, or ask for a point'
        )
    if not isinstance(point, CouplerPoint):
        raise InputError(
            f"point must be a coupler point, got {point!r:.80}; write "
            "flexmech.CouplerPoint(0.033, np.radians(320))"
        )
    return point


def _path(
    mechanism: Mechanism, point: CouplerPoint, environment: Environment, crank_angles: FloatArray
) -> Path:
    """Path of a point of the dry coupler, with linkage and coupler as the environment has them."""
    linkage = linkage_in_state(mechanism, environment)
    moved = coupler_point_in_state(mechanism, point, environment)
    linkage.motion(crank_angles)  # refuses angles that the linkage does not reach
    found = double_points(linkage, moved, float(crank_angles[0]))
    return Path(CouplerCurve(linkage, moved), found)


def _dataset(paths: Mapping[str, Path], crank_angles: FloatArray) -> xr.Dataset:
    every = list(paths.values())
    windows = np.concatenate([path.passages for path in every])
    # Every state's curve is drawn around every state's loops: all must reach there.
    if not all(path.curve.linkage.crank_turns_fully for path in every):
        windows = windows[:0]
    states = [_state(path.curve, crank_angles, windows) for path in every]
    doubles = [(state, double) for state, path in paths.items() for double in path.double_points]
    position = np.reshape([double.position for _, double in doubles], (-1, 2))
    angles = np.reshape([double.crank_angles for _, double in doubles], (-1, 2))
    named = np.array([(state, double.kind) for state, double in doubles], dtype=str)
    variables: dict[str, Any] = {
        "double_point_position": (("double_point", "component"), position, METRE),
        "double_point_crank_angle": (("double_point", "passage"), angles, RADIAN),
    }
    if windows.size:
        framed = [path.curve.position(windows.mean(axis=1)) for path in every]
        framed += [p.curve.position(np.linspace(a, b, FINE)) for p in every for a, b in p.passages]
        variables["framed"] = (("framed_place", "component"), np.concatenate(framed), METRE)
    coordinates = {
        "state": list(paths),
        "name": ("state", ["dry", "wet"][: len(every)]),
        "double_point_state": ("double_point", named.reshape(-1, 2)[:, 0]),
        "double_point_kind": ("double_point", named.reshape(-1, 2)[:, 1]),
    }
    return xr.concat(states, "state").assign(variables).assign_coords(coordinates)


def _state(curve: CouplerCurve, crank_angles: FloatArray, windows: FloatArray) -> xr.Dataset:
    """The path in one state, and what it does between pairs of crank angles, finely drawn."""
    linkage, position = curve.linkage, curve.position(crank_angles)
    motion = linkage.motion(crank_angles)
    pins = [motion.position(0, linkage.crank), motion.position(2, linkage.rocker)]
    residual = np.abs(coupler_sextic(linkage, curve.point, position)).max()
    angle = np.unwrap(motion.angle[:, 1:], axis=0)
    over = "crank_angle"
    limits = linkage.transmission_angle_limits()
    variables: dict[str, Any] = {
        "transmission_angle": ((over,), linkage.transmission_angle(crank_angles), RADIAN),
        "transmission_angle_limit": (("limit",), [*limits], RADIAN),
        "position": ((over, "component"), position, METRE),
        "pin_position": ((over, "pin", "component"), np.stack(pins, axis=1), METRE),
        "angle": ((over, "link"), angle, RADIAN),
        "length": ("member", [*linkage.lengths.values()], METRE),
        "coupler_point_distance": ((), curve.point.distance, METRE),
        "sextic_residual": ((), residual, {"units": "1"}),
    }
    if windows.size:
        around = [np.linspace(a - (b - a), b + (b - a), FINE) for a, b in windows]
        variables["close_up"] = (("window", "point", "component"), curve.position(around), METRE)
    coordinates = {
        "crank_angle": (over, crank_angles, RADIAN),
        "component": ["x", "y"],
        "pin": ["A", "B"],
        "link": ["coupler", "rocker"],
        "member": list(linkage.lengths),
        "limit": ["least", "greatest"],
    }
    return xr.Dataset(variables, coordinates)
