"""The page in a browser, where there is one."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from bt_mission.events.events import NodeInfo
from bt_mission.recording.model import RecordedRun
from bt_mission.views.html_report.page import page_of
from tests.support.browser import BROWSER, Page, browser

pytestmark = [
    pytest.mark.process,
    pytest.mark.skipif(BROWSER is None, reason="no Chromium is installed"),
]


@pytest.fixture(scope="module")
def chromium(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Page]:
    """A browser."""
    with browser(tmp_path_factory.mktemp("profile")) as page:
        yield page


@pytest.fixture
def page(chromium: Page, a_run: Callable[..., RecordedRun], tmp_path: Path) -> Iterator[Page]:
    """The page of a run, wide open; nothing may go wrong on it."""
    (tmp_path / "run.html").write_text(page_of(a_run()), encoding="utf-8")
    chromium.problems.clear()
    chromium.open(tmp_path / "run.html", width=1200, height=900)
    yield chromium
    assert chromium.problems == []


def middle_of(page: Page, selector: str) -> tuple[float, float]:
    """Where an element is on the screen."""
    x, y = page.look(
        f"(() => {{ const b = document.querySelector({selector!r}).getBoundingClientRect();"
        " return [b.x + b.width / 2, b.y + b.height / 2]; })()"
    )
    return x, y


def shown(page: Page) -> tuple[float, float]:
    """The window of time that the timeline shows, s."""
    begin, end = page.look(
        "['from', 'to'].map((one) => +document.querySelector('.timeline').dataset[one])"
    )
    return begin, end


def reading(page: Page) -> str:
    """What is said about the place that is pointed at."""
    text: str = page.look("document.querySelector('.reading').textContent")
    return text


def test_the_timeline_tells_what_is_pointed_at(page: Page) -> None:
    """The node, how it ended, when, and what it said; all drawings show that time."""
    x, y = middle_of(page, "rect.bar.halted")
    page.mouse("mouseMoved", x, y)
    assert re.match(r"4\.5\d? s\. drive: halted, from 2 s to 7 s \(5 s\)", reading(page))
    assert page.look("document.querySelector('.ghost').getAttribute('visibility')") == "visible"
    values = page.look("[...document.querySelectorAll('.value')].map((one) => one.textContent)")
    assert values == ["0.2 m/s", "0.7 m", "0.8 m", "100 %"]
    x, y = middle_of(page, "line.bar.failure")
    page.mouse("mouseMoved", x, y)
    assert "check: failure" in reading(page)
    assert "1 > 2 does not hold" in reading(page)


def test_what_lies_below_a_node_can_be_folded_away(page: Page) -> None:
    """Its rows and bars go, and those further down move up."""
    rows = "[...document.querySelectorAll('.name:not([hidden])')].map((one) => one.title)"
    before = page.look(rows)
    bottom = "document.querySelector('.bars').getBoundingClientRect().height"
    assert page.look(bottom) == 22 * len(before)
    inner = page.look("document.querySelectorAll('.name button').length")
    assert inner == 1, "the root"
    page.look("[...document.querySelectorAll('.name button')].at(-1).click()")
    after = page.look(rows)
    assert set(after) < set(before)
    assert page.look(bottom) == 22 * len(after)
    page.look("[...document.querySelectorAll('.name button')].at(-1).click()")
    assert page.look(rows) == before


def test_a_long_report_begins_folded(
    chromium: Page, a_run: Callable[..., RecordedRun], tmp_path: Path
) -> None:
    """What has succeeded is folded away; the way to what has not is open."""
    run = a_run()
    count, first = 200, run.tree[0]
    leaf = next(
        spans for node, spans in zip(run.tree, run.spans, strict=True) if spans and node.depth
    )
    ended = tuple(replace(span, status="success") for span in leaf)
    tree, spans = [first], [run.spans[0]]
    for index in range(count):
        path = f"0.{index // 2}" + ".0" * (index % 2)
        tree.append(NodeInfo(f"n{index}", "Sequence", path, index if index % 2 else 0))
        spans.append(ended)
    spans[99] = spans[100] = tuple(replace(span, status="failure") for span in leaf)
    long = replace(run, tree=tuple(tree), spans=tuple(spans))
    (tmp_path / "long.html").write_text(page_of(long), encoding="utf-8")
    chromium.open(tmp_path / "long.html", width=1200, height=900)
    rows = chromium.look(
        "[...document.querySelectorAll('.name:not([hidden])')].map((one) => one.title)"
    )
    assert len(rows) == 1 + count // 2 + 1
    assert any(title.startswith("n99 ") for title in rows), "below the one that failed"
    assert chromium.problems == []


def test_wheel_drag_and_double_click_move_through_time(page: Page) -> None:
    """Around the pointer; never beyond the run."""
    x, y = middle_of(page, ".bars")
    page.mouse("mouseWheel", x, y, deltaX=0, deltaY=-600)
    begin, end = shown(page)
    assert 0 < begin < end < 10
    assert begin + end == pytest.approx(10, abs=0.2)
    box = page.look("document.querySelector('.line').getAttribute('viewBox')")
    assert float(box.split()[0]) == pytest.approx(begin, abs=0.01)
    page.mouse("mousePressed", x, y, button="left", buttons=1, clickCount=1)
    page.mouse("mouseMoved", x - 100, y, button="left", buttons=1)
    page.mouse("mouseReleased", x - 100, y, button="left", clickCount=1)
    assert shown(page)[0] > begin
    for count in (1, 2):
        for kind in ("mousePressed", "mouseReleased"):
            page.mouse(kind, x, y, button="left", clickCount=count)
    assert shown(page) == (0, 10)


def test_keys_do_the_same(page: Page) -> None:
    """Once the timeline has the focus."""
    page.look("document.querySelector('.timeline').focus()")
    page.key("ArrowRight")
    page.key("ArrowDown")
    assert reading(page).startswith("0.1 s. root: failure")
    page.key("End")
    page.key("+")
    begin, end = shown(page)
    assert end == 10
    assert begin == pytest.approx(3, abs=0.01)
    page.key("0")
    assert shown(page) == (0, 10)
    page.key("Escape")
    assert reading(page).startswith("Point at the timeline")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_fits_a_phone(page: Page, tmp_path: Path, scheme: str) -> None:
    """Nothing is wider than the screen, by day and by night."""
    page.prefer(scheme)
    page.open(tmp_path / "run.html", width=390, height=844)
    assert page.look("document.documentElement.scrollWidth") == 390
    ground = page.look("getComputedStyle(document.body).backgroundColor")
    assert ground == ("rgb(255, 255, 255)" if scheme == "light" else "rgb(20, 24, 31)")
    page.prefer("light")


def test_it_is_whole_without_scripts(page: Page, tmp_path: Path) -> None:
    """What only a script could fill is not there; all drawings are."""
    page.open(tmp_path / "run.html", width=1200, height=900, scripts=False)
    tree = page.call("DOMSnapshot.captureSnapshot", computedStyles=["display"])
    words = " ".join(tree["strings"])
    assert "Point at the timeline" in words
    sizes = page.call("Page.getLayoutMetrics")["cssContentSize"]
    assert sizes["height"] > 2000
    page.open(tmp_path / "run.html", width=1200, height=900)
