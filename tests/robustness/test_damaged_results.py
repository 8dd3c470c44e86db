"""Results that are damaged, or that point to other files: refused, and nothing else is read."""

from __future__ import annotations

import random
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

from flexmech.analyses import MovingFrequencies, moving_frequencies
from flexmech.cli import app
from flexmech.errors import InputError
from flexmech.reference import ReferenceEngine
from tests.support.strategies import fourbar


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    folder = tmp_path_factory.mktemp("saved")
    engine = ReferenceEngine(fourbar(), 2)
    result = moving_frequencies(engine, np.array([0.0, 1.0]), [0.0], modes=2)
    result.save(folder)
    return (folder / "frequencies.nc").read_bytes()


@pytest.mark.parametrize(
    "cuts", [30, pytest.param(1000, marks=pytest.mark.thorough)], ids=["some", "many"]
)
def test_damaged_files_are_loaded_or_refused(cuts: int, saved: bytes, tmp_path: Path) -> None:
    chance, path, refused = random.Random(3), tmp_path / "frequencies.nc", 0
    for number in range(cuts):
        content = bytearray(saved)
        if number % 2:
            del content[chance.randrange(len(content)) :]
        else:
            place = chance.randrange(len(content))
            content[place : place + 40] = chance.randbytes(40)
        path.write_bytes(content)
        try:
            MovingFrequencies.load(path)
        except InputError:
            refused += 1
    assert refused > cuts / 3


@pytest.mark.parametrize("kind", ["external link", "soft link", "group", "external", "virtual"])
def test_no_other_file_is_read(kind: str, saved: bytes, tmp_path: Path) -> None:
    path, other = tmp_path / "frequencies.nc", tmp_path / "other.nc"
    other.write_bytes(saved)
    path.write_bytes(saved)
    with h5py.File(path, "r+") as file:
        if kind == "external link":
            del file["frequency"]
            file["frequency"] = h5py.ExternalLink("other.nc", "/frequency")
        elif kind == "soft link":
            file["more"] = h5py.SoftLink("/frequency")
        elif kind == "group":
            file.create_group("more")
        elif kind == "external":
            file.create_dataset("more", (4,), dtype="f8", external=[(str(other), 0, 32)])
        else:
            layout = h5py.VirtualLayout(shape=(2,), dtype="f8")
            layout[:] = h5py.VirtualSource(str(other), "crank_angle", shape=(2,))
            file.create_virtual_dataset("more", layout)
    with pytest.raises(InputError, match=r"frequencies\.nc: (frequency|more) is "):
        MovingFrequencies.load(path)


@pytest.mark.parametrize(
    "change",
    [
        lambda dataset: dataset.drop_vars("mode"),
        pytest.param(
            lambda dataset: dataset.drop_vars("discretisation_error", errors="raise"),
            marks=pytest.mark.thorough,
        ),
        lambda dataset: dataset.isel(crank_angle=slice(0, 0)),
        pytest.param(lambda dataset: dataset.isel(crank_speed=0), marks=pytest.mark.thorough),
        lambda dataset: dataset.assign_attrs(provenance_name=[1.0, 2.0], mechanism=[1.0, 2.0]),
    ],
    ids=["coordinate", "variable", "empty", "squeezed", "attribute"],
)
def test_what_another_program_changed_is_loaded_or_refused(
    change: Callable[[xr.Dataset], xr.Dataset], saved: bytes, tmp_path: Path
) -> None:
    """Both by the file itself and by the report of its folder."""
    path = tmp_path / "results" / "frequencies.nc"
    path.parent.mkdir()
    path.write_bytes(saved)
    with xr.open_dataset(path, engine="h5netcdf") as found:
        changed = change(found.load())
    changed.to_netcdf(path, engine="h5netcdf")
    done = CliRunner().invoke(
        app, ["report", str(path.parent), "--out", str(tmp_path / "report.html")]
    )
    assert done.exit_code in (0, 2), done.exception
    assert done.exit_code == 0 or "lacks something that a result holds" in done.stderr
    with suppress(InputError):
        MovingFrequencies.load(path)
