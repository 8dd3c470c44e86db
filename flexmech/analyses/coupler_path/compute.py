"""The paths of a coupler point, dry and in an environment, in one labelled dataset.

The result of coupler paths: their tables, pictures and words.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import ArrayLike

from flexmech import plots
from flexmech.analyses.datasets import DEGREES, origin
from flexmech.analyses.digits import Quantity, rounded
from flexmech.analyses.extremes import extremes
from flexmech.analyses.options import CouplerPathOptions
from flexmech.analyses.requests import asks, environment_of, in_radians
from flexmech.analyses.result import Result
from flexmech.analyses.schema import Values
from flexmech.analyses.summary import Summary, Table, environment_lines, state_name
from flexmech.arrays import ROUND_OFF, FloatArray
from flexmech.errors import InputError, suggestion
from flexmech.hygrothermal import (
    Environment,
    HygrothermalState,
    elongation_of,
    links_of_unknown_stiffness,
    rigid_linkage_in_state,
    without_softening,
)
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
from flexmech.mechanics import checked_mechanism
from flexmech.mechanism import Mechanism, drawing
from flexmech.validation import check_instance

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class CouplerPaths(Result):
    """Paths of a coupler point, dry and in an environment, with their crunodes and cusps.

    Parameters
    ----------
    dataset : xarray.Dataset
        The variables of ``schema.toml``: over ``state`` and ``crank_angle`` the ``position`` of the
        point, its link's pins and angle; of a four-bar's coupler also transmission angles, and
        crossings and cusps over ``double_point``; ``close_up`` of every path around the loops of
        any, and the places that are ``framed`` by it.
    stored_as : mapping of str to str, optional
        Conventions, title, date and command line of the file that it was loaded from.
    """

    stem = "coupler_curve"
    subject = "path of a coupler point"
    hallmark = "pin_position"
    significant_digits = 12
    digits = dict.fromkeys(
        ("theta3_deg", "theta4_deg", "coupler_curve.x_m", "coupler_curve.y_m"), 10
    )

    def tabulated(self) -> xr.Dataset:
        """The dataset with each angle and each passage by itself."""
        data = self.dataset
        passages = (data["double_point_crank_angle"].isel(passage=n, drop=True) for n in (0, 1))
        first, second = passages
        found = data.assign(
            first_passage=first,
            second_passage=second,
            name_of_double_point=data["name"]
            .sel(state=data["double_point_state"])
            .drop_vars("state"),
        )
        if not self.is_curve:
            return found.assign(angle_of_link=data["angle"])
        coupler, rocker = (data["angle"].isel(link=n, drop=True) for n in (0, 1))
        return found.assign(theta3=coupler, theta4=rocker)

    @property
    def is_curve(self) -> bool:
        """Whether it is of the coupler of a four-bar, whose double points are known."""
        return "sextic_residual" in self.dataset

    def plot(self, *, ax: plots.AxesLike | None = None) -> Figure:
        """Draw curves with their double points, in axes of the user's (one a panel) if given."""
        return plots.plot_coupler_curve(self.dataset, ax=ax)

    def summary(self) -> Summary:
        """Lengths, double points, changes, and the check by the sextic."""
        data = self.dataset
        topology = self.tables()["topology"]
        lines = data.attrs["environment_lines"].splitlines()
        for number, name in enumerate(data["name"].values):
            lines += _state_lines(data.isel(state=number), topology[topology["state"] == name])
        if data.sizes["state"] > 1:
            lines += _change_lines(*(data.isel(state=number) for number in (0, 1)))
        check = (
            "check: none, crossings are sought of the coupler of a four-bar alone, and not where "
            "its circuits meet in change points"
        )
        if self.is_curve:
            worst = float(data["sextic_residual"].max())
            check = f"check: the curve's sextic equation is met within {worst:.1e}"
        return Summary(
            tuple(_answer(data, self.is_curve)),
            _states_table(data),
            check,
            tuple(lines),
            tuple(filter(None, [data.attrs.get("warning")])),
            tuple(_numbers(data)),
        )


def _answer(data: xr.Dataset, is_curve: bool) -> Iterator[str]:
    """How large the path is, what crosses in it, and how far the point moves in an environment."""
    what = "coupler point" if is_curve else "point"
    for number, state in enumerate(data["state"].values.tolist()):
        size = _size(data.isel(state=number))
        counts = _counted(data, state) if is_curve else {}
        words = [
            f"{count or 'no'} {kind}{'' if count == 1 else 's'}" for kind, count in counts.items()
        ]
        who = f"The dry {what} covers" if number == 0 else f"At {state} it covers"
        loops = f", with {' and '.join(words)}" if words else ""
        yield f"{who} {' by '.join(size)} mm{loops}."
    if data.sizes["state"] > 1:
        moved, at = _moved(data)
        yield f"Its greatest shift is {moved:.3g} mm, at crank angle {at:.4g} deg."


def _states_table(data: xr.Dataset) -> Table:
    """A row for each state."""
    limits, rows = data.get("transmission_angle_limit"), []
    for number, state in enumerate(data["state"].values.tolist()):
        of_state = data.isel(state=number)
        x, y = (1e3 * of_state["extent"]).transpose("component", "bound").values.tolist()
        cells = [_text(value, of_state) for value in (*x, *y)]
        if limits is not None:
            angles = DEGREES * limits.isel(state=number).values
            counts = _counted(data, state)
            cells += [*map(str, counts.values()), *(f"{angle:.4g}" for angle in angles)]
        rows.append((state, *cells))
    headings = ["state", "least x mm", "greatest x mm", "least y mm", "greatest y mm"]
    if limits is not None:
        headings += ["crunodes", "cusps", "least µ deg", "greatest µ deg"]
    caption = "" if limits is None else "µ: transmission angle over the whole motion"
    return Table(
        f"path: {data.attrs['mechanism']}", tuple(headings), (tuple(rows),), caption=caption
    )


def _counted(data: xr.Dataset, state: str) -> dict[str, int]:
    """Number of crunodes and of cusps in a state."""
    kinds = data["double_point_kind"].values[data["double_point_state"].values == state]
    return {kind: int((kinds == kind).sum()) for kind in ("crunode", "cusp")}


def _size(state: xr.Dataset) -> list[str]:
    """Extents of a path along x and y in mm."""
    extent = 1e3 * state["extent"].transpose("component", "bound").values
    return [_text(high - low, state) for low, high in extent.tolist()]


def _text(value: float, state: xr.Dataset) -> str:
    """A coordinate in mm; what rounding leaves of a zero is none."""
    noise = 1e3 * ROUND_OFF * float(abs(state["position"]).max())
    return "0" if abs(value) <= noise else rounded(value, noise)


def _moved(data: xr.Dataset) -> tuple[float, float]:
    """Greatest displacement of the point in mm, and the crank angle in degrees."""
    dry, wet = (data["position"].isel(state=number) for number in (0, 1))
    apart = 1e3 * np.hypot(*(wet - dry).transpose("component", ...).values)
    place = int(apart.argmax())
    return float(apart[place]), float(DEGREES * data["crank_angle"].values[place])


def _numbers(data: xr.Dataset) -> Iterator[Quantity]:
    """Extents of each state, its double points and transmission angles, and the displacement."""
    for number, state in enumerate(data["state"].values.tolist()):
        of_state = data.isel(state=number)
        noise = 1e3 * ROUND_OFF * float(abs(of_state["position"]).max())
        for axis, (low, high) in zip("xy", 1e3 * of_state["extent"].values, strict=True):
            yield Quantity(f"extent_{axis}", float(high - low), "mm", noise, state)
        if "transmission_angle_limit" in data:
            for kind, count in _counted(data, state).items():
                yield Quantity(f"{kind}s", count, "", 0.0, state)
            for name, value in zip(
                ("least", "greatest"), of_state["transmission_angle_limit"].values, strict=True
            ):
                angle = float(DEGREES * value)
                yield Quantity(f"{name}_transmission_angle", angle, "deg", ROUND_OFF * angle, state)
    if data.sizes["state"] > 1:
        yield Quantity("greatest_displacement", _moved(data)[0], "mm")


def _state_lines(state: xr.Dataset, topology: pd.DataFrame) -> list[str]:
    """Lengths and double points of one state."""
    name, distance = state["name"].item(), 1e3 * state["coupler_point_distance"].item()
    lengths = (1e3 * state["length"]).to_series().items()
    named = ", ".join(f"{member} {length:.6g}" for member, length in lengths)
    if "sextic_residual" not in state:
        link = state["link"].values[0]
        return [f"{name}: {named}, point {distance:.6g} mm from the start of the {link}"]
    counts = {kind: int((topology["kind"] == kind).sum()) for kind in ("crunode", "cusp")}
    words = [f"{count} {kind}{'' if count == 1 else 's'}" for kind, count in counts.items()]
    least, greatest = DEGREES * state["transmission_angle_limit"].values
    linkage, where = FourBar(*state["length"].values.tolist()), ""
    if not linkage.crank_turns_fully:
        where = f" on the whole circuit, both branches ({linkage.grashof_class})"
    return [
        f"{name}: {named}, coupler point {distance:.6g} mm from A",
        f"{name}: transmission angle {least:.5g} to {greatest:.5g} deg",
        f"{name}: {' and '.join(words)}{where}",
        *(
            f"{name}: {kind} at ({1e3 * x:.6g}, {1e3 * y:.6g}) mm, crank angles {first:.6g} and "
            f"{second:.6g} deg"
            for _, _, kind, first, second, x, y in topology.itertuples()
        ),
    ]


def _change_lines(dry: xr.Dataset, wet: xr.Dataset) -> list[str]:
    """Greatest changes from the dry linkage to the wet one."""
    at, lines = DEGREES * dry["crank_angle"].values, []
    symbols = {"coupler": "theta3", "rocker": "theta4"}
    for link in dry["link"].values.tolist():
        symbol = symbols[link] if "sextic_residual" in dry else f"the angle of {link}"
        turned = (wet["angle"] - dry["angle"]).sel(link=link).values
        change = np.degrees(np.angle(np.exp(1j * turned)))
        low, high = change.argmin(), change.argmax()
        lines.append(
            f"change of {symbol}: {change[low]:+.5f} deg (at {at[low]:g} deg) to "
            f"{change[high]:+.5f} deg (at {at[high]:g} deg)"
        )
    what = "coupler point" if "sextic_residual" in dry else "point"
    moved = 1e3 * np.hypot(*(wet["position"] - dry["position"]).values.T)
    return [
        *lines,
        f"{what}: moved by at most {moved.max():.5g} mm, at crank angle {at[moved.argmax()]:g} deg",
    ]


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
        ends = extremes(self.position, np.unique(crank_angles))
        return np.stack([ends.least, ends.greatest], axis=1)

    def values(self, crank_angles: FloatArray, windows: FloatArray) -> Values:
        """The path, and what it does between pairs of crank angles (W, 2), finely drawn."""
        topology, motion = self.linkage.topology, self.linkage.motion(crank_angles)
        body, position = topology.links[self.link], self._position(motion)
        pins = [motion.position(self.link, x) for x in (0.0, body.length)]
        # A four-bar's coupler is shown with the rocker, and with all members.
        members = slice(self.link, self.link + (2 if self.is_curve else 1))
        lengths = {link.name: link.length for link in topology.links}
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


@asks(CouplerPathOptions)
def coupler_paths(mechanism: Mechanism, asked: CouplerPathOptions) -> CouplerPaths:
    """Path of a point of the coupler, or of another link, dry and in an environment.

    Crunodes, cusps and the check by the curve's equation are of the coupler of a four-bar without
    change points, where circuits meet; of other links and linkages the path itself is given.

    Parameters
    ----------
    mechanism : Mechanism
        Dry.

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
    >>> paths = flexmech.coupler_paths(mechanism, environment=wet)
    >>> paths.dataset["double_point_state"].values.tolist()  # the wet curve has no loop
    ['dry']
    """
    mechanism, warning = checked_mechanism(mechanism), ""
    angles, environment = in_radians("crank_angles", asked.crank_angles), asked.environment
    if angles.ndim != 1 or not angles.size:
        raise InputError(f"crank_angles must be a row of one or more, got shape {angles.shape}")
    point, link = _point_of(mechanism, asked.point), _link_named(mechanism.linkage, asked.link)

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
    """Warning on a path whose links are above their glass transition."""
    named = " and ".join(filter(None, [", ".join(links[:-1]), links[-1]]))
    return (
        f"the resin of {named} is above its wet glass transition, or beyond the moisture for which "
        "that rule holds: its stiffness is unknown. The path needs none: it is that of "
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
