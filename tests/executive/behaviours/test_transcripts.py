r"""Missions without servers, with all that happens in them, in `transcripts`.

`\n` in an input is a new line. An output has the ticks in which more changes than the time that is
left: statuses from the root down, what is logged, new messages of nodes. Behind them stand status,
reason and variables.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from tests.support.transcripts import assert_transcript, transcripts_of


def happenings(run: Any) -> Iterator[str]:
    """What happens in a run to its end, a line each."""
    before = ""
    messages: set[str] = set()
    for tick in range(1, 100):
        logged = len(run.logged)
        statuses = run.tick()
        logs = [f"'{text}'" for text in run.logged[logged:]]
        known, messages = messages, {node.feedback_message for node in run.root.iterate()}
        new = sorted(messages - known - {""})
        if logs or statuses != before or not all(text.endswith(" s left") for text in new):
            yield f"{tick}: {statuses} {', '.join([*logs, *new])}".rstrip()
        before = statuses
        if run.executive.is_done:
            break
    yield f"{run.status}: {run.executive.reason}" if run.executive.reason else run.status
    values = {
        key: value for key, value in run.scope.values.items() if key not in run.mission.inputs
    }
    if values:
        yield str(values)


@pytest.mark.parametrize("path", transcripts_of(__file__), ids=lambda path: path.stem)
def test_every_mission_runs_as_in_its_transcript(play: Any, path: Any) -> None:
    """To its end."""

    def output(line: str) -> str:
        tree = line.replace("\\n", "\n")
        run = play(f"  {tree}\n", "mission: test\ninputs: {speed: 0.5, legs: 3}")
        return "\n".join(happenings(run))

    assert_transcript(path, output)
