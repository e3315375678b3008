"""Tables, pictures and pages in US units."""

import matplotlib.ticker
import pytest
from support.commands import ok, refusal

import wrsim
from wrsim.plots.theme import new_figure, rendered
from wrsim.results.channels import SHOWN
from wrsim.results.table import Column, Table, ValueAt, as_text
from wrsim.results.units import converted, in_page, in_text, prefer_those_of, shown_in

TEXTS = (
    ("70 to 170 m, R 300 m", "230 to 558 ft, R 984 ft"),
    ("54.6 of 90 kN at 60 km/h", "12.3 of 20.2 kip at 37.3 mph"),
    ("R 699.8 and 5 s, 0 m", "R 2296 ft and 5 s, 0 ft"),
    ("12 mrad, 3 Hz, Q 1.5 kN m/m, 10 kN m", "12 mrad, 3 Hz, Q 1.5 kN m/m, 7.38 kip ft"),
)


def test_tables_and_sentences_are_in_the_units_of_their_block() -> None:
    table = Table(
        "over 100 m",
        (Column(), Column("cant", "mm", ".1f"), Column("curvature", "1/km", ".3f"), Column(), Column("waves", "m")),
        [["Y, largest [kN]", 80.0, 1.0 / 0.7, ValueAt(44.482, "50 m"), "3 to 70"], ["x", 100, None, 7.0, "none"]],
        ("at 10 m",),
    )
    metric = as_text([table])
    with wrsim.look(units="us"):
        text = as_text([table])
        for text_si, expected in TEXTS:
            assert in_text(text_si) == expected
        assert in_page("<p>10 m</p><pre>10 m</pre>") == "<p>32.8 ft</p><pre>10 m</pre>"
        assert converted(SHOWN["kN"]).suffix == "kip" and converted(SHOWN["mrad"]) == SHOWN["mrad"]
    for part in (
        "over 328 ft",
        "Y, largest [kip]",
        "[in]",
        "3.150",
        "2.495",
        "10 at 164 ft",
        "9.84 to 230",
        "at 32.8 ft",
    ):
        assert part in text, text
    assert as_text([table]) == metric and "[kN]" in metric


def test_axes_show_round_numbers_of_the_unit_and_panels_of_a_row_share_it() -> None:
    figure = new_figure(120.0, 60.0)
    left, right = figure.subplots(1, 2)
    for axes in (left, right):
        axes.plot([0.0, 100.0], [0.0, 50.0], label="to 10 m")
        axes.set_xlabel("Distance [m]")
    left.set_ylabel("Shift [mm]")
    with wrsim.look(units="us"):
        rendered(figure)
    assert (left.get_xlabel(), left.get_ylabel(), right.get_ylabel()) == ("Distance [ft]", "Shift [in]", "")
    for axes in (left, right):
        ticks = axes.yaxis.get_major_locator().tick_values(0.0, 50.0)
        assert [round(v / 25.4, 9) % 0.5 for v in ticks] == pytest.approx([0.0] * len(ticks))
        assert axes.yaxis.get_major_formatter()(25.4) in ("1", "1.0", "1.00")
        assert isinstance(axes.xaxis.get_major_formatter(), matplotlib.ticker.ScalarFormatter)


def test_the_units_of_a_scenario_count_unless_an_option_says_otherwise() -> None:
    for option, text, expected in ((None, 'units = "us"', "ft"), ("metric", 'units = "us"', "m"), (None, "", "m")):
        with shown_in(option):
            prefer_those_of(text)
            assert converted(SHOWN["m"]).symbol == expected
    assert '--units miles: must be "metric" or "us"' in refusal("profile", "wheels/S1002.toml", "--units", "miles")
    assert ok("check", "scenarios/curve_r300.toml").exit_code == 0
