"""Results of a shaped law: words, tables, pictures, refusals, and the model file's keys."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from flexmech import (
    ExudynEngine,
    InputError,
    InputShaper,
    LawDrive,
    Mechanism,
    ReferenceEngine,
    Response,
    ResponseRequest,
    ShapedDrive,
    Shaping,
    TableDrive,
    load_mechanism,
    response,
)
from flexmech.analyses.response.move_times import moves_of
from flexmech.cli import app
from tests.support.figure_checks import check_layout, check_texts
from tests.support.strategies import fourbar
from tests.unit.driven_data import LAW, shaped_run

pytestmark = pytest.mark.usefixtures("rough_pictures")

HELD = TableDrive((0.0, 0.1, 0.2, 0.3), (0.0, 0.1, 0.4, 0.9), ends="held", dwell=0.2)


def run(*arguments: str | Path) -> tuple[int, str, str]:
    result = CliRunner().invoke(app, [str(a) for a in arguments])
    return result.exit_code, result.stdout, result.stderr


def model(folder: Path, drive: object = LAW) -> Path:
    file = folder / "model.toml"
    file.write_text(fourbar(drive=drive).to_toml())
    return file


def test_the_answer_begins_with_what_the_shaper_leaves() -> None:
    summary = shaped_run().summary()
    assert len(summary.answer) <= 3
    first = summary.answer[0]
    assert first.startswith("After the stop the ")
    assert "with the ZV shaper for modes 1 and 2 by " in first
    assert first.endswith(" ms longer.")
    numbers = {one.name: one for one in summary.numbers}
    data = shaped_run().dataset
    assert numbers["shaper_delay"].value == pytest.approx(1e3 * data.attrs["shaper_delay"])
    assert "shaped_residual_amplitude" in numbers
    lines = [str(line) for line in summary.details]
    assert any(line.startswith("ZV shaper for mode 1 at ") for line in lines)
    assert sum(line.startswith("residual vibration over the time of a move") for line in lines) == 2


def test_the_shaped_run_is_a_run_of_its_own() -> None:
    """The same numbers as a run by the shaped law alone, which a model file can state."""
    data = shaped_run().dataset
    shaper = InputShaper(
        tuple(data["impulse_time"].values.tolist()), tuple(data["impulse_weight"].values.tolist())
    )
    request = ResponseRequest(ShapedDrive(LAW, shaper), samples=240, step=2e-4)
    alone = response(ReferenceEngine(fourbar(damping_time=1e-5), 2), request).dataset
    np.testing.assert_allclose(data["shaped_time"], alone["time"])
    for name in ("deflection", "driving_torque", "crank_angle", "residual_amplitude"):
        scale = float(abs(alone[name]).max())
        np.testing.assert_allclose(data[f"shaped_{name}"], alone[name], atol=1e-9 * scale)


def test_tables_and_pictures(tmp_path: Path) -> None:
    result = shaped_run()
    table = result.tables()["residual_over_move_time"]
    assert len(table) == 2 * 3 * 4
    assert list(table.columns[:6]) == [
        "law",
        "computed_by",
        "move_time_s",
        "whole_time_s",
        "mode",
        "frequency_Hz",
    ]
    one = table[(table.law == "shaped") & (table.move_time_s == 0.15) & (table["mode"] == 1)].iloc[
        0
    ]
    own = result.dataset["move_amplitude"].sel(law="shaped", move_time=0.15, mode=1)
    assert one["coupler_amplitude_m"] == float(own.sel(link="coupler"))
    assert one["whole_time_s"] == pytest.approx(0.15 + result.dataset.attrs["shaper_delay"])
    figures = result.figures()
    for name in ("shaped_law", "residual_over_move_time"):
        check_layout(figures[name])
        check_texts(figures[name])
    result.save(tmp_path)
    loaded = Response.load(tmp_path / "response.nc")
    assert loaded.summary().answer == result.summary().answer


def test_modes_that_ring_are_shaped_for_where_none_are_chosen() -> None:
    request = ResponseRequest(LAW, samples=240, step=4e-4, shaping=Shaping("zv"), modes=3)
    few = ResponseRequest(
        LAW, samples=240, step=4e-4, shaping=Shaping("zv"), modes=3, move_times=(0.15,)
    )
    data = response(ReferenceEngine(fourbar(), 2), few).dataset
    amplitude = data["modal_amplitude"].max("link").values[0]
    wanted = np.flatnonzero(amplitude > 0.1 * amplitude.max()) + 1
    assert data.attrs["shaped_modes"] == ",".join(map(str, wanted))
    assert len(moves_of(request, 200.0)) == 61
    assert len(moves_of(request, 1e6)) == 13


def test_times_of_a_move_need_no_shaper_and_no_dwell() -> None:
    law = LawDrive("cycloid", 1.0, 0.1)
    request = ResponseRequest(law, samples=100, step=5e-4, move_times=(0.2, 0.1))
    result = response(ReferenceEngine(fourbar(), 2), request)
    np.testing.assert_array_equal(result.dataset["move_time"], [0.1, 0.2])
    assert list(result.dataset["law"].values) == ["plain"]
    assert "residual_over_move_time" in result.figures()


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"speed": 20.0, "shaping": Shaping("zv")}, "law that stops"),
        ({"speed": LAW, "shaping": Shaping("zv"), "shaft": "free"}, "shaft prescribed"),
        ({"speed": LAW, "move_times": (0.1, -1.0)}, "time of a move must be positive"),
        ({"speed": LAW, "move_times": ()}, "give one to"),
        ({"speed": LAW, "shaping": "zv"}, "give a flexmech.Shaping"),
    ],
)
def test_requests_that_cannot_be_are_refused(asked: dict[str, object], said: str) -> None:
    with pytest.raises(InputError, match=said):
        ResponseRequest(**asked)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("wrong", "said"),
    [({"modes": ()}, "one or more"), ({"modes": (1, 1)}, "each once"), ({"kind": "xy"}, "shaper")],
)
def test_shapings_that_cannot_be_are_refused(wrong: dict[str, object], said: str) -> None:
    with pytest.raises(InputError, match=said):
        Shaping(**({"kind": "zv"} | wrong))  # type: ignore[arg-type]


def test_a_shaper_without_a_dwell_is_refused() -> None:
    request = ResponseRequest(LawDrive("cycloid", 1.0, 0.1), shaping=Shaping("zv"))
    with pytest.raises(InputError, match="give a dwell"):
        response(ReferenceEngine(fourbar(), 2), request)


def test_a_blow_is_for_an_engine_that_simulates() -> None:
    mechanism, request = fourbar(), ResponseRequest(HELD, samples=100, step=1e-3)
    with pytest.raises(InputError, match="where the theory of the reference engine's equations"):
        response(ReferenceEngine(mechanism, 2), request)
    found = response(ExudynEngine(mechanism, 2), request)
    assert any("its speed jumps by -6 rad/s" in str(line) for line in found.summary().details)
    asked = ResponseRequest(HELD, samples=100, step=1e-3, move_times=(0.1,))
    with pytest.raises(InputError, match="leave --move-times out"):
        response(ExudynEngine(mechanism, 2), asked)


class TestCommandLine:
    def test_turns_that_count_for_nothing_are_remarked(self, tmp_path: Path) -> None:
        asked = ("--engine", "reference", "--elements", "2", "--step", "0.5 ms", "--no-plots")
        file, out = model(tmp_path, LawDrive("cycloid", 1.0, 0.1)), ("--out", tmp_path)
        for turns, remarked in ((("--revolutions", "4"), True), ((), False)):
            code, said, _ = run("response", file, *asked, *out, *turns)
            assert code == 0
            assert ("remark: --revolutions counts for nothing under a law" in said) == remarked

    @pytest.mark.parametrize(
        ("options", "said"),
        [
            (("--shaper", "zz"), "'zz' is not one of"),
            (("--shaper", "zv", "--speed", "10 rad/s"), "a shaper is for a law that stops"),
            (("--shaper", "zv", "--shaft", "free"), "choose shaft prescribed"),
            (("--shaped-modes", "1"), "add --shaper"),
            (("--shaped-for", "path"), "add --shaper"),
            (("--shaper", "zv", "--shaped-modes", "0"), "counted from 1"),
            (("--shaper", "ei", "--tolerated", "2"), "between 0 and 1"),
            (("--shaper", "zv", "--tolerated", "2%"), "belongs to the shaper ei"),
            (("--tolerated", "2%"), "need --shaper"),
            (("--move-times", "0:1:0.1 s"), "not positive"),
            (("--move-times", "1 kg"), "--move-times"),
        ],
    )
    def test_what_is_wrong_is_told_in_one_line(
        self, options: tuple[str, ...], said: str, tmp_path: Path
    ) -> None:
        asked = ("--engine", "reference", "--out", tmp_path / "out", *options)
        code, _, error = run("response", model(tmp_path), *asked)
        assert code == 2
        [line] = error.splitlines()
        assert said in line


class TestModelFile:
    @pytest.mark.parametrize(
        "drive",
        [
            ShapedDrive(LAW, InputShaper((0.0, 0.01), (0.6, 0.4))),
            HELD,
            TableDrive((0.0, 0.1, 0.2, 0.3), (0.0, 0.1, 0.4, 0.9), ends="rest", dwell=0.1, moves=2),
        ],
    )
    def test_drives_are_written_and_read(self, drive: object, tmp_path: Path) -> None:
        mechanism: Mechanism = fourbar(drive=drive)
        file = tmp_path / "model.toml"
        file.write_text(mechanism.to_toml())
        assert load_mechanism(file).drive == drive

    @pytest.mark.parametrize(
        ("lines", "said"),
        [
            ('impulses = [["0 s", 0.5], ["10 ms", 0.6]]', "impulses: weights of impulses must add"),
            ('impulses = [["0 s", 0.5], ["10 kg", 0.5]]', "impulses: [1]"),
            ('impulses = [["0 s"], ["10 ms", 0.5]]', "impulses: [0]: got 1 values"),
        ],
    )
    def test_impulses_that_cannot_be_are_refused(
        self, lines: str, said: str, tmp_path: Path
    ) -> None:
        file = tmp_path / "model.toml"
        file.write_text(fourbar(drive=LAW).to_toml().replace("[drive]", f"[drive]\n{lines}"))
        with pytest.raises(InputError) as caught:
            load_mechanism(file)
        assert said in str(caught.value)

    def test_a_free_table_does_not_dwell(self) -> None:
        with pytest.raises(InputError, match="choose ends rest or held"):
            TableDrive((0.0, 0.1, 0.2, 0.3), (0.0, 0.1, 0.4, 0.9), dwell=0.1)
