"""What terminals show while a mission or a fleet runs, and what is left on them at the end."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import pytest
from bt_mission_interfaces.action import Turn
from rich.console import Console

from bt_mission.scenarios.fleets.loader import load_fleet
from bt_mission.sessions.drive import drive
from bt_mission.sessions.stage import Stage
from bt_mission.views.terminal.console import EscapingConsole
from bt_mission.views.terminal.live_view import LiveTree, LiveView, PlainView
from tests.support.played_session import PlayedSession
from tests.support.terminal import shown_by_terminal


def rows_on(stream: io.StringIO) -> list[str]:
    """What is left on a terminal, without the header's figures."""
    rows = shown_by_terminal(stream.getvalue())
    return [row.split("   ")[0] if "x real time" in row else row for row in rows if row]


TREE = """\
  sequence:
    - {log: hello, name: greet}
    - turn: {angle: 90}
      name: turn left
      timeout: 10
      cancel_when: current_angle >= 45
    - {wait: 1, name: rest}
"""


@pytest.fixture
def picture(play: Any) -> Any:
    """Play up to some feedback; gives the lines of the picture on a terminal of this size."""

    def draw(current: float, width: int = 80, height: int = 24, encoding: str = "utf-8") -> Any:
        run = play(TREE)
        run.tick()
        run.turn.accept()
        run.turn.feed(Turn.Feedback(current_angle=current, remaining_angle=90 - current))
        run.tick()
        stream = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
        console = Console(file=stream, width=width, height=height, color_system=None)
        with console.capture() as capture:
            console.print(LiveTree(console, run.executive, lambda: "test   0.1 s").render())
        return capture.get().rstrip("\n").split("\n")

    return draw


def test_status_progress_and_feedback_stand_in_one_line(picture: Any) -> None:
    """What is done, what runs and how far, what is still to come."""
    assert [line.rstrip() for line in picture(15.0, width=100)] == [
        "test   0.1 s",
        "▶ test",
        "  ✓ greet  hello",
        "  ▶ turn left  ████░░░░░░░░ 15 of 45  current_angle 15.00, remaining_angle 75.00",
        "  · rest",
    ]


def test_without_utf_8_it_is_drawn_in_ascii(picture: Any) -> None:
    """Other signs, the same facts."""
    lines = picture(45.0, encoding="ascii")
    assert lines[2].startswith("  + greet")
    assert "############ 45 of 45" in lines[3]
    assert lines[4].rstrip() == "  - rest"


@pytest.mark.parametrize("width", [20, 40, 80])
def test_no_line_is_wider_than_the_terminal(picture: Any, width: int) -> None:
    """What does not fit is cut, not wrapped."""
    lines = picture(15.0, width=width)
    assert len(lines) == 5
    assert max(len(line) for line in lines) <= width


def test_on_a_low_terminal_the_running_leaf_stays_in_sight(picture: Any) -> None:
    """Rows above it give way."""
    lines = picture(15.0, height=5)
    assert len(lines) == 3
    assert any("turn left" in line for line in lines)


def test_feedback_that_is_no_number_has_no_bar(picture: Any) -> None:
    """A NaN must not end what shows it."""
    assert "of 45" not in picture(float("nan"))[3]


def paused_with_a_goal(play: Any) -> Any:
    """A session that is paused while its goal is under way."""
    run = play("  turn: {angle: 90}\n")
    run.tick()
    run.turn.accept()
    run.executive.pause("by hand", keep_goals=True)
    session = PlayedSession(run.executive, world="arena")
    return session, run


@pytest.mark.parametrize(
    ("world", "title"),
    [("arena", "test in arena (waffle, seed 0)\n"), (None, "test (waffle, seed 0)\n")],
)
def test_the_title_names_the_world_of_the_run(play: Any, world: str | None, title: str) -> None:
    """Not that of the mission's file; an attached mission drives wherever the robot is."""
    stream = io.StringIO()
    session, _ = paused_with_a_goal(play)
    session.world = world
    PlainView(stream).open(session)
    assert stream.getvalue() == title


def test_a_pause_is_in_the_plain_lines_with_what_is_under_way(play: Any) -> None:
    """A line for each change of it, and one for its end."""
    stream = io.StringIO()
    session, run = paused_with_a_goal(play)
    view = PlainView(stream)
    view.open(session)
    view.refresh()
    view.refresh()
    run.turn.succeed()
    run.tick()
    view.refresh()
    session.executive.resume()
    view.refresh()
    assert [line.strip() for line in stream.getvalue().splitlines()[1:]] == [
        "2.00 s    mission paused  by hand; still running: 'turn'",
        "2.00 s    mission paused  by hand",
        "2.00 s    mission running",
    ]


def test_a_pause_is_above_the_live_tree_with_what_is_under_way(play: Any) -> None:
    """Instead of the state."""
    console = Console(file=io.StringIO(), width=120, force_terminal=True)
    view = LiveView(console)
    view.open(paused_with_a_goal(play)[0])
    view.refresh()
    view.close()
    drawn = console.file.getvalue()  # type: ignore[attr-defined]  # a StringIO
    assert "paused: by hand; still running: 'turn'" in drawn


class Run:
    """A mission on a terminal that the test reads."""

    def __init__(self, play: Any, text: str, width: int = 100, height: int = 24) -> None:
        self.played = play(text, "mission: test\ninputs: {pace: 1}")
        self.stream = io.StringIO()
        self.console = Console(
            file=self.stream, width=width, height=height, force_terminal=True, _environ={}
        )
        self.view = LiveView(self.console)
        self.session = PlayedSession(self.played.executive)
        self.view.open(self.session)

    def end(self) -> list[str]:
        """End the view; gives what is left on the terminal, without the header's figures."""
        self.view.close()
        return rows_on(self.stream)


@pytest.fixture
def run(play: Any) -> Any:
    """Begin a run: of this tree, on a terminal of this size."""

    def begin(text: str, **size: int) -> Run:
        return Run(play, text, **size)

    return begin


def test_all_that_a_mission_says_scrolls_by_above_the_tree(run: Any) -> None:
    """Also more than fits beside it, and nothing twice."""
    begun = run("  wait: 1\n")
    begun.view.refresh()
    for number in range(6):
        begun.session.say(begun.view, f"line {number}")
    assert begun.end() == [
        *(f"     2.00 s    line {number}" for number in range(6)),
        "test (waffle, seed 0)",
        "· wait",
    ]


def test_several_lines_are_said_in_as_many(run: Any) -> None:
    """Without what would move the cursor."""
    begun = run("  wait: 1\n")
    begun.session.say(begun.view, "one\ntwo\x1b[2A")
    assert begun.end()[:2] == ["     2.00 s    one", "     2.00 s    two\\x1b[2A"]


BOTH_FAIL = """\
  retry: {attempts: 2}
  do:
    fallback:
      - {check: pace > 2, name: quick look}
      - {turn: {angle: 90}, name: first way, timeout: 30}
      - {turn: {angle: 180}, name: second way, timeout: 30}
"""


def fail_all(played: Any) -> None:
    """Have every goal rejected, until the mission has failed."""
    while not played.executive.is_done:
        played.tick()
        played.turn.reject()


def test_the_last_frame_tells_why_each_node_has_failed(run: Any) -> None:
    """Also of those that py_trees has reset since: a fallback resets what it went on from."""
    begun = run(BOTH_FAIL)
    fail_all(begun.played)
    assert begun.end()[1:] == [
        "✗ test  attempt 2 of 2",
        "  ✗ fallback",
        "    ✗ quick look  does not hold (pace = 1)",
        "    ✗ first way  rejected: /turn: its server gave no reason",
        "    ✗ second way  rejected: /turn: its server gave no reason",
    ]


def test_on_a_low_terminal_the_path_to_the_failure_stays_in_sight(run: Any) -> None:
    """Rows that are not on it give way."""
    begun = run(BOTH_FAIL, height=6)
    fail_all(begun.played)
    assert [row.split()[1] for row in begun.end()[1:]] == ["test", "fallback", "second"]


def test_what_ran_at_ctrl_c_is_shown_as_it_ended(run: Any) -> None:
    """It was halted, with its last words; what had ended before stays."""
    begun = run(
        "  sequence:\n"
        "    - {log: hello, name: greet}\n"
        "    - parallel:\n"
        "        - {turn: {angle: 90}, name: left, cancel_when: current_angle >= 60, timeout: 9}\n"
        "        - {wait: 5}\n"
    )
    begun.played.tick()
    begun.played.turn.accept()
    begun.played.turn.feed(Turn.Feedback(current_angle=15.0, remaining_angle=75.0))
    begun.played.tick()
    begun.played.executive.interrupt("interrupted by Ctrl-C")
    begun.played.tick()
    begun.played.turn.cancel()
    begun.played.tick()
    assert begun.end() == [
        "test (waffle, seed 0)",
        "· test",
        "  ✓ greet  hello",
        "  · parallel",
        "    · left  halted",
        "    · wait  5.0 s left",
    ]


def test_the_round_that_was_interrupted_is_named(run: Any) -> None:
    """A node that runs on says other things than when it began to run."""
    begun = run("  repeat: {count: 9}\n  do: {wait: 0.1}\n")
    begun.played.tick(8)
    shown = begun.played.executive.root.feedback_message
    assert shown not in ("", "1 of 9")
    begun.played.executive.interrupt("interrupted by Ctrl-C")
    begun.played.tick()
    assert begun.end()[1] == f"· test  {shown}"


def test_on_a_narrow_terminal_the_header_says_how_it_goes(run: Any) -> None:
    """Rather than in which world, with which robot and seed."""
    begun = run("  wait: 1\n", width=30)
    begun.played.tick()
    begun.view.close()
    rows = shown_by_terminal(begun.stream.getvalue())
    assert rows[0] == "test   2.00 s   running"


def test_a_node_that_is_to_run_once_more_has_not_run_yet(run: Any) -> None:
    """Each round of a repeat begins with a clean sheet."""
    begun = run(
        "  repeat: {count: 2}\n  do:\n    sequence:\n      - {wait: 0.1, name: a}\n"
        "      - {wait: 0.1, name: b}\n"
    )
    signs = []
    for _ in range(7):
        begun.played.tick()
        tree = LiveTree(begun.console, begun.played.executive, lambda: "")
        with begun.console.capture() as capture:
            begun.console.print(tree.render())
        rows = shown_by_terminal(capture.get())
        signs.append("".join(row.strip()[0] for row in rows if row.split()[1:2] in (["a"], ["b"])))
    assert signs == ["▶·", "▶·", "✓▶", "✓▶", "✓✓", "▶·", "▶·"]


def shown_of_fleet(path: Path, folder: Path, height: int) -> list[str]:
    """Run a fleet; return what its picture leaves on a terminal of so many rows."""
    plan = load_fleet(path)
    stream = io.StringIO()
    console = EscapingConsole(stream, width=80, height=height, force_terminal=True, _environ={})
    with Stage(robots=plan.robots, image_folder=folder, options=plan.stage_options) as stage:
        drive(stage, [LiveView(console, title=plan.title)])
    return rows_on(stream)


@pytest.fixture
def fleet(tmp_path: Path) -> Path:
    """A fleet of three robots that wait for a moment each."""
    path = tmp_path / "it.yaml"
    robots = "".join(
        f"  r{n}:\n    mission:\n      mission: m{n}\n"
        f"      tree: {{sequence: [{{wait: 0.{n}}}, {{log: hm}}]}}\n"
        f"    start: {{x: {n - 2}}}\n"
        for n in (1, 2, 3)
    )
    path.write_text(f"fleet: three\nworld: empty_arena\nrobots:\n{robots}", encoding="utf-8")
    return path


def test_each_robot_has_its_tree_below_a_line_of_its_own(fleet: Path, tmp_path: Path) -> None:
    """What missions say scrolls by above, with the name."""
    assert shown_of_fleet(fleet, tmp_path, 30) == [
        "     0.15 s  r1  hm",
        "     0.25 s  r2  hm",
        "     0.35 s  r3  hm",
        "three in empty_arena (3 robots, seed 0)",
        *(
            row
            for n in (1, 2, 3)
            for row in (f"r{n}  m{n}  success", f"✓ m{n}", "  ✓ wait  0.0 s left", "  ✓ log  hm")
        ),
    ]


def test_where_there_is_no_room_for_trees_each_robot_has_its_line(
    fleet: Path, tmp_path: Path
) -> None:
    """A terminal of seven rows shows the three of them all the same."""
    assert shown_of_fleet(fleet, tmp_path, 7)[3:] == [
        "three in empty_arena (3 robots, seed 0)",
        "r1  m1  success",
        "r2  m2  success",
        "r3  m3  success",
    ]
