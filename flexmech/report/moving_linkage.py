"""The linkage that turns in the report: posture, mode shapes and deflection in link frames.

Posture is computed from the geometry at every degree. Mode shapes and deflections are stored in
the frame of each link, so that between two samples a link turns as a rigid one does and only the
small elastic displacement is interpolated.

Numbers and JSON stand in the page as text that ends no element.
"""

from __future__ import annotations

import json
import re
from base64 import b64encode
from html import escape
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from flexmech.analyses import MovingFrequencies, Response
from flexmech.analyses.response.dataset import needed
from flexmech.arrays import FloatArray, unbroken_runs
from flexmech.errors import InputError
from flexmech.linkages import CouplerCurve, FourBar, LinkEnd, Topology, assemblable
from flexmech.mechanism import Mechanism, drawn_parts
from flexmech.modelfile import mechanism_from_toml
from flexmech.plots import reading
from flexmech.plots.drawn_linkage.figures import real_shapes
from flexmech.plots.layout import round_enlargement
from flexmech.report.panels.frequencies import in_each_state
from flexmech.report.results import (
    Results,
    over_a_turn,
    speed_name,
    speed_unit_of,
    state_of,
    thinning,
)

# What would end a script element or is no character of JSON in old scripts.
ESCAPES = {
    ord("<"): "\\u003c",
    ord(">"): "\\u003e",
    ord("&"): "\\u0026",
    0x2028: "\\u2028",
    0x2029: "\\u2029",
}

# Where the bundle registers every kind of plot beyond lines and points, which its core has.
REGISTERED = re.compile(r"\.register\(\[(?:[\w$]+\(\),){20,}[\w$]+\(\)\]\)")

# Words that a column of a narrow screen does not hold.
LONG = re.compile(r"\S{17,}")


class Arrays:
    """Arrays of a page, each once; what shows them refers to them by number."""

    def __init__(self) -> None:
        self._numbers: dict[bytes, int] = {}
        self.encoded: list[str] = []
        """Little-endian numbers of 4 bytes, as text by base64."""

    def add(self, values: ArrayLike) -> int:
        """Keep an array, and give its number."""
        content = np.asarray(values, dtype="<f4").tobytes()
        if content not in self._numbers:
            self._numbers[content] = len(self.encoded)
            self.encoded.append(b64encode(content).decode("ascii"))
        return self._numbers[content]


def json_text(content: Any) -> str:
    r"""JSON that is text wherever it stands in a page: no name in it ends an element.

    Parameters
    ----------
    content : object
        Content of lists, dicts, texts, finite numbers and None.

    Returns
    -------
    str

    Examples
    --------
    >>> json_text({"name": "</script>"})
    '{"name":"\\u003c/script\\u003e"}'
    """
    text = json.dumps(content, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.translate(ESCAPES)


def breakable_markup(text: str) -> str:
    """A text whose long words, as those of a layup, are broken after a stroke.

    Parameters
    ----------
    text : str

    Returns
    -------
    str
        HTML.

    Examples
    --------
    >>> breakable_markup("crank: [U@45*2/U@-45*2/U*4]s at 20 rad/s")
    'crank: [U@45*2/<wbr>U@-45*2/<wbr>U*4]s at 20 rad/s'
    """
    # As templates escape all else; it comes with jinja2.
    from markupsafe import escape as escaped

    return LONG.sub(lambda word: word[0].replace("/", "/<wbr>"), str(escaped(text)))


def equation_markup(text: str) -> str:
    """An equation with ``_x`` or ``_{xy}`` lowered and ``^{xy}`` raised.

    Parameters
    ----------
    text : str

    Returns
    -------
    str
        HTML.

    Examples
    --------
    >>> equation_markup("K_g < e^{λt}")
    'K<sub>g</sub> &lt; e<sup>λt</sup>'
    """
    lowered = re.sub(r"_(?:\{([^}]*)\}|(\w))", _element("sub"), escape(text))
    return re.sub(r"\^(?:\{([^}]*)\}|(\w))", _element("sup"), lowered)


def _element(name: str) -> Any:
    return lambda found: f"<{name}>{found[1] or found[2]}</{name}>"


def plotly_source() -> str:
    """Text of plotly.js, which ends no script element.

    Kinds of plots that the report does not draw (maps, surfaces) stay in the text and are not
    registered: a browser would run all of them before the first line is drawn, which takes more
    than half of its time. A bundle that registers them in another way is taken as it is.

    Returns
    -------
    str
    """
    from plotly.offline import get_plotlyjs

    source: str = get_plotlyjs()
    if len(REGISTERED.findall(source)) == 1:
        source = REGISTERED.sub(".register([])", source)
    return source.replace("</script", "<\\/script")


# Most frames of a run's turn: the script interpolates between samples every three degrees.
MOST_FRAMES = 120
# Largest displacement as drawn, over the linkage's extent: seen at once, and the linkage is still
# itself.
ENLARGED_TO = 0.12
# What the ground holds is drawn so, whatever else is joined there.
HELD = ("clamp", "pivot")


def mechanism_of(results: Results) -> Mechanism | None:
    """Mechanism of the model file whose text the results hold; None if they hold none."""
    text = results.attribute("model_text")
    return mechanism_from_toml(text, results.attribute("model_file")) if text else None


def moving_linkage(mechanism: Mechanism, results: Results, arrays: Arrays) -> dict[str, Any]:
    """What the script draws of the linkage.

    Parameters
    ----------
    mechanism : Mechanism
    results : Results
    arrays : Arrays
        Numbers go here.

    Returns
    -------
    dict
        ``angle`` in degrees, ``links`` with ``origin`` and ``turn`` of their frames, ``joints``,
        ``parts`` of :func:`flexmech.mechanism.drawn_parts`, ``box`` in m, ``shapes`` and ``runs``
        with displacements in link frames, and ``path``.
    """
    degrees = _assemblable_angles(mechanism)
    linkage, topology = mechanism.linkage, mechanism.linkage.topology
    motion = linkage.motion(np.radians(degrees))
    turn = np.unwrap(motion.angle, axis=0)
    ends = np.stack(
        [motion.position(n, x) for n, one in enumerate(topology.links) for x in (0.0, one.length)],
        axis=1,
    )
    parts = drawn_parts(mechanism)
    held = [
        end["ground"] for spring in parts["springs"] for end in spring["ends"] if "ground" in end
    ]
    places = np.vstack([ends.reshape(-1, 2), np.reshape(held, (-1, 2))])
    low, high = np.minimum(places.min(axis=0), 0.0), np.maximum(places.max(axis=0), 0.0)
    extent = float(np.hypot(*(high - low)))
    unit = speed_unit_of(results)
    return {
        "angle": arrays.add(degrees),
        "links": [
            {
                "name": link.name,
                "length": link.length,
                "rigid": link.rigid,
                "origin": arrays.add(motion.origin[:, number]),
                "turn": arrays.add(turn[:, number]),
            }
            for number, link in enumerate(topology.links)
        ],
        "joints": _joints(topology),
        "parts": parts,
        "box": [*low.tolist(), *high.tolist()],
        "extent": extent,
        "shapes": _mode_shapes(results, unit, arrays),
        "runs": _runs(results, unit, extent, arrays),
        "path": _path(mechanism, degrees, arrays),
        "enlargedTo": ENLARGED_TO,
    }


def _joints(topology: Topology) -> list[dict[str, Any]]:
    """Joints with what they are: each place once, by its shortest name."""
    lines = {slider.joint: slider for slider in topology.sliders}
    kind_of = dict(zip(topology.joint_names, topology.joint_kinds, strict=True))
    places: dict[LinkEnd, list[str]] = {}
    for name, place in topology.joints.items():
        places.setdefault(topology.leader_of(place), []).append(name)
    found = []
    for names in places.values():
        name = min(names, key=len)
        place, kinds = topology.joints[name], {kind_of[each] for each in names}
        line = next((lines[each] for each in names if each in lines), None)
        guide = line.guide if line is not None else ""
        found.append(
            {
                "name": name,
                "kind": next((kind for kind in HELD if kind in kinds), kind_of[name]),
                "welded": "weld" in kinds,
                "turns": kinds != {"weld"},
                "link": topology.index(place.link),
                "end": place.end,
                "direction": None if line is None else line.direction,
                "guide": topology.index(guide) if guide else None,
            }
        )
    return found


def _assemblable_angles(mechanism: Mechanism) -> FloatArray:
    """Crank angles in whole degrees at which the linkage stands, without a gap between them."""
    degrees = np.arange(0.0, 361.0)
    stands = assemblable(mechanism.linkage, np.radians(degrees))
    if not stands.any():
        raise InputError("the linkage can be assembled at no crank angle of whole degrees")
    return degrees[max(unbroken_runs(stands), key=len)]


def _mode_shapes(results: Results, unit: str, arrays: Arrays) -> list[dict[str, Any]]:
    """Mode shapes over crank angle, of each state and speed and of every engine that has them."""
    result = results.first(MovingFrequencies)
    if result is None:
        return []
    shapes = []
    for state, data in in_each_state(result).items():
        for engine in reading.names_of(data, "engine"):
            # Shapes asked for are of the first engine, and finer.
            asked = "asked_shape" in data and engine == reading.names_of(data, "engine")[0]
            name, over = ("asked_shape", "shape_angle") if asked else ("mode_shape", "check_angle")
            place = "asked_position" if asked else "rigid_position"
            for speed in data["crank_speed"].values.tolist():
                one = data[name].sel(crank_speed=speed)
                one = one if asked else one.sel(engine=engine)
                order = ("mode", over, "part", "link", "station", "component")
                values = one.transpose(*order).values
                if not np.isfinite(values).all():
                    continue
                position = data[place].transpose(over, "link", "station", "component").values
                angle = reading.degrees(data[over])
                local = _in_link_frames(
                    real_shapes(values[:, :, 0] + 1j * values[:, :, 1]), position
                )
                angle, local = _closed(angle, local)
                when = {"state": state, "engine": engine, "speed": speed_name(speed, unit)}
                for number, mode in enumerate(data["mode"].values.tolist()):
                    shapes.append(
                        {
                            "when": {**when, "mode": f"mode {mode}"},
                            "angle": arrays.add(angle),
                            "stations": local.shape[-2],
                            "values": arrays.add(local[number]),
                        }
                    )
    return shapes


def _in_link_frames(displacement: FloatArray, position: FloatArray) -> FloatArray:
    """Turn displacements (..., angle, link, station, 2) from ground axes into link frames."""
    along = position[:, :, -1] - position[:, :, 0]
    direction = along / np.hypot(along[..., 0], along[..., 1])[..., None]
    x, y = direction[..., None, 0], direction[..., None, 1]
    u, v = displacement[..., 0], displacement[..., 1]
    return np.stack([x * u + y * v, -y * u + x * v], axis=-1)


def _closed(angle: FloatArray, local: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Signs that follow from angle to angle, and the first shape again after a whole turn."""
    for number in range(1, len(angle)):
        overlap = np.sum(local[:, number] * local[:, number - 1], axis=(-3, -2, -1))
        local[:, number] *= np.where(overlap < 0, -1.0, 1.0)[:, None, None, None]
    step = np.diff(angle).max(initial=0.0)
    if len(angle) > 2 and angle[0] == 0.0 and 0 < 360.0 - angle[-1] <= step + 1e-6:
        return np.append(angle, 360.0), np.concatenate([local, local[:, :1]], axis=1)
    return angle, local


def _runs(results: Results, unit: str, extent: float, arrays: Arrays) -> list[dict[str, Any]]:
    """Elastic displacements of each run's last turn, and how much they are enlarged."""
    runs = []
    for run in results.of_kind(Response):
        data = needed(run.dataset)
        turn = over_a_turn(data["frame_angle"].values.astype(float), thin=False)
        kept = thinning(len(turn.angle), MOST_FRAMES)
        order = ("frame_time", "link", "station", "component")
        position = turn.of(data["rigid_position"].transpose(*order).values)[kept]
        for engine in reading.names_of(data, "engine"):
            moved = turn.of(data["displacement"].sel(engine=engine).transpose(*order).values)
            local = _in_link_frames(moved[kept], position)
            speed = speed_name(float(data.attrs["crank_speed"]), unit)
            runs.append(
                {
                    "when": {"state": state_of(data.attrs), "engine": engine, "speed": speed},
                    "angle": arrays.add(turn.angle[kept]),
                    "stations": local.shape[-2],
                    "values": arrays.add(local),
                    "enlargement": round_enlargement(local, extent, ENLARGED_TO),
                }
            )
    return runs


def _path(mechanism: Mechanism, degrees: FloatArray, arrays: Arrays) -> dict[str, Any] | None:
    """Path of the coupler point, where the model names one."""
    linkage, point = mechanism.linkage, mechanism.coupler_point
    if point is None or not isinstance(linkage, FourBar):
        return None
    places = CouplerCurve(linkage, point).position(np.radians(degrees))
    return {"name": "coupler point", "places": arrays.add(places)}
