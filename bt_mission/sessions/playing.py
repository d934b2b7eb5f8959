"""Programs with the simulated robot and our action servers, without a mission."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bt_mission.core.errors import BtMissionError
from bt_mission.core.interrupts import InterruptSignals
from bt_mission.core.stamps import NS
from bt_mission.language.plugins import find_program, words_of
from bt_mission.programs.mains import WholeProgram
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import START_NS, Stage
from bt_mission.sessions.stage_robot import StageOptions

MISSION = "mission: play\nworld: empty_arena\ntree: {wait: 1000000}\n"
"""Waits for longer than any program."""


@dataclass
class Played:
    """The result of playing programs.

    Attributes:
        exit_codes: Of each program, by its name; None for one that has not ended.
        time_s: Virtual time, s.
        lines: What they have printed: time s, name, line.
        why: Why it has ended: ``ended``, ``idle``, ``limit`` or ``interrupted``.
    """

    exit_codes: dict[str, int | None]
    time_s: float = 0.0
    lines: list[tuple[float, str, str]] = field(default_factory=list)
    why: str = "ended"

    def as_dict(self) -> dict[str, Any]:
        """Return the fields by name, ready for JSON."""
        return vars(self)


def play(
    programs: Sequence[str],
    arguments: Sequence[str] = (),
    *,
    world: str | None = None,
    robot: str | None = None,
    seed: int | None = None,
    limit_s: float | None = None,
    say: Callable[[float, str, str], None] = lambda *_: None,
) -> Played:
    """Play programs until all have ended, none will do anything more, or a time is over.

    A signal is sent to all of them, as a terminal does; a second one ends the run.

    Args:
        programs: Their files, each with its own arguments after a space.
        arguments: For all of them.
        limit_s: Virtual time, s.
        say: Receives each line that they print: time s, name, line.

    Raises:
        BtMissionError: A program cannot be used, or a callback cannot continue.
    """
    lines = [words_of(text) or [""] for text in programs]
    names = [Path(words[0]).stem for words in lines]
    played = Played(dict.fromkeys(_told_apart(names)))

    def whole(name: str, words: Sequence[str]) -> WholeProgram:
        where = Path(words[0]).resolve()
        target = shlex.join([where.name, *words[1:], *arguments])
        file, words = find_program(target, str(where.parent / "play"))

        def take(time_s: float, line: str) -> None:
            played.lines.append((time_s, name, line))
            say(time_s, name, line)

        return WholeProgram(file, words, take, lambda code: played.exit_codes.update({name: code}))

    chosen = [whole(name, words) for name, words in zip(played.exit_codes, lines, strict=True)]
    mission = load(MISSION, world=world, robot=robot, seed=seed)
    options = StageOptions(programs=chosen)
    interrupts = InterruptSignals(2)
    with interrupts, Stage(mission, image_folder=Path("images"), options=options) as stage:
        stage.offer_all()
        was_interrupted = False
        while None in played.exit_codes.values():
            if interrupts.count and not was_interrupted:
                was_interrupted = True
                stage.interrupt_programs()
                continue
            if interrupts.count > 1 or stage.has_idle_programs:
                played.why = "interrupted" if was_interrupted else "idle"
                break
            if limit_s is not None and played.time_s >= limit_s:
                played.why = "limit"
                break
            stage.step()
            played.time_s = (stage.now_ns - START_NS) / NS
            if stage.is_done:
                raise BtMissionError(stage.runs[0].executive.reason, code="BT-903")
    return played


def _told_apart(names: Sequence[str]) -> list[str]:
    """Number the copies of a program."""
    return [
        name if names.count(name) == 1 else f"{name}_{names[:place].count(name) + 1}"
        for place, name in enumerate(names)
    ]
