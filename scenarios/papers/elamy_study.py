"""The campaign of Elamy et al. 2023 computed: frequency, damping, motion and strength.

Each task is one linkage, so that any executor's ``map`` serves. Loads, speed and steel of the
running linkages are assumed: the paper claims less driving torque and power, and says at no speed
how much. It prints a strength of each stacking and none of its plies: those of similar straight
plies stand in their place, with as many fibres, in epoxy in place of polyester.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from elamy_linkages import (
    CASES,
    COUNT,
    FLAT,
    LAMINATES,
    LAYERS,
    MODELS,
    PLIES,
    POSITIONS,
    SECOND,
    THICKNESS,
    WIDTH,
    crank_rocker,
    laminate_factors,
    position_angles,
    published_case,
    published_tables,
    stored,
    with_rigid_joints,
)

import flexmech
from flexmech import BeamSection, Laminate, Material, Mechanism, PlyStrength, ReferenceEngine
from flexmech.analyses import deflections
from flexmech.arrays import FloatArray
from flexmech.materials import Fibre, Matrix, ply_from_constituents, uncertainty_parts, woven_ply
from flexmech.mechanics.running import DrivenLinkage
from flexmech.sections import LaminateSection, Layers, SheetSection, unit_ply_stresses
from flexmech.solvers import periodic_turn

CONVERGED, PAPERS_MESH, THIRD_ORDER = "converged", "one element a link", "third order"
BEAMS = {CONVERGED: (8, "euler"), PAPERS_MESH: (1, "euler"), THIRD_ORDER: (8, "reddy")}
"""Elements a link and their kind: bending converged, as in the paper, and with shear by the
third-order theory of its section 3.1."""
CRANK_SPEED = 20.0
"""In rad/s, assumed: the paper states none."""
STEEL = Material(youngs_modulus=200e9, density=7850.0, poisson_ratio=0.3)
"""Assumed: the paper says metal."""
SOURCE = (
    "P. D. Soden, M. J. Hinton and A. S. Kaddour, Composites Science and Technology 58 (1998) "
    "1011-1022, plies with 60 % of fibres: carbon AS4 in epoxy 3501-6, E-glass in epoxy MY750"
)
STRENGTHS = {
    "C": PlyStrength(1950e6, 1480e6, 48e6, 200e6, 79e6, source=SOURCE),
    "G": PlyStrength(1280e6, 800e6, 40e6, 145e6, 73e6, source=SOURCE),
}
"""Strengths of the plies of Table 2's stacks, by their letters."""
CRITERION = "max-stress"
"""It says in which way a ply fails; plies along the load bear little else than that."""
TURN = np.radians(np.arange(361.0))
_SHARE, _FIBRES, _RESIN = 0.6, {"C": "carbon", "G": "E-glass"}, "polyester"
_RUNNING_PLIES = ("woven", "table 2")
_ORDERS: dict[str, list[Any]] = {
    "section_load": ["tension", "compression", "bending"],
    "plies": list(PLIES),
    "mixed_plies": list(PLIES[:2]),
    "running_plies": list(_RUNNING_PLIES),
    "layers": list(LAYERS),
    "beams": list(BEAMS),
    "position": [*POSITIONS, SECOND],
    "laminate": list(LAMINATES),
    "material": [*LAMINATES, "steel"],
    "case": list(CASES),
}
MakeEngine = Callable[[Mechanism, int, str], Any]


def study_composites(
    executor: Executor | None = None, make_engine: MakeEngine = ReferenceEngine
) -> xr.Dataset:
    """All linkages at rest and in motion, beside what is published.

    Parameters
    ----------
    executor : concurrent.futures.Executor, optional
        Any; this process if left out.
    make_engine : callable
        Engine of a mechanism, a number of elements a link and an element (``euler``, ``reddy``).

    Returns
    -------
    xarray.Dataset
        Its variables, with their units, stand in ``data/elamy_2023_variables.toml``.
    """

    def tabulated(task: Callable[..., pd.DataFrame], **asked: Iterable[Any]) -> xr.Dataset:
        """Rows of a task at each combination, over these and the dimensions that the rows have."""
        every = list(product(*asked.values()))
        found = (executor.map if executor else map)(task, every, [make_engine] * len(every))
        frame = pd.concat(
            rows.assign(**dict(zip(asked, one, strict=True)))
            for one, rows in zip(every, found, strict=True)
        )
        order = {dim: values for dim, values in _ORDERS.items() if dim in frame}
        return frame.set_index(list(order)).to_xarray().reindex(order)

    linkages = {"laminate": LAMINATES, "case": CASES}
    rest = tabulated(_at_rest, plies=PLIES, layers=LAYERS, **linkages)
    rigid = tabulated(_with_rigid_joints, **linkages)
    materials = _ORDERS["material"]
    peaks = tabulated(_in_motion, running_plies=_RUNNING_PLIES, material=materials, case=CASES)
    sections = tabulated(_sections_fail, layers=LAYERS, laminate=LAMINATES)
    breaks = tabulated(_breaks, layers=LAYERS, **linkages)
    printed, compared = published_tables(), list(POSITIONS)
    study = xr.merge([printed, laminate_properties(), peaks, sections, breaks], join="exact")
    study = study.assign_coords(crank_angle=TURN).assign(
        frequency=rest["frequency"].sel(position=compared),
        other_configuration=rest["frequency"].sel(position=SECOND, drop=True),
        **{f"{kind}_frequency": rigid[kind].sel(position=compared) for kind in rigid},
        **{
            f"{kind}_other_configuration": rigid[kind].sel(position=SECOND, drop=True)
            for kind in rigid
        },
        strain_energy_damping=rest["damping"].sel(position=compared),
        laminate_factor=laminate_factors(rest["frequency"].sel(position=compared)),
        published_laminate_factor=laminate_factors(
            printed["finite_element"].sel(position=["90", "max"])
        ),
        transmission_angle=(
            ("case", "crank_angle"),
            [published_case(case).transmission_angle(TURN) for case in CASES],
        ),
    )
    ours = (
        study["laminate_factor"].isel(plies=0, layers=0, drop=True).sel(beams=CONVERGED, drop=True)
    )
    relative = factor_uncertainty(study).isel(mixed_plies=0, layers=0, drop=True)
    study["laminate_factor_spread"] = ours * relative
    known = stored("elamy_2023_variables")
    for name, (unit, words) in known["variables"].items():
        study[name].attrs = {"units": unit, "long_name": words}
    return study.assign_attrs(known["attributes"], flexmech_version=flexmech.__version__)


def _at_rest(asked: tuple[str, str, str, int], make_engine: MakeEngine) -> pd.DataFrame:
    """Frequency in Hz, and damping by modal strain energy where a loss of plies is known."""
    plies, layers, laminate, case = asked
    mechanism = crank_rocker(case, laminate, plies, layers)
    angles = position_angles(published_case(case))
    frames = []
    for beams, elements in BEAMS.items():
        engine = make_engine(mechanism, *elements)
        place = {"beams": beams, "position": _ORDERS["position"]}
        frequency = flexmech.natural_frequencies(engine, angles, modes=1)[:, 0]
        frame = pd.DataFrame({**place, "frequency": frequency, "damping": np.nan})
        if plies != "table 2" and beams != PAPERS_MESH:
            frame["damping"] = flexmech.strain_energy_damping(engine, angles, modes=1)
        frames.append(frame)
    return pd.concat(frames)


def _with_rigid_joints(asked: tuple[str, int], make_engine: MakeEngine) -> pd.DataFrame:
    """The first plies, links held against turning at A and B, the crank clamped or pinned at O2."""
    laminate, case = asked
    angles = position_angles(published_case(case))
    # Without prestress the angle at which the joints have no torque does not matter, so that one
    # linkage serves all positions.
    mechanism = with_rigid_joints(crank_rocker(case, laminate), float(angles[0]))
    engine = make_engine(mechanism, *BEAMS[CONVERGED])
    found = {
        kind: flexmech.natural_frequencies(one, angles, modes=1, prestress="none")[:, 0]
        for kind, one in {
            "rigid_joints": engine,
            "literal_frame": engine.with_(shaft="free"),
        }.items()
    }
    return pd.DataFrame({"position": _ORDERS["position"], **found})


def _in_motion(asked: tuple[str, str, int], make_engine: MakeEngine) -> pd.DataFrame:
    """Greatest torque, power and joint force of rigid links, and deflection of linear beams."""
    plies, material, case = asked
    mechanism = crank_rocker(case, "C1" if material == "steel" else material, plies)
    if material == "steel":
        section = BeamSection.rectangle(STEEL, THICKNESS, WIDTH)
        mechanism = replace(mechanism, sections=dict.fromkeys(mechanism.sections, section))
    rigid = mechanism.inverse_dynamics(mechanism.linkage.motion(TURN, CRANK_SPEED))
    # Twice as many elements change no deflection by more than half a percent.
    engine = make_engine(mechanism, 4, "euler").fit_for(1)
    at_rest = flexmech.natural_frequencies(engine, position_angles(published_case(case)), modes=1)
    drive = flexmech.ConstantSpeed(CRANK_SPEED)
    linkage = DrivenLinkage(engine, drive, "none", modes=1, detail=2.0)
    steps = max(720, int(np.ceil(40 * at_rest.max() * drive.revolution_time)))
    peaks = {
        "peak_torque": np.abs(rigid.driving_torque).max(),
        "peak_power": np.abs(rigid.driving_power).max(),
        "peak_joint_force": max(np.hypot(*f.T).max() for f in rigid.joint_force.values()),
        "peak_deflection": np.abs(deflections(engine, periodic_turn(linkage, steps))).max(),
    }
    return pd.DataFrame([peaks])


def _strong(layers: Layers) -> Layers:
    """Layers whose plies have the strengths of :data:`STRENGTHS`, by their names."""
    strong = tuple(
        replace(layer, ply=replace(layer.ply, strength=STRENGTHS[layer.ply.name]))
        for layer in layers.laminate.layers
    )
    return layers.resized(replace(layers.laminate, layers=strong), 1.0)


def _sections_fail(asked: tuple[str, str], _: MakeEngine) -> pd.DataFrame:
    """Nominal stress in Pa, mode and ply of the first failure by each load of a section.

    It is the mean stress or, in bending in the plane of motion, that of the surface if the section
    were of one material.
    """
    layers, laminate = asked
    links = crank_rocker(1, laminate, "unidirectional", layers).layers_of("crank")
    assert links is not None
    strong, rows = _strong(links), []
    # Axial force, moment and shear force of a nominal stress of one pascal.
    force, moment = WIDTH * THICKNESS, WIDTH * THICKNESS**2 / 6
    loads = np.array([[force, 0.0, 0.0], [-force, 0.0, 0.0], [0.0, moment, 0.0]])
    by_layer = np.moveaxis(np.tensordot(loads, unit_ply_stresses(strong)[..., :3], 1), 1, 0)
    for layer, stress in zip(strong.laminate.layers, by_layer, strict=True):
        criterion = flexmech.failure_criterion(CRITERION, layer.ply)
        for load, factor, mode in zip(
            _ORDERS["section_load"], *criterion.load_factor(stress), strict=True
        ):
            worst = factor.argmin()
            rows.append((load, factor[worst], criterion.mode_names[mode[worst]], layer.ply.name))
    names = ["section_load", "first_ply_stress", "first_ply_mode", "first_ply"]
    frame = pd.DataFrame(rows, columns=names)
    return frame.loc[frame.groupby("section_load")["first_ply_stress"].idxmin()]


def _breaks(asked: tuple[str, str, int], _: MakeEngine) -> pd.DataFrame:
    """Crank speed in rad/s at which inertia forces of rigid links break a linkage."""
    layers, laminate, case = asked
    mechanism = crank_rocker(case, laminate, "unidirectional", layers)
    sections = {
        name: replace(section, layers=_strong(section.layers))
        for name, section in mechanism.sections.items()
    }
    # Loads go with the square of the speed, so that any speed serves.
    judged = replace(mechanism, sections=sections)
    found = flexmech.strength(judged, 1.0, criterion=CRITERION, source="rigid")
    first = found.dataset.isel(margin=0)
    return pd.DataFrame(
        {
            "failure_speed": [float(first["margin_speed_factor"])],
            "failing_link": [first["margin_part"].item()],
            "failing_mode": [first["margin_mode"].item()],
        }
    )


def laminate_properties() -> xr.Dataset:
    """Modulus in bending, Poisson's ratio and density by Table 1, their changes by it, and Table 2.

    In bending one laminate has one factor of frequency, the root of E I over rho A, in every
    linkage and position. So what the spread of a constituent does to a ratio of frequencies
    follows from sections alone: ``modulus_change`` and so on, over ``source``, is what one printed
    uncertainty of a property of a constituent adds.
    """
    known = flexmech.published_constituents()
    parts = [known[name] for name in (*_FIBRES.values(), _RESIN)]
    names, found = ("modulus", "poisson_ratio", "density"), []
    for plies, layers in MODELS[:4]:

        def numbers(*parts: Fibre | Matrix, plies: str = plies, layers: str = layers) -> FloatArray:
            return _numbers_of(parts, plies, layers)

        changes = {
            f"{part} {what.replace('_', ' ')}": change
            for (part, what), change in uncertainty_parts(numbers, parts).items()
        }
        dims, sources = ("number", "laminate"), list(changes)
        own = xr.Dataset(
            {
                "value": (dims, numbers(*parts)),
                "change": (("source", *dims), np.array(list(changes.values()))),
            },
            {"number": list(names), "laminate": list(LAMINATES), "source": sources},
        )
        found.append(own.expand_dims(mixed_plies=[plies], layers=[layers]))
    every = xr.combine_by_coords(found, join="outer")
    every = every.reindex(mixed_plies=_ORDERS["mixed_plies"], layers=_ORDERS["layers"])
    units = {"modulus": 1e9, "poisson_ratio": 1.0, "density": 1.0, "strength": 1e6}
    return xr.Dataset(
        {name: every["value"].sel(number=name, drop=True) for name in names}
        | {f"{name}_change": every["change"].sel(number=name, drop=True) for name in names}
        | {
            f"printed_{name}": ("laminate", [unit * row[name] for row in LAMINATES.values()])
            for name, unit in units.items()
        }
    )


def _numbers_of(parts: Sequence[Fibre | Matrix], plies: str, layers: str) -> FloatArray:
    """Modulus, Poisson's ratio and density of all laminates, (3, 6)."""
    *fibres, resin = parts
    mixed = {
        letter: ply_from_constituents(fibre, resin, _SHARE, "rule-of-mixtures")
        for letter, fibre in zip(_FIBRES, fibres, strict=True)
    }
    if plies == "woven":
        mixed = {letter: woven_ply(ply) for letter, ply in mixed.items()}
    size, rows = (WIDTH if layers == FLAT else THICKNESS) / COUNT, []
    for row in LAMINATES.values():
        stack = [mixed[letter] for letter in row["stack"] if letter in mixed]
        laminate = Laminate.stacked(stack, size, [0.0] * len(stack))
        flat = layers == FLAT
        section = SheetSection(laminate, THICKNESS) if flat else LaminateSection(laminate, WIDTH)
        flexible = np.linalg.inv(laminate.stiffness_moment(0))
        modulus = 12 * section.bending_stiffness / (WIDTH * THICKNESS**3)
        density = section.mass_per_length / (WIDTH * THICKNESS)
        rows.append((modulus, -flexible[0, 1] / flexible[0, 0], density))
    return np.array(rows).T


def spread_of(change: xr.DataArray) -> xr.DataArray:
    """Standard uncertainty from the changes by each source: the root of their squares' sum."""
    return (change**2).sum("source") ** 0.5


def relative_change(study: xr.Dataset, power: float, density_power: float) -> xr.DataArray:
    """Relative change of modulus to one power times density to another, by each source.

    Frequencies in bending have 1/2 and -1/2.
    """
    stiffer = study["modulus_change"] / study["modulus"]
    heavier = study["density_change"] / study["density"]
    return power * stiffer + density_power * heavier


def factor_uncertainty(study: xr.Dataset) -> xr.DataArray:
    """Relative uncertainty of each laminate's frequency in bending over that of C1."""
    change = relative_change(study, 0.5, -0.5)
    return spread_of(change - change.sel(laminate="C1"))


def all_models(study: xr.Dataset) -> list[xr.DataArray]:
    """Frequencies over position, laminate and case by each model, the first one ours.

    Every model comes twice: in both configurations with a right transmission angle. The last is
    that of rigid joints.
    """
    models = []
    for kind in ("", "rigid_joints_"):
        for values in in_both_configurations(study, kind):
            chosen = [
                {"plies": plies, "layers": layers, "beams": beams}
                for (plies, layers), beams in product(MODELS, BEAMS)
            ]
            models += [values.sel(one, drop=True) for one in ([{}] if kind else chosen)]
    return models


def in_both_configurations(study: xr.Dataset, kind: str = "") -> list[xr.DataArray]:
    """Frequencies of a kind with the first and with the second configuration with 90 deg."""
    frequency = study[f"{kind}frequency"]
    other = frequency.where(frequency["position"] != "90", study[f"{kind}other_configuration"])
    return [frequency, other.transpose(*frequency.dims)]
