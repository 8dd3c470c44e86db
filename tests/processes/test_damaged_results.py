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

import flexmech
from flexmech.errors import InputError
from tests.support.command import MODELS, run_command


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    folder = tmp_path_factory.mktemp("saved")
    engine = flexmech.ReferenceEngine(flexmech.load_mechanism(MODELS / "steel_fourbar.toml"), 2)
    flexmech.moving_frequencies(engine, np.array([0.0, 1.0]), [0.0], modes=2).save(folder)
    return (folder / "frequencies.nc").read_bytes()


def test_damaged_files_are_loaded_or_refused(saved: bytes, tmp_path: Path) -> None:
    chance, path, refused = random.Random(3), tmp_path / "frequencies.nc", 0
    for number in range(40):
        content = bytearray(saved)
        if number % 2:
            del content[chance.randrange(len(content)) :]
        else:
            place = chance.randrange(len(content))
            content[place : place + 40] = chance.randbytes(40)
        path.write_bytes(content)
        try:
            flexmech.MovingFrequencies.load(path)
        except InputError:
            refused += 1
    assert refused > 13


def external_link(file: h5py.File, other: Path) -> None:
    del file["frequency"]
    file["frequency"] = h5py.ExternalLink(other.name, "/frequency")


def external_dataset(file: h5py.File, other: Path) -> None:
    file.create_dataset("more", (4,), dtype="f8", external=[(str(other), 0, 32)])


def virtual_dataset(file: h5py.File, other: Path) -> None:
    layout = h5py.VirtualLayout(shape=(2,), dtype="f8")
    layout[:] = h5py.VirtualSource(str(other), "crank_angle", shape=(2,))
    file.create_virtual_dataset("more", layout)


@pytest.mark.parametrize("add", [external_link, external_dataset, virtual_dataset])
def test_no_other_file_is_read(
    add: Callable[[h5py.File, Path], None], saved: bytes, tmp_path: Path
) -> None:
    path, other = tmp_path / "frequencies.nc", tmp_path / "other.nc"
    other.write_bytes(saved)
    path.write_bytes(saved)
    with h5py.File(path, "r+") as file:
        add(file, other)
    with pytest.raises(InputError, match=r"frequencies\.nc: (frequency|more) is "):
        flexmech.MovingFrequencies.load(path)


@pytest.mark.parametrize(
    "change",
    [
        lambda dataset: dataset.drop_vars("mode"),
        lambda dataset: dataset.isel(crank_angle=slice(0, 0)),
        lambda dataset: dataset.assign_attrs(provenance_name=[1.0, 2.0], mechanism=[1.0, 2.0]),
    ],
    ids=["coordinate", "empty", "attribute"],
)
def test_what_another_program_changed_is_loaded_or_refused(
    change: Callable[[xr.Dataset], xr.Dataset], saved: bytes, tmp_path: Path
) -> None:
    """Both by the file itself and by the report of its folder."""
    path = tmp_path / "results" / "frequencies.nc"
    path.parent.mkdir()
    path.write_bytes(saved)
    with xr.open_dataset(path, engine="h5netcdf") as opened:
        changed = change(opened.load())
    changed.to_netcdf(path, engine="h5netcdf")
    ended = run_command(tmp_path, "report", path.parent, "--out", tmp_path / "report.html")
    assert ended.exit_code in (0, 2)
    assert ended.exit_code == 0 or "lacks something that a result holds" in ended.stderr
    with suppress(InputError):
        flexmech.MovingFrequencies.load(path)
