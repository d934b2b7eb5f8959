"""``bt-mission sweep-report``: the results of a sweep as tables, a page, CSV and JSON."""

from __future__ import annotations

import argparse
import json
import sys
from io import TextIOWrapper
from pathlib import Path
from typing import TYPE_CHECKING

from bt_mission.base.errors import BtMissionError
from bt_mission.cli.argument_types import count, output_file
from bt_mission.cli.exits import SUCCESS
from bt_mission.cli.options import FORCE, JSON
from bt_mission.cli.outputs import refuse_overwritten
from bt_mission.cli.parser import Command, Option, each
from bt_mission.views.terminal.streams import unescaped

if TYPE_CHECKING:
    from bt_mission.commands.sweep.columns import SweepColumns
    from bt_mission.commands.sweep.store import ResultStore

WORST = 20
UNSEEN_WIDTH = 140
"""Columns of what goes to a file or another program."""
SHOWN = 5
"""Of the worst, in the table unless more are asked for."""

EPILOG = """\
examples:
  bt-mission sweep-report explore_sweep                 print a table, and write sweep.html there
  bt-mission sweep-report explore_sweep --html out.html write the page to another file
  bt-mission sweep-report explore_sweep --csv -         every row, for a spreadsheet or pandas
  bt-mission sweep-report explore_sweep --json          print counts, rates, reasons and margins
  bt-mission sweep-report explore_sweep --scenario 12   write the scenario of row 12 as a file

The sweep can still be running; the report shows the results so far.

columns of --csv: those of the results, parameter.NAME of each parameter, verdict.NAME and
margin.NAME of each requirement. Text that a spreadsheet would evaluate as a formula begins with '.

exit codes: 0 success, 2 no results there, or a file that cannot be written
"""


def sweep_report(options: argparse.Namespace) -> int:
    """Report; gives the exit code."""
    is_stdout = str(options.csv) == "-"
    if options.json and is_stdout:
        raise BtMissionError(
            "--json and --csv - both write to standard output: give --csv a file", code="BT-1102"
        )
    from bt_mission.commands.sweep.store import FILE, ResultStore

    with ResultStore.read(options.folder) as store:
        refuse_overwritten(options, [store.folder / FILE])
        if options.scenario is not None:
            return _write_scenario(store, options.scenario)
        if options.csv is not None:
            _write_csv(store, None if is_stdout else options.csv)
        if options.json:
            _print_json(store, options.worst or WORST)
        elif options.csv is None:
            tell_results(store, options.html, options.worst)
            return SUCCESS
        if options.html is not None:
            print(write_page(store, options.html, options.worst), file=sys.stderr)
    return SUCCESS


def _write_scenario(store: ResultStore, name: str) -> int:
    from bt_mission.commands.sweep.repeat import Repeater, find_row

    print(Repeater(store).write(find_row(store, name)))
    return SUCCESS


def _write_csv(store: ResultStore, path: Path | None) -> None:
    from bt_mission.base.output import new_file
    from bt_mission.commands.sweep.store import write_csv

    if path is None:
        write_csv(store.rows, unescaped(sys.stdout))  # its cells are escaped, its line ends not
        return
    with new_file(path) as stream:
        text = TextIOWrapper(stream, encoding="utf-8", newline="")
        write_csv(store.rows, text)
        text.detach()  # else the stream would be closed with it
    print(path, file=sys.stderr)


def _print_json(store: ResultStore, worst: int) -> None:
    from bt_mission.commands.sweep.columns import SweepColumns
    from bt_mission.commands.sweep.report.explanation import results_as_dict

    columns = SweepColumns(store.rows())
    about = {"results": str(store.folder), "of": store.about.scenarios}
    print(json.dumps({**results_as_dict(columns), "worst": columns.worst(worst), **about}))


def tell_results(store: ResultStore, page: Path | None = None, worst: int | None = None) -> None:
    """Print the tables of a sweep, and make its page.

    Args:
        page: Where that goes; None is among the results.
        worst: The number of worst runs that are listed.

    Raises:
        BtMissionError: Where the page cannot be made in the place that was named.
    """
    from rich.text import Text

    from bt_mission.commands.sweep.columns import SweepColumns
    from bt_mission.commands.sweep.repeat import Repeater
    from bt_mission.commands.sweep.report.terminal import tables
    from bt_mission.views.terminal.console import EscapingConsole

    columns = SweepColumns(store.rows())
    width = None if sys.stdout.isatty() else UNSEEN_WIDTH
    console = EscapingConsole(sys.stdout, width=width)
    shown = columns.worst_rows(store, worst or SHOWN)
    name = store.about.mission
    for table in tables(name, columns, shown, Repeater(store)):
        console.print(table, soft_wrap=isinstance(table, Text))  # a command is not broken
    try:
        written = write_page(store, page, worst, columns)
    except BtMissionError as error:
        if page is not None:
            raise
        print(error.headline, file=sys.stderr)  # the tables are there without the page
    else:
        print(f"\nthe page: {written}")


def write_page(
    store: ResultStore, page: Path | None, worst: int | None, columns: SweepColumns | None = None
) -> Path:
    """Make the page of a sweep; gives its path.

    Raises:
        BtMissionError: Where it cannot be made.
    """
    from bt_mission.commands.sweep.report.page import write_sweep_page

    return write_sweep_page(store, page, worst=worst or WORST, columns=columns)


COMMANDS = {
    "sweep-report": Command(
        sweep_report,
        "Reports the results of a sweep: success rates with confidence intervals, in all and by "
        "parameters, margins of requirements, coverage of the tree, failures by leaf and reason "
        "with the command that repeats each, and the worst runs. The page needs no network and "
        "no other file. Its charts need Plotly (pip install 'bt-mission[sweep]').",
        (
            Option(
                "folder",
                "folder of the results (bt-mission sweep -o)",
                Path,
                takes=("sweep folder",),
            ),
            Option(
                "--html FILE",
                "file of the HTML page (default: sweep.html in FOLDER, which is overwritten)",
                output_file,
            ),
            Option(
                "--csv FILE",
                "write all rows as CSV; - writes only the CSV, to standard output",
                output_file,
            ),
            JSON.but(help="print one JSON object"),
            Option(
                "--worst N",
                f"show the N worst runs (default: {WORST} on the page, {SHOWN} in the terminal)",
                count,
            ),
            Option(
                "--scenario ID",
                "write the scenario with this id or number and its files to FOLDER, and print "
                "its path, for `bt-mission run`",
                excludes=each("html", "csv", "json"),
            ),
            FORCE,
        ),
        EPILOG,
    )
}
