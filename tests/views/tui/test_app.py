"""The full-screen view: sizes, executives that come and go, odd terminals and names."""

from __future__ import annotations

from functools import partial

import pytest

from bt_mission.executive.events.source import ListedExecutive
from bt_mission.views.terminal.marks import ASCII_SIGNS
from bt_mission.views.tui import app
from tests.support.screens import Screen, on_screen, shown
from tests.support.watched import ScriptedExecutive, begun, goal_in


@shown()
async def test_the_whole_picture_at_80_by_24(screen: Screen) -> None:
    """Header, running path, tree, log, keys."""
    executive = screen.executive
    executive.change(explore="running", look_around="running")
    executive.change(8.4, look_around="success: canceled by condition", repeat="running")
    executive.change(drive="running")
    progress = executive.progress("drive", 1.2, 2.0, "travelled 1.20")
    executive.detail(2.5, running=(progress,))
    await screen.look()
    assert screen.rows == [
        "explore  ▶ running  10.90 s",
        "explore ▸ repeat ▸ drive",
        "─ tree, following ──────────────────────────────────────────────────────────────",
        "  ▶ explore  10.90 s",
        "    ✓ look around  8.40 s  canceled by condition",
        "    ▶ repeat  2.50 s",
        "»     ▶ drive  2.50 s  ███████░░░░░ 1.20 of 2  travelled 1.20",
        "      · turn away",
        *[""] * 8,
        "─ log ──────────────────────────────────────────────────────────────────────────",
        "    0.00    explore  begins",
        "    0.00    mission running",
        "    0.00  ▶ look around",
        "    8.40  ✓ look around  canceled by condition",
        "    8.40  ▶ drive",
        "",
        "p pause  x stop  b break  / search  f follow  Tab goals  ? help  q leave",
    ]


@pytest.mark.parametrize("size", [(20, 6), (20, 24), (40, 10), (80, 24), (140, 45), (300, 80)])
def test_every_size_has_a_picture(size: tuple[int, int]):
    """The running node is in it, and no row is longer than the terminal."""

    async def play(screen: Screen) -> None:
        screen.executive.change(explore="running", repeat="running", drive="running")
        await screen.look()
        assert "drive" in screen.text
        assert max(len(row) for row in screen.rows) <= size[0]

    on_screen(play, size=size)


@shown()
async def test_a_terminal_may_change_its_size(screen: Screen) -> None:
    """Wide ones show all panels at once."""
    screen.executive.detail(variables=(("legs", "6"),))
    await screen.look()
    assert "legs" not in screen.text
    await screen.pilot.resize_terminal(140, 45)
    await screen.look()
    assert "legs 6" in screen.text
    assert "map" in screen.rows[2]
    await screen.pilot.resize_terminal(30, 8)
    await screen.look()
    assert "explore" in screen.rows[0]


@shown(size=(140, 45), marks=ASCII_SIGNS)
async def test_without_utf_8_every_sign_is_ascii(screen: Screen) -> None:
    """Also those of rules, bars and maps."""
    screen.executive.change(explore="running", drive="running: größer")
    await screen.look()
    assert screen.text.isascii()
    await screen.press("question_mark")
    assert screen.text.isascii()


def absent() -> ScriptedExecutive:
    """An executive that has not come yet."""
    executive = ScriptedExecutive()
    executive.is_there = False
    return executive


@shown(make=absent)
async def test_nobody_there_is_said_and_looked_for(screen: Screen) -> None:
    """Until somebody comes."""
    assert screen.rows[0] == " searching  no mission"
    assert screen.rows[3] == "an executive was not found (a test)."
    assert "bt-mission run FILE --visible" in screen.text
    assert screen.rows[-1] == "c choose  ? help  q leave"
    screen.executive.is_there = True
    screen.executive.begin()
    await screen.look()
    assert screen.rows[0].startswith("explore  ▶ running")


@shown()
async def test_an_executive_that_vanishes_is_waited_for(screen: Screen) -> None:
    """The last picture stays; what it does when it is back begins a new one."""
    screen.executive.change(explore="running", drive="running")
    await screen.look()
    screen.executive.is_there = False
    await screen.look()
    assert screen.rows[0].startswith(" disconnected; reconnecting  explore")
    assert "drive" in screen.text
    screen.executive.is_there = True
    screen.executive.begin("another run")
    await screen.look()
    assert screen.rows[0].startswith("explore  ▶ running  0.00 s")
    assert "▶ drive" not in screen.rows[6]


def test_of_several_one_is_chosen_in_a_list():
    """At the start, and whenever somebody wants another one."""
    first, second = begun(name="/robot1/bt_mission"), begun("patrol\n  go", "/robot2/bt_mission")

    async def play(screen: Screen) -> None:
        assert "/robot1/bt_mission" in screen.text
        await screen.press("down", "enter")
        await screen.look()
        assert screen.rows[0].startswith("patrol")
        await screen.press("c", "up", "enter")
        await screen.look()
        assert screen.rows[0].startswith("explore")
        assert second.closed
        await screen.press("c", "escape")
        assert screen.rows[0].startswith("explore")

    on_screen(play, first, second)


def test_one_that_is_named_is_taken_without_a_question():
    """Though there are others."""
    first, second = (begun(name=f"/robot{n}/bt_mission") for n in (1, 2))

    async def play(screen: Screen) -> None:
        assert screen.rows[0].startswith("explore")
        assert screen.app.source is second

    on_screen(play, first, second, name="/robot2/bt_mission")


FOREIGN = ListedExecutive(
    "/bt_mission", "its Tree messages are of another version", is_foreign=True
)


@pytest.mark.parametrize(
    ("listed", "row", "is_read"),
    [
        (FOREIGN, "/bt_mission: its Tree messages are of another version", False),
        (
            ListedExecutive("/bt_mission", "2 executives share this name"),
            "2 executives share this name",
            True,
        ),
    ],
    ids=["another version", "two of one name"],
)
@shown(make=absent)
async def test_an_executive_with_a_fault_is_told(
    screen: Screen, listed: ListedExecutive, row: str, *, is_read: bool
) -> None:
    """One of another version is not read."""
    screen.graph.faults["/bt_mission"] = listed
    screen.executive.is_there = True
    await screen.look()
    assert screen.rows[-1] == row
    assert (screen.app.source is screen.executive) is is_read


@shown(make=partial(begun, "a\x1b[31m\x07b\n  \x9b2Jc"))
async def test_names_with_control_characters_are_shown_as_codes(screen: Screen) -> None:
    """They neither move the cursor nor colour the screen."""
    assert "a\\x1b[31m\\x07b" in screen.text
    assert "\\x9b2Jc" in screen.text
    letters = screen.text.replace("\n", "")
    assert not any(ord(letter) < 32 or ord(letter) == 0x9B for letter in letters)


LONG = "\n".join(["root", *(f"  part {n}\n    leaf {n}" for n in range(200))])


@shown(make=partial(begun, LONG))
async def test_the_running_path_stays_in_view_in_a_long_tree(screen: Screen) -> None:
    """With what it runs below, as far as there is room."""
    screen.executive.change(leaf_150="running", part_150="running", root="running")
    await screen.look()
    assert screen.chosen.startswith("▶ leaf 150")
    assert any("▶ part 150" in row for row in screen.rows)
    assert screen.rows[1] == "root ▸ part 150 ▸ leaf 150"
    assert "of 401" in screen.rows[2]


@shown()
async def test_goals_are_listed_with_those_that_are_open_first(screen: Screen) -> None:
    """State, duration, action, node."""
    screen.executive.detail(
        5.0,
        goals_sent=2,
        goals=(
            goal_in("succeeded", goal_id="ab" * 16, at_s=4, sent_s=2),
            goal_in("active", goal_id="cd" * 16, action="/explore_forward", owner="drive"),
        ),
    )
    await screen.look()
    await screen.press("tab")
    assert screen.rows[16:19] == [
        "─ goals: 2 sent, 1 open ────────────────────────────────────────────────────────",
        "▶ active     5.00 s  /explore_forward  drive  cdcdcdcd",
        "✓ succeeded  2.00 s  /turn  turn away  abababab",
    ]


@shown()
async def test_an_executive_that_comes_back_as_another_version_is_left(
    screen: Screen, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its messages are read no longer."""
    assert screen.app.source is screen.executive
    screen.graph.faults["/bt_mission"] = FOREIGN
    monkeypatch.setattr(app, "CHECK_S", 0.0)
    await screen.look()
    assert screen.executive.closed
    assert screen.rows[-1] == "/bt_mission: its Tree messages are of another version"


@shown(make=absent, wait_s=0.0)
async def test_who_does_not_want_to_wait_leaves(screen: Screen) -> None:
    """With a code that scripts can read."""
    assert screen.app.return_code == 1


@shown()
async def test_the_mouse_selects_and_folds(screen: Screen) -> None:
    """A click selects, a second one folds, the wheel moves."""
    await screen.pilot.click("#tree", offset=(8, 3))
    assert screen.chosen.startswith("· repeat")
    await screen.pilot.click("#tree", offset=(8, 3), times=2)
    assert screen.chosen.startswith("· repeat [+2]")
    screen.app.on_mouse_scroll_up()
    await screen.pilot.pause()
    assert screen.chosen.startswith("· look around")


@shown()
async def test_who_has_gone_is_not_offered_anything(screen: Screen) -> None:
    """Nor is a mission that has ended: nothing of it starts any more."""
    assert screen.rows[-1].startswith("p pause  x stop  b break  / search")
    screen.executive.is_there = False
    await screen.look()
    assert screen.rows[-1].startswith("/ search")
    screen.executive.is_there = True
    screen.executive.stand("success")
    await screen.look()
    assert screen.rows[-1].startswith("/ search")


@pytest.mark.parametrize("count", [1, 20])
def test_requirements_have_a_panel(count: int):
    """Where there is room, at once; else it is the next one. Enlarged, twenty stand there."""

    async def narrow(screen: Screen) -> None:
        names = [f"number_{number}" for number in range(count)]
        verdicts = dict.fromkeys(names, "open 0.2") | {names[-1]: "violated -0.1"}
        screen.executive.judge(**verdicts)
        await screen.look()
        assert f"✗ 1 of {count} violated" in screen.rows[0]
        assert "Tab requirements" in screen.rows[-1]
        await screen.press("tab")
        await screen.press("z")
        assert screen.rows[3].startswith(f"✗ violated number {count - 1}")
        assert screen.text.count("▶ open ") == count - 1
        await screen.press("z")
        await screen.press("tab")
        assert "─ goals" in screen.text

    on_screen(narrow)

    async def wide(screen: Screen) -> None:
        screen.executive.judge(**{f"number_{number}": "open 0.2" for number in range(count)})
        await screen.look()
        await screen.look()
        assert f"─ requirements: {count} open ─" in screen.text

    on_screen(wide, size=(120, 40))
