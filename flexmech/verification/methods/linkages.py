"""Rigid linkages: crossings of coupler curves, swollen links, transmission angles, synthesis."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.optimize import brentq

from flexmech import linkages
from flexmech.arrays import FloatArray
from flexmech.errors import ComputationError, InputError
from flexmech.hygrothermal import HygrothermalState, coupler_point_in_state, linkage_in_state
from flexmech.verification.methods.engines import example


def crunodes(
    *, models: Sequence[str], temperature_rise: float = 0.0, moisture: float = 0.0
) -> FloatArray:
    """How often coupler curves of example models cross themselves.

    Parameters
    ----------
    models : sequence of str
        Names of the examples.
    temperature_rise : float
        In K.
    moisture : float
        Moisture of every resin: mass of water over its dry mass.

    Returns
    -------
    ndarray, shape (n_models,)
    """
    state = HygrothermalState(temperature_rise, moisture)
    counts = []
    for name in models:
        mechanism, point = example(name), _point(name)
        found = linkages.double_points(
            linkage_in_state(mechanism, state), coupler_point_in_state(mechanism, point, state)
        )
        counts.append(sum(double.kind == "crunode" for double in found))
    return np.array(counts, dtype=float)


def swelling_of_angles(
    *, model: str, crank_angles: Sequence[float], temperature_rise: float, moisture: float
) -> FloatArray:
    """By how much coupler and rocker of an example model turn as its links swell.

    Parameters
    ----------
    model : str
    crank_angles : sequence of float
        In deg.
    temperature_rise : float
        In K.
    moisture : float
        Mass of water over the resin's dry mass.

    Returns
    -------
    ndarray, shape (n_angles, 2)
        In deg.
    """
    mechanism = example(model)
    dry, wet = (
        linkage_in_state(mechanism, state).motion(np.radians(crank_angles)).angle[:, 1:]
        for state in (HygrothermalState(), HygrothermalState(temperature_rise, moisture))
    )
    return np.asarray(np.degrees(np.remainder(wet - dry + np.pi, 2 * np.pi) - np.pi))


def swollen(
    linkage: linkages.FourBar, point: linkages.CouplerPoint, link_strain: float, frame_strain: float
) -> tuple[linkages.FourBar, linkages.CouplerPoint]:
    """Swell all links alike, and the frame by itself.

    Singh & Sanyal 2022, eq. 12, corrected: a swollen length is the dry one times one plus the
    strain.

    Parameters
    ----------
    linkage : FourBar
    point : CouplerPoint
        Swells along with the coupler.
    link_strain, frame_strain : float

    Returns
    -------
    FourBar, CouplerPoint
    """
    links = {name: (1 + link_strain) * length for name, length in linkage.lengths.items()}
    swollen = linkage.resized(links, 1 + frame_strain)
    return swollen, point.scaled(1 + link_strain)


def cusp_moistures(*, models: Sequence[str], **state: float) -> FloatArray:
    """Moisture in percent at which the loop of each example's coupler curve is a cusp.

    Further settings are expansions, the temperature rise and the saturation.

    Parameters
    ----------
    models : sequence of str

    Returns
    -------
    ndarray, shape (n_models,)
    """
    return np.array([_cusp(name, **state)[0] for name in models])


def cusp_angles(*, models: Sequence[str], **state: float) -> FloatArray:
    """Crank angle at which the loop of each example's coupler curve is a cusp.

    Further settings are those of :func:`cusp_moistures`.

    Parameters
    ----------
    models : sequence of str

    Returns
    -------
    ndarray, shape (n_models,)
        In deg.
    """
    return np.degrees([_cusp(name, **state)[1] for name in models])


def _cusp(
    name: str,
    *,
    thermal_expansion: float,
    moisture_expansion: float,
    temperature_rise: float,
    saturation: float,
) -> tuple[float, float]:
    """The one cusp on the way from hot and dry to saturated, by the paper's one coefficient.

    There the margin of a double point passes zero, and its loop vanishes.

    Parameters
    ----------
    name : str
        Name of the example.
    thermal_expansion : float
        Thermal expansion of links and frame, per K.
    moisture_expansion : float
        Moisture expansion of the links, per percent of water.
    temperature_rise : float
        In K.
    saturation : float
        Moisture at the end, in percent.

    Returns
    -------
    float, float
        Moisture in percent, and crank angle in rad.
    """
    linkage, point = _four_bar(name), _point(name)
    heat, circuit = thermal_expansion * temperature_rise, linkages.circuit_of(linkage)

    def nodes(moisture: float) -> tuple[linkages.DoublePoint, ...]:
        own = swollen(linkage, point, heat + moisture_expansion * moisture, heat)
        return linkages.finite_double_points(*own)

    def nearest(moisture: float, place: float) -> linkages.DoublePoint:
        return min(nodes(moisture), key=lambda node: abs(math.remainder(node.place - place, np.pi)))

    crossed = [
        loop.place
        for end in (0.0, saturation)
        for loop in nodes(end)
        if loop.lies_on(circuit) and nearest(saturation - end, loop.place).margin < 0
    ]
    if len(crossed) != 1:
        raise ComputationError(f"{name}: {len(crossed)} cusps were found where one is expected")
    (place,) = crossed
    moisture = brentq(lambda m: nearest(m, place).margin, 0.0, saturation)
    one, other = (attitude.crank_angle for attitude in nearest(moisture, place).attitudes)
    return float(moisture), one + math.remainder(other - one, 2 * np.pi) / 2


def _four_bar(name: str) -> linkages.FourBar:
    linkage = example(name).linkage
    if not isinstance(linkage, linkages.FourBar):
        raise InputError(f"{name}: a four-bar is needed")
    return linkage


def _point(name: str) -> linkages.CouplerPoint:
    point = example(name).coupler_point
    if point is None:
        raise InputError(f"{name}: the model names no coupler_point")
    return point


def transmission_angle_limits(*, proportions: Sequence[float]) -> FloatArray:
    """Limits of the transmission angle of a crank-rocker by equations 2, 3 of Elamy et al. 2023.

    Parameters
    ----------
    proportions : sequence of float
        Crank, coupler and rocker over the ground.

    Returns
    -------
    ndarray, shape (2,)
        In deg.
    """
    crank, coupler, rocker = proportions
    return np.degrees(linkages.FourBar(1.0, crank, coupler, rocker).transmission_angle_limits())


def crank_rocker_proportions(*, deviation: float, rocker_angle: float) -> FloatArray:
    """Crank, coupler and rocker over the ground by equations 11 to 17 of Elamy et al. 2023.

    Parameters
    ----------
    deviation : float
        Deviation of the transmission angle from 90 deg, in deg.
    rocker_angle : float
        At crank angle zero, in deg.

    Returns
    -------
    ndarray, shape (3,)
    """
    found = linkages.synthesize_crank_rocker(np.radians(deviation), np.radians(rocker_angle))
    return np.array([found.crank, found.coupler, found.rocker], dtype=float)
