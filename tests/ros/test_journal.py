"""Requirements of a mission whose process dies, and that is resumed from its journal."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from bt_mission.base.errors import BtMissionError
from bt_mission.base.verdicts import RequirementResult
from bt_mission.ros.journal import open_journal
from bt_mission.ros.mission_runner import MissionRunner

MISSION = """\
mission: m
requirements:
  is quick: {formula: always time < 1.22, on_violation: REPORT}
  ends: eventually succeeded("second")
  in time: 'eventually within 60 s: succeeded("second")'
  in order: "whenever running(\\"second\\"): previously within 4 s running(\\"first\\")"
tree:
  sequence:
    - {wait: 2, name: first}
    - {wait: 2, name: second}
"""


def verdicts(runner: MissionRunner) -> dict[str, str]:
    """Of all requirements."""
    return {result.name: result.verdict for result in runner.requirements.results()}


def resumed_after(ros: Any, path: Path, seconds: float) -> MissionRunner:
    """A mission whose process dies after so many seconds; it has ended in a second one."""
    text = MISSION.replace("REPORT", "report")
    first = ros.mission(text)
    journal = open_journal(path, first.mission, first, resume=False)
    ros.run(seconds)
    journal.close()  # nothing is written any more
    first.close()
    ros.logged.clear()
    second: MissionRunner = ros.mission(text)
    journal = open_journal(path, second.mission, second, resume=True)
    ros.until(lambda: second.executive.is_done)
    journal.close()
    assert second.executive.status == "success", second.executive.reason
    return second


def test_what_was_violated_stays_so(ros: Any, tmp_path: Path) -> None:
    """It is not said again; what looks across the gap is open, and says why."""
    second = resumed_after(ros, tmp_path / "journal", 2.5)
    expected = {"is quick": "violated", "ends": "holds", "in time": "open", "in order": "open"}
    assert verdicts(second) == expected
    assert not [line for line in ros.logged if "is quick" in line]
    quick, *_, order = second.report().requirements
    assert quick.violated_at == 1.25
    assert str(quick).endswith(": before the mission was resumed")
    assert order.why == "it is about times across the instant at which the mission was resumed"
    assert second.report().failing


def test_what_was_open_is_judged_from_the_resumption_on(ros: Any, tmp_path: Path) -> None:
    """The signal `time` begins anew, as the report does."""
    second = resumed_after(ros, tmp_path / "journal", 1.0)
    assert verdicts(second)["is quick"] == "violated"
    (lines,) = [line for line in ros.logged if "is quick" in line]
    assert lines.startswith("requirement is quick: violated by 0.03 s at 1.25 s")


def test_a_mission_that_was_observed_has_ended(ros: Any, tmp_path: Path) -> None:
    """A process that dies while time goes on after the end leaves nothing to resume."""
    text = MISSION.replace("REPORT", "report").replace("mission: m\n", "mission: m\nobserve: 5\n")
    first = ros.mission(text)
    journal = open_journal(tmp_path / "journal", first.mission, first, resume=False)
    ros.run(6)
    assert first.status == "observing"
    journal.close()  # nothing is written any more
    first.close()
    assert first.status == "success"
    second = ros.mission(text)
    with pytest.raises(BtMissionError, match="success"):
        open_journal(tmp_path / "journal", second.mission, second, resume=True)


def test_a_requirement_of_another_text_begins_again(ros: Any) -> None:
    """What one of the same name had come to says nothing of it."""
    requirements = ros.mission(MISSION.replace("REPORT", "report")).requirements
    for text, is_kept in (("always time < 9", False), ("always time < 1.22", True)):
        requirements.resume({"is quick": RequirementResult("is quick", text, "violated", -0.1)})
        quick, *_ = requirements.results()
        assert (quick.verdict == "violated") is is_kept
