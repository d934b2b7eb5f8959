"""A finding is written as a scenario with scripted servers, and its run on the stage shows it."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_mission.base.yaml.document import read
from bt_mission.commands.prove.answers import parse_answers
from bt_mission.commands.prove.confirm import confirmed
from bt_mission.commands.prove.proof import USUAL_FAULTS, Finding, ProofOptions, prove
from bt_mission.scenarios.run import run_scenario
from bt_mission.sessions.load import load

TURN = "{turn: {angle: 90}, timeout: 9}"
MOVE = "{move: {secs: 1, linear_velocity: 0.1}, timeout: 9}"


def run_all(
    folder: Path, tree: str, head: str = "", faults: int = USUAL_FAULTS, answers: str = "usual"
) -> list[Finding]:
    """Prove a mission and run its findings."""
    path = folder / "m.yaml"
    path.write_text(f"mission: m\n{head}tree:\n{tree}\n", encoding="utf-8")
    chosen, mission = ProofOptions(faults, parse_answers(answers)), load(path)
    return list(confirmed(prove(mission, chosen).findings, mission, chosen, folder))


def scenario_of(finding: Finding) -> dict[str, object]:
    """Return the content of the scenario of a finding, whose run has confirmed it."""
    assert finding.stage is not None
    assert finding.stage.is_confirmed, finding.stage
    data: dict[str, object] = read(finding.stage.scenario).data
    return data


UNSET = """  sequence:
    - fallback:
        - {turn: {angle: 90}, timeout: 9, outputs: {error_code: code}}
        - log: no turn
    - log: $code"""


def test_a_rejected_goal_is_scripted_and_its_test_passes_after_the_mend(tmp_path: Path) -> None:
    """The scenario fails as long as the mistake is in the mission."""
    (finding,) = run_all(tmp_path, UNSET)
    scenario = tmp_path / "m_unset_variable.scenario.yaml"
    assert str(finding.stage) == f"confirmed on the stage: {scenario}"
    data = scenario_of(finding)
    assert data["servers"] == {"turn": [{"answer": "reject"}]}
    assert data["mission"] == "m.yaml"
    assert data["expect"] == {
        "outcome": "any",
        "orphaned_goals": "any",
        "reason": r"^(?!.*'\$?code' has no value)",
    }
    assert not run_scenario(scenario).passed
    mended = UNSET.replace("  sequence:\n", "  sequence:\n    - set: {code: 0}\n")
    (tmp_path / "m.yaml").write_text(f"mission: m\ntree:\n{mended}\n", encoding="utf-8")
    result = run_scenario(scenario)
    assert (result.passed, result.report.status) == (True, "success")


GRIP = """action:
        name: gripper_controller/gripper_cmd
        type: control_msgs/action/GripperCommand
        goal: {command: {position: 0.01}}
      timeout: 9"""


@pytest.mark.parametrize(
    ("part", "goals", "accepted", "servers"),
    [
        (
            "base",
            (TURN, MOVE),
            'accepted("turn") and accepted("move")',
            {"turn": [{"end": "never"}], "move": [{"end": "never"}]},
        ),
        (
            "gripper",
            (GRIP, GRIP),
            'accepted("gripper_controller/gripper_cmd")',
            {"gripper_controller/gripper_cmd": [{"end": "never"}] * 2},
        ),
    ],
)
def test_two_goals_at_a_part_are_seen(
    part: str,
    goals: tuple[str, str],
    accepted: str,
    servers: dict[str, object],
    tmp_path: Path,
) -> None:
    """Both goals are accepted and stay open."""
    tree = "  parallel:\n" + "".join(f"    - {goal}\n" for goal in goals)
    (finding,) = run_all(tmp_path, tree, "robot: waffle_arm\n", faults=0)
    data = scenario_of(finding)
    assert data["servers"] == servers
    requirement = f"never goals_at_{part} > 1 and {accepted}"
    assert data["requirements"] == {f"one goal at the {part}": requirement}


def test_a_refused_cancel_is_scripted_with_the_times_of_the_way(tmp_path: Path) -> None:
    """The first goal is canceled at 9.1 s, and given up 3 s after the server has refused that.

    The second server accepts its goal within the next tick.
    """
    tree = f"  sequence:\n    - fallback:\n        - {TURN}\n        - log: late\n    - {MOVE}"
    finding = run_all(tmp_path, tree)[0]
    data = scenario_of(finding)
    assert data["servers"] == {
        "turn": [{"cancel": "refuse", "end": "never"}],
        "move": [{"end": "never"}],
    }
    assert data["limit"] == pytest.approx(22.25)
    result = run_scenario(tmp_path / "m_one_goal_at_the_base.scenario.yaml")
    (requirement,) = result.report.requirements
    assert requirement.verdict == "violated"
    assert requirement.at == pytest.approx(12.25)


@pytest.mark.thorough
def test_a_goal_without_a_limit_waits_for_ever(tmp_path: Path) -> None:
    """The run is interrupted 100 s behind the end of the way."""
    (finding,) = run_all(tmp_path, "  turn: {angle: 90}")
    data = scenario_of(finding)
    assert data["servers"] == {"turn": [{"end": "never"}]}
    assert data["expect"] == {"outcome": "any", "orphaned_goals": "any", "before": data["limit"]}


@pytest.mark.thorough
def test_a_loop_without_an_end_is_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its goals succeed as usual, until the run is interrupted: here after less than 100 s."""
    monkeypatch.setattr("bt_mission.commands.prove.confirm.LONGEST_S", 20.0)
    tree = f"  repeat: {{until: 1 > 2}}\n  do: {TURN}"
    (finding,) = run_all(tmp_path, tree)
    assert scenario_of(finding)["mission"] == "m.yaml"


def test_a_server_that_is_lost_is_killed_by_a_fault(tmp_path: Path) -> None:
    """At the time of the way."""
    tree = "  sequence:\n    - fallback: [TURN, {log: lost}]\n    - log: $angle".replace(
        "TURN", "{turn: {angle: 90}, timeout: 9, outputs: {angle_turned: angle}}"
    )
    left_out = ("reject", "no_answer", "refuse_cancel", "ignore_cancel", "no_server")
    answers = ",".join(["usual", *(f"turn:{name}" for name in left_out)])
    (finding,) = run_all(tmp_path, tree, answers=answers)
    assert scenario_of(finding)["faults"] == ["at 0.1: kill_server turn"]


def test_a_random_draw_is_found_among_seeds(tmp_path: Path) -> None:
    """The scenario has the first seed whose draws show the finding."""
    indented = UNSET.strip().replace("\n", "\n    ")
    (drawn,) = run_all(tmp_path, f"  choose:\n    - log: one\n    - {indented}")
    assert scenario_of(drawn).get("seed") == 1


def test_a_service_that_fails_is_a_fault(tmp_path: Path) -> None:
    """It begins with the tick that calls."""
    tree = """  sequence:
    - fallback:
        - service: {name: stop, type: std_srvs/srv/Trigger}
          outputs: {message: said}
        - log: no answer
    - log: $said"""
    (finding,) = run_all(tmp_path, tree, answers="usual,stop:fail,stop:no_server")
    assert scenario_of(finding)["faults"] == [
        "at 0.0: serve stop success=true",
        "at 0.05: ignore_service stop lasting 0.05",
    ]


def test_a_message_that_a_mission_waits_for_is_published(tmp_path: Path) -> None:
    """It comes with the tick of the way."""
    tree = """  sequence:
    - wait_for: {topic: /ready, type: std_msgs/msg/Bool, until: data}
      timeout: 5
      name: ready
    - """ + UNSET.strip().replace("\n", "\n    ")
    (finding,) = run_all(tmp_path, tree)
    assert scenario_of(finding)["faults"] == [
        "at 0.0: drop ready lasting 0.1",
        "at 0.1: publish ready data=true",
    ]


def test_a_topic_that_a_variable_follows_has_its_values_and_falls_silent(tmp_path: Path) -> None:
    """A value comes again at each tick, until the topic falls silent or has another."""
    head = """\
follow:
  - {topic: /load, type: std_msgs/msg/Float64, field: data, as: load, timeout: 1, initial: 0.0}
requirements:
  is light: never $load > 2
"""
    tree = """  sequence:
    - fallback: [{check: load < 4}, {log: heavy}]
    - wait: 2
    - log: $load"""
    sent, silent = run_all(tmp_path, tree, head, faults=1, answers="usual,load:extreme")[:2]
    assert scenario_of(sent)["faults"] == [
        "at 0.0: drop load lasting 0.05",
        "at 0.05: publish load every 0.05 data=3.0",
    ]
    assert silent.steps[1:] == (
        "/load sends nothing more",
        "/load is silent for 1 s",
        "time passes: 'wait' is over",
    )
    assert scenario_of(silent)["faults"] == [
        "at 0.0: drop load lasting 0.05",
        "at 0.05: publish load every 0.05 data=0.0 lasting 1.025",
        "at 1.075: drop load",
    ]


def test_a_message_is_as_old_as_it_has_to_be(tmp_path: Path) -> None:
    """The time that is missing on a shortest way passes where no limit is over."""
    head = """\
follow:
  - {topic: /on, type: std_msgs/msg/Bool, field: data, as: is_on, timeout: 2, initial: true}
"""
    tree = f"""  sequence:
    - {TURN}
    - wait: 1.5
    - log: $is_on"""
    (silent,) = run_all(tmp_path, tree, head, faults=1)
    assert "/on is silent for 2 s" in silent.steps
    assert scenario_of(silent)["faults"] == [
        "at 0.0: drop on lasting 0.1",
        "at 0.1: publish on every 0.05 lasting 0.075",
        "at 0.175: drop on",
    ]


def test_lists_without_elements_and_rounded_numbers_are_sent(tmp_path: Path) -> None:
    """A field of float32 rounds what a scenario writes."""
    head = """world: empty_arena
follow:
  - {topic: scan, type: sensor_msgs/msg/LaserScan, field: ranges, as: ranges}
  - {topic: /heat, type: std_msgs/msg/Float32, field: data, as: heat, initial: 0.0}
requirements:
  stays cool: never ($heat > 0.61 and $heat < 0.64)
"""
    tree = """  turn: {angle: 90}
  cancel_when: $ranges[0] < 0.3
  timeout: 9"""
    findings = run_all(tmp_path, tree, head, faults=0)
    faults = [fault for entry in findings for fault in scenario_of(entry)["faults"]]  # type: ignore[attr-defined]
    assert "at 0.05: publish scan ranges=()" in faults
    assert "at 0.05: publish heat data=0.6200000047683716" in faults


CODE = """\
from py_trees.behaviour import Behaviour
from py_trees.common import Status


class Door(Behaviour):
    width = 1.0

    def update(self):
        self.width = 2.0
        return Status.SUCCESS
"""


def test_a_leaf_in_python_returns_the_statuses_of_the_way(tmp_path: Path) -> None:
    """With the values of its outputs, or it raises."""
    (tmp_path / "door.py").write_text(CODE)
    tree = """  sequence:
    - fallback:
        - python: door.py:Door
          name: door
          outputs: {width: width}
        - log: no door
    - check: width > 1
    - check: width < 3"""
    head = "requirements: {opens: never $width > 2}\n"
    value, waits = run_all(tmp_path, tree, head)
    fault = "return_status door failure width=2.5 lasting 0.05"
    assert scenario_of(value)["faults"] == [f"at 0.05: {fault}"]
    assert scenario_of(waits)["faults"] == ["at 0.05: return_status door running"]


def test_a_service_and_a_reader_that_no_stage_has_are_there(tmp_path: Path) -> None:
    """The way goes past both."""
    (tmp_path / "door.py").write_text(CODE)
    tree = """  sequence:
    - publish: {topic: /opening, type: std_msgs/msg/Bool, message: {data: true}}
    - service: {name: /count, type: rcl_interfaces/srv/ListParameters}
    - fallback:
        - timeout: 5
          do: {python: door.py:Door, name: door, outputs: {width: width}}
        - log: no door
    - log: $width"""
    (finding,) = run_all(tmp_path, tree, answers="usual,*:no_server,*:no_readers")
    assert scenario_of(finding)["faults"] == [
        "at 0.0: subscribe opening",
        "at 0.0: serve count",
        "at 0.1: return_status door running",
    ]


def test_what_no_run_shows_is_named(tmp_path: Path) -> None:
    """A node that is never entered is the absence of a run."""
    (dead,) = run_all(tmp_path, f"  fallback:\n    - log: always\n    - {TURN}")
    assert str(dead.stage) == (
        "not decided on the stage: no run shows that a node is never entered"
    )
    written = dead.as_dict()
    assert written["confirmed"] is None
    assert written["undecided"] == "no run shows that a node is never entered"
    assert "at once" not in str(dead)


def test_a_server_that_comes_back_is_there_when_the_way_has_it(tmp_path: Path) -> None:
    """Behind the limit of the first goal, which has no result."""
    goal = "move: {secs: 1, linear_velocity: 0.1}, timeout: 9, server_timeout: 1"
    tree = f"""\
  sequence:
    - fallback:
        - {{{goal}, outputs: {{error_code: code}}, name: first}}
        - log: nobody
    - {{{goal}, name: second}}
    - log: $code"""
    left_out = "usual,move:reject,move:no_answer,move:server_lost,move:refuse_cancel"
    (finding,) = run_all(tmp_path, tree, answers=f"{left_out},move:ignore_cancel")
    assert finding.steps[2] == "/move has a server again"
    assert scenario_of(finding)["faults"] == ["at 0.0: kill_server move lasting 1.1"]


def test_feedback_that_ends_is_scripted(tmp_path: Path) -> None:
    """The server sends feedback at each tick, then a last message, and ignores the cancel."""
    tree = """  sequence:
    - fallback:
        - turn: {angle: 90}
          timeout: 20
          feedback_timeout: 1
          outputs: {angle_turned: angle}
        - log: no angle
    - log: $angle"""
    left_out = ("reject", "no_answer", "refuse_cancel", "no_server", "abort", "server_lost", "late")
    answers = ",".join(["usual", *(f"turn:{name}" for name in left_out)])
    (finding,) = run_all(tmp_path, tree, answers=answers)
    goal = {"feedback": [{"after": 0.05, "every": 0.05}, {"after": 0.1}], "cancel": "ignore"}
    assert scenario_of(finding)["servers"] == {"turn": [{**goal, "after": 4.15}]}
