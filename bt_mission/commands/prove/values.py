"""The values of messages, leaves in Python and draws that a mission can tell apart.

A number has one value of each region in which everything that reads it does the same: conditions,
computed numbers, and variables that it is passed on to. Where an expression is not followed, the
values are samples; :attr:`ValueCases.sampled` says which, and what stopped it.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from itertools import chain, islice, product
from typing import Any, NamedTuple, TypeVar

from bt_mission.commands.prove.answers import EXTREME, AnswerSet
from bt_mission.commands.prove.domains import Domain, domain_in
from bt_mission.commands.prove.regions import (
    DOUBLES,
    DRAW,
    DRAWN,
    FAILED,
    Line,
    Splitter,
    UnfollowedError,
    evaluated,
)
from bt_mission.commands.prove.uses import (
    Use,
    Uses,
    atoms_of,
    condition_use,
    field_name,
    names_in,
    numbers_in,
    texts_in,
)
from bt_mission.executive.behaviours.runtime import read_field
from bt_mission.language.mission import Mission, Requirement
from bt_mission.language.nodes.base import NodeModel
from bt_mission.language.nodes.interfaces import InterfaceNode


class Known(dict[Any, Any]):
    """Cached results; not a part of a state."""


MOST_COMBINATIONS = 64
"""Combinations of values of one message that are tried."""
MOST_FIXED = 16
"""Combinations of known values of the other names in an expression that are considered."""
MOST_ELEMENTS = 12
OTHER_TEXT = "other"
DISTINCT_ROUNDS = (1, 2, 3)
"""Numbers of rounds that are distinguished, where a value decides how many there are."""


class Case(NamedTuple):
    """A value with the faults that it counts as; is it a fault as an extreme number?"""

    value: Any
    faults: int = 0
    is_extreme: bool = False


class Message(NamedTuple):
    """Fields of a message, by their dotted names, and the faults that they count as."""

    fields: Mapping[str, Any]
    faults: int = 0
    is_extreme: bool = False


Told = TypeVar("Told", Case, Message)


Reader = tuple[Use, str]
"""An expression, and the name under which it reads a value."""


class ValueCases:
    """The values of each thing that a mission reads.

    Args:
        mission: Whose expressions count, those of its named trees included.
        requirements: Their conditions on variables count, too.
        has_bound: Is the number of faults bounded? Extreme numbers are faults.
        are_extremes_free: Do they cost none of the faults of a way?
    """

    def __init__(
        self,
        mission: Mission,
        requirements: Iterable[Requirement] = (),
        *,
        has_bound: bool = False,
        are_extremes_free: bool = False,
    ) -> None:
        self._uses = Uses(mission, requirements)
        self._messages, self._conditions, self._cached = Known(), Known(), Known()
        self._borders, self._busy = Known(), Known()
        self.sampled: dict[str, None] = {}
        """The values that were used and of which not all are tried, with what stopped that."""
        self._has_bound = has_bound and not are_extremes_free
        self._extreme_faults = int(not are_extremes_free)
        self.without_extremes: dict[str, None] = {}
        """The names whose extreme numbers, each a fault, give another result than all others."""

    # ---- what is asked -----------------------------------------------------------------------

    def of(self, domain: Domain, *variables: str) -> list[Case]:
        """Return the values of a type that differ for what reads these variables."""
        key = domain.kind, repr(domain), variables
        if key not in self._cached:
            readers = [(use, name) for name in variables for use in self._uses.of.get(name, ())]
            self._cached[key] = self._cases(domain, readers, {}, " and ".join(variables))
        cases, notes = self._cached[key]
        self.sampled |= dict.fromkeys(notes)
        return list(cases)

    def guessed(self, variable: str, leaf: str) -> Domain:
        """Return the values of an output whose type is not known, by what reads it."""
        uses = self._uses.of.get(variable, ())
        self.sampled[f"'{variable}' of '{leaf}': its type is not known"] = None
        if any(True for use in uses for _ in texts_in(use.root)):
            return Domain("text", "")
        is_asked = any(use.is_whole and use.kind == "condition" for use in uses)
        return Domain("bool", False) if is_asked else Domain("double", 0.0)

    def considered(self, cases: list[Told], answers: AnswerSet, name: str) -> list[Told]:
        """Return the values that something gives: without extreme numbers if these are left out.

        Args:
            cases: The values that a mission can tell apart.
            answers: Those that are considered.
            name: Of what gives them.
        """
        if not answers.is_ever(EXTREME, name):
            return [case for case in cases if not case.is_extreme]
        if self._has_bound and any(case.is_extreme for case in cases):
            self.without_extremes[name] = None
        return cases

    def of_draw(self, node: NodeModel | None) -> tuple[float, ...]:
        """Return the numbers from 0 to 1 that differ for a node that draws."""
        key = DRAW, id(node)
        if key not in self._cached:
            values, notes = self._draw_cases([] if node is None else self._uses.drawing(node))
            self._cached[key] = tuple(values), dict.fromkeys(notes)
        self.sampled |= self._cached[key][1]
        numbers: tuple[float, ...] = self._cached[key][0]
        return numbers

    def of_outputs(
        self, outputs: Mapping[str, str], message: Any, without: Iterable[str] = ()
    ) -> list[Message]:
        """Return the messages that a mission can tell apart by what it reads of them.

        Args:
            outputs: The variable into which each field is read.
            message: One of this type.
            without: Fields that are given otherwise.
        """
        read = {name: [variable] for name, variable in outputs.items() if name not in without}
        return self.messages(message, read, (), {})

    def messages(
        self,
        message: Any,
        read: Mapping[str, Sequence[str]],
        conditions: Sequence[Use],
        variables: Mapping[str, Any],
        followed: Collection[str] = (),
    ) -> list[Message]:
        """Return the messages of a type that a mission can tell apart.

        Args:
            message: One of this type.
            read: The variables into which each field is read.
            conditions: On the fields.
            variables: Their present values, for the conditions.
            followed: The fields for which NaN is no value at all.
        """
        asked = [name[1:-1] for use in conditions for name in names_in(use.root) if name[:1] == "<"]
        names = list(dict.fromkeys([*read, *asked]))
        known = default_fields(message, names)
        parts: dict[str, list[Case]] = {}
        for dotted, default in known.items():
            domain = domain_in(message, dotted, default)
            into = tuple(read.get(dotted, ()))
            mine = [use for use in conditions if field_name(dotted) in names_in(use.root)]
            cases = self._of_field(domain, dotted, into, mine, variables)
            if dotted in followed and domain.kind in ("float", "double") and into:
                cases = [case for case in cases if case.value == case.value]
                cases.append(Case(math.nan, self._extreme_faults, True))
            parts[dotted] = cases
        parts = {name: cases for name, cases in parts.items() if len(cases) > 1} or {}
        if not parts:
            return [Message({})]
        if math.prod(map(len, parts.values())) > MOST_COMBINATIONS:
            self.sampled[f"messages with {' and '.join(parts)}: more than {MOST_COMBINATIONS}"] = (
                None
            )
        return list(_combinations(parts))

    def condition_of(self, node: InterfaceNode) -> Use:
        """Return the condition of a node on messages."""
        if id(node) not in self._conditions:
            self._conditions[id(node)] = node, condition_use(node, f"line {node.line}")
        use: Use = self._conditions[id(node)][1]
        return use

    def answer(self, use: Use, message: Any, variables: Mapping[str, Any]) -> Any:
        """Return whether a message meets a condition: true, false, or `FAILED`."""
        fields = default_fields(
            message, [name[1:-1] for name in names_in(use.root) if name[:1] == "<"]
        )
        named = {field_name(dotted): value for dotted, value in fields.items()}
        return evaluated(use.root, "", 0.0, {**variables, **named})

    def message_that(
        self, use: Use, kind: type, variables: Mapping[str, Any], *, holds: bool
    ) -> Mapping[str, Any] | None:
        """Return fields of a message for which a condition holds, or does not.

        None where no combination of the values of its fields does.
        """
        read = tuple(
            (name, repr(variables[name]))
            for name in sorted(names_in(use.root))
            if name in variables
        )
        key = id(use), kind, holds, read
        if key not in self._cached:
            default = kind()
            candidates = sorted(
                self.messages(default, {}, [use], variables), key=lambda message: message.faults
            )
            self._cached[key] = next(
                (
                    entry.fields
                    for entry in candidates
                    if self.answer(use, self.message(kind, entry.fields), variables) is holds
                ),
                None,
            )
        fields: Mapping[str, Any] | None = self._cached[key]
        return fields

    def message(self, kind: type, fields: Mapping[str, Any]) -> Any:
        """Return a message with these fields, always the same one: nobody writes to it."""
        key = kind, repr(fields)
        if key not in self._messages:
            self._messages[key] = assign(kind(), fields)
        return self._messages[key]

    # ---- the values of one thing -------------------------------------------------------------

    def _of_field(
        self,
        domain: Domain,
        dotted: str,
        variables: tuple[str, ...],
        conditions: Sequence[Use],
        present: Mapping[str, Any],
    ) -> list[Case]:
        if not conditions:
            return self.of(domain, *variables)
        names = {name for use in conditions for name in names_in(use.root)}
        given = {name: present[name] for name in names if name in present}
        key = repr(domain), dotted, variables, tuple(map(id, conditions)), repr(given)
        if key not in self._cached:
            readers = [(use, name) for name in variables for use in self._uses.of.get(name, ())]
            readers += [(use, field_name(dotted)) for use in conditions]
            self._cached[key] = self._cases(domain, readers, given, dotted)
        cases, notes = self._cached[key]
        self.sampled |= dict.fromkeys(notes)
        return list(cases)

    def _cases(
        self, domain: Domain, readers: list[Reader], given: Mapping[str, Any], what: str
    ) -> tuple[list[Case], list[str]]:
        """Return values, each of another effect, and what is not followed."""
        notes: dict[str, None] = {}
        candidates = [
            Case(value) for value in self._candidates(domain, readers, given, what, notes)
        ]
        candidates += [Case(value, self._extreme_faults, True) for value in domain.unusual]
        cases: dict[Any, Case] = {}
        for case in candidates:
            cases.setdefault(self._effect(case.value, readers, given), case)
        if len(cases) == 1:
            return [Case(domain.default)], [] if domain.kind == "list" else list(notes)
        return list(cases.values()), list(notes)

    def _candidates(
        self,
        domain: Domain,
        readers: list[Reader],
        given: Mapping[str, Any],
        what: str,
        notes: dict[str, None],
    ) -> Iterator[Any]:
        yield domain.default
        line = domain.line
        if line is not None:
            spans, samples = self._spans(line, readers, given, what, notes)
            yield from (line.representative(span) for span in spans)
            yield from (
                value for value in samples if line.at(line.first) <= value <= line.at(line.last)
            )
        elif domain.kind == "bool":
            yield not domain.default
        elif domain.kind == "text":
            texts = sorted(
                {text for use, _ in self._reached(readers) for text in texts_in(use.root)}
            )
            texts += [
                value
                for use, _ in self._reached(readers)
                for name in names_in(use.root)
                for value in self._texts_of(name, given)
            ]
            yield from texts
            yield next(
                other for number in range(99) if (other := OTHER_TEXT + "_" * number) not in texts
            )
            self._note_unfollowed(readers, given, what, notes)
        elif domain.kind == "list":
            yield from self._lists(domain, readers, what, notes)
        elif readers:
            for use, _ in readers:
                notes[f"'{what}' in {use.shown}: values of its type are not known"] = None

    def _texts_of(self, name: str, given: Mapping[str, Any]) -> list[str]:
        values = [given[name]] if name in given else self._uses.fixed.get(name, [])
        return [value for value in values if isinstance(value, str)]

    def _reached(self, readers: Iterable[Reader]) -> list[Reader]:
        """Return expressions, and those of the variables that they are assigned to."""
        known: dict[tuple[int, str], Reader] = {}
        waiting = list(readers)
        while waiting:
            use, name = waiting.pop()
            if (id(use), name) in known:
                continue
            known[id(use), name] = use, name
            waiting += [(entry, use.target) for entry in self._uses.of.get(use.target, ())]
        return list(known.values())

    def _lists(
        self, domain: Domain, readers: list[Reader], what: str, notes: dict[str, None]
    ) -> Iterator[Any]:
        item = domain.item or Domain("other", None)
        elements: list[Any] = [item.default]
        if item.kind != "other":
            targets = {use.target for use, _ in readers if use.kind == "elements"}
            elements += [case.value for name in targets for case in self.of(item, name)]
            numbers = [number for use, _ in readers for number in numbers_in(use.root)]
            line = item.line
            if line is not None:
                near = {number + step for number in numbers for step in (-1, 0, 1)}
                whole = int if item.kind == "integer" else float
                elements += [whole(value) for value in sorted(near)]
        counts = {0, 1, 2, 3}
        counts |= {
            int(number) + step
            for use, _ in readers
            for number in numbers_in(use.root)
            for step in (0, 1)
            if 0 <= number < MOST_ELEMENTS
        }
        if domain.size is not None:
            counts = {domain.size}
        elif domain.most_items is not None:
            counts = {count for count in counts if count <= domain.most_items}
        for count in sorted(counts):
            for element in elements if count else elements[:1]:
                yield [element] * count
            if count > 1 and len(elements) > 1:
                yield list(islice((entry for _ in range(count) for entry in elements), count))
        for use, _ in readers:
            if use.kind != "plain" or not use.is_whole:
                lengths = ", ".join(map(str, sorted(counts)))
                notes[f"'{what}' in {use.shown}: lists of {lengths} elements"] = None

    def _note_unfollowed(
        self, readers: list[Reader], given: Mapping[str, Any], what: str, notes: dict[str, None]
    ) -> None:
        for use, name in readers:
            try:
                self._effect_of(use, name, None, given, ())
            except UnfollowedError:
                notes[f"'{what}' in {use.shown}"] = None

    # ---- numbers -----------------------------------------------------------------------------

    def _spans(
        self,
        line: Line,
        readers: list[Reader],
        given: Mapping[str, Any],
        what: str,
        notes: dict[str, None],
    ) -> tuple[list[tuple[int, int]], list[Any]]:
        """Return the regions of a number, and samples where it is not followed."""
        begins = {line.first}
        samples: list[Any] = []
        for use, name in readers:
            try:
                begins |= self._begins(line, use, name, given, ())
            except UnfollowedError:
                notes[f"'{what}' in {use.shown}"] = None
                near = {
                    number * sign + step
                    for number in numbers_in(use.root)
                    for sign in (1, -1)
                    for step in (-1, 0, 1)
                }
                whole = int if line.is_whole else float
                samples += [whole(value) for value in sorted(near | {-1, 0, 1, 100, -100})]
            if any(entry.kind == "number" for entry, _ in self._reached([(use, name)])):
                for entry, _ in self._reached([(use, name)]):
                    if entry.kind == "number":
                        notes[f"'{what}' in {entry.shown}: lengths and counts"] = None
        edges = sorted(begins)
        return list(
            zip(edges, [*(edge - 1 for edge in edges[1:]), line.last], strict=True)
        ), samples

    def _begins(
        self, line: Line, use: Use, name: str, given: Mapping[str, Any], above: tuple[str, ...]
    ) -> set[int]:
        """Return the positions at which the effect of a number changes. Raises UnfollowedError."""
        begins: set[int] = set()
        for others in self._others(use, name, given):
            splitter = Splitter(line, name, others)
            for atom in atoms_of(use, name, others):
                splitter.follow(atom)
                if atom is use.root or use.kind == "sent":
                    for number in self._levels(use, above):
                        splitter.level(atom, number)
            begins |= {first for first, _ in splitter.spans}
        return begins

    def _levels(self, use: Use, above: tuple[str, ...]) -> list[float]:
        """Return the numbers at which the effect of the value of an expression changes."""
        match use.kind:
            case "flow":
                return self._borders_of(use, above)
            case "sent":
                return list(use.ends_of_field)
            case "number":
                rule = use.rule
                assert rule is not None
                ends = [end for end in (rule.least, rule.most) if math.isfinite(end)]
                numbers: Sequence[float] = DISTINCT_ROUNDS if rule.whole else self._uses.times
                return [*ends, *numbers]
        return []

    def _borders_of(self, use: Use, above: tuple[str, ...]) -> list[float]:
        """Return the numbers at which the effect of a variable changes."""
        name = use.target
        if name in above:
            if use.is_whole:
                return []
            raise UnfollowedError
        if name not in self._borders or above:
            begins: set[int] = set()
            for entry in self._uses.of.get(name, ()):
                begins |= self._begins(DOUBLES, entry, name, {}, (*above, name))
            numbers = [DOUBLES.at(begin) for begin in sorted(begins) if begin != DOUBLES.first]
            if above:
                return numbers
            self._borders[name] = numbers
        borders: list[float] = self._borders[name]
        return borders

    def _others(self, use: Use, name: str, given: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
        """Yield the known values of the other names of an expression. Raises UnfollowedError."""
        names = [other for other in sorted(names_in(use.root)) if other != name]
        known = {
            other: [given[other]] if other in given else self._uses.fixed[other]
            for other in names
            if other in given or other in self._uses.fixed
        }
        if math.prod(map(len, known.values())) > MOST_FIXED:
            raise UnfollowedError
        for values in product(*known.values()):
            yield dict(zip(known, values, strict=True))

    # ---- effects -----------------------------------------------------------------------------

    def _effect(self, value: Any, readers: list[Reader], given: Mapping[str, Any]) -> Any:
        """Return what tells a value from others: what is made of it where it is read."""
        effects = []
        for use, name in readers:
            try:
                effects.append(self._effect_of(use, name, value, given, ()))
            except UnfollowedError:
                effects.append(("a sample", repr(value)))
        return tuple(effects)

    def _effect_of(
        self, use: Use, name: str, value: Any, given: Mapping[str, Any], above: tuple[str, ...]
    ) -> Any:
        effects = []
        for others in self._others(use, name, given):
            for atom in atoms_of(use, name, others):
                result = evaluated(atom, name, value, others)
                effects.append(self._seen(use, result, above, is_whole=atom is use.root))
        return tuple(effects)

    def _seen(self, use: Use, result: Any, above: tuple[str, ...], *, is_whole: bool) -> Any:
        if result is FAILED:
            return "an error"
        if use.kind == "condition" or (not is_whole and use.kind != "sent"):
            return result if isinstance(result, bool) else "no condition"
        match use.kind:
            case "flow":
                return self._effect_on(use, result, above)
            case "number":
                return self._length_of(use, result)
            case "elements":
                return repr(result)
            case "sent" if not use.is_sent(result):
                return "refused"
        return ""

    def _length_of(self, use: Use, result: Any) -> Any:
        rule = use.rule
        assert rule is not None
        if not rule.allows(result):
            return "refused"
        numbers: Sequence[float] = DISTINCT_ROUNDS if rule.whole else self._uses.times
        return tuple((result > number) - (result < number) for number in numbers)

    def _effect_on(self, use: Use, result: Any, above: tuple[str, ...]) -> Any:
        """Return the effect of a value on what reads the variable that it is assigned to."""
        name = use.target
        if name in above:
            if use.is_whole:
                return ""
            raise UnfollowedError
        return tuple(
            self._effect_of(entry, name, result, {}, (*above, name))
            for entry in self._uses.of.get(name, ())
        )

    # ---- draws -------------------------------------------------------------------------------

    def _draw_cases(self, uses: list[Use]) -> tuple[list[float], list[str]]:
        readers: list[Reader] = [(use, DRAW) for use in uses]
        draws = sum(_draws_in(use.root) for use in uses)
        notes: dict[str, None] = {}
        spans, _ = self._spans(DRAWN, readers, {}, "the draw", notes)
        values = dict.fromkeys(DRAWN.representative(span) for span in spans)
        draw_of: dict[Any, float] = {}
        for value in (0.5, *values):
            draw_of.setdefault(self._effect(value, readers, {}), value)
        is_told = len(draw_of) > 1
        if draws > 1 and is_told:
            notes |= dict.fromkeys(f"the draws in {use.shown}: several together" for use in uses)
        if notes:
            draw_of |= {"first": DRAWN.at(DRAWN.first), "last": DRAWN.at(DRAWN.last)}
        return list(dict.fromkeys(draw_of.values())), list(notes)


def _draws_in(root: Any) -> int:
    return int(getattr(root, "draws", False) is True) + sum(map(_draws_in, root.parts))


def more_words(fields: Mapping[str, Any]) -> str:
    """Return the values of fields, for people."""
    return "".join(f", {name} = {value!r}" for name, value in fields.items())


def _combinations(parts: Mapping[str, Sequence[Case]]) -> Iterator[Message]:
    """Yield messages: first those in which one field alone is unusual; a bounded number."""
    names = list(parts)
    if math.prod(map(len, parts.values())) <= MOST_COMBINATIONS:
        chosen: Iterable[tuple[Case, ...]] = product(*parts.values())
    else:
        first = tuple(cases[0] for cases in parts.values())
        singles = (
            (*first[:index], case, *first[index + 1 :])
            for index, cases in enumerate(parts.values())
            for case in cases
        )
        chosen = islice(dict.fromkeys(chain(singles, product(*parts.values()))), MOST_COMBINATIONS)
    for cases in chosen:
        fields = dict(zip(names, [case.value for case in cases], strict=True))
        is_extreme = any(case.is_extreme for case in cases)
        yield Message(fields, sum(case.faults for case in cases), is_extreme)


def assign(message: Any, fields: Mapping[str, Any]) -> Any:
    """Return a message after its fields, by dotted names, have got these values."""
    for dotted, value in fields.items():
        *path, last = dotted.split(".")
        part = message
        for name in path:
            part = getattr(part, name)
        setattr(part, last, value)
    return message


def default_fields(message: Any, names: Iterable[str]) -> dict[str, Any]:
    """Return the values of these fields, by dotted names; of those that it has."""
    collected = {}
    for name in names:
        try:
            collected[name] = read_field(message, name)
        except AttributeError:
            continue
    return collected
