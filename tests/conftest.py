"""Mechanisms that many tests use."""

from __future__ import annotations

import functools
import gc
import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

# Many small matrices: more BLAS threads only slow the tests down.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# Where Python writes no compiled modules, each command that a test starts would compile
# the whole package again: they are kept in the folder of temporary files.
if os.environ.pop("PYTHONDONTWRITEBYTECODE", ""):
    kept = str(Path(tempfile.gettempdir()) / f"flexmech-tests-{os.getuid()}")
    sys.pycache_prefix = os.environ.setdefault("PYTHONPYCACHEPREFIX", kept)
    sys.dont_write_bytecode = False

import pytest
import typer.testing
from hypothesis import settings

from flexmech import Mechanism, load_mechanism
from flexmech.verification.methods.frequencies import unit_arm as make_unit_arm
from tests.support.command import MODELS, Ended, run_command

# Draws are the same in every run; --hypothesis-profile=random draws anew.
settings.register_profile("quick", max_examples=30, derandomize=True, deadline=None)
settings.register_profile("thorough", max_examples=300, derandomize=True, deadline=None)
settings.register_profile("random", max_examples=300, deadline=None)
settings.load_profile("quick")


def pytest_xdist_auto_num_workers(config: pytest.Config) -> int | None:
    """Benchmarks run alone: what runs beside them would be timed with them."""
    alone = any("benchmarks" in str(argument) for argument in config.args)
    return 0 if alone else None


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Pictures and pages first, in one worker: they share results that a process computes once."""
    items.sort(key=lambda item: item.path.parent.name not in ("figures", "report"))


def pytest_collection_finish() -> None:
    """What was imported and collected stays: searches for unused objects need not look at it.

    They took a twelfth of the suite's time.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 20)


@pytest.fixture(scope="session", autouse=True)
def _one_tree_of_commands() -> Iterator[None]:
    """A process builds the tree of commands once, and so do all tests of a worker."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(typer.testing, "_get_command", functools.cache(typer.testing._get_command))
        yield


@pytest.fixture
def rough_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Save pictures without arranging or drawing what is in them: nobody looks.

    That takes most of the time of one. The tests of the plots and of the users' scripts draw.
    """
    from matplotlib.figure import Figure

    from flexmech.plots import style

    save = Figure.savefig

    def roughly(figure: Figure, path: Path, *, dpi: int, **options: Any) -> None:
        assert dpi == (200 if path.suffix == ".png" else 300)
        figure.set_layout_engine("none")
        for part in figure.get_children():
            part.set_visible(part is figure.patch)
        save(figure, path, dpi=30, **options)

    monkeypatch.setattr(Figure, "savefig", roughly)

    def written(figure: Figure, path: Path, dpi: int) -> None:
        roughly(figure, path, dpi=dpi)

    monkeypatch.setattr(style, "_write_png", written)


@pytest.fixture
def command(tmp_path: Path) -> Callable[..., Ended]:
    """Runs a command line: ``command("check", "models/steel_fourbar.toml", "--no-plots")``."""
    return functools.partial(run_command, tmp_path / "results")


@pytest.fixture(scope="session")
def models() -> Path:
    return MODELS


@pytest.fixture(scope="session")
def aluminium() -> Mechanism:
    return load_mechanism(MODELS / "aluminium_fourbar.toml")


@pytest.fixture(scope="session")
def steel() -> Mechanism:
    return load_mechanism(MODELS / "steel_fourbar.toml")


@pytest.fixture(scope="session")
def mechanisms(aluminium: Mechanism, steel: Mechanism) -> dict[str, Mechanism]:
    return {"aluminium": aluminium, "steel": steel}


@pytest.fixture(scope="session")
def unit_arm():
    """Arm of unit length, mass and bending stiffness: speeds and frequencies without unit."""
    return make_unit_arm
