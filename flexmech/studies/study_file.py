"""Study files: TOML with a unit in every value, to a :class:`Study`."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

from pydantic import Field, ValidationError

from flexmech import si
from flexmech.analyses.parameters import Parameters
from flexmech.choices import EngineName, Prestress
from flexmech.errors import InputError
from flexmech.files import bytes_of, given_path
from flexmech.mechanism import Mechanism
from flexmech.modelfile import base_table as base
from flexmech.modelfile import load_mechanism
from flexmech.modelfile.messages import Findings, input_error
from flexmech.modelfile.read import MOST_BYTES
from flexmech.studies.outputs import Output, Quantity
from flexmech.studies.study import Correlation, Goal, Limit, Sense, Study, known_output
from flexmech.studies.variables import Distribution, Variable, known_variable
from flexmech.units import ANGULAR_SPEED, Dimension, parse_quantity, split_quantity

Value = str | float
Pair = tuple[Value, Value]
_DISTRIBUTIONS: tuple[Distribution, ...] = ("range", "values", "uniform", "normal", "lognormal")
_PERCENTILE = (
    "`optimize`: percentile of the output over the uncertain properties; the mean if left out"
)


class VaryTable(base.Table):
    """A variable, and what values it takes."""

    paths: list[base.Text] | None = base.optional(
        "Keys of the model that all get the value; the table's own name if left out"
    )
    range: Pair | None = base.optional("Least and greatest value")
    steps: int = Field(default=5, ge=2, description="Number of values of a range")
    values: list[Value] | None = base.optional("Every value, quantities or texts")
    uniform: Pair | None = base.optional("Least and greatest value, all equally likely")
    normal: Pair | None = base.optional("Mean and standard deviation")
    lognormal: Pair | None = base.optional("Mean and standard deviation, never negative")


class OutputTable(base.Table):
    """A number that is computed of every design."""

    quantity: Quantity = Field(description="Quantity to compute")
    speed: si.WrittenSpeed | None = base.optional("Crank speed")
    mode: int = Field(default=1, ge=1, description="Mode of frequencies and damping")
    orders: list[int] | None = base.optional("Multiples of the crank speed to keep away from")
    link: base.Text | None = base.optional("Link of deflection, strain and stress")
    joint: base.Text | None = base.optional("Joint of joint forces")
    point: base.Text | None = base.optional("Point of deviations from the path")
    prestress: Prestress = Field(default="equilibrium", description="Prestress of frequencies")
    angles: int = Field(default=36, ge=4, description="Crank angles over a turn")
    points: list[tuple[si.Distance, si.Distance]] | None = base.optional(
        "That the coupler point should pass"
    )


class LimitTable(base.Table):
    """A bound that an output must keep."""

    output: base.Text = Field(description="Name of an output")
    above: Value | None = base.optional("The least that it may be")
    below: Value | None = base.optional("The greatest that it may be")
    percentile: float | None = Field(default=None, gt=0, lt=100, description=_PERCENTILE)


class GoalTable(base.Table):
    """An output that is to be as small or as great as can be."""

    output: base.Text = Field(description="Name of an output")
    sense: Sense = Field(default="min", description="Whether less of it is better, or more")
    percentile: float | None = Field(default=None, gt=0, lt=100, description=_PERCENTILE)


class CorrelationTable(base.Table):
    """Correlation of two variables with distributions."""

    variables: tuple[base.Text, base.Text] = Field(description="Names of two variables")
    coefficient: float = Field(
        gt=-1, lt=1, description="Correlation of the underlying normal variables"
    )


class StudyFile(base.Table):
    """A study of designs."""

    model: base.Text = Field(description="Model file, beside the study or by its path")
    seed: int = Field(default=1, ge=0, description="Seed of the samples")
    engine: EngineName = "reference"
    percentile_samples: int = Field(
        default=64,
        ge=8,
        description="`optimize`: runs of every design where properties have distributions",
    )
    vary: dict[str, VaryTable]
    outputs: dict[str, OutputTable]
    limits: list[LimitTable] = Field(default_factory=list)
    goals: list[GoalTable] = Field(default_factory=list)
    correlations: list[CorrelationTable] = Field(default_factory=list)
    failure_values: dict[str, Value] = Field(
        default_factory=dict, description="Values that stand for the outputs of a design that fails"
    )


def load_study(path: str | os.PathLike[str]) -> Study:
    """Study of a study file.

    Parameters
    ----------
    path : path-like
        A TOML file; ``flexmech new study`` writes one to start from.

    Returns
    -------
    Study

    Raises
    ------
    InputError
        If a file cannot be read, or something in it is wrong; names the file, the key and the
        remedy.
    """
    file, shown = given_path(path), os.fspath(path)
    try:
        text = bytes_of(file, shown, "a study file", MOST_BYTES).decode("utf-8-sig")
        data = tomllib.loads(text)
    except OSError as error:
        raise InputError(
            f"{shown}: cannot be read ({error.strerror}); check the path, or write a study to "
            "start from with 'flexmech new study FILE'"
        ) from error
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InputError(
            f"{shown}: is not valid TOML: {error}; values with a unit stand in quotes, as in "
            'range = ["1 mm", "3 mm"]'
        ) from error
    try:
        tables = StudyFile.model_validate(data)
    except ValidationError as error:
        raise input_error(error, data, shown) from error
    model = Path(tables.model)
    mechanism = load_mechanism(model if model.is_absolute() else file.parent / model)
    return study_of(tables, mechanism, shown)


EXAMPLE_OF_A_STUDY = "aluminium_fourbar"
"""Name of the example that a new study file varies, beside which it stands."""


def new_study() -> str:
    """A commented study file to start from, of the aluminium four-bar.

    Returns
    -------
    str
        TOML.
    """
    folder = resources.files("flexmech.studies")
    return (folder / "study.toml").read_text(encoding="utf-8")


def study_of(tables: StudyFile, mechanism: Mechanism, shown: str) -> Study:
    """Study of the tables of a study file.

    Parameters
    ----------
    tables : StudyFile
    mechanism : Mechanism
        Mechanism of its model file.
    shown : str
        What messages call the file.

    Returns
    -------
    Study

    Raises
    ------
    InputError
        Names the file, all keys that are wrong, and the remedies.
    """
    findings, parameters = Findings(shown), Parameters.of(mechanism)
    variables: list[Variable] = []
    outputs: dict[str, Output] = {}
    limits: list[Limit] = []
    failures: dict[str, float] = {}
    for name, table in tables.vary.items():
        with findings.at(f'vary."{name}"'):
            variables.append(_variable(parameters, name, table))
    for name, own in tables.outputs.items():
        with findings.at(f"outputs.{name}"):
            outputs[name] = _output(own)
    findings.refuse()
    for number, limit in enumerate(tables.limits):
        with findings.at(f"limits[{number}]"):
            limits.append(_limit(limit, outputs))
    for number, goal in enumerate(tables.goals):
        with findings.at(f"goals[{number}]"):
            known_output(outputs, goal.output)
    for name, value in tables.failure_values.items():
        with findings.at(f"failure_values.{name}"):
            failures[name] = _number(value, known_output(outputs, name).dimension)
    findings.refuse()
    try:
        return Study(
            mechanism,
            tuple(variables),
            outputs,
            tables.seed,
            tuple(limits),
            tuple(Goal(goal.output, goal.sense, goal.percentile) for goal in tables.goals),
            tuple(Correlation(one.variables, one.coefficient) for one in tables.correlations),
            tables.engine,
            failures,
            tables.percentile_samples,
        )
    except InputError as error:
        raise error.within(shown) from error


def _variable(parameters: Parameters, name: str, table: VaryTable) -> Variable:
    given: dict[Distribution, Any] = {
        kind: getattr(table, kind) for kind in _DISTRIBUTIONS if getattr(table, kind) is not None
    }
    if len(given) != 1:
        raise InputError(
            f"give one of {', '.join(_DISTRIBUTIONS)}"
            + (f", not {' and '.join(given)}" if given else "")
        )
    keys = tuple(table.paths or [name])
    dimension = known_variable(parameters, name, keys, ANGULAR_SPEED)
    ((kind, values),) = given.items()
    if dimension is None:
        numbers: tuple[Any, ...] = tuple(str(value) for value in values)
    else:
        numbers = tuple(_number(value, dimension) for value in values)
    # In the unit in which they are written; of an empty list there is none.
    written = ""
    if dimension is not None and values:
        written = split_quantity(str(values[0]), dimension)[1]
    return Variable(name, keys, dimension, kind, numbers, table.steps, written)


def _output(table: OutputTable) -> Output:
    given = table.model_dump(exclude_none=True)
    if table.speed is not None:
        given["speed"] = table.speed.value
    for name in ("orders", "points"):
        if name in given:
            given[name] = tuple(given[name])
    return Output(**given)


def _limit(table: LimitTable, outputs: Mapping[str, Output]) -> Limit:
    if (table.above is None) == (table.below is None):
        raise InputError("give above = ... or below = ...")
    dimension = known_output(outputs, table.output).dimension
    if table.above is not None:
        least = _number(table.above, dimension)
        return Limit(table.output, least=least, percentile=table.percentile)
    assert table.below is not None
    greatest = _number(table.below, dimension)
    return Limit(table.output, greatest=greatest, percentile=table.percentile)


def _number(value: Value, dimension: Dimension) -> float:
    """SI value of a quantity; a bare number where it has no unit."""
    if not dimension.unit and not isinstance(value, str):
        return float(value)
    return parse_quantity(value, dimension)
