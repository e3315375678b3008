"""Tables for people: one formatting of numbers on the terminal, in pages, in CSV and JSON files."""

import csv
import io

import numpy as np
import pytest
from support.synthetic_result import curve_run

from wrsim.results import Result
from wrsim.results.files import as_csv
from wrsim.results.summary import PEAKS
from wrsim.results.table import Column, Placed, Table, as_html, as_records, as_rows, as_text, formatted, quantity

TABLE = Table(
    "forces <b>",
    (Column("wheel", key="wheel"), Column("Y", "kN", ".3g", "Y_kN"), Column("of", key="place")),
    [("left", 1234.5678, Placed(-0.25, "3.0 m")), ("<i>right</i>", None, Placed(None, ""))],
    ("a note & more",),
)


def test_terminal_and_page_show_the_same_cells():
    text, page = as_text([TABLE]), as_html(TABLE)
    for cell in ("1.23e+03", "-0.25 at 3.0 m", "Y [kN]"):
        assert cell in text and cell in page
    assert text.splitlines()[-1] == "a note & more"


def test_texts_of_a_table_are_no_markup_of_a_page():
    page = as_html(TABLE)
    assert "<i>" not in page and "<b>" not in page and "&lt;i&gt;" in page


def test_files_hold_ten_digits_and_no_words_for_a_missing_number():
    head, left, right = csv.reader(io.StringIO(as_csv(as_rows(TABLE)).decode()))
    assert head == ["wheel", "Y_kN", "place"]
    assert left == ["left", "1234.5678", "-0.25"] and right[1:] == ["", ""]
    assert as_records(TABLE)[0] == {"wheel": "left", "Y_kN": 1234.5678, "place": -0.25}
    assert as_records(TABLE)[1]["Y_kN"] is None


@pytest.mark.parametrize("nothing", [None, float("nan"), np.float64("nan"), Placed(None, "")])
def test_a_missing_number_is_a_dash(nothing):
    assert formatted(nothing) == "-"


def test_a_number_that_rounds_to_zero_has_no_sign():
    assert formatted(-1e-9, ".3f") == "0.000"
    assert quantity(-0.0, "mm", ".1f") == "0.0 mm"


def test_every_peak_of_a_wheel_has_a_row_with_its_place():
    """One entry of PEAKS makes the number in summary.json and the row in every table."""
    result = Result(curve_run())
    peaks = result.numbers()[0]
    known = {key for key in PEAKS if result.summary()["wheelsets"]["wheelset"]["wheels"]["right"][key]["value"]}
    assert len(peaks.rows) == len(known)
    assert all(isinstance(cell, Placed) and cell.place.endswith(" m") for row in peaks.rows for cell in row[1:])


def test_a_row_of_a_curve_never_mixes_two_patches():
    run = curve_run().copy(deep=True)
    for name, value in {"N": 26.5e3, "p0": 2233e6, "contact_angle": np.radians(17.3), "area": 2e-5}.items():
        run[name][{"patch": 1}] = value
    (table,) = (t for t in Result(run).numbers() if t.title.startswith("full curve"))
    second = [row[-4:] for row in table.rows if "second" in row]
    assert len(second) == 2  # one a wheel
    assert all(cells == pytest.approx([26.5, 2233.0, 17.3, 20.0]) for cells in second)
