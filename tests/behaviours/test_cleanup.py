"""Clean-ups: each runs once, however its node ends, and the mission waits for it."""

from __future__ import annotations

from typing import Any

import pytest

from tests.support.play import TICK_NS, S

TURN = "{action: {name: /%s, type: bt_mission_interfaces/action/Turn}, name: %s, timeout: 99}"
A, B, C = (TURN % (name, name) for name in "abc")


def tidy(body: str = A, then: str = C, timeout: str = "1") -> str:
    """A node with a clean-up."""
    return f"{{finally: {{timeout: {timeout}}}, do: {body}, then: {then}, name: tidy}}"


def end(story: Any, name: str, status: int = 4) -> None:
    """The newest goal of a server ends."""
    story.servers[f"/{name}"].goal.on_result(status, None)


def accept(story: Any, *names: str) -> None:
    """Servers take their newest goals."""
    for name in names:
        story.servers[f"/{name}"].accept()


def clean_up_after_a_timeout(story: Any) -> None:
    """Goal a is cancelled after half a second; that of the clean-up, c, is accepted."""
    story.tick()
    accept(story, "a")
    story.tick(10)
    end(story, "a", 5)
    story.tick()
    accept(story, "c")


@pytest.mark.parametrize(("result", "letter", "status"), [(4, "S", "success"), (6, "F", "failure")])
def test_the_status_is_that_of_the_node(play: Any, result: int, letter: str, status: str) -> None:
    """The clean-up begins in the tick in which the node ends."""
    story = play(f"  {tidy()}")
    assert story.tick() == "RRI"
    accept(story, "a")
    end(story, "a", result)
    assert story.tick() == f"R{letter}R"
    accept(story, "c")
    end(story, "c")
    assert story.tick() == f"{letter}{letter}S"
    story.tick()
    assert story.status == status


def test_a_clean_up_that_fails_is_a_failure(play: Any) -> None:
    """Though the node has succeeded; the reason names what has failed in it."""
    story = play(f"  {tidy('{log: a}', '{check: false}')}")
    assert story.tick() == "FSF"
    assert story.executive.reason == "'check false' never holds"
    assert story.root.feedback_message == "clean-up failed: 'check false' never holds"


def test_a_clean_up_that_takes_too_long_is_halted(play: Any) -> None:
    """After its timeout of one second, to the tick; its goal is cancelled and awaited."""
    story = play(f"  {tidy('{log: a}')}")
    story.tick()
    accept(story, "c")
    assert story.tick(19) == "RSR"
    assert story.tick() == "FSI"
    assert story.servers["/c"].cancels
    end(story, "c", 5)
    story.tick()
    assert (story.status, story.executive.reason) == (
        "failure",
        "'tidy' clean-up not done within 1 s",
    )


def test_an_interrupted_mission_waits_for_its_clean_up(play: Any) -> None:
    """The goal of the node is cancelled; that of the clean-up is carried out to its end."""
    story = play(f"  {tidy()}")
    story.tick()
    accept(story, "a")
    story.tick()
    story.executive.interrupt("interrupted by SIGINT")
    assert (story.statuses, story.status) == ("III", "ending")
    end(story, "a", 5)
    assert story.tick() == "IIR"
    accept(story, "c")
    story.tick(10)
    assert story.status == "ending"
    assert not story.servers["/c"].cancels
    end(story, "c")
    assert story.tick() == "IIS"
    assert (story.status, story.executive.reason) == ("interrupted", "interrupted by SIGINT")
    assert (story.executive.goals_sent, story.executive.goals_left_behind) == (2, ())


def test_an_interrupted_clean_up_goes_on(play: Any) -> None:
    """With the time that it has left: it is not begun anew."""
    story = play(f"  {tidy('{log: a}', '{sequence: [{log: tidy}, ' + C + ']}')}")
    story.tick()
    accept(story, "c")
    story.tick(10)
    story.executive.interrupt("enough")
    assert story.tick(9) == "IIRSR"
    story.tick()
    end(story, "c", 5)
    story.tick()
    assert story.said == ["a", "tidy", "'tidy': clean-up not done within 1 s"]
    assert story.executive.reason == "enough; 'tidy': clean-up not done within 1 s"
    assert story.status == "interrupted"


def test_leaving_at_once_skips_the_clean_up(play: Any) -> None:
    """As a second Ctrl-C does; its goals are cancelled, and named where nobody confirms that."""
    story = play(f"  {tidy()}")
    story.tick()
    accept(story, "a")
    story.executive.interrupt("interrupted by SIGINT")
    end(story, "a", 5)
    story.tick()
    accept(story, "c")
    story.tick()
    story.executive.abandon("left at once")
    assert story.servers["/c"].cancels
    assert story.status == "interrupted"
    assert "'tidy': clean-up skipped: left at once" in story.executive.reason
    assert "orphaned goals: /c goal" in story.executive.reason


def test_a_mission_that_is_left_before_its_clean_up_begins_skips_it(play: Any) -> None:
    """It has sent nothing."""
    story = play(f"  {tidy(then='{log: tidy}')}")
    story.tick()
    story.executive.abandon("left at once")
    assert story.status == "failure"
    assert story.said == ["'tidy': clean-up skipped: left at once"]


def test_a_leaf_that_raises_is_cleaned_up_after(play: Any) -> None:
    """Also one that raises in the very first tick of its node."""
    story = play(f"  {tidy('{log: $nothing}', '{log: tidy}')}", "mission: m\ninputs: {nothing: 1}")
    del story.scope.values["nothing"]
    story.tick(2)
    assert story.said == ["tidy"]
    assert story.status == "failure"
    assert "'$nothing' has no value" in story.executive.reason


def test_a_clean_up_that_raises_is_not_begun_again(play: Any) -> None:
    """In its place it ends the mission; behind a halt it only ends itself."""
    then = "{sequence: [{log: tidy}, {log: $nothing}]}"
    head = "mission: m\ninputs: {nothing: 1}"
    story = play(f"  {tidy('{log: a}', then)}", head)
    del story.scope.values["nothing"]
    story.tick(3)
    assert (story.said, story.status) == (["a", "tidy"], "failure")
    story = play(f"  {tidy('{wait: 9}', then)}", head)
    del story.scope.values["nothing"]
    story.tick()
    story.executive.interrupt("enough")
    story.tick(3)
    assert story.said[0] == "tidy"
    assert len(story.said) == 2
    assert story.status == "interrupted"
    assert "'tidy': clean-up failed: " in story.executive.reason


def test_a_tree_goes_on_and_sends_no_goal_meanwhile(play: Any) -> None:
    """What ticks and what is limited goes on; the next goal waits until the robot is free."""
    story = play(f"  fallback:\n    - {{timeout: 0.5, do: {tidy()}}}\n    - {B}")
    story.tick()
    accept(story, "a")
    assert story.tick(9) == "RRRRII"
    assert story.tick() == "RFIIIR"
    end(story, "a", 5)
    assert story.tick() == "RIIIRR"
    accept(story, "c")
    story.tick(5)
    assert "/b" in story.servers
    assert not story.servers["/b"].goals
    end(story, "c")
    assert story.tick() == "RIIISR"
    assert len(story.servers["/b"].goals) == 1
    accept(story, "b")
    end(story, "b")
    story.tick()
    assert story.status == "success"


def test_waiting_for_a_clean_up_is_no_waiting_for_a_server(play: Any) -> None:
    """The limit of that begins behind it."""
    tree = f"{{timeout: 0.5, do: {tidy(timeout='20')}}}"
    story = play(f"  fallback:\n    - {tree}\n    - {B[:-1]}, server_timeout: 0.2}}")
    clean_up_after_a_timeout(story)
    story.tick(100)
    assert story.root.children[1].attempt.stage == "waiting for a clean-up"
    end(story, "c")
    story.tick()
    assert len(story.servers["/b"].goals) == 1


def test_a_node_that_is_entered_again_waits_for_its_clean_up(play: Any) -> None:
    """In the next round of a loop."""
    story = play(
        f"  force: success\n  do: {{repeat: {{count: 2}}, do: {{force: success, do: "
        f"{{timeout: 0.5, do: {tidy()}}}}}}}"
    )
    story.tick()
    accept(story, "a")
    assert story.tick(10) == "RRSFIII"
    end(story, "a", 5)
    assert story.tick() == "RRRRRIR"
    accept(story, "c")
    assert len(story.servers["/a"].goals) == 1
    end(story, "c")
    story.tick()
    story.tick()
    assert len(story.servers["/a"].goals) == 2


def test_a_clean_up_sees_the_variables_as_they_were(play: Any) -> None:
    """Also that of a loop which has ended; what it writes stays its own."""
    then = "{sequence: [{set: {n: n + 1}}, {log: '$n $place'}]}"
    story = play(
        "  sequence:\n    - set: {n: 1}\n    - force: success\n      do:\n        timeout: 0.1\n"
        f"        do: {{for_each: {{place: [7, 8]}}, do: {tidy('{wait: 9}', then)}}}\n"
        "    - set: {n: 5}\n    - wait: 0.2\n    - log: $n\n"
    )
    story.tick(20)
    assert story.said == ["2 7", "5"]
    assert story.status == "success"


def test_inner_clean_ups_come_first(play: Any) -> None:
    """The time of the outer one begins behind them."""
    inner = tidy("{wait: 9}", "{sequence: [{wait: 0.4}, {log: inner}]}", "1")
    story = play(f"  {tidy(inner, '{sequence: [{wait: 0.4}, {log: outer}]}', '0.5')}")
    story.tick()
    story.executive.interrupt("enough")
    story.tick(25)
    assert story.said == ["inner", "outer"]
    assert (story.status, story.executive.reason) == ("interrupted", "enough")


def test_a_mission_that_succeeds_waits_for_what_was_halted_in_it(play: Any) -> None:
    """And fails where that fails."""
    for then, status in (("{wait: 0.5}", "success"), ("{check: false}", "failure")):
        story = play(f"  parallel: [{tidy('{wait: 9}', then)}, {{wait: 0.1}}]\n  succeed_when: any")
        story.tick(3)
        assert story.status == "ending"
        story.tick(12)
        assert story.status == status
    assert story.executive.reason == "'tidy': clean-up failed: 'check false' never holds"


def test_the_time_of_a_clean_up_is_on_the_clock(play: Any) -> None:
    """A tick is 50 ms; the clean-up behind an interrupt is begun in the next tick."""
    story = play(f"  {tidy('{wait: 9}', '{wait: 0.2}')}")
    story.tick()
    began_ns = story.now_ns
    story.executive.interrupt("enough")
    while not story.executive.is_done:
        story.tick()
    assert story.now_ns - began_ns == TICK_NS + round(0.2 * S)


def test_a_clean_up_keeps_its_time_and_no_other_while_paused(play: Any) -> None:
    """The timeout that has halted its node does not halt it as well."""
    tree = f"{{force: success, do: {{timeout: 0.5, do: {tidy(timeout='2')}}}}}"
    story = play(f"  sequence: [{tree}, {{wait: 4}}]")
    clean_up_after_a_timeout(story)
    story.tick()
    story.executive.pause("a look around", keep_goals=True)
    story.tick(37)
    assert not story.servers["/c"].cancels
    story.tick(2)
    assert story.servers["/c"].cancels
    end(story, "c", 5)
    story.executive.resume()
    story.tick(60)
    assert story.status == "failure"
    assert story.executive.reason == (
        "'tidy': clean-up failed: 'c' canceled by halt: clean-up not done within 2 s"
    )
