"""The messages, responses and statuses of leaves on a way, as faults of a scenario."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from bt_mission.base.stamps import NS
from bt_mission.commands.prove.clients import AnyBehaviour, Service, Speech, Topic
from bt_mission.commands.prove.environment import START_NS, TICK_NS, Environment
from bt_mission.scenarios.faults.planned import AtTime, PlannedFault

BEAT_S = TICK_NS / NS
"""The interval of messages that keep a limit of silence from being over, s."""


class Effect(NamedTuple):
    """A fault without its times."""

    name: str
    arguments: Mapping[str, Any]


class EffectTimeline:
    """What happens to one thing: each effect lasts until the next begins.

    Attributes:
        last: The newest effect; None for none.
        last_ns: When it began.
    """

    def __init__(self, first: Effect | None = None) -> None:
        self._entries: list[tuple[int, Effect | None]] = [(START_NS, first)]

    @property
    def last(self) -> Effect | None:
        """The newest effect."""
        return self._entries[-1][1]

    @property
    def last_ns(self) -> int:
        """When it began, ns."""
        return self._entries[-1][0]

    def change(self, at_ns: int, effect: Effect | None) -> None:
        """Have an effect begin, instead of one that begins at the same time or later."""
        while self._entries and self._entries[-1][0] >= at_ns:
            self._entries.pop()
        if not self._entries or self.last != effect:
            self._entries.append((at_ns, effect))

    def end_before(self, at_ns: int, effect: Effect) -> int:
        """Have the last effect begin at another time; return by how much that is too early, ns.

        Args:
            at_ns: When it begins now.
            effect: The last one. The one before it lasts until then.
        """
        self._entries.pop()
        if self.last is not None and self.last.name == "publish" and at_ns > self.last_ns + TICK_NS:
            begin_ns, before = self._entries.pop()
            again = {**before.arguments, "every": BEAT_S} if before is not None else {}
            self._entries.append((begin_ns, Effect("publish", again)))
        earliest_ns = self.last_ns + TICK_NS
        self.change(max(at_ns, earliest_ns), effect)
        return max(0, earliest_ns - at_ns)

    @property
    def faults(self) -> Iterator[str]:
        """The effects as faults."""
        ends = [begin_ns for begin_ns, _ in self._entries[1:]]
        for (begin_ns, effect), end_ns in zip(self._entries, [*ends, None], strict=True):
            if effect is not None:
                lasting = None if end_ns is None else seconds_of(end_ns - begin_ns)
                begins = AtTime(seconds_of(begin_ns - START_NS))
                yield PlannedFault(begins, effect.name, effect.arguments, lasting).text


class Timelines:
    """Notes what clients other than those of actions do on a way.

    Attributes:
        doubts: Why a run that does not show the finding decides nothing.
        others: The answers that no scenario scripts, as text.
    """

    def __init__(self, environment: Environment) -> None:
        self.doubts: list[str] = []
        self.others: list[str] = []
        self._environment = environment
        self._known: dict[str, EffectTimeline] = {}
        self._answers: list[str] = []
        """The faults of single answers of services."""
        self._beats: dict[str, int] = {}
        self._ages: dict[str, float] = {}
        self.missing: tuple[int, int] = (0, 0)
        """The ticks by which the last step is too early for the age of a message, and when that
        message came, ns."""
        self._began_ns = START_NS
        for topic in environment.topics:
            self._known[topic.name] = EffectTimeline(_dropped(topic))
            topic.on_message = self._noter(topic)
        for publisher in environment.publishers:
            self._known[publisher.name] = EffectTimeline(self._subscribed(publisher))
        for service in environment.services:
            self._known[service.name] = EffectTimeline(_served(service))
            service.on_response = self._response_noter(service)
        for leaf in environment.any_behaviours:
            self._known[self._path_of(leaf)] = EffectTimeline()
            leaf.on_answer = self._answer_noter(leaf)
        leaves = [f"'{leaf.name}'" for leaf in environment.any_behaviours]
        clients = [name for name in self._known if name.startswith("/")]
        self._prefixes = tuple(f"{name} " for name in (*clients, *leaves))

    @property
    def faults(self) -> list[str]:
        """The faults of a scenario."""
        lasting = [fault for timeline in self._known.values() for fault in timeline.faults]
        return lasting + self._answers

    def knows(self, words: str) -> bool:
        """Are these the words for an answer that is noted here?"""
        return words.startswith(self._prefixes)

    def begin(self) -> None:
        """Note the time before a step."""
        self.missing = (0, 0)
        self._began_ns = self._environment.now_ns

    def end(self, words: list[str]) -> None:
        """Note what the clients are like behind a step."""
        environment = self._environment
        for topic in environment.topics:
            if topic.is_quiet and self._known[topic.name].last != _dropped(topic):
                self._silence(topic)
            if topic.age_s > self._ages.get(topic.name, 0.0):
                self._age(topic)
        for publisher in environment.publishers:
            self._note_presence(publisher, self._subscribed(publisher))
        for service in environment.services:
            if f"{service.name} does not answer" in words:
                effect = Effect("ignore_service", {"service": _bare(service.name)})
                self._answer(effect)
            if service.calls and service.delays:
                self.doubts.append(f"no scenario delays a response of {service.name}")
            self._note_presence(service, _served(service))

    def _silence(self, topic: Topic) -> None:
        """Note that a topic has no message behind its last one."""
        timeline = self._known[topic.name]
        last_ns = self._beats.get(topic.name, self._began_ns)
        if timeline.last is not None and timeline.last_ns == last_ns:
            arguments = timeline.last.arguments.items()
            once = {name: value for name, value in arguments if name != "every"}
            timeline.change(last_ns, timeline.last._replace(arguments=once))
            timeline.change(last_ns + TICK_NS, _dropped(topic))
        else:
            timeline.change(last_ns + TICK_NS // 2, _dropped(topic))

    def _age(self, topic: Topic) -> None:
        """Have the last message of a silent topic come so early that it is too old now."""
        self._ages[topic.name] = topic.age_s
        at_ns = self._environment.ticked_ns - round(topic.age_s * NS) + TICK_NS // 2
        timeline = self._known[topic.name]
        missing_ns = timeline.end_before(at_ns, _dropped(topic))
        if missing_ns:
            self.missing = -(-missing_ns // TICK_NS), timeline.last_ns - TICK_NS
            self.doubts.append(f"{topic.name} is silent for {topic.age_s:g} s earlier than it can")

    def _note_presence(self, client: Speech | Service, present: Effect | None) -> None:
        """Note when a counterpart goes, a tick before the tick that notices it, and comes back."""
        timeline, now_ns = self._known[client.name], self._environment.now_ns
        if client.is_away and timeline.last is not None:
            timeline.change(max(START_NS, now_ns - TICK_NS), None)
            if isinstance(client, Service):
                self.doubts.append(f"the stage may offer {client.name}")
        elif not client.is_away and timeline.last is None and present is not None:
            timeline.change(now_ns, present)

    # ---- topics -----------------------------------------------------------------------------

    def _noter(self, topic: Topic) -> Any:
        def note(fields: Mapping[str, Any]) -> None:
            timeline, now_ns = self._known[topic.name], self._environment.now_ns
            is_beat = now_ns != self._began_ns
            at_ns = now_ns if is_beat else now_ns + TICK_NS
            once = Effect("publish", {"topic": _bare(topic.name), **fields})
            again = Effect("publish", {"topic": _bare(topic.name), "every": BEAT_S, **fields})
            if is_beat:
                self._beats[topic.name] = now_ns
                is_new = timeline.last_ns == at_ns and timeline.last not in (once, _dropped(topic))
                if not is_new and timeline.last != again:
                    timeline.change(at_ns, again)
            else:
                timeline.change(at_ns, once)

        return note

    def _subscribed(self, publisher: Speech) -> Effect | None:
        count = self._environment.subscriptions_wanted(publisher)
        arguments = {"topic": _bare(publisher.name), **({"times": count} if count > 1 else {})}
        return Effect("subscribe", arguments) if count else None

    # ---- services ---------------------------------------------------------------------------

    def _response_noter(self, service: Service) -> Any:
        usual = _served(service)

        def note(fields: Mapping[str, Any]) -> None:
            arguments = {"service": _bare(service.name), **fields}
            if arguments != usual.arguments:
                self._answer(Effect("fail_service", arguments))

        return note

    def _answer(self, effect: Effect) -> None:
        """Note the answer to a call of the last tick; the server stays there."""
        begins = AtTime(seconds_of(self._began_ns - START_NS))
        lasting = PlannedFault(begins, effect.name, effect.arguments, BEAT_S)
        self._answers.append(lasting.text)

    # ---- leaves -----------------------------------------------------------------------------

    def _path_of(self, leaf: AnyBehaviour) -> str:
        return self._environment.executive.path_of(leaf)

    def _answer_noter(self, leaf: AnyBehaviour) -> Any:
        path = self._path_of(leaf)
        nodes = self._environment.executive.nodes
        name = leaf.name if sum(leaf.name == node.name for node in nodes) == 1 else path

        def note() -> None:
            timeline, now_ns = self._known[path], self._environment.now_ns
            effect = Effect("return_status", {"leaf": name, "status": leaf.answer})
            if leaf.answer == "raise":
                effect = Effect("raise_in_leaf", {"leaf": name})
            elif leaf.answer != "running":
                effect = Effect("return_status", {**effect.arguments, **leaf.outputs})
            if timeline.last_ns > now_ns:
                self.others.append(f"'{leaf.name}' answers twice at the same time")
            if timeline.last != effect:
                timeline.change(now_ns, effect)
            if leaf.answer != "running":
                timeline.change(now_ns + TICK_NS, None)

        return note


def seconds_of(nanoseconds: int) -> float:
    """Return a time for a scenario, s."""
    return round(nanoseconds / NS, 3)


def _dropped(topic: Topic) -> Effect:
    return Effect("drop", {"topic": _bare(topic.name)})


def _served(service: Service) -> Effect:
    usual = {"success": True} if service.has_success else {}
    return Effect("serve", {"service": _bare(service.name), **usual})


def _bare(name: str) -> str:
    return name.strip("/")
