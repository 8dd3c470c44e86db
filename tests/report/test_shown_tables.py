"""Tables of the page: as narrow as they can be, and none without rows."""

from __future__ import annotations

from flexmech.analyses import Table
from flexmech.report.tables import narrowed, shown_tables

ROWS = (
    ("dry", "reference", "crank", "", "1.25 ± 0.01", "-"),
    ("dry", "reference", "rod", "< 3", "2.50 ± 0.02", "-"),
)
HEADINGS = ("state", "engine", "of", "from", "peak", "nearest")


def test_what_is_the_same_in_all_rows_goes_into_the_title() -> None:
    table = narrowed(Table("Peaks", HEADINGS, (ROWS[:1], ROWS[1:]), text_columns=3))
    assert table.title == "Peaks (state: dry, engine: reference)"
    assert table.headings == ("of", "from", "peak")
    assert table.text_columns == 1
    # Numbers are broken before their errors alone.
    assert table.groups == (
        (("crank", "", "1.25 ±\u00a00.01"),),
        (("rod", "<\u00a03", "2.50 ±\u00a00.02"),),
    )


def test_the_words_of_one_row_and_equal_numbers_stay() -> None:
    one = narrowed(Table("Peaks", HEADINGS, (ROWS[:1],), text_columns=3))
    assert one.title == "Peaks"
    assert one.headings == ("state", "engine", "of", "peak")
    equal = Table("Links", ("link", "mm"), ((("crank", "3"), ("rod", "3")),))
    assert narrowed(equal) == equal


def test_a_table_without_rows_is_left_out() -> None:
    assert shown_tables([Table("none", HEADINGS, ((),)), Table("none", HEADINGS, ())]) == []
