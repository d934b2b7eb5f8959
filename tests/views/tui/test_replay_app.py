"""A recording on a full screen: what stands there, and what each key does."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_mission.base.text import seconds
from bt_mission.views.terminal.marks import ASCII_SIGNS
from bt_mission.views.tui.keys import REPLAY_KEYS
from bt_mission.views.tui.replay_app import Suspend
from tests.support.recordings import recording
from tests.support.replayed import Replayed, on_replay, replayed


@replayed()
async def test_the_whole_picture_at_80_by_24(screen: Replayed) -> None:
    """Header, running path, tree, log, time, keys."""
    await screen.show(1.0)
    duration = f"{screen.player.duration_s:.2f} s"
    rows = screen.rows
    assert rows[0] == "replay  there and back  ▶ running  1.00 s  battery 100 %"
    assert rows[1] == "there and back ▸ repeat ▸ sequence ▸ drive"
    assert rows[7].startswith("»       ▶ drive  0.95 s  ██")
    assert "of 0.4" in rows[7]
    assert "    0.05    off we go" in rows
    assert rows[-2].startswith("1.00 ███")
    assert rows[-2].endswith(f"{duration}  paused          1 x")
    assert rows[-1] == (
        "p play  s/S step  r reverse  +/- speed  t time  Tab goals  ? help  q leave"
    )


@replayed(size=(140, 45))
async def test_all_panels_at_140_by_45(screen: Replayed) -> None:
    """Map, goals, variables, the selected node: as they were."""
    await screen.show(1.0)
    assert "goals: 1 sent, 1 open" in screen.text
    assert "room  1.6" not in screen.text  # the variable, not the output it is written by
    assert "map: x" in screen.text
    early = [row for row in screen.rows if "map: x" in row]
    await screen.show(screen.player.duration_s)
    assert "goals: 4 sent, 0 open" in screen.text
    assert "room  1.6" in screen.text
    assert [row for row in screen.rows if "map: x" in row] != early
    await screen.show(1.0)
    assert "goals: 1 sent, 1 open" in screen.text
    assert "room  1.6" not in screen.text
    assert [row for row in screen.rows if "map: x" in row] == early


@pytest.mark.parametrize("size", [(20, 3), (20, 6), (40, 10), (80, 24), (300, 80)])
def test_every_size_has_a_picture(size: tuple[int, int]) -> None:
    """No row is longer than the terminal; from four rows on time is there."""

    async def play(screen: Replayed) -> None:
        await screen.show(1.0)
        assert max(len(row) for row in screen.rows) <= size[0]
        assert ("1.00" in screen.text) == (size[1] >= 4)

    on_replay(play, size=size)


@replayed(marks=ASCII_SIGNS)
async def test_without_utf_8_every_sign_is_ascii(screen: Replayed) -> None:
    """Also those of the line of time."""
    await screen.show(1.0)
    assert screen.text.isascii()
    await screen.press("question_mark")
    assert screen.text.isascii()


@replayed(speed=0.1)
async def test_p_plays_and_pauses(screen: Replayed) -> None:
    """And plays from the start once it is at the end."""
    await screen.press("p")
    assert "playing" in screen.rows[-2]
    assert screen.rows[-1].startswith("p pause")
    await screen.press("p")
    assert "playing" not in screen.rows[-2]
    assert screen.rows[-1].startswith("p play")
    await screen.press("G")
    assert "at the end" in screen.rows[-2]
    await screen.press("p")
    assert "playing" in screen.rows[-2]
    assert screen.player.at_s < screen.player.duration_s


@replayed(speed=0.1)
async def test_r_plays_the_other_way(screen: Replayed) -> None:
    """And once more forwards."""
    await screen.show(3.0)
    await screen.press("r")
    assert "backwards" in screen.rows[-2]
    await screen.press("r")
    assert "playing" in screen.rows[-2]


@replayed()
async def test_plus_and_minus_are_faster_and_slower(screen: Replayed) -> None:
    """Twice, and half; it goes on standing still."""
    await screen.press("plus", "plus")
    assert screen.rows[-2].endswith("at the start    4 x")
    await screen.press("equals_sign")
    assert screen.rows[-2].endswith("8 x")
    await screen.press("minus", "minus", "minus", "minus")
    assert screen.rows[-2].endswith(" 0.5 x")
    assert not screen.player.is_playing


@replayed()
async def test_s_steps_from_change_to_change(screen: Replayed) -> None:
    """Forwards and backwards, to the ends."""
    await screen.press("s")
    first = screen.player.at_s
    await screen.press("s")
    assert screen.player.at_s > first
    await screen.press("S")
    assert screen.player.at_s == first
    await screen.press("G", "s")
    assert screen.rows[-1] == "the tree does not change after this"
    await screen.press("g", "S")
    assert screen.rows[-1] == "no change before this"


@replayed()
async def test_b_goes_to_the_starts_of_the_selected_node(screen: Replayed) -> None:
    """The next, the one before; else it says that there is none."""
    await screen.press("slash")
    await screen.type("turn")
    await screen.press("b")
    first = screen.player.at_s
    assert any(row.startswith("»       ▶ turn away  0.00 s") for row in screen.rows)
    await screen.press("b")
    second = screen.player.at_s
    assert second > first > 0
    await screen.press("b")
    assert screen.rows[-1] == "'turn away' does not start later"
    await screen.press("B")
    assert screen.player.at_s == first
    await screen.press("B")
    assert screen.rows[-1] == "'turn away' does not start before this"


@replayed()
async def test_leaps(screen: Replayed) -> None:
    """Ten seconds on and back, to the start, to the end."""
    end = screen.player.duration_s
    await screen.press("G")
    assert screen.player.at_s == end
    await screen.press("less_than_sign")
    assert screen.player.at_s == max(end - 10, 0)
    await screen.press("greater_than_sign")
    assert screen.player.at_s == end
    await screen.press("g")
    assert screen.player.at_s == 0
    assert "at the start" in screen.rows[-2]


@replayed()
async def test_t_asks_for_a_time(screen: Replayed) -> None:
    """What is none is said; Esc leaves everything as it was."""
    await screen.press("t")
    assert screen.rows[-1].startswith("seconds since the start")
    await screen.type("2.5")
    assert screen.player.at_s == 2.5
    assert screen.rows[-2].startswith("2.50 ")
    await screen.press("t")
    await screen.type("nan")
    assert screen.rows[-1] == "'nan' is not a time: expected seconds, such as 12.5"
    await screen.press("t", "7", "escape", "t", "escape")
    assert screen.player.at_s == 2.5
    await screen.press("t")
    await screen.type("99")
    assert screen.player.is_at_end


@replayed()
async def test_looking_works_as_it_does_at_a_running_mission(screen: Replayed) -> None:
    """Selection, folding, panels; it outlasts a leap backwards."""
    await screen.show(3.0)
    await screen.press("home", "down", "down", "left")
    assert "»   ▶ repeat" in screen.text
    assert "[+3]" in screen.text
    await screen.press("tab", "g")
    assert "[+3]" in screen.text
    assert "goals: 0 sent" not in screen.text
    assert "─ goals" in screen.text
    await screen.press("right", "f")
    await screen.show(3.0)
    assert screen.app.outlook.is_following


def test_a_recording_that_was_cut_says_so_where_it_ends() -> None:
    """Once it has been played to there."""

    async def play(screen: Replayed) -> None:
        screen.player.go(screen.player.duration_s - 1e-4)
        screen.player.faster(1024)
        await screen.press("p")
        screen.app.look()
        await screen.pilot.pause()
        assert "incomplete from here" in screen.rows[-2]
        assert screen.rows[-1] == (
            "the recording ends here: the file is incomplete, or the recorder was killed"
        )

    data = recording().read_bytes()
    path = recording().with_name("cut.mcap")
    path.write_bytes(data[: len(data) // 2])
    on_replay(play, path=Path(path))


@replayed()
async def test_the_help_names_every_key(screen: Replayed) -> None:
    """And none that would ask a mission for something."""
    await screen.press("question_mark")
    for key in REPLAY_KEYS:
        assert not key.help or key.shown in screen.text
    assert "stop the mission" not in screen.text
    await screen.press("x")
    assert "tree" in screen.rows[2]


@pytest.mark.parametrize("key", ["q", "ctrl+c", "ctrl+q"])
@replayed()
async def test_leaving(screen: Replayed, key: str) -> None:
    """At once."""
    await screen.press(key)
    assert screen.app._exit


@pytest.mark.thorough
def test_a_fork_at_the_shown_instant_is_shown_instead(tmp_path: Path) -> None:
    """With what was typed as its change; the replay stands still meanwhile."""
    forks: list[tuple[Path, float, list[str]]] = []
    other = tmp_path / "fork.mcap"
    other.write_bytes(recording().read_bytes())

    def fork(path: Path, at_s: float, words: list[str], _free: Suspend) -> Path | None:
        forks.append((path, at_s, words))
        return other if len(forks) > 1 else None

    async def play(screen: Replayed) -> None:
        await screen.show(1.0)
        await screen.press("p", "F")
        assert not screen.player.is_playing
        assert f"fork at {seconds(screen.player.at_s)}" in screen.text
        await screen.press(*"reach=0.2", "enter")
        assert not screen.player.is_playing
        assert "the fork failed; this is the original recording" in screen.text
        await screen.press("F", *"reach=0.2 --fault 'at 3: drop scan'", "enter")
        assert screen.app.player.timeline.path == other
        assert screen.app.player.at_s == forks[1][1]
        assert "the fork: " in screen.text
        await screen.press("F", *"reach='", "enter")
        assert "cannot be read: No closing quotation" in screen.text

    on_replay(play, fork=fork)
    assert [words for _, _, words in forks] == [
        ["reach=0.2"],
        ["reach=0.2", "--fault", "at 3: drop scan"],
    ]
    assert {path for path, _, _ in forks} == {recording()}
    assert 1.0 <= forks[0][1] < 2.0


@replayed()
async def test_where_forks_are_not_offered_the_key_says_so(screen: Replayed) -> None:
    """Such as in a view of other programs."""
    await screen.press("F")
    assert "forks are not available here" in screen.text
