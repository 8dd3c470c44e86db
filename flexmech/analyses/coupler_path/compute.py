"""The paths of a coupler point, dry and in an environment, in one labelled dataset."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import ArrayLike

from flexmech.analyses.coupler_path.result import CouplerPaths
from flexmech.analyses.environment import environment_lines
from flexmech.analyses.provenance import origin
from flexmech.analyses.requests import environment_of, in_radians, mechanism_of
from flexmech.errors import InputError
from flexmech.hygrothermal import (
    Environment,
    HygrothermalState,
    coupler_point_in_state,
    linkage_in_state,
)
from flexmech.linkages import (
    CouplerCurve,
    CouplerPoint,
    DoublePoint,
    coupler_sextic,
    double_points,
)
from flexmech.mechanism import Mechanism
from flexmech.types import FloatArray

__all__ = ["coupler_paths"]

# Points of a finely drawn loop.
FINE = 400
METRE, RADIAN = {"units": "m"}, {"units": "rad"}


@dataclass(frozen=True)
class CouplerPath:
    """The path of a coupler point of the rigid linkage in one environment.

    Parameters
    ----------
    curve : CouplerCurve
        With linkage and point as they are in the environment.
    crank_angle : ndarray, shape (A,)
        In rad.
    double_points : tuple of DoublePoint
        Crunodes and cusps of the whole curve, whatever the crank angles.
    """

    curve: CouplerCurve
    crank_angle: FloatArray
    double_points: tuple[DoublePoint, ...]

    @classmethod
    def of(
        cls,
        mechanism: Mechanism,
        point: CouplerPoint,
        environment: Environment,
        crank_angle: FloatArray,
    ) -> Self:
        """Path of a point of the dry coupler in an environment.

        Parameters
        ----------
        mechanism : Mechanism
            Of a four-bar, dry.
        point : CouplerPoint
        environment : HygrothermalState or Exposure
        crank_angle : ndarray, shape (A,)
            In rad.

        Returns
        -------
        CouplerPath

        Raises
        ------
        InputError
            If the linkage is no four-bar, cannot be assembled at a crank angle, or as
            :func:`flexmech.hygrothermal.swollen_links`.
        """
        linkage = linkage_in_state(mechanism, environment)
        moved = coupler_point_in_state(mechanism, point, environment)
        linkage.motion(crank_angle)  # refuses angles that the linkage does not reach
        found = double_points(linkage, moved, float(crank_angle[0]))
        return cls(CouplerCurve(linkage, moved), crank_angle, found)

    @property
    def passages(self) -> FloatArray:
        """Crank angles of both passages of each double point in rad, by the shorter way, (D, 2).

        The first is below zero where the way leads through crank angle zero.
        """
        angles = np.reshape([double.crank_angles for double in self.double_points], (-1, 2))
        through_zero = angles[:, 1] - angles[:, 0] > np.pi
        angles[through_zero] = angles[through_zero][:, ::-1] - [2 * np.pi, 0.0]
        return angles

    def dataset(self, windows: FloatArray) -> xr.Dataset:
        """Everything that there is of one environment.

        Parameters
        ----------
        windows : ndarray, shape (W, 2)
            Crank angles between which the path is close to a loop of any environment's.

        Returns
        -------
        xarray.Dataset
        """
        linkage, point = self.curve.linkage, self.curve.point
        motion, position = linkage.motion(self.crank_angle), self.curve.position(self.crank_angle)
        pins = [motion.position(0, linkage.crank), motion.position(2, linkage.rocker)]
        residual = np.abs(coupler_sextic(linkage, point, position)).max()
        variables = {
            "position": (("crank_angle", "component"), position, METRE),
            "pin_position": (("pin", "crank_angle", "component"), pins, METRE),
            "angle": (("crank_angle", "link"), np.unwrap(motion.angle[:, 1:], axis=0), RADIAN),
            "length": ("member", [*linkage.lengths.values()], METRE),
            "coupler_point_distance": ((), point.distance, METRE),
            "coupler_point_angle": ((), point.angle, RADIAN),
            "grashof_class": ((), linkage.grashof_class),
            "crank_turns_fully": ((), linkage.crank_turns_fully),
            "sextic_residual": ((), residual, {"units": "1"}),
        }
        if windows.size:
            start, stop = windows.T
            angles = np.linspace(start - (stop - start), stop + (stop - start), FINE, axis=1)
            place = self.curve.position(angles)
            variables["close_up"] = (("window", "point", "component"), place, METRE)
        coordinates = {
            "crank_angle": ("crank_angle", self.crank_angle, RADIAN),
            "component": ["x", "y"],
            "pin": ["A", "B"],
            "link": ["coupler", "rocker"],
            "member": list(linkage.lengths),
        }
        return xr.Dataset(variables, coordinates)


def coupler_paths(
    mechanism: Mechanism,
    crank_angles: ArrayLike,
    point: CouplerPoint | None = None,
    environment: Environment | None = None,
) -> CouplerPaths:
    """Path of a coupler point of the rigid linkage, dry and in an environment.

    Parameters
    ----------
    mechanism : Mechanism
        Of a four-bar, dry.
    crank_angles : array_like, shape (A,)
        In rad.
    point : CouplerPoint, optional
        On the dry coupler; that of the mechanism if left out.
    environment : HygrothermalState or Exposure, optional
        Compared with the dry linkage, if given.

    Returns
    -------
    CouplerPaths

    Raises
    ------
    InputError
        If there is no point, the linkage is no four-bar or cannot be assembled at a crank angle,
        or as :func:`flexmech.hygrothermal.swollen_links`.
    """
    mechanism = mechanism_of(mechanism)
    angles = in_radians("crank_angles", crank_angles)
    if angles.ndim != 1 or not angles.size:
        raise InputError(f"crank_angles must be a row of one or more, got shape {angles.shape}")
    given = _point_of(mechanism, point)
    paths = {"dry": CouplerPath.of(mechanism, given, HygrothermalState(), angles)}
    if environment is not None:
        label = environment_of(environment).label
        try:
            found = CouplerPath.of(mechanism, given, environment, angles)
        except InputError as error:
            # The dry linkage has passed: the environment is the cause.
            raise error.within(label) from error
        # An environment without heat and moisture is labelled dry too.
        paths["wet" if label == "dry" else label] = found
    lines = "\n".join(environment_lines(mechanism, environment))
    attributes = {**origin(mechanism), "environment_lines": lines}
    return CouplerPaths(_dataset(paths).assign_attrs(attributes))


def _point_of(mechanism: Mechanism, given: CouplerPoint | None) -> CouplerPoint:
    point = mechanism.coupler_point if given is None else given
    if point is None:
        file = mechanism.provenance.file or "mechanism"
        raise InputError(
            f"{file}: linkage.coupler_point: is missing; add coupler_point = "
            '{ distance = "33 mm", angle = "320 deg" }, or ask for a point'
        )
    if not isinstance(point, CouplerPoint):
        raise InputError(
            f"point must be a coupler point, got {point!r:.80}; write "
            "flexmech.CouplerPoint(0.033, np.radians(320))"
        )
    return point


def _dataset(paths: dict[str, CouplerPath]) -> xr.Dataset:
    every = list(paths.values())
    windows = np.concatenate([path.passages for path in every])
    # Every state's curve is drawn around every state's loops: all must reach there.
    if not all(path.curve.linkage.crank_turns_fully for path in every):
        windows = windows[:0]
    states = [path.dataset(windows) for path in every]
    dataset = xr.concat(states, pd.Index(list(paths), name="state"))
    doubles = [(state, double) for state, path in paths.items() for double in path.double_points]
    names = np.array([(state, double.kind) for state, double in doubles], dtype=str)
    named_state, kind = names.reshape(-1, 2).T
    position = np.reshape([double.position for _, double in doubles], (-1, 2))
    crank_angle = np.reshape([double.crank_angles for _, double in doubles], (-1, 2))
    of_double = "double_point"
    dataset["double_point_position"] = ((of_double, "component"), position, METRE)
    dataset["double_point_crank_angle"] = ((of_double, "passage"), crank_angle, RADIAN)
    if windows.size:
        middles = windows.mean(axis=1)
        framed = [
            path.curve.position(np.concatenate([middles, np.linspace(*own, FINE)]))
            for path in every
            for own in path.passages
        ]
        dataset["framed"] = (("framed_place", "component"), np.concatenate(framed), METRE)
    return dataset.assign_coords(
        double_point_state=(of_double, named_state), double_point_kind=(of_double, kind)
    )
