"""Each key of the full-screen view does what the help says."""

from __future__ import annotations

import pytest

from bt_mission.executive.events.source import ControlRequest, Verb
from bt_mission.views.terminal.marks import SIGNS
from bt_mission.views.tui.keys import KEYS
from tests.support.screens import Screen, shown
from tests.support.thorough import sample


async def running(screen: Screen) -> None:
    """The robot drives."""
    screen.executive.change(
        explore="running", look_around="success", repeat="running", drive="running"
    )
    await screen.look()


@pytest.mark.parametrize(
    ("keys", "command"),
    sample(
        [
            ("p", ControlRequest(Verb.PAUSE)),
            ("P", ControlRequest(Verb.PAUSE_KEEPING_GOALS)),
            ("r", ControlRequest(Verb.RESUME)),
            ("s", ControlRequest(Verb.STEP)),
            ("xx", ControlRequest(Verb.STOP)),
            ("b", ControlRequest(Verb.BREAK, "0.1.0")),
        ],
        3,
    ),
)
@shown()
async def test_wishes_are_passed_on(screen: Screen, keys: str, command: ControlRequest) -> None:
    """Once each."""
    await running(screen)
    await screen.press(*keys)
    assert screen.executive.commands == [command]


@shown()
async def test_a_mission_is_not_stopped_by_one_key(screen: Screen) -> None:
    """Another key in between takes the wish back."""
    await screen.press("x")
    assert screen.rows[-1] == "x again stops the mission; any other key does not"
    await screen.press("down", "x")
    assert screen.executive.commands == []


@shown()
async def test_the_answer_to_a_wish_is_shown(screen: Screen) -> None:
    """In the place of the keys."""
    screen.executive.answer("the mission is not paused", is_done=False)
    await screen.look()
    assert screen.rows[-1] == "the mission is not paused"


@pytest.mark.parametrize("name", ["drive", "0.1.0"])
@shown()
async def test_a_breakpoint_is_removed_by_the_same_key(screen: Screen, name: str) -> None:
    """By the name or path by which it was set."""
    await running(screen)
    screen.executive.detail(breakpoints=(name,))
    await screen.look()
    assert screen.chosen.startswith("▶ drive")
    assert any(row.startswith("»●") for row in screen.rows)
    await screen.press("b")
    assert screen.executive.commands == [ControlRequest(Verb.UNBREAK, name)]


@pytest.mark.parametrize(
    ("keys", "name"),
    sample(
        [
            (["home"], "explore"),
            (["end"], "turn away"),
            (["up"], "repeat"),
            (["k", "k"], "look around"),
            (["j"], "turn away"),
            (["home", "down", "down"], "repeat"),
            (["home", "up"], "explore"),
            (["pagedown"], "turn away"),
            (["pageup"], "explore"),
            (["left"], "repeat"),
            (["left", "left", "left"], "explore"),
        ],
        3,
    ),
)
@shown()
async def test_nodes_are_selected(screen: Screen, keys: list[str], name: str) -> None:
    """From the one that runs on; the left key leads to the parent of a leaf."""
    await running(screen)
    await screen.press(*keys)
    assert screen.chosen[2:].startswith(name)


@shown()
async def test_nodes_are_folded_and_unfolded(screen: Screen) -> None:
    """By arrows, Enter and the star."""
    await running(screen)
    await screen.press("up", "left")
    assert screen.chosen.startswith("▶ repeat [+2]")
    assert "turn away" not in screen.text
    for number, key in enumerate(("right", "enter", "space", "asterisk", "asterisk")):
        await screen.press(key)
        assert ("turn away" in screen.text) is (number % 2 == 0), key


@shown()
async def test_following_selects_what_runs(screen: Screen) -> None:
    """A move by hand ends it, the key begins it anew."""
    await running(screen)
    assert "tree, following" in screen.rows[2]
    await screen.press("home")
    assert "following" not in screen.rows[2]
    screen.executive.change(drive="success", turn_away="running")
    await screen.look()
    assert screen.chosen.startswith("▶ explore")
    await screen.press("f")
    assert screen.chosen.startswith("▶ turn away")


@shown()
async def test_following_shows_the_folded_node_that_hides_what_runs(screen: Screen) -> None:
    """What somebody has folded stays folded."""
    await running(screen)
    await screen.press("up", "left", "f")
    assert screen.chosen.startswith("▶ repeat [+2]")
    assert screen.rows[1] == "explore ▸ repeat ▸ drive"


@shown()
async def test_a_search_finds_while_it_is_typed(screen: Screen) -> None:
    """Enter stays there; n and N go on. Keys that are typed are no commands."""
    await running(screen)
    await screen.press("slash", "r", "e", "p")
    assert screen.chosen.startswith("▶ repeat")
    await screen.press("enter")
    assert "search" in screen.rows[-1], "the keys are back"
    await screen.press("slash", "a", "enter")
    first = screen.chosen
    await screen.press("n")
    assert screen.chosen != first
    await screen.press("N")
    assert screen.chosen == first
    assert screen.executive.commands == []


@shown()
async def test_a_search_that_is_left_changes_nothing(screen: Screen) -> None:
    """Escape goes back to where it began."""
    await running(screen)
    await screen.press("home", "slash", "t", "u", "escape")
    assert screen.chosen.startswith("▶ explore")


@shown()
async def test_what_is_not_there_is_said(screen: Screen) -> None:
    """And so is a repetition without a search."""
    await screen.press("n")
    assert screen.rows[-1] == "no search yet; press /"
    await screen.press("slash", "z", "z", "enter")
    assert screen.rows[-1] == "'zz' is not in the tree"


@shown()
async def test_tab_goes_through_the_panels(screen: Screen) -> None:
    """And back; z gives one the whole screen."""
    titles = []
    for _ in range(6):
        titles.append(next(row for row in screen.rows[4:] if row.startswith("─ ")).split()[1])
        await screen.press("tab")
    assert titles == ["log", "goals", "variables", "map", "selected", "log"]
    await screen.press("shift+tab", "z")
    assert screen.rows[2].startswith("─ log ─")
    assert "tree" not in screen.rows[2]
    await screen.press("z")
    assert screen.rows[2].startswith("─ tree")


@shown()
async def test_an_enlarged_log_scrolls(screen: Screen) -> None:
    """Upwards into the past."""
    for number in range(40):
        screen.executive.say(f"line {number}")
    await screen.look()
    await screen.press("z")
    assert screen.rows[-2].endswith("line 39")
    await screen.press("up", "up")
    assert screen.rows[-2].endswith("line 37")
    await screen.press("down", "down", "down")
    assert screen.rows[-2].endswith("line 39")


@shown(size=(80, 30))
async def test_the_help_names_every_key(screen: Screen) -> None:
    """Any key closes it."""
    await screen.press("question_mark")
    for key in KEYS:
        assert not key.help or key.shown in screen.text
    await screen.press("p")
    assert screen.executive.commands == []
    assert "tree" in screen.rows[2]
    await screen.press("f1")
    assert "this help" in screen.text


@pytest.mark.parametrize("key", ["q", "ctrl+c", "ctrl+q"])
@shown()
async def test_leaving_leaves_the_mission_alone(screen: Screen, key: str) -> None:
    """Nothing is sent."""
    await screen.press(key)
    assert not screen.app.is_running or screen.app._exit
    assert screen.executive.commands == []


@shown()
async def test_signs_of_the_cursor_are_there_without_colour(screen: Screen) -> None:
    """The selected row begins with a sign of its own."""
    assert [row for row in screen.rows if row.startswith(SIGNS.cursor)] != []
