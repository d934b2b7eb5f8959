"""Programs with the simulated robot and our action servers, without a mission."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, Self

from bt_mission.base.interrupts import InterruptSignals
from bt_mission.base.stamps import NS
from bt_mission.base.wall_clock import Pacer
from bt_mission.executive.events.events import LogLine
from bt_mission.executive.status import MissionStatus
from bt_mission.language.plugins import called_program, words_of
from bt_mission.programs.mains import WholeProgram
from bt_mission.sessions.drive import Steps
from bt_mission.sessions.load import load
from bt_mission.sessions.session import Onlooker
from bt_mission.sessions.stage import START_NS, Stage
from bt_mission.sessions.stage_robot import StageOptions

MISSION = "mission: play\nworld: empty_arena\ntree: {wait: 1000000, name: programs}\n"
"""Waits for longer than any program."""


WHY = {
    "ended": "all programs have ended",
    "idle": "the programs that remain only wait to be asked, and nobody will ask them",
    "limit": "the time is over",
    "interrupted": "interrupted",
    "failed": "failed",
}
"""Why programs have ended, for people."""


@dataclass
class PlayResult:
    """The result of playing programs.

    Attributes:
        exit_codes: Of each program, by its name; None for one that has not ended.
        time_s: Virtual time, s.
        lines: What they have printed: time s, name, line.
        why: Why it has ended: ``ended``, ``idle``, ``limit``, ``interrupted`` or ``failed``.
        failure: Why they cannot continue, such as a deadlock.
        flaws: A line for each callback that has held the clock.
        warnings: Those of their nodes about their threads, messages and clocks.
    """

    exit_codes: dict[str, int | None]
    time_s: float = 0.0
    lines: list[tuple[float, str, str]] = field(default_factory=list)
    why: str = "ended"
    failure: str = ""
    flaws: list[str] = field(default_factory=list)
    warnings: Sequence[str] = ()

    @property
    def verdict(self) -> str:
        """Why it has ended, in one line."""
        return f"{self.time_s:g} s: {self.failure or WHY[self.why]}"

    def as_dict(self) -> dict[str, Any]:
        """Return the fields by name, ready for JSON."""
        return vars(self)


class Playing:
    """Programs on a stage.

    Args:
        programs: Files, modules or console scripts, each with its own arguments after a space.
        arguments: For all of them.
        limit_s: Virtual time, s. Without it, programs that only serve have nothing to do when
            another one has ended.
        say: Receives each line that they print: time s, name, line.
        options: Of the stage.

    Raises:
        BtMissionError: A program cannot be used.
    """

    def __init__(
        self,
        programs: Sequence[str],
        arguments: Sequence[str] = (),
        *,
        world: str | None = None,
        robot: str | None = None,
        seed: int | None = None,
        limit_s: float | None = None,
        say: Callable[[float, str, str], None] = lambda *_: None,
        options: StageOptions | None = None,
    ) -> None:
        called = [called_program([*words_of(text), *arguments]) for text in programs]
        names = [each.module.rpartition(".")[2] or each.file.stem for each in called]
        self.played = PlayResult(dict.fromkeys(_told_apart(names)))
        self._say, self._limit_s = say, limit_s
        self._new_lines: list[LogLine] = []
        whole = [
            WholeProgram(
                each.file,
                each.arguments,
                partial(self._take, name),
                partial(self.played.exit_codes.__setitem__, name),
                each.module,
                each.function,
            )
            for name, each in zip(self.played.exit_codes, called, strict=True)
        ]
        mission = load(MISSION, world=world, robot=robot, seed=seed)
        options = replace(options or StageOptions(), programs=whole)
        self.stage = Stage(mission, image_folder=Path("images"), options=options)
        try:
            self.stage.offer_all()
        except BaseException:
            self.stage.__exit__(None, None, None)
            raise

    def __enter__(self) -> Self:
        """Have the stage taken down at the end."""
        return self

    def __exit__(self, *error: object) -> None:
        self.stage.__exit__(*error)

    def steps(
        self,
        interrupts: InterruptSignals,
        onlookers: Sequence[Onlooker] = (),
        speed: float | None = None,
    ) -> Steps[PlayResult]:
        """Play until all have ended, none will do anything more, or a time is over.

        A signal is sent to all of them, as a terminal does; a second one ends the run.

        Args:
            speed: Virtual seconds per second; None is as fast as possible.
        """
        stage, played = self.stage, self.played
        pacer = Pacer(speed, stage.now_ns)
        was_interrupted = False
        with ExitStack() as stack:
            for onlooker in onlookers:
                stage.attach(onlooker)
                stack.callback(onlooker.close)
            while None in played.exit_codes.values():
                if interrupts.count and not was_interrupted:
                    was_interrupted = True
                    stage.interrupt_programs()
                    continue
                left = next((each.why_left for each in onlookers if each.why_left), None)
                if interrupts.count > 1 or left or self._is_idle():
                    is_idle = not (was_interrupted or left)
                    played.why = "idle" if is_idle else "interrupted"
                    break
                if self._limit_s is not None and played.time_s >= self._limit_s:
                    played.why = "limit"
                    break
                stage.step()
                self._log()
                played.time_s = (stage.now_ns - START_NS) / NS
                if stage.is_done:
                    executive = stage.executive
                    if executive.status is MissionStatus.FAILURE:
                        played.why, played.failure = "failed", executive.reason
                    else:  # by who looks on
                        played.why = "interrupted"
                    break
                while speed is not None and not interrupts.count:
                    if (ahead_s := pacer.ahead_s(stage.now_ns)) <= 0:
                        break
                    yield ahead_s
                yield 0.0
        return played

    def _is_idle(self) -> bool:
        """Return whether nothing will happen any more; a client that has ended asks for nothing."""
        has_ended = any(code is not None for code in self.played.exit_codes.values())
        return self.stage.has_idle_programs(only_serve=has_ended and self._limit_s is None)

    def _take(self, name: str, time_s: float, line: str) -> None:
        self.played.lines.append((time_s, name, line))
        self._new_lines.append(LogLine(START_NS + round(time_s * NS), f"{name}: {line}"))
        self._say(time_s, name, line)

    def _log(self) -> None:
        """Pass new lines to the log that pages, screens, reports and recordings show."""
        lines, self._new_lines = self._new_lines, []
        for line in lines:
            self.stage.executive.events.emit(line)


def _told_apart(names: Sequence[str]) -> list[str]:
    """Number the copies of a program."""
    return [
        name if names.count(name) == 1 else f"{name}_{names[:place].count(name) + 1}"
        for place, name in enumerate(names)
    ]
