"""The requirements of a running mission: sampled at every control step, reported at once."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property

from bt_mission.base.stamps import NS
from bt_mission.base.verdicts import RequirementResult
from bt_mission.executive.events.events import RequirementChanged
from bt_mission.executive.status import MissionStatus
from bt_mission.language.mission import Requirement
from bt_mission.requirements import resumption
from bt_mission.requirements.monitor import Monitors
from bt_mission.ros.mission_runtime import MissionRuntime
from bt_mission.ros.signals import LiveSignals

STOP, STOP_TYPE = "stop", "std_srvs/srv/Trigger"
"""The service of the action servers that stops the base; they refuse goals until their `release` is
called.
"""


PERIOD_NS = NS
"""Margins are as new as this, in the mission's time."""


class RequirementWatch:
    """Evaluates the requirements of a runner's mission; without any it does nothing.

    Args:
        runner: The runner of the mission.
        make_signals: Makes the source of the signals.
    """

    def __init__(
        self, runner: MissionRuntime, make_signals: Callable[[MissionRuntime], LiveSignals]
    ) -> None:
        self._runner = runner
        self._make_signals = make_signals
        self._samplers: list[Callable[[], None]] = []
        self._monitors: Monitors | None = None
        self._violated = 0
        self._emitted: dict[str, RequirementResult] = {}
        self._next_ns = 0
        self._violated_then = 0
        self._before: Mapping[str, RequirementResult] | None = None
        if runner.mission.requirements:
            self._monitors = Monitors(runner.mission.requirements, self.signals, self._on_violation)
            self.signals.listen()

    @cached_property
    def signals(self) -> LiveSignals:
        """The signals of the mission, from now on; without requirements they wait for a sampler."""
        signals = self._make_signals(self._runner)
        self._runner.executive.after_tick.append(self._step)
        return signals

    def add_sampler(self, sample: Callable[[], None]) -> None:
        """Call a function at every control step, before requirements are evaluated."""
        _ = self.signals
        self._samplers.append(sample)

    def remove_sampler(self, sample: Callable[[], None]) -> None:
        """Call it no more."""
        self._samplers.remove(sample)

    def results(self) -> tuple[RequirementResult, ...]:
        """The results of the requirements; final at the mission's end."""
        monitors, executive = self._monitors, self._runner.executive
        if monitors is None:
            return ()
        if executive.status.is_final:
            monitors.finish(is_complete=executive.status is not MissionStatus.INTERRUPTED)
        return tuple(map(self._joined, self._runner.mission.requirements, monitors.results))

    def resume(self, before: Mapping[str, RequirementResult]) -> None:
        """Continue with the results of an earlier process, for requirements of the same text."""
        self._before = {
            requirement.name: before[requirement.name]
            for requirement in self._runner.mission.requirements
            if requirement.name in before
            and before[requirement.name].requirement == requirement.text
        }
        verdicts = [verdict.verdict for verdict in self._before.values()]
        self._violated = verdicts.count("violated")

    def _joined(self, requirement: Requirement, result: RequirementResult) -> RequirementResult:
        if self._before is None:
            return result
        return resumption.joined(requirement, self._before.get(requirement.name), result)

    def _step(self) -> None:
        executive = self._runner.executive
        if not executive.started_ns:
            return  # goals of an earlier process end first
        self.signals.step()
        for sample in self._samplers:
            sample()
        if self._monitors is not None:
            self._monitors.step(self._runner.now_ns - executive.started_ns)
        self.signals.forget()
        if executive.status.is_final:
            self.results()

    def emit_changes(self) -> None:
        """Emit the verdicts and margins that have changed, if that is due.

        It is due once a second of the mission's time, when one is violated, and at its end.
        """
        runner, violated = self._runner, self._violated
        if self._monitors is None or (
            runner.now_ns < self._next_ns
            and violated == self._violated_then
            and not runner.executive.status.is_final
        ):
            return
        self._next_ns, self._violated_then = runner.now_ns + PERIOD_NS, violated
        for result in self.results():
            if result.on_violation != "measure" and self._emitted.get(result.name) != result:
                self._emit(result, is_update=True)

    def _emit(self, result: RequirementResult, *, is_update: bool) -> None:
        self._emitted[result.name] = result
        shown = result.shown
        self._runner.executive.events.emit(
            RequirementChanged(
                self._runner.now_ns,
                result.name,
                result.requirement,
                result.verdict,
                shown.margin,
                shown.unit,
                shown.at,
                result.violated_at,
                result.on_violation,
                tuple(result.sources),
                result.why,
                result.outcome,
                is_update,
            )
        )

    def _on_violation(self, requirement: Requirement, seen: RequirementResult) -> None:
        if requirement.on_violation == "measure":
            return
        runner, result = self._runner, self._joined(requirement, seen)
        before = (self._before or {}).get(requirement.name)
        if result.verdict != "violated" or (before is not None and before.verdict == "violated"):
            return  # it was reported before the resume, or cannot be determined
        self._violated += 1
        self._emit(result, is_update=False)
        runner.explain(f"requirement {result}")
        if result.on_violation == "report":
            return
        reason = f"requirement {result}"
        if result.on_violation == "halt":
            self._stop_base()
        runner.executive.fail(reason)

    def _stop_base(self) -> None:
        """Ask the servers to hold the base until `release` is called."""
        runner = self._runner
        client = runner.service_client(STOP, STOP_TYPE)
        if not client.is_ready():
            runner.log(f"{client.name} has no server, so it did not stop the base")
            return
        client.call(client.prepare({}), lambda _: None)
