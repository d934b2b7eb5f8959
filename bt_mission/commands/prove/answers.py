"""The possible answers of servers, as rows, and the choice of considered rows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from bt_mission.base.diagnostics import did_you_mean, listed, quoted
from bt_mission.base.errors import BtMissionError


@dataclass(frozen=True)
class Answer:
    """An answer that a server, a service, a topic or a Python class may give.

    Attributes:
        name: As it is written in a file of answers.
        stage: At which it may come, such as "asked": the goal is not answered yet.
        words: What happens, behind the name of the server.
        faults: 1 where it counts as a fault, 0 where it is usual.
        is_rare: It is considered with ``--answers all`` only.
    """

    name: str
    stage: str
    words: str
    faults: int = 0
    is_rare: bool = False


ROWS = (
    Answer("there", "found", ""),
    Answer("no_server", "found", "has no server", 1),
    Answer("back", "missing", "has a server again"),
    Answer("away", "missing", ""),
    Answer("accept", "asked", "accepts the goal"),
    Answer("reject", "asked", "rejects the goal", 1),
    Answer("no_answer", "asked", "does not answer the goal", 1),
    Answer("late_accept", "mute", "accepts the goal late", 1, is_rare=True),
    Answer("succeed", "working", "succeeds"),
    Answer("condition", "working", "sends feedback that meets the condition"),
    Answer("feedback", "working", "sends feedback"),
    Answer("silence", "working", "sends no more feedback", 1),
    Answer("abort", "working", "aborts the goal", 1),
    Answer("server_lost", "working", "loses its server", 1),
    Answer("cancel_outside", "working", "is cancelled by another client", 1, is_rare=True),
    Answer("confirm_cancel", "cancel", "confirms the cancel"),
    Answer("refuse_cancel", "cancel", "refuses to cancel", 1),
    Answer("ignore_cancel", "cancel", "does not answer the cancel", 1),
    Answer("succeed_first", "cancel", "succeeds before it is cancelled"),
    Answer("abort_first", "cancel", "aborts before it is cancelled", 1),
    Answer("respond", "called", "answers"),
    Answer("fail", "called", "answers without success", 1),
    Answer("no_response", "called", "does not answer", 1),
    Answer("message", "topic", "sends a message that meets the condition"),
    Answer("value", "followed", "sends"),
    Answer("quiet", "followed", "sends nothing more", 1),
    Answer("readers", "readers", ""),
    Answer("no_readers", "readers", "has no subscriptions", 1),
    Answer("success", "python", "succeeds"),
    Answer("failure", "python", "fails"),
    Answer("running", "python", "takes its time"),
    Answer("raise", "python", "raises an exception", 1),
)
SILENT = frozenset(("no_answer", "ignore_cancel", "no_response"))
"""The rows after which nothing comes: it makes no difference when that is decided."""
ANSWERS: Mapping[str, Answer] = {row.name: row for row in ROWS}
LATE = "late"
"""The name of the fault that a limit is met while its server works."""
EXTREME = "extreme"
"""The name of the fault that a number is not finite, NaN, or greater than any usual one."""
NAMES = (*(row.name for row in ROWS if row.faults), LATE, EXTREME)
"""The answers that a file may leave out."""


@dataclass(frozen=True)
class AnswerSet:
    """The answers that are considered.

    Attributes:
        has_rare: The rows for ``--answers all``, too.
        without: Names of rows that are left out, by the name of the action, service or topic;
            under "*" for all of them.
    """

    has_rare: bool = False
    without: Mapping[str, frozenset[str]] = field(default_factory=dict)
    _known: dict[tuple[str, str], list[Answer]] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )

    def at(self, stage: str, name: str) -> list[Answer]:
        """Return the answers of a server at a stage."""
        known = self._known.get((stage, name))
        if known is None:
            left_out = self._left_out(name)
            known = self._known[stage, name] = [
                row
                for row in ROWS
                if row.stage == stage
                and (self.has_rare or not row.is_rare)
                and not (row.faults and row.name in left_out)
            ]
        return known

    def is_ever(self, fault: str, name: str) -> bool:
        """May a server, a service, a topic or a class have this fault?"""
        return fault not in self._left_out(name)

    def is_ever_late(self, name: str) -> bool:
        """May a limit of this server be met while it works?"""
        return self.is_ever(LATE, name)

    def _left_out(self, name: str) -> frozenset[str]:
        bare = name.strip("/")
        return self.without.get(bare, frozenset()) | self.without.get("*", frozenset())


def parse_answers(text: str) -> AnswerSet:
    """Return the answers of ``usual``, ``all``, or ``usual,turn:reject,*:late``.

    Each item behind the first leaves out one answer, of one server or of all.

    Raises:
        BtMissionError: For an unknown word.
    """
    first, *items = (part.strip() for part in text.split(","))
    if first not in ("usual", "all"):
        items.insert(0, first)
        first = "usual"
    without: dict[str, set[str]] = {}
    for item in items:
        server, colon, name = item.rpartition(":")
        if not colon or not server or name not in NAMES:
            raise BtMissionError(_unknown(item, name if colon else item), code="BT-1101")
        without.setdefault(server.removeprefix("-").strip("/"), set()).add(name)
    return AnswerSet(
        has_rare=first == "all",
        without={server: frozenset(names) for server, names in without.items()},
    )


def _unknown(item: str, name: str) -> str:
    hint = did_you_mean(name, ("usual", "all", *NAMES))
    return (
        f"--answers: expected 'usual', 'all' or SERVER:ANSWER such as 'turn:reject', got "
        f"{quoted(item)}; answers that can be left out: {listed(NAMES)}"
        + (f" ({hint})" if hint else "")
    )
