"""``bt-mission sweep-report``: what it prints and writes, and its exit codes."""

from __future__ import annotations

import csv
import io
import sqlite3
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pytest

from bt_mission.commands.sweep.report import page as page_module
from bt_mission.commands.sweep.report.page import INSTALL
from tests.commands.sweep.conftest import origin, some_rows, write_results
from tests.support.command_line import CommandLine
from tests.support.rows import failed, row

RESULTS = Path("results")
REPORT = "sweep-report results"


def write(rows: Iterable[Any], made_from: Any = None) -> None:
    """Write results of these rows only."""
    (RESULTS / "results.sqlite").unlink()
    write_results(RESULTS, rows, made_from).close()


@pytest.fixture
def report(cli: CommandLine, monkeypatch: pytest.MonkeyPatch) -> CommandLine:
    """Results in a folder; Plotly's five megabytes are not read again for each test."""
    monkeypatch.setattr(page_module, "plotly_script", lambda: "var Plotly;")
    write_results(RESULTS, some_rows(), origin()).close()
    return cli


def test_a_table_for_people_and_the_page(report: CommandLine) -> None:
    """The page is made again each time, and its place is said."""
    assert report(REPORT) == report(REPORT)
    assert "go: 58 of 80 succeeded (72.5 %; 95 % confidence interval 61.9 to 81.1 %)" in report.out
    assert "  hall          40        40         29  72.5 %  57.2 to 83.9 %" in report.out
    assert "22 times 'look around' aborted" in report.out
    assert f"the page: {RESULTS / 'sweep.html'}" in report.out
    assert "72.5 %" in (RESULTS / "sweep.html").read_text()


def test_a_command_is_on_one_line(report: CommandLine) -> None:
    """However narrow the terminal is, it can be copied."""
    assert (
        "bt-mission run mine/go.yaml --seed 0 --set speed=0.2 --world hall --fault "
        "'at 2.0: drop scan lasting 2'\n"
    ) in report(REPORT)


def test_csv_on_standard_output_alone(report: CommandLine) -> None:
    """Every row, with the line ends of CSV, and nothing else that a reader would stumble over."""
    out = report(f"{REPORT} --csv -")
    lines = list(csv.DictReader(io.StringIO(out, newline="")))
    assert len(lines) == 80
    assert lines[1]["parameter.speed"] == "0.1"
    assert lines[-1]["margin.keeps clear"] == str(0.01 * 9 - 0.005)
    assert out.count("\r\n") == 81
    assert "\\r" not in out
    assert not (RESULTS / "sweep.html").exists()


def test_csv_and_page_in_files(report: CommandLine) -> None:
    """They are not overwritten without --force."""
    line = f"{REPORT} --csv rows.csv --html page.html"
    assert report(line) == ""
    assert len(Path("rows.csv").read_bytes().splitlines()) == 81
    assert Path("page.html").is_file()
    assert "--force" in report.refused(line)
    report(f"{line} --force")


def test_json_is_one_object(report: CommandLine) -> None:
    """With what the sweep itself prints at its end, and the worst."""
    data = report.json(f"{REPORT} --worst 3")
    keys = ("scenarios", "succeeded", "failed", "errors", "orphaned_goals", "collisions")
    assert [data[key] for key in keys] == [80, 58, 22, 0, 0, 0]
    assert data["success_rate"] == 58 / 80
    assert data["interval"][0] < 58 / 80 < data["interval"][1]
    assert len(data["worst"]) == 3
    assert not (RESULTS / "sweep.html").exists()


def test_a_scenario_as_a_file(report: CommandLine) -> None:
    """The path of the file is printed; of what is not there, an error."""
    write([row(3)])
    error = report.refused(f"{REPORT} --scenario 4")
    assert "no scenario is called so or begins with '4'" in error
    assert "contains no files of its mission" in report.refused(f"{REPORT} --scenario 3")


def test_a_sweep_that_has_just_begun(report: CommandLine) -> None:
    """There are no results yet, and a message says so."""
    write([], origin())
    assert "go: 0 of 0 succeeded" in report(REPORT)


def test_without_plotly_the_tables_are_there(
    report: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is said what to install; a page that was asked for is an error."""
    monkeypatch.undo()
    monkeypatch.chdir(report.folder)
    monkeypatch.setitem(sys.modules, "plotly", None)
    assert "58 of 80 succeeded" in report(REPORT)
    assert INSTALL in report.err
    report(f"{REPORT} --html x.html", 2)


def test_what_a_message_says_commands_no_terminal(report: CommandLine) -> None:
    """In the table and in CSV."""
    write([failed(0, reason="\x1b[2J[bold]gone", parameters={"\x1b[2J": "\x1b[2J"})], origin())
    for line in (REPORT, f"{REPORT} --csv -"):
        out = report(line)
        assert "\x1b[2J" not in out
        assert "\\x1b[2J[bold]gone" in out


def test_the_page_is_not_written_through_a_link(report: CommandLine) -> None:
    """A folder that comes from others may have links out of it."""
    report.write("victim", "precious")
    (RESULTS / "sweep.html").symlink_to(report.folder / "victim")
    report.call(REPORT)
    assert "a symbolic link" in report.err
    assert Path("victim").read_text() == "precious"


def test_a_broken_row_ends_with_its_name(report: CommandLine) -> None:
    """And exit code 2, in each form of the report."""
    with sqlite3.connect(RESULTS / "results.sqlite") as connection:
        connection.execute("UPDATE scenarios SET parameters = ? WHERE number = 3", ('{"a": [1',))
    for words in ("", "--json", "--csv -"):
        report(f"{REPORT} {words}", 2)
        assert "row 3" in report.err
