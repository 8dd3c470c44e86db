"""``docs/files.md`` names the columns that files have, and schemas name what there is."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

import flexmech
from flexmech import plots
from flexmech.analyses.schema import schema_of

ROOT = Path(flexmech.__file__).parents[1]
sys.path.append(str(ROOT / "docs"))
from making.columns import PAGE, with_columns  # noqa: E402

ANALYSES = sorted(
    path.parent.name for path in (ROOT / "flexmech" / "analyses").glob("*/schema.toml")
)


def test_the_page_has_the_columns_of_the_schemas() -> None:
    """After a change of a schema: ``python docs/build.py --columns``."""
    page = PAGE.read_text(encoding="utf-8")
    with_tables = [name for name in ANALYSES if schema_of(f"flexmech.analyses.{name}").tables]
    assert all(f"<!-- columns of {name} -->" in page for name in with_tables)
    assert with_columns(page) == page


@pytest.mark.parametrize("analysis", ANALYSES)
def test_what_a_schema_names_is_there(analysis: str) -> None:
    schema = schema_of(f"flexmech.analyses.{analysis}")
    for table in schema.tables.values():
        assert set(table.over) <= set(schema.index)
        assert set(table.columns) <= set(schema.columns)
        assert not table.needs or table.needs in schema.variables
    for picture in schema.pictures.values():
        assert not picture.draws or callable(getattr(plots, picture.draws))
        assert not picture.needs or picture.needs in schema.variables
    assert set(schema.when) <= set(schema.columns) | set(schema.tables)


def test_every_variable_of_a_result_is_declared() -> None:
    """Coordinates that are names, such as links, have none."""
    result = flexmech.kinematics(
        flexmech.load_mechanism(ROOT / "models" / "slider_crank.toml"), 1.0
    )
    declared = result.schema().variables
    assert all(
        name in declared or one.dims == (name,) for name, one in result.dataset.variables.items()
    )
    assert all(one.long_name for one in declared.values())
