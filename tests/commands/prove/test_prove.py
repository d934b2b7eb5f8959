"""Every answer is explored, and what does not hold is found with a shortest way."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace
from typing import Any

import pytest

from bt_mission.base.errors import BtMissionError
from bt_mission.commands.prove.answers import parse_answers
from bt_mission.commands.prove.claims import Claims
from bt_mission.commands.prove.explorer import Bounds, ExplorationProgress, explore
from bt_mission.commands.prove.memento import Keeper
from bt_mission.commands.prove.proof import Proof, ProofOptions, prove
from bt_mission.sessions.load import load
from tests.commands.prove.brute_force import enumerated, explored, looping_mission, small_mission
from tests.support.project import ROOT
from tests.support.thorough import sample

TURN = "{turn: {angle: 90}, timeout: 9}"
MOVE = "{move: {secs: 1, linear_velocity: 0.1}, timeout: 9}"


LARGE = {0, 2, 42, 56}
"""Seeds with too many runs for a test; benchmarks/commands/prove/prove.py takes them, too."""


def proof_of(tree: str, head: str = "", **options: object) -> Proof:
    """Prove a tree."""
    return prove(load(f"mission: m\n{head}tree:\n{tree}\n"), ProofOptions(**options))  # type: ignore[arg-type]


def collected(proof: Proof) -> list[tuple[str, str]]:
    """Return properties and nodes of the findings."""
    return [(entry.property, entry.node) for entry in proof.findings]


@pytest.mark.parametrize("seed", sample(sorted({*range(0, 60, 2), *range(1, 30, 2)} - LARGE), 9))
def test_the_exploration_finds_what_plain_enumeration_finds(seed: int) -> None:
    """All runs of a small tree, each from its beginning, have the same ends and findings."""
    mission = small_mission(seed)
    assert explored(mission, 1) == enumerated(mission, 1, most=10_000)


STATES = (19, 78, 4, 184, 16, 158, 21, 5, 77, 3, 15, 15, 90, 30, 5, 1, 24, 22, 12, 16)
"""The states of the small missions with seeds that 3 does not divide. A state that is merged
wrongly, or not merged, changes a count."""


def test_small_missions_have_their_number_of_states() -> None:
    """With one fault."""
    options = ProofOptions(faults=1)
    counts = [prove(small_mission(seed), options).states for seed in range(30) if seed % 3]
    assert tuple(counts) == STATES


@pytest.mark.parametrize(
    ("name", "faults", "states", "ends"),
    [("patrol", 2, 33, 12), ("square", 2, 167, 24), ("explore", 1, 238, 21)],
)
def test_shipped_missions_have_their_number_of_states(
    name: str, faults: int, states: int, ends: int
) -> None:
    """And their number of ends."""
    proof = prove(load(ROOT / "missions" / f"{name}.yaml"), ProofOptions(faults=faults))
    assert (proof.states, proof.paths) == (states, ends)


PARALLEL = f"""mission: m
tree:
  parallel:
    - sequence: [{TURN}, {{wait: 2}}, {TURN}]
    - timeout: 12
      do: {{take_pictures: {{nseconds: 5}}, timeout: 20, feedback_timeout: 1}}
"""


FOLLOWED = """mission: m
follow:
  - {topic: /load, type: std_msgs/msg/Float64, field: data, as: load, timeout: 1, initial: 0.0}
tree:
  sequence: [{check: load < 4}, {wait: 2}, {log: $load}]
"""
"""A message begins the limit of a topic again, which may then end at the same instant as before."""


BATTERY = """mission: m
follow:
  - topic: battery_state
    type: sensor_msgs/msg/BatteryState
    field: percentage
    as: charge
    timeout: 5
    default: 0.0
tree:
  sequence:
    - guard: charge > 20
      do:
        sequence:
          - {explore_forward: {fwd_velocity: 0.2, stopping_distance: 0.5}, timeout: 30}
          - {turn: {angle: 90}, timeout: 10}
          - {move: {secs: 2, linear_velocity: 0.1}, timeout: 10}
    - {turn: {angle: -90}, timeout: 10, name: back}
"""


def test_the_age_of_a_message_multiplies_no_states() -> None:
    """It may be too old at any tick behind its last one, so no state holds its age."""
    proof = prove(load(BATTERY), ProofOptions(faults=1))
    assert proof.states == 196
    assert proof.abstracted == ("the last message of /battery_state may be too old at any tick",)
    assert "unhandled" in proof.proved


@pytest.mark.parametrize("seed", sample(range(40), every=13, first=3))
def test_known_steps_do_what_the_mission_does(seed: int) -> None:
    """The exploration that takes every step has the same states, ends and findings."""
    missions = [small_mission(seed), looping_mission(seed)]
    if not seed:
        missions += [load(PARALLEL), load(FOLLOWED), load(ROOT / "missions" / "square.yaml")]
    for mission in missions:
        known, taken = Claims(), Claims()
        options = ProofOptions(faults=1)
        fast = explore(options.environment(mission), known)
        slow = explore(options.environment(mission), taken, learns=False)
        assert fast.progress == slow.progress
        assert (fast.came_from, fast.scripts) == (slow.came_from, slow.scripts)
        assert (fast.edges, fast.ended, fast.stuck) == (slow.edges, slow.ended, slow.stuck)
        assert (known.broken, known.failures) == (taken.broken, taken.failures)
        assert known.entered == taken.entered


@pytest.mark.parametrize("seed", sample(range(0, 40, 4), 3))
def test_a_step_changes_only_what_it_is_known_to_use(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The exploration that saves every object after each step has the same states and ends."""
    for mission in (small_mission(seed), looping_mission(seed)):
        options = ProofOptions(faults=1)
        part = explore(options.environment(mission), Claims(), learns=False)
        with monkeypatch.context() as patched:
            patched.setattr(Keeper, "touch", lambda keeper, _entries: keeper.touch_all())
            whole = explore(options.environment(mission), Claims(), learns=False)
        assert part.progress == whole.progress
        assert (part.scripts, part.edges, part.ended) == (whole.scripts, whole.edges, whole.ended)


def test_a_mission_with_one_goal_is_proved() -> None:
    """All properties hold; each outcome of its goal ends the mission."""
    proof = proof_of(f"  {TURN}")
    assert proof.exhaustive
    assert collected(proof) == []
    assert set(proof.proved) == {
        "ends",
        "goals_accounted",
        "one_goal_at_the_base",
        "cleanup",
        "unset_variable",
        "unhandled",
        "dead_node",
    }
    assert "\n  ends the mission: 'turn' rejected, aborted, server not available, " in str(proof)


def test_without_faults_only_usual_answers_come() -> None:
    """Then a goal is accepted and succeeds."""
    proof = proof_of(f"  {TURN}", faults=0)
    assert (proof.faults, proof.failures) == (0, ())


def test_the_output_of_a_goal_without_a_result_is_found() -> None:
    """A rejected goal has no result, so the log reads a variable that has no value."""
    proof = proof_of(
        "  sequence:\n"
        "    - fallback:\n"
        "        - {turn: {angle: 90}, timeout: 9, outputs: {error_code: code}}\n"
        "        - {log: no turn, name: unturned}\n"
        "    - log: $code"
    )
    assert [entry.property for entry in proof.findings] == ["unset_variable"]
    assert proof.findings[0].steps == ("/turn rejects the goal",)
    assert proof.findings[0].nodes == ("0.1",)


def test_two_drives_in_parallel_are_found() -> None:
    """The shortest way is that both are accepted."""
    proof = proof_of(f"  parallel:\n    - {TURN}\n    - {MOVE}", faults=0)
    assert collected(proof) == [("one_goal_at_the_base", "")]
    assert proof.findings[0].steps == ("/turn accepts the goal", "/move accepts the goal")
    assert proof.findings[0].as_dict()["nodes"] == ["0.0", "0.1"]


def test_a_refused_cancel_before_the_next_drive_is_found() -> None:
    """The goal that refuses still drives when the next one begins; without that fault it holds."""
    tree = f"  sequence:\n    - fallback:\n        - {TURN}\n        - log: late\n    - {MOVE}"
    proof = proof_of(tree, faults=2)
    assert "one_goal_at_the_base" not in proof.proved
    assert proof.findings[0].steps[-2:] == ("/turn refuses to cancel", "/move accepts the goal")
    answers = parse_answers("usual,turn:refuse_cancel,turn:ignore_cancel")
    assert collected(proof_of(tree, faults=2, answers=answers)) == []


def test_a_server_that_is_never_late_meets_no_limit() -> None:
    """Its goal is not cancelled for being late; without that answer left out it is."""
    in_time = proof_of(f"  {TURN}", answers=parse_answers("usual,turn:late")).failures
    assert not any("not done within" in reason for reason in in_time)
    assert any("not done within" in reason for reason in proof_of(f"  {TURN}").failures)


@pytest.mark.parametrize(
    ("tree", "finding"),
    [
        ("  turn: {angle: 90}", ("ends", "turn")),
        ("  repeat: {until: 1 > 2}\n  do: {wait: 1}", ("ends", "")),
        (f"  fallback:\n    - log: always\n    - {TURN}", ("dead_node", "turn")),
    ],
    ids=["a goal without a limit", "a loop without an end", "a dead node"],
)
def test_what_no_answer_ends_or_reaches_is_found(tree: str, finding: tuple[str, str]) -> None:
    """It is the only finding."""
    assert collected(proof_of(tree)) == [finding]


def test_a_node_that_needs_more_faults_is_named_and_is_no_finding() -> None:
    """It is entered with two faults more."""
    proof = proof_of(f"  fallback:\n    - {TURN}\n    - {MOVE}\n    - log: neither", faults=1)
    assert (collected(proof), proof.never_entered) == ([], ("log",))


def test_both_sides_of_a_comparison_are_explored() -> None:
    """A result is looked at by a check, so both of its children are entered."""
    proof = proof_of(
        "  sequence:\n"
        "    - {turn: {angle: 90}, timeout: 9, outputs: {angle_turned: angle}}\n"
        "    - fallback:\n"
        "        - check: angle > 80\n"
        "        - log: not far enough",
        faults=0,
    )
    assert "dead_node" in proof.proved


ANGLE = """  sequence:
    - {turn: {angle: 90}, timeout: 9, outputs: {angle_turned: angle}}
    - fallback:
        - sequence: [{check: CONDITION}, {log: it holds}]
        - log: it does not
"""


@pytest.mark.parametrize("condition", ["angle > 80", "angle < -80", "80 < angle < 100"])
def test_both_sides_of_each_constant_are_tried(condition: str) -> None:
    """Of negative ones, too."""
    proof = proof_of(ANGLE.replace("CONDITION", condition), faults=0)
    assert proof.exhaustive
    assert "dead_node" in proof.proved


def test_each_branch_of_a_random_choice_is_explored() -> None:
    """One of them fails."""
    proof = proof_of("  choose:\n    - log: one\n    - check: false", faults=0)
    assert proof.paths == 2
    assert len(proof.failures) == 1


def test_a_clean_up_runs_behind_every_interrupt() -> None:
    """Ctrl-C in any state halts the tree; the clean-up is entered, and everything ends."""
    proof = proof_of(
        f"  finally: {{timeout: 5}}\n  do: {TURN}\n  then: {{log: clean}}",
        with_interrupts=True,
        faults=1,
    )
    assert collected(proof) == []
    assert "interrupt" in proof.proved


def test_a_long_repeat_may_end_after_any_round() -> None:
    """Its rounds are alike, so that the exploration is exhaustive."""
    proof = proof_of(f"  repeat: {{count: 100}}\n  do: {TURN}", faults=0)
    assert proof.exhaustive
    assert proof.abstracted == ("'m' may end after any of its 100 rounds",)


SAMPLED = "not all values are tried: 'angle' in 'angle % 7 > 3' (<text>:6)"
ROUNDS = "'m' is repeated {} times instead of 100 (--rounds)"


@pytest.mark.parametrize(
    ("tree", "options", "why"),
    [
        (ANGLE.replace("CONDITION", "angle % 7 > 3"), {}, SAMPLED),
        (f"  repeat: {{count: 100}}\n  do: {TURN}", {"rounds": 3}, ROUNDS.format(3)),
        ("  repeat: {count: 100}\n  do: {set: {n: 1}}", {}, ROUNDS.format(2)),
    ],
    ids=["values are samples", "a bound on rounds", "rounds that compute are not alike"],
)
def test_what_is_not_explored_is_named_and_nothing_is_proved(
    tree: str, options: dict[str, Any], why: str
) -> None:
    """Properties count as not violated only."""
    proof = proof_of(tree, faults=0, **options)
    assert (proof.exhaustive, proof.proved, proof.why_not) == (False, (), (why,))
    assert "ends" in proof.not_violated


def test_a_deadline_beside_a_long_loop_may_be_met_at_any_tick() -> None:
    """The loop takes any time, so the state does not hold how much is left."""
    tree = f"  parallel:\n    - wait: 90\n    - repeat: {{count: 1000}}\n      do: {TURN}"
    proof = proof_of(f"{tree}\n  succeed_when: any", faults=1)
    assert proof.exhaustive
    assert "'wait' may be over at any tick" in proof.abstracted


def test_a_deadline_beside_an_endless_loop_is_exact_without_a_bound_on_rounds() -> None:
    """The loop turns until the deadline, and no run ends earlier."""
    tree = """\
  fallback:
    - timeout: 3
      do: {repeat: {until: 1 > 2}, do: {wait: 1}}
    - log: late"""
    proof = proof_of(tree, rounds=0)
    assert (proof.exhaustive, proof.abstracted, proof.findings) == (True, (), ())
    assert {"ends", "dead_node"} <= set(proof.proved)
    assert set(proof_of(tree).not_violated) == {"ends", "dead_node"}


def test_a_run_that_may_not_exist_proves_no_property_of_some_run() -> None:
    """The limit of 100 s is never met by 20 waits of 1 s: with exact deadlines the log is dead."""
    tree = """\
  fallback:
    - timeout: 100
      do:
        sequence:
          - repeat: {count: 20}
            do: {wait: 1}
    - log: never"""
    proof = proof_of(tree)
    assert (proof.exhaustive, proof.findings) == (True, ())
    assert proof.not_violated == ("ends", "dead_node")
    assert "goals_accounted" in proof.proved
    exact = proof_of(tree, rounds=0)
    assert collected(exact) == [("dead_node", "log")]
    assert exact.abstracted == ()


@pytest.mark.parametrize("seed", sample(range(40), 20))
def test_what_is_abstract_finds_all_that_exact_time_finds(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where every loop is long, the ends and findings of exact counts and times are among those."""
    mission = looping_mission(seed)
    exact = explored(mission, 1)
    monkeypatch.setattr("bt_mission.commands.prove.abstraction.MANY_ROUNDS", 1)
    abstract = explored(mission, 1)
    assert exact.ends <= abstract.ends
    assert exact.broken <= abstract.broken


def test_a_budget_ends_the_exploration() -> None:
    """What was reached is told, and nothing counts as proved."""
    proof = proof_of(f"  {TURN}", bounds=Bounds(states=5))
    assert (proof.exhaustive, proof.proved) == (False, ())
    assert proof.why_not == ("the budget of 5 states is used up",)


@pytest.mark.thorough
@pytest.mark.parametrize(
    "mission", sample(["missions/explore.yaml", "benchmarks/nav2_recovery.yaml"], 2)
)
def test_the_bound_on_memory_holds(mission: str) -> None:
    """An exploration is over before its states take more than the bound, not much before."""
    environment = ProofOptions(faults=1).environment(load(ROOT / mission))
    claims, measured = Claims(), 0
    progress = ExplorationProgress()
    tracemalloc.start()
    try:

        def measure(now: ExplorationProgress) -> bool:
            nonlocal measured, progress
            progress, measured = replace(now), tracemalloc.get_traced_memory()[0]
            return now.states < 300

        explore(environment, claims, on_progress=measure)
    finally:
        tracemalloc.stop()
    used = f"the memory of {measured / 1e6:g} MB is used up"
    assert Bounds(megabytes=measured / 1e6).why_over(progress, 0) == used
    assert not Bounds(megabytes=4 * measured / 1e6).why_over(progress, 0)


def test_two_explorations_are_equal() -> None:
    """The same input gives the same output."""
    tree = f"  parallel:\n    - {TURN}\n    - {{wait: 1}}\n  succeed_when: any"
    assert proof_of(tree).as_dict() == proof_of(tree).as_dict()


@pytest.mark.parametrize("text", ["most", "turn:foo", "usual,reject", "usual,:reject"])
def test_an_unknown_answer_is_refused(text: str) -> None:
    """The message lists the answers."""
    with pytest.raises(BtMissionError, match="answers that can be left out: no_server, reject"):
        parse_answers(text)


def test_the_way_of_a_finding_is_within_the_bound_on_faults() -> None:
    """A state that is visited again with more faults left is reached by the later way."""
    mission, options = load("missions/sources/stop_service.yaml"), ProofOptions()
    for finding in prove(mission, options).findings:
        environment = options.environment(mission)
        assert [environment.step(script) for script in finding.way] == [True] * len(finding.way)
        assert len(environment.open_at_parts["base"]) == 2


GRIP = """mission: m
trees:
  grip:
    outputs: {stalled: bool}
    do:
      action:
        name: gripper_controller/gripper_cmd
        type: control_msgs/action/GripperCommand
        goal: {command: {position: 0.0}}
      timeout: 9
      outputs: {stalled: stalled}
tree:
  sequence:
    - tree: {name: grip}
      outputs: {stalled: holds}
    - set: {is_held: $holds}
    - check: is_held
    - log: held
"""


def test_a_result_that_is_passed_on_has_the_values_that_matter_there() -> None:
    """Through the output of a named tree, and a variable that is set to it."""
    proof = prove(load(GRIP), ProofOptions(faults=0))
    assert (proof.exhaustive, proof.never_entered, proof.findings) == (True, (), ())
    assert proof.failures == ("'check is_held' does not hold (is_held = false)",)
