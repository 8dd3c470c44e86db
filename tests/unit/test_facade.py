"""What a user meets first: the package's names, their types, examples and short texts."""

from __future__ import annotations

import ast
import doctest
import importlib
import inspect
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexmech

ROOT = Path(__file__).parents[2]
PACKAGE = Path(flexmech.__file__).parent
# What is called or made by a user; errors and results come by themselves.
MADE = [
    name
    for name in flexmech.__all__
    if not inspect.ismodule(value := getattr(flexmech, name))
    and not (inspect.isclass(value) and issubclass(value, Exception | flexmech.Result))
]
LONGEST_REPR = 200


def test_names_are_listed_and_loaded_when_first_used() -> None:
    assert set(flexmech.__all__) <= set(dir(flexmech))
    assert "__version__" in vars(flexmech)
    with pytest.raises(AttributeError, match="attribute Linkag"):
        flexmech.Linkag  # noqa: B018
    heavy = "print([m for m in ('numpy', 'xarray', 'exudyn', 'pint') if m in sys.modules])"
    script = f"import sys, flexmech, flexmech.cli.application; dir(flexmech); {heavy}"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.stdout.strip() == "[]", done.stderr


def test_a_type_checker_sees_the_names() -> None:
    assert (PACKAGE / "py.typed").is_file()
    stub = ast.parse((PACKAGE / "__init__.pyi").read_text())
    named = {
        alias.asname
        for node in stub.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert named == set(flexmech.__all__)


def test_the_version_is_that_of_the_package() -> None:
    from importlib.metadata import version

    assert flexmech.__version__ == version("flexmech")


@pytest.mark.thorough
def test_examples_say_what_is_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every example of the package, with numpy and the package at hand."""
    monkeypatch.chdir(ROOT)
    finder = doctest.DocTestFinder(exclude_empty=True)
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE, verbose=False)
    failed, with_examples = [], set()
    for path in sorted(PACKAGE.rglob("*.py")):
        if ">>>" not in path.read_text():
            continue
        parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
        module = importlib.import_module(".".join(p for p in parts if p != "__init__"))
        for test in finder.find(module, extraglobs={"np": np, "flexmech": flexmech}):
            if test.examples:
                with_examples.add(test.name.rsplit(".", 1)[-1])
                outcome: list[str] = []
                runner.run(test, out=outcome.append)
                failed += outcome
    assert not failed, "".join(failed)
    assert set(MADE) <= with_examples, sorted(set(MADE) - with_examples)


def examples() -> list[Any]:
    """One of each kind of thing that a user holds in his hands."""
    mechanism = flexmech.load_mechanism(ROOT / "models" / "moist_composite_fourbar.toml")
    metal = flexmech.load_mechanism(ROOT / "models" / "aluminium_fourbar.toml")
    arm = flexmech.load_mechanism(ROOT / "models" / "rotating_arm.toml")
    engine = flexmech.ReferenceEngine(metal, 2)
    section = mechanism.sections["coupler"]
    assert section.layers is not None
    ply = section.layers.laminate.layers[0].ply
    return [
        mechanism,
        metal,
        arm,
        mechanism.linkage,
        arm.linkage,
        mechanism.coupler_point or flexmech.CouplerPoint(0.1, 0.2),
        section,
        metal.sections["crank"],
        section.layers,
        section.layers.laminate,
        ply,
        *flexmech.published_constituents().values(),
        flexmech.PointMass("crank", 0.1, 0.2),
        flexmech.ConstantSpeed(20.0),
        engine,
        flexmech.ExudynEngine(metal, 2),
        flexmech.HygrothermalState(60.0, 0.04),
        flexmech.Exposure(60.0, 0.85, 86400.0),
        flexmech.Formulation(),
        flexmech.Formulation("axial", flexmech.RotationTerms.parse("coriolis")),
        flexmech.RotationTerms(),
        flexmech.FrequencyRequest([0.0], [0.0]),
        flexmech.ResponseRequest(20.0),
        flexmech.moving_frequencies(engine, [0.0, 1.0], [0.0], modes=1),
    ]


def test_everything_says_in_a_line_what_it_is() -> None:
    for thing in examples():
        text = repr(thing)
        assert len(text) <= LONGEST_REPR, text
        assert "\n" not in text
        assert " at 0x" not in text


def test_mechanisms_and_results_show_themselves_in_a_notebook() -> None:
    metal = flexmech.load_mechanism(ROOT / "models" / "aluminium_fourbar.toml")
    result = flexmech.moving_frequencies(flexmech.ReferenceEngine(metal, 2), [0.0, 1.0], [0.0])
    for thing in (metal, result):
        page = thing._repr_html_()
        assert "<table" in page
        assert "data:image/png;base64," in page
    assert result.plot()._repr_png_().startswith(b"\x89PNG")  # type: ignore[attr-defined]


WRONG = [
    (lambda: flexmech.FourBar("0.1", 0.2, 0.3, 0.3), "ground|length"),
    (lambda: flexmech.ConstantSpeed("300 rpm"), "rad/s"),
    (lambda: flexmech.ReferenceEngine("model.toml"), "load_mechanism"),
    (lambda: flexmech.moving_frequencies("model.toml", [0.0], [0.0]), "ReferenceEngine"),
    (lambda: flexmech.natural_frequencies(flexmech.FourBar, 0.0), "ReferenceEngine"),
    (lambda: flexmech.ResponseRequest("fast"), "speed must be a number of rad/s"),
    (lambda: flexmech.HygrothermalState(temperature_rise="60 K"), "temperature_rise"),
    (lambda: flexmech.Formulation("axial", "coriolis"), "RotationTerms.parse"),
    (lambda: flexmech.RotationTerms.parse("gyroscopic"), "coriolis, centripetal, tangential"),
    (lambda: flexmech.crank_rocker_synthesis(30, 90), "rad"),
]


@pytest.mark.parametrize(("call", "words"), WRONG)
def test_what_is_given_for_something_else_is_refused_with_words_that_help(
    call: Any, words: str
) -> None:
    with pytest.raises(flexmech.InputError, match=words):
        call()
