"""The page of a run, as text."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest

from bt_mission.recording.model import (
    RecordedGoal,
    RecordedLine,
    RecordedRequirement,
    RecordedRun,
    Series,
    Span,
    Track,
)
from bt_mission.requirements.monitor import RequirementResult
from bt_mission.views.html_report.page import page_of

S = 1_000_000_000
VOID = {"meta", "img", "br"}
NONE = np.empty(0)
NOTHING = Track(np.empty(0, np.int64), NONE, NONE, NONE, NONE, NONE)


class Outline(HTMLParser):
    """What is seen of a page without a browser: texts, and whether elements are closed."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.text = ""
        self.headings: list[str] = []
        self.sources: list[str] = []
        self.feed(page)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.sources += [value or "" for name, value in attrs if name in ("src", "href", "srcset")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Nothing to close."""

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] == "h2":
            self.headings.append(data)
        if self.open and self.open[-1] not in ("script", "style"):
            self.text += f"{data} "


def outline(run: RecordedRun) -> Outline:
    """The outline of a run's page."""
    return Outline(page_of(run))


def test_it_says_what_came_of_the_run_and_why(a_run: Callable[..., RecordedRun]) -> None:
    """Before anything else: outcome, reason, the way to the leaf that failed."""
    text = outline(a_run()).text
    assert "try <i>this</i>  failure" in text
    assert "'check' 1 > 2 does not hold" in text
    assert "root \N{RIGHTWARDS ARROW} check, at 2.00 s" in text
    for words in ("duration 10.00 s", "distance 0.8 m", "world arena", "seed 7", "collisions 1"):
        assert re.search(words.replace(" ", r"\s+"), text), words


def test_every_part_is_there(a_run: Callable[..., RecordedRun]) -> None:
    """In this order; pictures and files only where there are any."""
    parts = ["Timeline", "Where it went", "Figures", "Goals"]
    rest = ["Leaves", "Log", "Mission file", "Made with"]
    assert outline(a_run()).headings == [*parts, "Pictures", *rest]
    bare = outline(a_run(pictures=(), files={}))
    assert bare.headings == [*parts, "Leaves", "Log", "Made with"]


def test_requirements_stand_first_with_their_margins(a_run: Callable[..., RecordedRun]) -> None:
    """In words, and drawn over time with the instants that count; no script is needed."""
    times = np.linspace(0, 10, 201)
    slow = RequirementResult(
        "is <slow>", "always speed < 0.1", "violated", -0.1, "m/s", 1.05, violated_at=1.0
    )
    ends = RequirementResult("ends", "eventually succeeded('x')", "unknown", why="no node 'x'")
    margins = np.where(times > 1, -0.1, 0.1)
    margins[:3] = np.nan
    run = a_run(
        requirements=(
            RecordedRequirement(slow, times, margins, is_of_instants=True),
            RecordedRequirement(ends, times, np.full(201, np.inf), is_of_instants=True),
        )
    )
    page = page_of(run)
    found = Outline(page)
    assert found.headings[0] == "Requirements"
    text = re.sub(r"\s+", " ", found.text)
    assert "is <slow> always speed < 0.1 violated -0.1 m/s 1.05 s noticed at 1.00 s" in text
    assert "ends eventually succeeded('x') unknown no node 'x'" in text
    assert "is <slow> margin at each instant, m/s" in text
    assert page.count('class="line margin zoomed"') == 1
    assert "from -0.1 to 0.1; below 0 it is violated" in page
    for line in ("instant violated", "instant decides"):
        assert page.count(f'<line class="{line}"') == 1
    data = json.loads(page.split('id="run">')[1].split("</script>")[0])
    assert data["charts"]["requirement 0"]["unit"] == "m/s"
    assert len(data["charts"]["requirement 0"]["v"]) == 198


def test_nothing_is_fetched(a_run: Callable[..., RecordedRun]) -> None:
    """Not even by name: pictures stand in the page, and a policy forbids the rest."""
    page = page_of(a_run())
    assert all(source.startswith(("data:", "#")) for source in Outline(page).sources)
    assert "default-src 'none'" in page
    assert not re.findall(r"https?://", page)


def test_texts_of_a_run_are_texts(a_run: Callable[..., RecordedRun]) -> None:
    """However much they look like markup, or end the script that they are told to."""
    page = page_of(a_run(reason="</script><script>alert(2)</script>"))
    assert "<script>alert" not in page
    assert "mind </pre> the gap" in Outline(page).text
    assert "# </script><b>" in Outline(page).text


def test_goals_tell_their_lives(a_run: Callable[..., RecordedRun]) -> None:
    """Fields that say nothing are left out."""
    text = outline(a_run()).text
    goals = re.sub(r"\s+", " ", text[text.index(" result ") : text.index("Pictures")])
    assert "1 /turn turn <b> 0.00 s 2.00 s canceled cancel after 1.00 s 1 x feedback" in goals
    assert "angle 90 pose.y 2.5" in goals
    assert "error_code" not in goals


def test_a_recording_that_is_not_whole_says_so(a_run: Callable[..., RecordedRun]) -> None:
    """At the top."""
    text = outline(a_run(why_cut="the file was cut", status="running")).text
    assert "This recording is not whole: the file was cut." in text
    assert text.index("not whole") < text.index("Timeline")
    assert "everything after 3 s" in outline(a_run(missing="everything after 3 s")).text


@pytest.mark.parametrize(
    "fields",
    [
        {"truth": NOTHING, "measured": NOTHING},
        {"truth": NOTHING, "grid": None},
        {"truth": NOTHING, "measured": NOTHING, "grid": None, "scans": ()},
        {"scans": (), "battery": Series(np.empty(0, np.int64), np.empty(0))},
        {"goals": (), "log": (), "collisions": (), "hull": None},
        {"end_ns": S, "spans": ((Span(S, S, "failure", ""),), (), (), (), ())},
        {"spans": ((), (), (), (), ()), "status": "", "reason": ""},
        {
            "goals": (
                RecordedGoal("b", "/lost", sent_ns=2 * S),
                RecordedGoal("c", "/left", given_up_ns=4 * S),
            )
        },
    ],
)
def test_a_run_of_which_little_is_known_has_a_page(
    a_run: Callable[..., RecordedRun], fields: dict[str, Any]
) -> None:
    """Of robots elsewhere, of files that end early."""
    assert outline(a_run(**fields)).headings


def test_a_long_run_has_a_page_of_bounded_size(a_run: Callable[..., RecordedRun]) -> None:
    """Ten hours of a node that runs in every tick, and of a log."""
    count = 100_000
    spans = tuple(Span(S + i * S // 3, S + i * S // 3, "success", "m" * 50) for i in range(count))
    run = a_run(
        end_ns=S + count * S // 3,
        spans=(spans, spans, (), (), ()),
        log=tuple(RecordedLine(S + i, 10, "n", "x" * 80) for i in range(count)),
    )
    page = page_of(run)
    assert len(page) < 3_000_000
    assert "99000 more lines are in the recording." in page
