"""Wrong study files: exit code 2 and one line with the file, the key and the remedy."""

from __future__ import annotations

import socket
from pathlib import Path

import pytest
from typer.testing import CliRunner

from flexmech.cli import app
from flexmech.studies import load_study, new_study
from tests.support.study_data import FILE, MODELS, THICKNESS, study_file

RANGE = 'range = ["1 mm", "3 mm"]\nsteps = 3'
NORMAL = 'normal = ["1 mm", "0.3 mm"]'
LIMIT = 'output = "f1"\nabove = "40 Hz"'
GOAL = '[[goals]]\noutput = "mass"\n'
END = f'{GOAL}[[correlations]]\nvariables = ["length", "{THICKNESS}"]\ncoefficient = 0.5\n'

WRONG = {
    "an unknown path": (
        f'[vary."{THICKNESS}"]',
        '[vary."links.coupler.in_plane_thicknes"]',
        f"there is no parameter 'links.coupler.in_plane_thicknes'; did you mean '{THICKNESS}'?",
    ),
    "a path of another kind": (
        'paths = ["linkage.coupler"]',
        'paths = ["linkage.coupler", "materials.aluminium.density"]',
        "length: its paths are of several kinds: linkage.coupler, materials.aluminium.density",
    ),
    "a unit of another kind": ('"3 mm"', '"3 kg"', f"vary.\"{THICKNESS}\": got '3 kg'"),
    "no unit": ('"3 mm"', "3", f'vary."{THICKNESS}": got the number 3.0, which'),
    "an empty range": ('"3 mm"', '"1 mm"', "is empty; the second number must be greater"),
    "an impossible thickness": ('"1 mm", "3 mm"', '"-1 mm", "3 mm"', f"{THICKNESS} at -1 mm: "),
    "a distribution of negative thicknesses": (
        RANGE,
        NORMAL,
        "one of a million designs is there: take a smaller standard deviation, uniform or "
        "lognormal",
    ),
    "a negative spread": (RANGE, 'normal = ["1 mm", "-1 mm"]', "must be positive"),
    "a lognormal of negative mean": (RANGE, 'lognormal = ["-1 mm", "1 mm"]', "must be positive"),
    "two kinds of values": (RANGE, f"{RANGE}\n{NORMAL}", "not range and normal"),
    "no values": (RANGE, "steps = 3", "give one of range, values, uniform, normal, lognormal"),
    "an empty list": ('"250 mm", "280 mm", "900 mm"', "", "length: list one value or more"),
    "a value twice": ('"280 mm", "900 mm"', '"250 mm"', "each one once"),
    "a range of one step": ("steps = 3", "steps = 1", "steps: got 1; give 2 or more"),
    "an unknown key": ("steps = 3", "step = 3", f"vary.{THICKNESS}.step"),
    "a text that is no material": (
        f'[vary."{THICKNESS}"]\n{RANGE}',
        '[vary."links.coupler.material"]\nvalues = ["aluminium", "brass"]',
        "links.coupler.material at brass: the changed model: links.coupler.material: there is no",
    ),
    "a range of texts": (
        f'[vary."{THICKNESS}"]\n{RANGE}',
        '[vary."links.coupler.material"]\nrange = ["aluminium", "crank_aluminium"]',
        "range needs two quantities; texts have values = [...]",
    ),
    "an impossible damping ratio": (
        f'[vary."{THICKNESS}"]\n{RANGE}',
        '[vary.damping-ratio]\nrange = ["-1 %", "5 %"]',
        "damping-ratio at -0.01: ",
    ),
    "a path twice": (
        'paths = ["linkage.coupler"]\nvalues = ["250 mm", "280 mm", "900 mm"]',
        f'paths = ["{THICKNESS}"]\nrange = ["1 mm", "2 mm"]',
        f"vary: {THICKNESS} varies twice; name it in one variable",
    ),
    "an unknown quantity": ('"mass" }', '"weight" }', "outputs.mass.quantity: got 'weight'"),
    "a mode that is none": ("angles = 4 }", "mode = 0 }", "outputs.f1.mode: got 0; give 1"),
    "a limit on an output that is missing": (
        'output = "f1"',
        'output = "f2"',
        "limits[0]: there is no output 'f2'; use one of mass, f1",
    ),
    "a limit of another kind": ('"40 Hz"', '"40 kg"', "limits[0]: got '40 kg'"),
    "a limit of two sides": (LIMIT, f'{LIMIT}\nbelow = "50 Hz"', "limits[0]: give above = ..."),
    "a limit without one": (LIMIT, 'output = "f1"', "limits[0]: give above = ..."),
    "a goal that is missing": (
        GOAL,
        '[[goals]]\noutput = "f3"\n',
        "goals[0]: there is no output 'f3'; use one of mass, f1",
    ),
    "a sense that is none": (
        GOAL,
        f'{GOAL}sense = "least"\n',
        "goals[0].sense: got 'least'",
    ),
    "a worth of an output that is missing": (
        GOAL,
        f'{GOAL}[failure_values]\nf2 = "0 Hz"\n',
        "failure_values.f2: there is no output 'f2'; use one of mass, f1",
    ),
    "an unknown variable in correlations": (
        GOAL,
        END.replace('"length"', '"lenght"'),
        "correlations: there is no variable 'lenght'; did you mean 'length'?",
    ),
    "a correlation with itself": (
        GOAL,
        END.replace(f'"{THICKNESS}"', '"length"'),
        "correlations: length and length need one coefficient, of two variables",
    ),
    "a coefficient of one": (GOAL, END.replace("0.5", "1.0"), "correlations[0].coefficient"),
    "a variable that is an output too": (
        "[vary.length]",
        "[vary.mass]",
        "is a variable and an output",
    ),
    "a name that results need": ("[vary.length]", "[vary.std]", "'std' cannot be the name"),
    "a name that is no word": ("[vary.length]", '[vary."m/1"]', "'m/1' cannot be the name"),
    "no outputs": (FILE[FILE.index("[outputs]") :], "[outputs]\n", "nothing is computed"),
    "a negative seed": ("seed = 1", "seed = -1", "seed: got -1; give 0 or more"),
    "no TOML": ("seed = 1", "seed = 1 mm", "is not valid TOML"),
    "a model that is not there": ("aluminium_fourbar", "gold_fourbar", "gold_fourbar.toml"),
}


def told(*arguments: object) -> str:
    """The one line of a command that is refused."""
    result = CliRunner().invoke(app, [*map(str, arguments)])
    assert result.exit_code == 2, result.output
    assert isinstance(result.exception, SystemExit)
    assert result.stdout == ""
    assert result.stderr.count("\n") == 1
    assert "Traceback" not in result.stderr
    return result.stderr


@pytest.mark.parametrize("name", WRONG)
def test_wrong_studies_are_refused_in_one_line(name: str, tmp_path: Path) -> None:
    old, new, message = WRONG[name]
    file = study_file(tmp_path, old, new)
    line = told("sweep", file, "--out", tmp_path / "out", "--no-plots")
    assert message in line
    if name != "a model that is not there":
        assert line.startswith(f"error: {file}: ")
    assert not (tmp_path / "out").exists()


def test_all_that_is_wrong_is_told_at_once(tmp_path: Path) -> None:
    text = FILE.replace('"3 mm"', '"3 kg"').replace('"280 mm"', '"280 s"')
    line = told("sweep", study_file(tmp_path, text=text))
    assert "2 errors" in line
    assert "3 kg" in line
    assert "280 s" in line


def test_a_study_that_is_not_there(tmp_path: Path) -> None:
    line = told("sweep", tmp_path / "none.toml")
    assert "none.toml: cannot be read (No such file or directory)" in line
    assert "flexmech new study FILE" in line


def test_a_search_without_a_goal(tmp_path: Path) -> None:
    line = told("optimize", study_file(tmp_path, GOAL, ""))
    assert "goals: there is none; add [[goals]]" in line


def test_a_distribution_without_ends_has_no_combinations(tmp_path: Path) -> None:
    file = study_file(tmp_path, RANGE, 'normal = ["2 mm", "0.1 mm"]')
    assert "a normal distribution has no combinations; give a number of samples" in told(
        "sweep", file
    )


def test_too_many_combinations(tmp_path: Path) -> None:
    file = study_file(tmp_path, "steps = 3", "steps = 30000000")
    assert "90000000 combinations are too many; take fewer steps, or a sample" in told(
        "sweep", file
    )


def test_a_number_of_samples_that_is_no_power_of_two(tmp_path: Path) -> None:
    line = told("uncertainty", study_file(tmp_path), "--samples", 100)
    assert "samples: 100 is no power of two; take 64 or 128" in line


@pytest.mark.thorough  # it waits for ten seconds
def test_a_cluster_that_does_not_answer(tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    line = told("sweep", study_file(tmp_path), "--cluster", address)
    assert f"--cluster {address}: no scheduler answers there; start one with 'dask " in line


def test_a_cluster_whose_address_is_none(tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    line = told("sweep", study_file(tmp_path), "--cluster", "nowhere")
    assert "--cluster nowhere: no scheduler answers there" in line


class TestStores:
    @pytest.fixture
    def kept(self, tmp_path: Path) -> Path:
        out = tmp_path / "out"
        result = CliRunner().invoke(app, self.sweep(study_file(tmp_path), out))
        assert result.exit_code == 0, result.output
        return out

    @staticmethod
    def sweep(file: Path, out: Path, *more: str) -> list[str]:
        return ["sweep", str(file), "--out", str(out), "--no-plots", *more]

    def test_designs_that_are_there_are_not_written_over(self, kept: Path, tmp_path: Path) -> None:
        line = told(*self.sweep(tmp_path / "study.toml", kept))
        assert f"{kept / 'designs.zarr'}: holds designs already; go on with --resume" in line

    def test_nothing_to_go_on_with(self, tmp_path: Path) -> None:
        line = told(*self.sweep(study_file(tmp_path), tmp_path / "out", "--resume"))
        assert "--resume: there is no " in line

    @pytest.mark.parametrize(
        ("old", "new", "difference"),
        [
            ('"3 mm"', '"4 mm"', f'vary.{THICKNESS} is ["range", [0.001, 0.003], '),
            ("seed = 1", "seed = 2", "seed is 1 there and 2 now"),
            ("steps = 3", "steps = 4", "designs is 9 there and 12 now"),
            ("angles = 4", "angles = 5", "outputs.f1 is {"),
            ("aluminium_fourbar", "steel_fourbar", 'model is "'),
        ],
    )
    def test_a_store_of_another_study(
        self, kept: Path, tmp_path: Path, old: str, new: str, difference: str
    ) -> None:
        line = told(*self.sweep(study_file(tmp_path, old, new), kept, "--resume"))
        assert f"{kept / 'designs.zarr'}: is of another study: {difference}" in line
        assert "use --force to begin again, or another folder" in line

    def test_a_sample_is_not_every_combination(self, kept: Path, tmp_path: Path) -> None:
        more = ("--samples", "9", "--resume")
        assert "samples is null there and 9 now" in told(
            *self.sweep(tmp_path / "study.toml", kept, *more)
        )

    def test_another_engine(self, kept: Path, tmp_path: Path) -> None:
        more = ("--engine", "exudyn", "--resume")
        assert 'engine is "reference" there and "exudyn" now' in told(
            *self.sweep(tmp_path / "study.toml", kept, *more)
        )

    def test_a_damaged_store(self, kept: Path, tmp_path: Path) -> None:
        (kept / "designs.zarr" / "zarr.json").write_text("{")
        line = told(*self.sweep(tmp_path / "study.toml", kept, "--resume"))
        assert "is no store of a study that can be gone on with; use --force" in line

    def test_force_begins_again(self, kept: Path, tmp_path: Path) -> None:
        file = study_file(tmp_path, "steps = 3", "steps = 2")
        result = CliRunner().invoke(app, self.sweep(file, kept, "--force"))
        assert result.exit_code == 0, result.output
        assert (kept / "designs.csv").read_text().count("\n") == 7


def test_the_study_to_start_from_can_be_loaded(tmp_path: Path) -> None:
    file = tmp_path / "study.toml"
    file.write_text(new_study())
    (tmp_path / "aluminium_fourbar.toml").write_bytes(
        (MODELS / "aluminium_fourbar.toml").read_bytes()
    )
    study = load_study(file)
    assert study.names == [THICKNESS, "thickness"]
    assert study.limits[0].least == 45.0
