"""Moving natural frequencies: how they change with crank angle and crank speed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from flexmech.analyses.beam_theory import theory_attributes
from flexmech.analyses.crank_speeds import asked_speeds
from flexmech.analyses.datasets import provenance, rigid_positions
from flexmech.analyses.frequencies.discretisation import check_angle_indices
from flexmech.analyses.frequencies.engine_map import drawn_between, map_engine, shapes_asked_for
from flexmech.analyses.frequencies.frequency_map import speed_effect_terms
from flexmech.analyses.frequencies.modal_damping import links_without_loss
from flexmech.analyses.frequencies.request import FrequencyRequest
from flexmech.analyses.frequencies.result import MovingFrequencies
from flexmech.analyses.options import FrequencyOptions
from flexmech.analyses.requests import Engines, as_many_modes, asks, engines_of
from flexmech.analyses.summary import environment_lines, left_out_attributes, state_name
from flexmech.arrays import FloatArray, LabelledProgress, silent
from flexmech.crank_values import operating_speeds
from flexmech.hygrothermal import Environment, mechanism_in_state
from flexmech.mechanics import Engine
from flexmech.mechanism import drawing
from flexmech.solvers.formulation import Formulation
from flexmech.threads import one_thread
from flexmech.validation import checked_array


def joined(
    engines: Sequence[Engine],
    request: FrequencyRequest,
    maps: Sequence[xr.Dataset],
    speed_effect: dict[str, FloatArray] | None,
    pictured: Sequence[xr.Dataset] = (),
) -> xr.Dataset:
    """Join the maps of all engines, and label them.

    Parameters
    ----------
    engines : sequence of Engine
    request : FrequencyRequest
    maps : sequence of xarray.Dataset
        One for each engine; see :class:`flexmech.analyses.frequencies.engine_map.EngineMap`.
    speed_effect : dict of str to ndarray, shape (S, A, modes), or None
    pictured : sequence of xarray.Dataset
        What pictures of the first engine show besides.

    Returns
    -------
    xarray.Dataset
    """
    first, formulation = engines[0], request.formulation
    if any("lumping_error" in each for each in maps):
        # The mass of the other engine is not lumped.
        none = (each.assign(lumping_error=0 * each["discretisation_error"]) for each in maps)
        maps = [
            each if "lumping_error" in each else without
            for each, without in zip(maps, none, strict=True)
        ]
    names = xr.DataArray([engine.name for engine in engines], dims="engine", name="engine")
    dataset = xr.concat(maps, names, join="inner")
    checks = request.crank_angles[check_angle_indices(request.crank_angles, request.full_turn)]
    positions = rigid_positions(first, first.mechanism.linkage.motion(checks))
    dataset["rigid_position"] = (("check_angle", "link", "station", "component"), positions)
    if speed_effect:
        values = np.stack(list(speed_effect.values()))
        dataset["speed_effect"] = (("term", "crank_speed", "crank_angle", "mode"), values)
        dataset = dataset.assign_coords(term=list(speed_effect))
    if "strain_energy_damping" in dataset:
        unknown = ", ".join(links_without_loss(first.mechanism))
        dataset["strain_energy_damping"].attrs["links_without_data"] = unknown
    dataset = dataset.assign_coords(
        element=("engine", [_element(engine) for engine in engines]),
        elements=("engine", [engine.elements for engine in engines]),
        crank_angle=request.crank_angles,
        mode=np.arange(1, formulation.modes + 1),
        check_angle=checks,
        part=["real", "imaginary"],
        link=list(first.mechanism.linkage.topology.link_names),
        station=np.linspace(0.0, 1.0, positions.shape[2]),
        component=["x", "y"],
    )
    lumps = max(engine.lumped_mass_count for engine in engines)
    for part in pictured:
        dataset = dataset.merge(part)
    return (
        MovingFrequencies.schema()
        .labelled(dataset)
        .assign_attrs(
            provenance(engines),
            drawing=drawing(first.mechanism),
            prestress=formulation.prestress,
            rotation_terms=str(formulation.counted_terms),
            speed_unit=request.shown_unit,
            **({"lumped_masses": lumps} if lumps else {}),
        )
    )


def _element(engine: Engine) -> str:
    """Kind of element, and that masses are lumped where they are."""
    return engine.element if engine.mass == "distributed" else f"{engine.element}, lumped masses"


def with_states(states: dict[str, xr.Dataset], environment_lines: Sequence[str]) -> xr.Dataset:
    """Join the datasets of a mechanism dry and in an environment.

    Parameters
    ----------
    states : dict of str to xarray.Dataset
        By what a state is called, the dry one first.
    environment_lines : sequence of str
        What the environment does to each link.

    Returns
    -------
    xarray.Dataset
        Over ``state`` besides. What there is of one state alone is not a number in the other.
    """
    parts = list(states.values())
    for part in parts:
        for name in set(parts[0].data_vars) - set(part.data_vars):
            part[name] = xr.full_like(parts[0][name], np.nan)
    both = xr.concat(
        parts,
        xr.DataArray(list(states), dims="state", name="state"),
        coords="minimal",
        compat="override",
        join="inner",
        combine_attrs="override",
    )
    return both.assign_attrs(environment_lines="\n".join(environment_lines))


@asks(FrequencyOptions)
def moving_frequencies(mechanism: Engines, asked: FrequencyOptions) -> MovingFrequencies:
    """Tracked natural frequencies over crank angles and speeds, with their errors.

    Parameters
    ----------
    mechanism : Mechanism, Engine or sequence of them
        Several engines give results side by side.

    Returns
    -------
    MovingFrequencies
        With an environment over ``state`` too, of which there are two: dry, and the environment's.

    Raises
    ------
    InputError
        If the request makes no sense or the linkage cannot reach a crank angle.
    ComputationError
        If an equilibrium does not converge or a mode does not oscillate.

    Examples
    --------
    >>> engine = flexmech.ReferenceEngine(flexmech.load_mechanism("models/aluminium_fourbar.toml"))
    >>> result = flexmech.moving_frequencies(engine, np.radians([0, 60, 120]), [0, 20])
    >>> result.dataset["frequency"].shape
    (1, 2, 3, 4)
    """
    engines, environment = engines_of(mechanism, asked), asked.environment
    first, tolerance = engines[0].mechanism, asked.tolerance if asked.elements is None else None
    speeds, unit = asked_speeds(asked.crank_speeds, asked.speed_unit, first, operating_speeds)
    angles = checked_array(asked.crank_angles, "crank_angles", "rad")
    report = asked.progress or silent

    def compute(count: int) -> xr.Dataset:
        request = FrequencyRequest(
            angles,
            speeds,
            Formulation(asked.prestress, asked.rotation_terms, count),
            asked.speed_effect,
            unit,
            tolerance,
            np.zeros(0) if asked.shapes_at is None else np.asanyarray(asked.shapes_at),
            asked.smooth and asked.prestress != "trajectory",
        )
        fit = [each.fit_for(count) for each in engines]
        if environment is None:
            return _in_one_state(fit, request, report)[0].assign_attrs(
                theory_attributes(fit, count)
            )
        return _dry_and_in(environment, fit, request, report)

    found, fewer = as_many_modes(compute, asked.modes, unit)
    notes = left_out_attributes(first) | ({} if tolerance is None else {"tolerance": tolerance})
    return MovingFrequencies(found.assign_attrs(notes | fewer))


def _dry_and_in(
    environment: Environment,
    engines: Sequence[Engine],
    request: FrequencyRequest,
    report: LabelledProgress,
) -> xr.Dataset:
    """Dataset of engines on one mechanism, dry and in heat and moisture."""
    mechanism, modes = engines[0].mechanism, request.formulation.modes
    lines = environment_lines(mechanism, environment)
    wet = mechanism_in_state(mechanism, environment)
    exposed = [each.with_(mechanism=wet).fit_for(modes) for each in engines]
    theories = theory_attributes(exposed, modes)
    # The same elements in both states: only heat and moisture shall make a difference.
    elements = [_finer(*pair) for pair in zip(engines, exposed, strict=True)]
    exposed = [each.with_(element=e) for each, e in zip(exposed, elements, strict=True)]
    # First in the environment: what it refuses is refused before the long work.
    found, used = _in_one_state(exposed, request, report)
    dry = [
        each.with_(mechanism=mechanism, element=one.element, elements=one.elements)
        for each, one in zip(engines, used, strict=True)
    ]
    between = found["between_angle"].values if "between_angle" in found else np.zeros(0)
    as_meshed = replace(request, tolerance=None, smooth=between if request.smooth else False)
    states = {"dry": _in_one_state(dry, as_meshed, report)[0], state_name(environment): found}
    return with_states(states, lines).assign_attrs(theories)


def _finer(one: Engine, other: Engine) -> str:
    """Finer of two like engines' elements, the one whose beam theory leaves out less."""
    return max((one.element, other.element), key=one.element_kinds.index)


def _in_one_state(
    engines: Sequence[Engine], request: FrequencyRequest, report: LabelledProgress
) -> tuple[xr.Dataset, list[Engine]]:
    """Dataset of engines on one mechanism, and the engines with the elements that they used."""
    terms = None
    with one_thread():
        maps = [map_engine(engine, request, report) for engine in engines]
        if request.split_speeds.size and not engines[0].mechanism.is_free_strained:
            terms = speed_effect_terms(maps[0].systems, request, report)
        first, pictured = maps[0], []
        if not isinstance(request.smooth, bool) or request.smooth:
            pictured.append(drawn_between(first.systems, request, first.dataset))
        if len(request.shapes_at):
            pictured.append(shapes_asked_for(first.systems, request))
    used = [
        engine.with_(elements=each.engine.elements)
        for engine, each in zip(engines, maps, strict=True)
    ]
    return joined(used, request, [each.dataset for each in maps], terms, pictured), used
