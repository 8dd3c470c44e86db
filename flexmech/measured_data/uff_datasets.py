"""Contents of a universal file as the data sets that pyuff writes, and back."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.errors import InputError, one_line
from flexmech.measured_data.uff_units import (
    QUANTITIES,
    SI,
    UffDegreeOfFreedom,
    UffFile,
    UffFrame,
    UffFunction,
    UffFunctionKind,
    UffMode,
    UffNodes,
    UffUnits,
    function_unit,
    quantity_of,
    si_unit,
)
from flexmech.units import ZERO_CELSIUS

KINDS: dict[UffFunctionKind, int] = {
    "general": 0,
    "time response": 1,
    "auto spectrum": 2,
    "cross spectrum": 3,
    "frequency response": 4,
    "coherence": 6,
}
ABSCISSAE = {"time": 17, "frequency": 18, "other": 1}
# Constants of the format: the code of SI in data set 164, that of complex modes in data set 55, and
# how many characters a line of text and the name of an entity have room for.
SI_CODE, COMPLEX_MODE = 1, 3
LINE, ENTITY = 80, 10
# Part of its step by which an abscissa may miss even spacing: the step is written with six digits,
# by which the last of two hundred values is off by as much.
UNEVEN = 1e-3

DataSet = dict[str, Any]


def datasets_of(contents: UffFile) -> list[DataSet]:
    """Data sets to write, in the order in which they refer to each other.

    Parameters
    ----------
    contents : UffFile

    Returns
    -------
    list of dict

    Raises
    ------
    InputError
        Values are not finite, or a function is unevenly spaced.
    """
    return [
        _header(contents),
        _units(),
        *([_frames(contents.frames)] if contents.frames else []),
        *([_nodes(contents.nodes)] if contents.nodes else []),
        *(_function(number, one) for number, one in enumerate(contents.functions, 1)),
        *(_mode(mode) for mode in contents.modes),
    ]


def contents_of(datasets: Sequence[DataSet]) -> UffFile:
    """Data sets as read by pyuff, in SI units.

    Parameters
    ----------
    datasets : sequence of dict

    Returns
    -------
    UffFile

    Raises
    ------
    InputError
        The units of data set 164 are none.
    """
    readers: dict[int, Callable[[DataSet, UffUnits | None], Any]] = {
        15: _read_nodes,
        18: _read_frames,
        55: _read_mode,
        58: _read_function,
    }
    found: dict[int, list[Any]] = {number: [] for number in (*readers, 151, 164)}
    others: list[int] = []
    # Units count for what follows them.
    units: UffUnits | None = None
    for dataset in datasets:
        number = int(dataset.get("type", 0))
        if number == 164:
            units = UffUnits(float(dataset["length"]), float(dataset["force"]))
            if not all(np.isfinite(size) and size > 0.0 for size in units):
                raise InputError(f"data set 164 has the factors {units}: correct its units")
        elif number == 151:
            found[151].append(dataset)
        # Only complex modes are read from data at nodes; all other data sets are read.
        elif number in readers and len(dataset) > 1 and (number != 55 or "eig" in dataset):
            found[number].append(readers[number](dataset, units))
        else:
            others.append(number)
    header: Mapping[str, Any] = found[151][0] if found[151] else {}
    return UffFile(
        model=_text(header.get("model_name")),
        description=_text(header.get("description")),
        program=_text(header.get("program")),
        nodes=_joined(found[15]),
        frames=tuple(frame for group in found[18] for frame in group),
        functions=tuple(found[58]),
        modes=tuple(found[55]),
        others=tuple(others),
    )


def _header(contents: UffFile) -> DataSet:
    return {
        "type": 151,
        "model_name": _line(contents.model),
        "description": _line(contents.description),
        "db_app": _line(contents.program),
        "program": _line(contents.program),
    }


def _units() -> DataSet:
    return {
        "type": 164,
        "units_code": SI_CODE,
        "units_description": "SI: m, N, kg, s, K",
        "temp_mode": 1,
        "length": 1.0,
        "force": 1.0,
        "temp": 1.0,
        "temp_offset": ZERO_CELSIUS,
    }


def _frames(frames: Sequence[UffFrame]) -> DataSet:
    """Origin, a point on the x axis, and one in the plane of x and z."""
    origin = np.array([[*frame.origin, 0.0] for frame in frames])
    along = np.array([[np.cos(frame.angle), np.sin(frame.angle), 0.0] for frame in frames])
    return {
        "type": 18,
        "cs_num": [frame.label for frame in frames],
        "ref_cs_num": [0 for _ in frames],
        "cs_name": [_line(frame.name)[:40] for frame in frames],
        "ref_o": origin,
        "x_point": origin + along,
        "xz_point": origin + np.array([0.0, 0.0, 1.0]),
    }


def _nodes(nodes: UffNodes) -> DataSet:
    _check_finite(nodes.position, "positions of nodes")
    x, y, z = np.asarray(nodes.position, dtype=float).T
    return {
        "type": 15,
        "node_nums": nodes.label,
        "disp_cs": nodes.frame,
        "x": x,
        "y": y,
        "z": z,
    }


def _function(number: int, one: UffFunction) -> DataSet:
    _check_finite(one.position, f"abscissa of {one.name}")
    # What is not a number would be written as zero.
    _check_finite(one.values, one.name)
    step = np.diff(one.position)
    if np.any(abs(step - step.mean()) > UNEVEN * abs(step.mean())):
        raise InputError(f"{one.name}: is unevenly spaced; interpolate it to equal steps")
    label = si_unit(one.quantity, one.over)
    return {
        "type": 58,
        "func_type": KINDS[one.kind],
        "func_id": number,
        "id1": _line(one.name),
        "id2": _line(one.remark),
        **_degree_of_freedom("rsp", one.response),
        **_degree_of_freedom("ref", one.reference),
        "abscissa_spacing": 1,
        "abscissa_spec_data_type": ABSCISSAE[one.abscissa],
        "abscissa_axis_lab": one.abscissa.capitalize(),
        "abscissa_axis_units_lab": {"time": "s", "frequency": "Hz"}.get(one.abscissa, "NONE"),
        "ordinate_spec_data_type": QUANTITIES[one.quantity].code,
        "ordinate_axis_lab": one.quantity.capitalize(),
        "ordinate_axis_units_lab": si_unit(one.quantity) or "NONE",
        "orddenom_spec_data_type": QUANTITIES[one.over].code,
        "orddenom_axis_lab": one.over.capitalize() if label != si_unit(one.quantity) else "NONE",
        "orddenom_axis_units_lab": si_unit(one.over) or "NONE",
        "z_axis_axis_lab": "NONE",
        # pyuff takes the step from the first two values.
        "x": one.position[0] + step.mean() * np.arange(one.position.size),
        "data": np.array(one.values),
    }


def _degree_of_freedom(prefix: str, where: UffDegreeOfFreedom) -> DataSet:
    return {
        f"{prefix}_node": where.node,
        f"{prefix}_dir": where.direction,
        f"{prefix}_ent_name": _line(where.entity)[:ENTITY],
    }


def _mode(mode: UffMode) -> DataSet:
    _check_finite(mode.shape, f"shape of mode {mode.number}")
    _check_finite(np.array([mode.pole, mode.modal_a]), f"pole of mode {mode.number}")
    shape = np.asarray(mode.shape, dtype=complex)
    return {
        "type": 55,
        "id1": _line(mode.name),
        "analysis_type": COMPLEX_MODE,
        "data_ch": 2,
        "spec_data_type": QUANTITIES["displacement"].code,
        "load_case": 0,
        "mode_n": mode.number,
        "eig": complex(mode.pole),
        "modal_a": complex(mode.modal_a),
        "node_nums": mode.nodes,
        **{f"r{axis + 1}": shape[:, axis] for axis in range(3)},
    }


def _line(text: str) -> str:
    """One line in ASCII, never blank: of what a file does not say it holds NONE."""
    plain = one_line(text).encode("ascii", "replace").decode("ascii").strip()
    return plain[:LINE] or "NONE"


def _check_finite(values: Any, name: str) -> None:
    if not np.all(np.isfinite(values)):
        raise InputError(
            f"{name}: holds values that are not finite, which a universal file cannot; leave it out"
        )


def _text(value: object) -> str:
    text = str(value or "").strip()
    return "" if text == "NONE" else text


def _integers(values: Any) -> Any:
    return np.round(np.asarray(values, dtype=float)).astype(np.intp)


def _read_nodes(dataset: DataSet, units: UffUnits | None) -> UffNodes:
    position = np.column_stack([dataset["x"], dataset["y"], dataset["z"]]).astype(float)
    return UffNodes(
        _integers(dataset["node_nums"]),
        position / (units or SI).length,
        _integers(dataset["disp_cs"]),
    )


def _joined(groups: Sequence[UffNodes]) -> UffNodes | None:
    if not groups:
        return None
    return UffNodes(
        np.concatenate([group.label for group in groups]),
        np.concatenate([group.position for group in groups]),
        np.concatenate([group.frame for group in groups]),
    )


def _read_frames(dataset: DataSet, units: UffUnits | None) -> list[UffFrame]:
    origin, point = (np.asarray(dataset[name], dtype=float) for name in ("ref_o", "x_point"))
    along = point - origin
    angle: FloatArray = np.arctan2(along[:, 1], along[:, 0])
    length = (units or SI).length
    return [
        UffFrame(int(label), _text(name), (float(x / length), float(y / length)), float(turned))
        for label, name, (x, y, _), turned in zip(
            dataset["cs_num"], dataset["cs_name"], origin, angle, strict=True
        )
    ]


def _read_function(dataset: DataSet, units: UffUnits | None) -> UffFunction:
    unit, factor, problem = function_unit(dataset, units)
    position, values = _counted(dataset)
    code = int(dataset["abscissa_spec_data_type"])
    kind = int(dataset["func_type"])
    return UffFunction(
        kind=next((name for name, known in KINDS.items() if known == kind), "general"),
        abscissa="time" if code == 17 else "frequency" if code == 18 else "other",
        position=position,
        values=values * factor,
        quantity=quantity_of(int(dataset["ordinate_spec_data_type"])),
        over=quantity_of(int(dataset["orddenom_spec_data_type"])),
        response=_read_degree_of_freedom("rsp", dataset),
        reference=_read_degree_of_freedom("ref", dataset),
        name=_text(dataset["id1"]),
        remark=_text(dataset["id2"]),
        unit=unit,
        problem=problem,
    )


def _counted(dataset: DataSet) -> tuple[FloatArray, FloatArray | ComplexArray]:
    """Abscissa and values (N,), as many as data set 58 says: its last line may be padded."""
    count = int(dataset["num_pts"])
    position, values = np.asarray(dataset["x"], dtype=float), np.asarray(dataset["data"])
    if len(values) < count:
        raise InputError(
            f"the function {_text(dataset['id1'])!r} has {len(values)} of the {count} values that "
            "its data set 58 announces; export it anew"
        )
    return position[:count], values[:count]


def _read_degree_of_freedom(prefix: str, dataset: DataSet) -> UffDegreeOfFreedom:
    return UffDegreeOfFreedom(
        int(dataset[f"{prefix}_node"]),
        int(dataset[f"{prefix}_dir"]),
        _text(dataset[f"{prefix}_ent_name"]) or "NONE",
    )


def _read_mode(dataset: DataSet, _units: UffUnits | None) -> UffMode:
    return UffMode(
        number=int(dataset["mode_n"]),
        pole=complex(dataset["eig"]),
        nodes=_integers(dataset["node_nums"]),
        shape=np.column_stack([dataset["r1"], dataset["r2"], dataset["r3"]]).astype(complex),
        modal_a=complex(dataset["modal_a"]),
        name=_text(dataset["id1"]) or "NONE",
    )
