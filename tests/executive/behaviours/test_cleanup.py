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


def end(run: Any, name: str, status: int = 4) -> None:
    """The newest goal of a server ends."""
    run.servers[f"/{name}"].goal.on_result(status, None)


def accept(run: Any, *names: str) -> None:
    """Servers take their newest goals."""
    for name in names:
        run.servers[f"/{name}"].accept()


def clean_up_after_a_timeout(run: Any) -> None:
    """Goal a is cancelled after half a second; that of the clean-up, c, is accepted."""
    run.tick()
    accept(run, "a")
    run.tick(10)
    end(run, "a", 5)
    run.tick()
    accept(run, "c")


@pytest.mark.parametrize(("result", "letter", "status"), [(4, "S", "success"), (6, "F", "failure")])
def test_the_status_is_that_of_the_node(play: Any, result: int, letter: str, status: str) -> None:
    """The clean-up begins in the tick in which the node ends."""
    run = play(f"  {tidy()}")
    assert run.tick() == "RRI"
    accept(run, "a")
    end(run, "a", result)
    assert run.tick() == f"R{letter}R"
    accept(run, "c")
    end(run, "c")
    assert run.tick() == f"{letter}{letter}S"
    run.tick()
    assert run.status == status


def test_a_clean_up_that_takes_too_long_is_halted(play: Any) -> None:
    """After its timeout of one second, to the tick; its goal is cancelled and awaited."""
    run = play(f"  {tidy('{log: a}')}")
    run.tick()
    accept(run, "c")
    assert run.tick(19) == "RSR"
    assert run.tick() == "FSI"
    assert run.servers["/c"].cancels
    end(run, "c", 5)
    run.tick()
    assert (run.status, run.executive.reason) == (
        "failure",
        "'tidy' clean-up not done within 1 s",
    )


def test_an_interrupted_mission_waits_for_its_clean_up(play: Any) -> None:
    """The goal of the node is cancelled; that of the clean-up is carried out to its end."""
    run = play(f"  {tidy()}")
    run.tick()
    accept(run, "a")
    run.tick()
    run.executive.interrupt("interrupted by SIGINT")
    assert (run.statuses, run.status) == ("III", "ending")
    end(run, "a", 5)
    assert run.tick() == "IIR"
    accept(run, "c")
    run.tick(10)
    assert run.status == "ending"
    assert not run.servers["/c"].cancels
    end(run, "c")
    assert run.tick() == "IIS"
    assert (run.status, run.executive.reason) == ("interrupted", "interrupted by SIGINT")
    assert (run.executive.goals_sent, run.executive.goals_left_behind) == (2, ())


def test_an_interrupted_clean_up_goes_on(play: Any) -> None:
    """With the time that it has left: it is not begun anew."""
    run = play(f"  {tidy('{log: a}', '{sequence: [{log: tidy}, ' + C + ']}')}")
    run.tick()
    accept(run, "c")
    run.tick(10)
    run.executive.interrupt("enough")
    assert run.tick(9) == "IIRSR"
    run.tick()
    end(run, "c", 5)
    run.tick()
    assert run.logged == ["a", "tidy", "'tidy': clean-up not done within 1 s"]
    assert run.executive.reason == "enough; 'tidy': clean-up not done within 1 s"
    assert run.status == "interrupted"


def test_leaving_at_once_skips_the_clean_up(play: Any) -> None:
    """As a second Ctrl-C does; its goals are cancelled, and named where nobody confirms that."""
    run = play(f"  {tidy()}")
    run.tick()
    accept(run, "a")
    run.executive.interrupt("interrupted by SIGINT")
    end(run, "a", 5)
    run.tick()
    accept(run, "c")
    run.tick()
    run.executive.abandon("left at once")
    assert run.servers["/c"].cancels
    assert run.status == "interrupted"
    assert "'tidy': clean-up skipped: left at once" in run.executive.reason
    assert "orphaned goals: /c goal" in run.executive.reason


def test_a_mission_that_is_left_before_its_clean_up_begins_skips_it(play: Any) -> None:
    """It has sent nothing."""
    run = play(f"  {tidy(then='{log: tidy}')}")
    run.tick()
    run.executive.abandon("left at once")
    assert run.status == "failure"
    assert run.logged == ["'tidy': clean-up skipped: left at once"]


def test_a_leaf_that_raises_is_cleaned_up_after(play: Any) -> None:
    """Also one that raises in the very first tick of its node."""
    run = play(f"  {tidy('{log: $nothing}', '{log: tidy}')}", "mission: m\ninputs: {nothing: 1}")
    del run.scope.values["nothing"]
    run.tick(2)
    assert run.logged == ["tidy"]
    assert run.status == "failure"
    assert "'$nothing' has no value" in run.executive.reason


def test_a_clean_up_that_raises_is_not_begun_again(play: Any) -> None:
    """In its place it ends the mission; behind a halt it only ends itself."""
    then = "{sequence: [{log: tidy}, {log: $nothing}]}"
    head = "mission: m\ninputs: {nothing: 1}"
    run = play(f"  {tidy('{log: a}', then)}", head)
    del run.scope.values["nothing"]
    run.tick(3)
    assert (run.logged, run.status) == (["a", "tidy"], "failure")
    run = play(f"  {tidy('{wait: 9}', then)}", head)
    del run.scope.values["nothing"]
    run.tick()
    run.executive.interrupt("enough")
    run.tick(3)
    assert run.logged[0] == "tidy"
    assert len(run.logged) == 2
    assert run.status == "interrupted"
    assert "'tidy': clean-up failed: " in run.executive.reason


def test_a_tree_goes_on_and_sends_no_goal_meanwhile(play: Any) -> None:
    """What ticks and what is limited goes on; the next goal waits until the robot is free."""
    run = play(f"  fallback:\n    - {{timeout: 0.5, do: {tidy()}}}\n    - {B}")
    run.tick()
    accept(run, "a")
    assert run.tick(9) == "RRRRII"
    assert run.tick() == "RFIIIR"
    end(run, "a", 5)
    assert run.tick() == "RIIIRR"
    accept(run, "c")
    run.tick(5)
    assert "/b" in run.servers
    assert not run.servers["/b"].goals
    end(run, "c")
    assert run.tick() == "RIIISR"
    assert len(run.servers["/b"].goals) == 1
    accept(run, "b")
    end(run, "b")
    run.tick()
    assert run.status == "success"


def test_waiting_for_a_clean_up_is_no_waiting_for_a_server(play: Any) -> None:
    """The limit of that begins behind it."""
    tree = f"{{timeout: 0.5, do: {tidy(timeout='20')}}}"
    run = play(f"  fallback:\n    - {tree}\n    - {B[:-1]}, server_timeout: 0.2}}")
    clean_up_after_a_timeout(run)
    run.tick(100)
    assert run.root.children[1].attempt.stage == "waiting for a clean-up"
    end(run, "c")
    run.tick()
    assert len(run.servers["/b"].goals) == 1


def test_a_node_that_is_entered_again_waits_for_its_clean_up(play: Any) -> None:
    """In the next round of a loop."""
    run = play(
        f"  force: success\n  do: {{repeat: {{count: 2}}, do: {{force: success, do: "
        f"{{timeout: 0.5, do: {tidy()}}}}}}}"
    )
    run.tick()
    accept(run, "a")
    assert run.tick(10) == "RRSFIII"
    end(run, "a", 5)
    assert run.tick() == "RRRRRIR"
    accept(run, "c")
    assert len(run.servers["/a"].goals) == 1
    end(run, "c")
    run.tick()
    run.tick()
    assert len(run.servers["/a"].goals) == 2


def test_inner_clean_ups_come_first(play: Any) -> None:
    """The time of the outer one begins behind them."""
    inner = tidy("{wait: 9}", "{sequence: [{wait: 0.4}, {log: inner}]}", "1")
    run = play(f"  {tidy(inner, '{sequence: [{wait: 0.4}, {log: outer}]}', '0.5')}")
    run.tick()
    run.executive.interrupt("enough")
    run.tick(25)
    assert run.logged == ["inner", "outer"]
    assert (run.status, run.executive.reason) == ("interrupted", "enough")


def test_the_time_of_a_clean_up_is_on_the_clock(play: Any) -> None:
    """A tick is 50 ms; the clean-up behind an interrupt is begun in the next tick."""
    run = play(f"  {tidy('{wait: 9}', '{wait: 0.2}')}")
    run.tick()
    began_ns = run.now_ns
    run.executive.interrupt("enough")
    while not run.executive.is_done:
        run.tick()
    assert run.now_ns - began_ns == TICK_NS + round(0.2 * S)


def test_a_clean_up_keeps_its_time_and_no_other_while_paused(play: Any) -> None:
    """The timeout that has halted its node does not halt it as well."""
    tree = f"{{force: success, do: {{timeout: 0.5, do: {tidy(timeout='2')}}}}}"
    run = play(f"  sequence: [{tree}, {{wait: 4}}]")
    clean_up_after_a_timeout(run)
    run.tick()
    run.executive.pause("a look around", keep_goals=True)
    run.tick(37)
    assert not run.servers["/c"].cancels
    run.tick(2)
    assert run.servers["/c"].cancels
    end(run, "c", 5)
    run.executive.resume()
    run.tick(60)
    assert run.status == "failure"
    assert run.executive.reason == (
        "'tidy': clean-up failed: 'c' canceled by halt: clean-up not done within 2 s"
    )
