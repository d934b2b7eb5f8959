"""The page of a recorded run in a browser: one file, without a server."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from bt_mission.cli import main
from tests.support.browser import IN_BROWSER, Page

pytestmark = IN_BROWSER

OPENED = "document.body.classList.contains('has-report') && document.querySelector('.row')"
FLEET = """\
fleet: pair
world: empty_arena
seed: 3
robots:
  one: {mission: a.yaml, start: {x: 0.5, y: 0}}
  two: {mission: b.yaml, start: {x: -0.5, y: 0}}
"""


def text(page: Page, name: str) -> str:
    """The text of an element."""
    result: str = page.look(f"document.getElementById({name!r}).textContent")
    return result


def click(page: Page, selector: str) -> None:
    """Click an element."""
    page.look(f"document.querySelector({selector!r}).click()")


def middle_of(page: Page, selector: str) -> tuple[float, float, float]:
    """Where an element is on the screen, once it is in view, and its width."""
    page.look(f"document.querySelector({selector!r}).scrollIntoView({{block: 'center'}})")
    x, y, width = page.look(
        f"(() => {{ const b = document.querySelector({selector!r}).getBoundingClientRect();"
        " return [b.x + b.width / 2, b.y + b.height / 2, b.width]; })()"
    )
    return x, y, width


@pytest.fixture
def opened(chromium: Page, page_of: Callable[[Path], Path]) -> Iterator[Callable[..., Page]]:
    """Opens the page of a recording; nothing may go wrong on it, and nothing may be fetched."""

    def visit(recording: Path, width: int = 1400, height: int = 900) -> Page:
        chromium.problems.clear()
        chromium.open(page_of(recording), width=width, height=height)
        chromium.until(OPENED)
        chromium.until("document.documentElement.dataset.drawn > 1")
        return chromium

    yield visit
    assert chromium.problems == []


def test_it_opens_at_the_end_with_outcome_and_failure(opened: Callable[..., Page], hurried: Path):
    """Texts of the mission are texts."""
    page = opened(hurried)
    assert text(page, "mission") == "hurried <b>&amp;"
    assert text(page, "status") == "failure"
    page.until("document.getElementById('at').textContent.includes('at the end')")
    assert text(page, "failure-path") == "hurried <b>&amp;fallbackcheck $room > 100"
    assert "2 of 2 requirements violated" in text(page, "figures")
    assert "alert(1)" in text(page, "log")
    assert "'check $room > 100'" in text(page, "reason")
    assert "</script><script>alert(1)" in text(page, "files")
    page.until("document.getElementById('connection').textContent === ''")


def test_the_way_to_the_failure_leads_to_its_node(opened: Callable[..., Page], hurried: Path):
    """At the instant at which it failed."""
    page = opened(hurried)
    click(page, "#failure-path li:last-child button")
    page.until("document.getElementById('node').textContent.includes('check $room > 100')")
    assert "does not hold" in text(page, "node")


@pytest.mark.thorough
def test_one_moves_in_it_as_in_a_replay(opened: Callable[..., Page], hurried: Path):
    """By the slider, changes, starts of a node, and played in both directions."""
    page = opened(hurried)
    page.look(
        "(() => { const time = document.getElementById('time'); time.value = 1;"
        " time.dispatchEvent(new Event('input')); })()"
    )
    page.until("document.getElementById('at').textContent.startsWith('1.00 of')")
    page.until("document.getElementById('status').textContent === 'running'")
    assert page.look("document.querySelectorAll('#goals li').length") == 1
    click(page, "#change-on")
    page.until("!document.getElementById('at').textContent.startsWith('1.00 of')")
    at = float(text(page, "at").split()[0])
    assert at > 1
    click(page, "#change-back")
    page.until(f"parseFloat(document.getElementById('at').textContent) < {at}")
    click(page, "#faster")
    click(page, "#play")
    page.until("document.getElementById('at').textContent.includes('at the end')")
    page.until("document.getElementById('status').textContent === 'failure'")
    click(page, "#reverse")
    page.until("document.getElementById('at').textContent.includes('backwards')")
    page.until("document.getElementById('at').textContent.includes('at the start')")


def test_the_timeline_tells_what_is_pointed_at(opened: Callable[..., Page], hurried: Path):
    """The node, how it ended, when, and its message; a click goes there."""
    page = opened(hurried)
    x, _, width = middle_of(page, "#span-bars")
    rows = page.look("[...document.querySelectorAll('.name')].map((one) => one.textContent)")
    number = next(index for index, name in enumerate(rows) if "far away" in name)
    top = page.look("document.getElementById('span-bars').getBoundingClientRect().top")
    place = x + width / 2 - 10, top + 22 * number + 11
    page.mouse("mouseMoved", *place)
    reading = text(page, "span-reading")
    assert reading.startswith("far away: failure, ")
    assert "canceled by timeout" in reading
    page.mouse("mousePressed", *place, button="left", clickCount=1)
    page.mouse("mouseReleased", *place, button="left", clickCount=1)
    page.until("!document.getElementById('at').textContent.includes('at the end')")
    page.until("document.getElementById('node').textContent.includes('far away')")
    page.until("document.querySelector('.figure .value').textContent.endsWith('m/s')")


def test_nodes_of_the_timeline_are_folded(opened: Callable[..., Page], hurried: Path):
    """Their rows go, and the drawing is as high as what is left."""
    page = opened(hurried)
    rows = "document.querySelectorAll('.name').length"
    before = page.look(rows)
    click(page, ".name:nth-child(3) button")
    after = page.look(rows)
    assert after < before
    height = "document.getElementById('span-bars').getBoundingClientRect().height"
    assert page.look(height) == 22 * after
    click(page, ".name:nth-child(3) button")
    assert page.look(rows) == before


def test_keys_move_and_zoom_the_timeline(opened: Callable[..., Page], hurried: Path):
    """All drawings show the same stretch of time."""
    page = opened(hurried)
    page.look("document.getElementById('spans').focus()")
    page.key("Home")
    page.until("document.getElementById('at').textContent.startsWith('0.00 of')")
    page.key("+")
    boxes = (
        "[...document.querySelectorAll('.figure svg')].map((one) => one.getAttribute('viewBox'))"
    )
    zoomed = page.look(boxes)
    assert len({label.split()[2] for label in zoomed}) == 1
    page.key("ArrowRight")
    page.until("!document.getElementById('at').textContent.startsWith('0.00 of')")
    page.key("0")
    assert page.look(boxes) != zoomed


def test_a_goal_shows_its_feedback(opened: Callable[..., Page], hurried: Path):
    """Against time, at the instant at which it was sent."""
    page = opened(hurried)
    assert page.look("document.querySelectorAll('#lives tr').length") == 5
    click(page, "#goal-3 button")
    title = "document.getElementById('feedback-title').textContent"
    page.until(f"{title} === 'Feedback of goal 3 to /explore_forward'")
    assert "current_distance_travelled" in text(page, "feedback-list")
    page.until("!document.getElementById('at').textContent.includes('at the end')")


def test_on_a_phone_nothing_is_wider_than_the_screen(opened: Callable[..., Page], hurried: Path):
    """Tables become lists."""
    page = opened(hurried, 390, 800)
    assert page.look("document.documentElement.scrollWidth") <= 390


def test_robots_of_a_fleet_are_chosen_on_the_page(opened: Callable[..., Page], tmp_path: Path):
    """Each with its own tree."""
    (tmp_path / "a.yaml").write_text("mission: waits\ntree: {wait: 1}\n")
    (tmp_path / "b.yaml").write_text("mission: turns\ntree: {turn: {angle: 45}, timeout: 9}\n")
    fleet, recording = tmp_path / "pair.fleet.yaml", tmp_path / "pair.mcap"
    fleet.write_text(FLEET)
    assert main(["run", str(fleet), "--record", str(recording)]) == 0
    page = opened(recording)
    assert text(page, "mission") == "waits"
    assert text(page, "choice-list") == "onetwo"
    click(page, "#choice-list li:last-child button")
    page.until("document.getElementById('mission').textContent === 'turns'")
    page.until("document.getElementById('tree').textContent.includes('turn')")
    assert page.look("document.querySelector('[aria-pressed=true]').textContent") == "two"


def test_without_scripts_the_outcome_is_shown(
    chromium: Page, hurried: Path, page_of: Callable[[Path], Path]
):
    """And what is missing."""
    chromium.open(page_of(hurried), width=800, height=600, scripts=False)
    words = " ".join(chromium.call("DOMSnapshot.captureSnapshot", computedStyles=[])["strings"])
    assert "need JavaScript" in words
    assert "does not hold" in words
