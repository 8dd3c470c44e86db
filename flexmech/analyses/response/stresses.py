"""Normal stress at the surfaces of links of one isotropic material along a run, and its words."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import xarray as xr

from flexmech.analyses.digits import Quantity, plain, rounded
from flexmech.analyses.extremes import peaks_between
from flexmech.analyses.response.agreement import peak_quantities
from flexmech.analyses.response.sprung_frame import carried_by_frame
from flexmech.analyses.summary import Aspect
from flexmech.arrays import FloatArray
from flexmech.linkages import Drive, RigidMotion, continuous_angles
from flexmech.linkages.applied_forces import applied_forces
from flexmech.linkages.inverse_dynamics import LinkForces, forces_by_joints
from flexmech.materials import Material
from flexmech.mechanics import Engine, LinkModel, kinks_of
from flexmech.mechanics.running import Trajectory
from flexmech.sections import BeamSection, LaminateSection

# Places of a link, at least: a parabola of stress is highest between two of them by a thousandth
# less.
_PLACES = 32
# Off the ends of a link, where joint forces act, and off the masses and loads at nodes.
_INSIDE = 1e-9


@dataclass(frozen=True)
class StressedLink:
    """A link whose stress is known by its strain.

    Parameters
    ----------
    number : int
        In the topology.
    section : BeamSection
    material : Material
    places : ndarray, shape (p,)
        From the link's start in m: nodes of the mesh, and evenly between them.
    link : LinkModel
    kinks : tuple of float
        Where something acts between the ends, from the start in m.
    """

    number: int
    section: BeamSection
    material: Material
    places: FloatArray
    link: LinkModel
    kinks: tuple[float, ...]

    def stress(self, displacement: FloatArray, tension: FloatArray) -> FloatArray:
        """Greatest size of the normal stress of both surfaces (N, p) in Pa.

        ``|N| / A + E |kappa| h / 2`` of the normal force N and the curvature (Timoshenko and Gere,
        *Mechanics of Materials*, sec. 5.12).

        Parameters
        ----------
        displacement : ndarray, shape (N, n_link)
        tension : ndarray, shape (N, p)
            Normal force in N.
        """
        curvature = self.link.readings.bent_curvature(
            displacement, self.places, self.kinks, self.link.vectors[1]
        )
        bent = np.abs(curvature) * self.section.in_plane_thickness / 2
        stretched = np.abs(tension) / self.section.axial_stiffness
        return np.asarray(self.material.youngs_modulus * (bent + stretched))


@dataclass(frozen=True)
class PeakStress:
    """Greatest stress of each link, and where it is.

    Parameters
    ----------
    stress : ndarray, shape (n_links,)
        In Pa; not a number where it is not known by the strain: of laminates, of sections stated by
        their stiffness, and of rigid links.
    axial : ndarray, shape (n_links,)
        Greatest part of the normal force alone.
    place : ndarray, shape (n_links,)
        From the link's start in m.
    crank_angle : ndarray, shape (n_links,)
        In rad.
    yield_strength : ndarray, shape (n_links,)
        Yield strength of the material in Pa; not a number where it is not stated.
    """

    stress: FloatArray
    axial: FloatArray
    place: FloatArray
    crank_angle: FloatArray
    yield_strength: FloatArray


def stressed_links(engine: Engine) -> list[StressedLink]:
    """Elastic links of one isotropic material.

    Parameters
    ----------
    engine : Engine

    Returns
    -------
    list of StressedLink
    """
    found = []
    for number, link in enumerate(engine.links):
        section = engine.mechanism.sections.get(link.name)
        material = None if section is None or link.rigid else _only_material(section)
        if section is not None and material is not None:
            kinks = tuple(kinks_of(engine.mechanism, link.name))
            found.append(StressedLink(number, section, material, _places(link), link, kinks))
    return found


def greatest_stresses(engine: Engine, trajectory: Trajectory, drive: Drive) -> FloatArray:
    """Greatest size of the normal stress anywhere in each link along a run.

    Parameters
    ----------
    engine : Engine
    trajectory : Trajectory
        N samples.
    drive : Drive

    Returns
    -------
    ndarray, shape (N, n_links)
        In Pa; zero of links whose stress is not known.
    """
    greatest = np.zeros((len(trajectory.time), len(engine.links)))
    for link, _, stress in _stresses(engine, trajectory, drive):
        greatest[:, link.number] = stress.max(axis=1)
    return greatest


def peak_stresses(engine: Engine, trajectory: Trajectory, drive: Drive) -> PeakStress:
    """Greatest stress of each link along a run, between the samples too.

    Parameters
    ----------
    engine : Engine
    trajectory : Trajectory
    drive : Drive

    Returns
    -------
    PeakStress
    """
    angle = drive.crank_angle(trajectory.time)
    found = np.full((5, len(engine.links)), np.nan)
    for link, tension, stress in _stresses(engine, trajectory, drive):
        worst = int(stress.max(axis=0).argmax())
        (size,), (where,) = peaks_between(stress[:, [worst]], angle)
        material = link.material
        axial = material.youngs_modulus * np.abs(tension).max() / link.section.axial_stiffness
        bound = math.nan if material.yield_strength is None else material.yield_strength
        found[:, link.number] = size, axial, link.places[worst], where, bound
    return PeakStress(*found)


def _stresses(
    engine: Engine, trajectory: Trajectory, drive: Drive
) -> Iterator[tuple[StressedLink, FloatArray, FloatArray]]:
    """Links with their normal force and the stress of both surfaces along a run, (N, p) each."""
    links = stressed_links(engine)
    for link, tension in zip(links, _tensions(links, engine, trajectory, drive), strict=True):
        yield link, tension, link.stress(trajectory.displacement[link.number], tension)


def _only_material(section: BeamSection) -> Material | None:
    """The one isotropic material of a section; None where it has others, or they are not known."""
    layers = section.layers
    if not isinstance(layers, LaminateSection) or len(layers.laminate.layers) > 1:
        return None
    return layers.laminate.layers[0].ply.isotropic_material


def _places(link: LinkModel) -> FloatArray:
    nodes = link.readings.nodes
    parts = math.ceil(_PLACES / (len(nodes) - 1))
    number = np.arange((len(nodes) - 1) * parts + 1) / parts
    return np.asarray(np.interp(number, np.arange(len(nodes)), nodes))


def _tensions(
    links: list[StressedLink], engine: Engine, trajectory: Trajectory, drive: Drive
) -> list[FloatArray]:
    """Normal force (N, p) of links along a run."""
    forces = running_forces(engine, trajectory, drive)
    lengths = [engine.mechanism.linkage.topology.links[link.number].length for link in links]
    return [
        forces.axial_force(link.number, np.clip(link.places, _INSIDE * a, (1 - _INSIDE) * a))
        for link, a in zip(links, lengths, strict=True)
    ]


def running_forces(engine: Engine, trajectory: Trajectory, drive: Drive) -> LinkForces:
    """Internal forces by the joint forces of a run and the inertia of rigid links.

    Parameters
    ----------
    engine : Engine
    trajectory : Trajectory
        N samples.
    drive : Drive

    Returns
    -------
    LinkForces
        At the samples; of :func:`flexmech.linkages.forces_by_joints`, without couples of clamps.
    """
    mechanism, motion = engine.mechanism, carried(engine, trajectory, drive)
    topology = mechanism.linkage.topology
    turning = any(spring.torsional_stiffness for spring in mechanism.joint_springs)
    applied = applied_forces(
        topology,
        motion,
        mechanism.loads,
        mechanism.springs,
        mechanism.joint_springs,
        continuous_angles(mechanism.linkage, motion) if turning else motion.angle,
        trajectory.time,
    )
    return forces_by_joints(
        topology,
        motion,
        mechanism.link_masses_in_order,
        mechanism.gravity,
        trajectory.joint_force,
        applied,
    )


def carried(engine: Engine, trajectory: Trajectory, drive: Drive) -> RigidMotion:
    """Motion of the rigid linkage at a run's samples, on a free shaft or a frame on springs.

    Parameters
    ----------
    engine : Engine
    trajectory : Trajectory
        N samples.
    drive : Drive

    Returns
    -------
    RigidMotion
    """
    time, linkage = trajectory.time, engine.mechanism.linkage
    if trajectory.shaft is None:
        return carried_by_frame(engine, drive.motion(linkage, time), trajectory)
    angle = drive.crank_angle(time) + trajectory.shaft.rotation
    return linkage.motion(angle, drive.crank_speed(time), drive.crank_acceleration(time))


def stress_aspect(dataset: xr.Dataset) -> Aspect:
    """What the stress counts, and which links yield.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of a response.

    Returns
    -------
    Aspect
    """
    return Aspect(details=(_line(dataset),), warnings=yielding(dataset))


def _line(dataset: xr.Dataset) -> str:
    """What the stress is of, and the links of which none is known."""
    own = dataset.isel(engine=0)
    known = np.isfinite(own["peak_stress"].values)
    without = [str(link) for link in dataset["link"].values[~known]]
    line = "stress: |N| / A + |M| h / (2 I) at the surfaces, greatest along the link"
    parts = [
        f"{link} {rounded(1e-6 * float(own['peak_axial_stress'].sel(link=link)), 0.0, 3)}"
        for link in dataset["link"].values[known]
    ]
    if parts:
        line += f"; by the normal force alone at most {', '.join(parts)} MPa"
    return f"{line}; not known of {', '.join(without)}" if without else line


def stress_words(dataset: xr.Dataset, stress: Quantity) -> str:
    """Greatest stress, where it is, and the yield strength there.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of a response.
    stress : Quantity
        The greatest one.

    Returns
    -------
    str
    """
    own = dataset.sel(link=stress.of).isel(engine=0)
    place = f"{1e3 * float(own['peak_stress_place']):.3g} mm from its start"
    said = f"the greatest normal stress is {stress}, in the {stress.of}, {place}"
    bound = float(own["yield_strength"])
    return f"{said}; yielding begins at {plain(1e-6 * bound)} MPa" if math.isfinite(bound) else said


def yielding(dataset: xr.Dataset) -> tuple[str, ...]:
    """What to do with links whose stress is above the yield strength; or nothing.

    Parameters
    ----------
    dataset : xarray.Dataset
        Dataset of a response.

    Returns
    -------
    tuple of str
    """
    found = []
    for one in peak_quantities(dataset, "peak_stress", "MPa", 1e-6):
        bound = 1e-6 * float(dataset["yield_strength"].sel(link=one.of).isel(engine=0))
        if one.value > bound:
            found.append(
                f"the {one.of} yields: its stress reaches {one}, above the yield strength of "
                f"{plain(bound)} MPa; make it thicker or of a stronger material, or run slower"
            )
    return tuple(found)
