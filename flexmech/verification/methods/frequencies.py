"""Natural frequencies and decay rates of linkages and rotating arms, and closed forms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.optimize import brentq

from flexmech.analyses import natural_frequencies
from flexmech.arrays import FloatArray
from flexmech.choices import ElementName, EngineName, Prestress
from flexmech.errors import InputError
from flexmech.linkages import RotatingArm
from flexmech.mechanism import Mechanism
from flexmech.sections import BeamSection
from flexmech.solvers import solve_modes
from flexmech.verification.methods.engines import SLENDER, engine_of_name, example
from flexmech.verification.methods.stored_tables import stored_table

_FREE_SHAFT = "slider_crank_free_shaft"


def four_bar_frequencies(
    *,
    model: str,
    engine: EngineName,
    elements: int,
    crank_angles: Sequence[float],
    modes: int,
    crank_speed: float = 0.0,
    prestress: Prestress = "equilibrium",
    rotation_terms: bool = True,
    element: ElementName | None = None,
) -> FloatArray:
    """Natural frequencies of an example model.

    Parameters
    ----------
    model : str
        Name of the example.
    engine : {"reference", "exudyn"}
    elements : int
        On each link.
    crank_angles : sequence of float
        In deg.
    modes : int
    crank_speed : float
        In rad/s.
    prestress : {"none", "axial", "equilibrium"}
    rotation_terms : bool
    element : str, optional
        By default that of slender links, of either engine.

    Returns
    -------
    ndarray, shape (n_angles, modes)
        In Hz.
    """
    chosen = engine_of_name(engine, example(model), elements, element=element or SLENDER[engine])
    return natural_frequencies(
        chosen,
        np.radians(crank_angles),
        crank_speed,
        modes=modes,
        prestress=prestress,
        rotation_terms=rotation_terms,
    )


def stored_frequencies(*, table: str) -> FloatArray:
    """Published natural frequencies over the crank angle, as stored.

    Parameters
    ----------
    table : str
        Name of the stored table: crank angles in deg, then frequencies in rad/s, one column a mode.

    Returns
    -------
    ndarray, shape (n_angles, modes)
        In Hz.
    """
    return np.asarray(stored_table(table).to_numpy(dtype=float)[:, 1:] / (2 * np.pi))


def frequencies_at_stored_angles(*, table: str, **settings: Any) -> FloatArray:
    """Natural frequencies of an example model at the crank angles of published ones.

    Further settings are those of :func:`four_bar_frequencies`.

    Parameters
    ----------
    table : str
        As in :func:`stored_frequencies`.

    Returns
    -------
    ndarray, shape (n_angles, modes)
        In Hz.
    """
    angles = stored_table(table)["crank_angle_deg"].to_numpy(dtype=float)
    return four_bar_frequencies(crank_angles=angles.tolist(), **settings)


def unit_arm(slenderness: float, hub_radius: float = 0.0) -> Mechanism:
    """Arm of unit length, mass and bending stiffness: speeds and frequencies without unit.

    Parameters
    ----------
    slenderness : float
        Root of A L^2 / I.
    hub_radius : float
        Over the length.

    Returns
    -------
    Mechanism
    """
    section = BeamSection(
        axial_stiffness=slenderness**2,
        bending_stiffness=1.0,
        shear_stiffness=slenderness**2 / 3,
        mass_per_length=1.0,
        rotary_inertia=slenderness**-2,
        in_plane_thickness=0.01,
    )
    return Mechanism(RotatingArm(1.0, hub_radius), {"arm": section})


def rotating_arm_frequencies(
    *,
    engine: EngineName,
    elements: int,
    slenderness: float,
    speeds: Sequence[float],
    prestress: Prestress,
    rotation_terms: bool,
    hub_radius: float = 0.0,
    modes: int = 1,
    component_modes: bool = False,
) -> FloatArray:
    """Natural frequencies of a rotating arm over the root of EI / (rho A L^4).

    Parameters
    ----------
    engine : {"reference", "exudyn"}
    elements : int
    slenderness : float
        Root of A L^2 / I.
    speeds : sequence of float
        Over the same root.
    prestress : {"none", "axial", "equilibrium"}
    rotation_terms : bool
        Without them it is the flapping out of the plane of rotation.
    hub_radius : float
        Over the length.
    modes : int
    component_modes : bool

    Returns
    -------
    ndarray, shape (n_speeds, modes)
    """
    chosen = engine_of_name(
        engine, unit_arm(slenderness, hub_radius), elements, component_modes=component_modes
    )
    found = natural_frequencies(
        chosen,
        0.0,
        np.asarray(speeds, dtype=float),
        modes=modes,
        prestress=prestress,
        rotation_terms=rotation_terms,
    )
    return np.asarray(2 * np.pi * found)


def cantilever_frequencies(*, modes: int) -> FloatArray:
    """Closed form of the clamped beam at rest: squares of the roots of cos x cosh x = -1.

    Parameters
    ----------
    modes : int

    Returns
    -------
    ndarray, shape (modes,)
        Angular frequencies over the root of EI / (rho A L^4).
    """
    # Divided by cosh x, so that large roots do not overflow.
    roots = [
        brentq(lambda x: np.cos(x) + 1 / np.cosh(x), n * np.pi, (n + 1) * np.pi)
        for n in range(modes)
    ]
    return np.square(roots)


def four_bar_by_plane_elasticity(
    *, model: str, crank_angle: float, elements: int, modes: int
) -> FloatArray:
    """Natural frequencies of a four-bar at rest by plane stress, its layers in elements.

    Parameters
    ----------
    model : str
        Name of an example with laminated links.
    crank_angle : float
        In deg.
    elements : int
        Along each link.
    modes : int

    Returns
    -------
    ndarray, shape (modes,)
        In Hz.

    Raises
    ------
    InputError
        If a link has no layers.
    """
    from flexmech.verification.methods.plane_elasticity import fourbar_frequencies, plane_link

    mechanism = example(model)
    links = mechanism.linkage.topology.links
    made = []
    for link in links:
        layers = mechanism.sections[link.name].layers
        if layers is None:
            raise InputError(f"{model}: {link.name} has no layers")
        made.append(plane_link(layers.smeared.laminate, layers.width, link.length, elements))
    angles = mechanism.linkage.motion(np.radians(crank_angle)).angle.tolist()
    return fourbar_frequencies(made, angles, [link.length for link in links], modes)


def free_shaft_frequencies(
    *, engine: EngineName, elements: int, crank_angles: Sequence[float], modes: int
) -> FloatArray:
    """Natural frequencies of the slider-crank with a free shaft, at rest, without damping.

    Parameters
    ----------
    engine : {"reference", "exudyn"}
    elements : int
    crank_angles : sequence of float
        In deg.
    modes : int
        Above the free motion.

    Returns
    -------
    ndarray, shape (n_angles, modes)
        In Hz.
    """
    damped = example(_FREE_SHAFT)
    sections = {name: section.with_damping_time(0.0) for name, section in damped.sections.items()}
    chosen = engine_of_name(
        engine, replace(damped, sections=sections), elements, element=SLENDER[engine], shaft="free"
    )
    return natural_frequencies(chosen, np.radians(crank_angles), modes=modes)


def free_shaft_decay_rates(
    *, engine: EngineName, elements: int, crank_angles: Sequence[float]
) -> FloatArray:
    """Least and greatest decay rate of the first two bending modes over crank angles.

    Parameters
    ----------
    engine : {"reference", "exudyn"}
    elements : int
    crank_angles : sequence of float
        In deg.

    Returns
    -------
    ndarray, shape (2, 2)
        In 1/s, by mode; the least first.
    """
    chosen = engine_of_name(
        engine,
        example(_FREE_SHAFT),
        elements,
        element=SLENDER[engine],
        shaft="free",
        component_modes=False,
    )
    system = chosen.linear_system(np.radians(crank_angles))
    decay = -solve_modes(system, 2).eigenvalues.real
    return np.stack([decay.min(axis=0), decay.max(axis=0)], axis=1)
