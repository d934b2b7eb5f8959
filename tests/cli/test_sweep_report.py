"""``bt-mission sweep-report``: what it prints and writes, and its exit codes."""

from __future__ import annotations

import csv
import io
import json
import sqlite3
import sys

import pytest

from bt_mission.cli import main
from bt_mission.sweeps.report import page as page_module
from bt_mission.sweeps.report.page import INSTALL
from tests.sweeps.conftest import origin, some_rows, write_results
from tests.sweeps.rows import failed, row


@pytest.fixture(autouse=True)
def short_script(monkeypatch):
    """Plotly's five megabytes are not read again for each test."""
    monkeypatch.setattr(page_module, "plotly_script", lambda: "var Plotly;")


@pytest.fixture
def folder(tmp_path):
    """A folder of results."""
    write_results(tmp_path / "results", some_rows(), origin()).close()
    return tmp_path / "results"


def report(folder, *words):
    """Call the command; gives the exit code."""
    return main(["sweep-report", str(folder), *map(str, words)])


def test_a_table_for_people_and_the_page(folder, capsys):
    """The page is made again each time, and its place is said."""
    assert report(folder) == 0
    assert report(folder) == 0
    out = capsys.readouterr().out
    assert "go: 58 of 80 succeeded (72.5 %; 95 % confidence interval 61.9 to 81.1 %)" in out
    assert "  hall          40        40         29  72.5 %  57.2 to 83.9 %" in out
    assert "22 times 'look around' aborted" in out
    assert f"the page: {folder / 'sweep.html'}" in out
    assert "72.5 %" in (folder / "sweep.html").read_text()


def test_a_command_is_on_one_line(folder, capsys):
    """However narrow the terminal is, it can be copied."""
    assert report(folder) == 0
    assert (
        "bt-mission run mine/go.yaml --seed 0 --set speed=0.2 --world hall --fault "
        "'at 2.0: drop scan lasting 2'\n"
    ) in capsys.readouterr().out


def test_csv_on_standard_output_alone(folder, capsys):
    """Every row, and nothing else that a reader of it would stumble over."""
    assert report(folder, "--csv", "-") == 0
    lines = list(csv.DictReader(io.StringIO(capsys.readouterr().out, newline="")))
    assert len(lines) == 80
    assert lines[1]["parameter.speed"] == "0.1"
    assert lines[-1]["margin.keeps clear"] == str(0.01 * 9 - 0.005)
    assert not (folder / "sweep.html").exists()


def test_csv_lines_end_as_they_must(folder, capsys):
    """No escape stands for the carriage return."""
    assert report(folder, "--csv", "-") == 0
    out = capsys.readouterr().out
    assert out.count("\r\n") == 81
    assert "\\r" not in out


def test_csv_and_page_in_files(folder, tmp_path, capsys):
    """They are not overwritten without --force."""
    words = ("--csv", tmp_path / "rows.csv", "--html", tmp_path / "page.html")
    assert report(folder, *words) == 0
    assert len((tmp_path / "rows.csv").read_bytes().splitlines()) == 81
    assert (tmp_path / "page.html").is_file()
    assert capsys.readouterr().out == ""
    assert report(folder, *words) == 2
    assert "--force" in capsys.readouterr().err
    assert report(folder, *words, "--force") == 0


def test_json_is_one_object(folder, capsys):
    """With what the sweep itself prints at its end, and the worst."""
    assert report(folder, "--json", "--worst", 3) == 0
    data = json.loads(capsys.readouterr().out)
    keys = ("scenarios", "succeeded", "failed", "errors", "orphaned_goals", "collisions")
    assert [data[key] for key in keys] == [80, 58, 22, 0, 0, 0]
    assert data["success_rate"] == 58 / 80
    assert data["interval"][0] < 58 / 80 < data["interval"][1]
    assert len(data["worst"]) == 3
    assert not (folder / "sweep.html").exists()


def test_a_scenario_as_a_file(tmp_path, capsys):
    """The path of the file is printed; of what is not there, an error."""
    write_results(tmp_path / "r", [row(3)], None).close()
    assert report(tmp_path / "r", "--scenario", "4") == 2
    assert "no scenario is called so or begins with '4'" in capsys.readouterr().err
    assert report(tmp_path / "r", "--scenario", "3") == 2
    assert "contains no files of its mission" in capsys.readouterr().err


def test_a_folder_without_results(tmp_path, capsys):
    """The error has its name."""
    assert report(tmp_path) == 2
    assert "contains no results of a sweep" in capsys.readouterr().err


def test_a_file_that_is_no_result(tmp_path, capsys):
    """Is no traceback."""
    (tmp_path / "results.sqlite").write_text("hello\n" * 1000)
    assert report(tmp_path) == 2
    assert "not results of a sweep" in capsys.readouterr().err


def test_a_sweep_that_has_just_begun(tmp_path, capsys):
    """There are no results yet, and a message says so."""
    write_results(tmp_path / "r", [], origin()).close()
    assert report(tmp_path / "r") == 0
    assert "go: 0 of 0 succeeded" in capsys.readouterr().out


def test_without_plotly_the_tables_are_there(folder, capsys, monkeypatch):
    """It is said what to install; a page that was asked for is an error."""
    monkeypatch.undo()
    monkeypatch.setitem(sys.modules, "plotly", None)
    assert report(folder) == 0
    reported = capsys.readouterr()
    assert "58 of 80 succeeded" in reported.out
    assert INSTALL in reported.err
    assert report(folder, "--html", folder / "x.html") == 2


def test_what_a_message_says_commands_no_terminal(tmp_path, capsys):
    """In the table and in CSV."""
    rows = [failed(0, reason="\x1b[2J[bold]gone", parameters={"\x1b[2J": "\x1b[2J"})]
    write_results(tmp_path / "r", rows, origin()).close()
    assert report(tmp_path / "r") == 0
    assert report(tmp_path / "r", "--csv", "-") == 0
    out = capsys.readouterr().out
    assert "\x1b[2J" not in out
    assert "\\x1b[2J[bold]gone" in out


def test_the_page_is_not_written_through_a_link(folder, tmp_path, capsys):
    """A folder that comes from others may have links out of it."""
    victim = tmp_path / "victim"
    victim.write_text("precious")
    (folder / "sweep.html").symlink_to(victim)
    report(folder)
    assert "a symbolic link" in capsys.readouterr().err
    assert victim.read_text() == "precious"


def test_a_broken_row_ends_with_its_name(folder, capsys):
    """And exit code 2, in each form of the report."""
    with sqlite3.connect(folder / "results.sqlite") as connection:
        connection.execute("UPDATE scenarios SET parameters = ? WHERE number = 3", ('{"a": [1',))
    for words in ([], ["--json"], ["--csv", "-"]):
        assert report(folder, *words) == 2
        assert "row 3" in capsys.readouterr().err
