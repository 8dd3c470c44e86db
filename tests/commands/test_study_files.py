"""Study files: wrong ones are refused in one line that names the file, the key and the remedy."""

from __future__ import annotations

import shutil
from dataclasses import replace

import pytest

from flexmech import InputError
from flexmech.studies import Goal, Limit, load_study, new_study, sweep_study, uncertainty_study
from tests.support.command import MODELS, run_command
from tests.support.study_data import FILE, THICKNESS, study, study_file, thickness

RANGE = 'range = ["1 mm", "3 mm"]\nsteps = 3'
VARY = f'[vary."{THICKNESS}"]\n{RANGE}'
NORMAL = 'normal = ["1 mm", "0.3 mm"]'
LIMIT = 'output = "f1"\nabove = "40 Hz"'
GOAL = '[[goals]]\noutput = "mass"\n'
LENGTHS = '"250 mm", "280 mm", "900 mm"'
PAIR = f'{GOAL}[[correlations]]\nvariables = ["length", "{THICKNESS}"]\ncoefficient = 0.5\n'
SCATTER = 'percentile = 97.5\n[vary.d]\npaths = ["materials.aluminium.density"]\n'
SCATTER = f'{GOAL}{SCATTER}normal = ["2923 kg/m^3", "30 kg/m^3"]\n'

# What is wrong: a part of the file, what stands there instead, and what the one line must hold.
WRONG = {
    "an unknown path": ("in_plane_thickness", "in_plane_thicknes", f"did you mean '{THICKNESS}'"),
    "a path twice": (
        f'paths = ["linkage.coupler"]\nvalues = [{LENGTHS}]',
        f'paths = ["{THICKNESS}"]\nrange = ["1 mm", "2 mm"]',
        "varies twice",
    ),
    "a unit of another kind": ('"3 mm"', '"3 kg"', f"vary.\"{THICKNESS}\": got '3 kg'"),
    "no unit": ('"3 mm"', "3", f'vary."{THICKNESS}": got the number 3.0'),
    "an empty range": ('"3 mm"', '"1 mm"', "second number must be greater"),
    "an impossible thickness": ('"1 mm", "3 mm"', '"-1 mm", "3 mm"', f"{THICKNESS} at -1 mm"),
    "negative thicknesses now and then": (RANGE, NORMAL, "smaller standard deviation"),
    "a negative spread": (RANGE, 'normal = ["1 mm", "-1 mm"]', "must be positive"),
    "two distributions": (RANGE, f"{RANGE}\n{NORMAL}", "range and normal"),
    "no distribution": (RANGE, "steps = 3", "range, values, uniform, normal, lognormal"),
    "an empty list": (LENGTHS, "", "length: list one value or more"),
    "an unknown key": ("steps = 3", "step = 3", f"vary.{THICKNESS}.step"),
    "no such material": (
        VARY,
        '[vary."links.coupler.material"]\nvalues = ["aluminium", "brass"]',
        "links.coupler.material at brass",
    ),
    "a range of texts": (
        VARY,
        '[vary."links.coupler.material"]\nrange = ["aluminium", "crank_aluminium"]',
        "values = [...]",
    ),
    "an unknown quantity": ('"mass" }', '"weight" }', "outputs.mass.quantity: got 'weight'"),
    "a limit on no output": ('output = "f1"', 'output = "f2"', "limits[0]: there is no output"),
    "a limit of another kind": ('"40 Hz"', '"40 kg"', "limits[0]: got '40 kg'"),
    "a limit of two sides": (LIMIT, f'{LIMIT}\nbelow = "50 Hz"', "limits[0]: give above"),
    "a sense that is none": (GOAL, f'{GOAL}sense = "least"\n', "goals[0].sense: got 'least'"),
    "a worth of no output": (
        GOAL,
        f'{GOAL}[failure_values]\nf2 = "0 Hz"\n',
        "failure_values.f2: there is no output",
    ),
    "a correlation of no variable": (GOAL, PAIR.replace('"length"', '"lenght"'), "did you mean"),
    "a correlation of one": (GOAL, PAIR.replace("0.5", "1.0"), "correlations[0].coefficient"),
    "a percentile of one hundred": (
        GOAL,
        SCATTER.replace("97.5", "100"),
        "goals[0].percentile",
    ),
    "an output for a variable": ("[vary.length]", "[vary.mass]", "a variable and an output"),
    "a name that results need": ("[vary.length]", "[vary.std]", "'std' cannot be the name"),
    "no outputs": (FILE[FILE.index("[outputs]") :], "[outputs]\n", "nothing is computed"),
    "samples that are no power of two": (
        *("seed = 1", "seed = 1\npercentile_samples = 12"),
        "take 8 or 16",
    ),
    "a negative seed": ("seed = 1", "seed = -1", "seed: got -1; give 0 or more"),
    "a seed of twenty digits": ("seed = 1", f"seed = {10**19}", "seed must be at most 9223372036"),
    "no TOML": ("seed = 1", "seed = 1 mm", "is not valid TOML"),
    "no model": ("aluminium_fourbar", "gold_fourbar", "gold_fourbar.toml"),
}


def told(folder, *words) -> str:
    """The one line of a command that is refused, and that leaves no result."""
    ended = run_command(folder / "out", *words, "--no-plots")
    assert (ended.exit_code, ended.stdout) == (2, "")
    assert ended.stderr.count("\n") == 1
    return ended.stderr


@pytest.mark.parametrize("wrong", WRONG)
def test_wrong_studies_are_refused_in_one_line(wrong, tmp_path):
    old, new, words = WRONG[wrong]
    file = study_file(tmp_path, old, new)
    line = told(tmp_path, "sweep", file)
    assert words in line
    assert wrong == "no model" or line.startswith(f"error: {file}: ")
    assert not (tmp_path / "out").exists()


def test_all_that_is_wrong_is_told_at_once(tmp_path):
    text = FILE.replace('"3 mm"', '"3 kg"').replace('"280 mm"', '"280 s"')
    line = told(tmp_path, "sweep", study_file(tmp_path, text=text))
    assert "2 errors" in line
    assert "3 kg" in line
    assert "280 s" in line


COMMANDS = {
    "no file": ("sweep", ("none.toml",), "", "", "flexmech new study"),
    "a search without a goal": ("optimize", (), GOAL, "", "add [[goals]]"),
    "combinations of a normal variable": (
        *("sweep", (), RANGE, 'normal = ["2 mm", "0.1 mm"]'),
        "give a number of samples",
    ),
    "too many combinations": ("sweep", (), "steps = 3", "steps = 30000000", "90000000"),
    "no power of two": ("uncertainty", ("--samples", 100), "", "", "take 64 or 128"),
    "no scheduler": ("sweep", ("--cluster", "nowhere"), "", "", "--cluster nowhere"),
    "nothing to go on with": ("sweep", ("--resume",), "", "", "--resume: there is no "),
}


@pytest.mark.parametrize("wrong", COMMANDS)
def test_commands_that_a_study_does_not_bear_are_refused(wrong, tmp_path):
    name, options, old, new, words = COMMANDS[wrong]
    if wrong == "no scheduler":
        pytest.importorskip("distributed")
    file = study_file(tmp_path, old, new)
    given = (tmp_path / "none.toml",) if wrong == "no file" else (file, *options)
    assert words in told(tmp_path, name, *given)


def test_a_study_file_is_read_as_it_stands(tmp_path):
    read = load_study(study_file(tmp_path, GOAL, SCATTER, f"percentile_samples = 128\n{FILE}"))
    assert read.names == [THICKNESS, "length", "d"]
    assert (read.percentile_samples, read.uncertain) == (128, ["d"])
    assert read.goals == (Goal("mass", "min", 97.5),)
    assert read.limits == (Limit("f1", least=40.0),)
    shared = load_study(
        study_file(
            tmp_path,
            f'[vary."{THICKNESS}"]',
            f'[vary.all]\npaths = ["{THICKNESS}", "links.rocker.in_plane_thickness"]',
        )
    )
    assert shared.names == ["all", "length"]
    both = sweep_study(replace(shared, variables=shared.variables[:1])).dataset
    links = 2923.0 * 25.4e-3 * (0.2794 + 0.2667) * both["all"].values
    crank = 2698.0 * 4.24e-3 * 25.4e-3 * 0.102
    assert both["mass"].values == pytest.approx(crank + links, rel=1e-9)


def test_the_study_to_start_from_is_one(tmp_path):
    (tmp_path / "study.toml").write_text(new_study())
    shutil.copy(MODELS / "aluminium_fourbar.toml", tmp_path)
    read = load_study(tmp_path / "study.toml")
    assert read.names == [THICKNESS, "thickness"]
    assert read.limits[0].least == 45.0


def test_of_variables_of_one_value_nothing_is_uncertain():
    with pytest.raises(InputError, match="every variable has one value"):
        uncertainty_study(study(thickness(2e-3, distribution="values")), 16)
