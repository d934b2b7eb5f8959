"""From the element of a leaf to the node that a YAML file would have."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from bt_mission.btcpp import parts
from bt_mission.btcpp.attributes import FaultReport, read_reference, read_text, read_value
from bt_mission.btcpp.elements import Attribute, Element
from bt_mission.btcpp.leaves import OUT, TEXTS, LeafElement
from bt_mission.btcpp.parts import At, Entry, LocatedValue
from bt_mission.core.diagnostics import did_you_mean, listed, quoted

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


@dataclass
class _Fields:
    """Fields of a message as they are gathered."""

    at: At
    parts: dict[str, tuple[At, LocatedValue | _Fields]] = field(default_factory=dict)

    def put(self, path: tuple[str, ...], at: At, part: LocatedValue) -> bool:
        """Put a value at a path; return whether that place was free."""
        name, *rest = path
        if not rest:
            if name in self.parts:
                return False
            self.parts[name] = (at, part)
            return True
        _, inner = self.parts.setdefault(name, (at, _Fields(at)))
        return isinstance(inner, _Fields) and inner.put(tuple(rest), at, part)

    def part(self) -> LocatedValue:
        """Return the mapping."""
        return parts.mapping(
            self.at,
            [
                (name, at, inner.part() if isinstance(inner, _Fields) else inner)
                for name, (at, inner) in self.parts.items()
            ],
        )


@dataclass
class _Gathered:
    """What the attributes of one leaf say."""

    fields: _Fields
    whole: LocatedValue | None = None
    settings: list[Entry] = field(default_factory=list)
    named: list[Entry] = field(default_factory=list)
    modifiers: list[Entry] = field(default_factory=list)
    outputs: list[Entry] = field(default_factory=list)


def read_leaf(leaf: LeafElement, element: Element, report: FaultReport) -> LocatedValue:
    """Return a leaf as the node of a mission; what is wrong with it is reported."""
    at = (element.line, element.column)
    for child in element.children:
        report((child.line, child.column), f"<{element.tag}> is a leaf, with nothing in it", None)
    found = _Gathered(_Fields(at))
    for attribute in element.attributes.values():
        _take(leaf, attribute, found, report)
    entries = [(leaf.kind, at, _value(leaf, found, at, report)), *found.modifiers]
    if leaf.whole and found.named:
        entries.append(("inputs", found.named[0][1], parts.mapping(at, found.named)))
    if found.outputs:
        entries.append(("outputs", found.outputs[0][1], parts.mapping(at, found.outputs)))
    return parts.mapping(at, entries)


def _value(leaf: LeafElement, found: _Gathered, at: At, report: FaultReport) -> LocatedValue:
    if leaf.whole is not None:
        if found.whole is None:
            report(at, f"the attribute '{leaf.whole}' is missing", None)
            return parts.scalar("", at)
        return found.whole
    if leaf.is_short:
        return found.fields.part()
    if leaf.named:
        return parts.mapping(at, found.named)
    entries = found.settings
    if leaf.fields is not None and found.fields.parts:
        entries = [*entries, (leaf.fields, at, found.fields.part())]
    return parts.mapping(at, entries)


def _take(leaf: LeafElement, attribute: Attribute, found: _Gathered, report: FaultReport) -> None:
    name, at = attribute.name, (attribute.line, attribute.column)
    path = leaf.field_path(name)
    if name == "name":
        found.modifiers.append((name, at, parts.text(attribute.value, attribute)))
    elif name == leaf.whole:
        found.whole = _said(attribute, report)
    elif name in leaf.settings:
        found.settings.append((leaf.settings[name], at, _said(attribute, report)))
    elif name in leaf.modifiers:
        found.modifiers.append((name, at, _said(attribute, report)))
    elif leaf.gives and name.startswith(OUT):
        found.outputs.append((leaf.output_name(name), at, variable(attribute, report)))
    elif leaf.named and name.startswith(leaf.named) and _NAME.fullmatch(name, len(leaf.named)):
        found.named.append((name.removeprefix(leaf.named), at, read_value(attribute, report)))
    elif path is not None:
        if not found.fields.put(path, at, read_value(attribute, report)):
            report(at, f"the field {quoted('.'.join(path))} is given twice", None)
    else:
        refuse_attribute(attribute, leaf.kind, leaf.known, report)


def _said(attribute: Attribute, report: FaultReport) -> LocatedValue:
    read = read_text if attribute.name in TEXTS else read_value
    return read(attribute, report)


def variable(attribute: Attribute, report: FaultReport) -> LocatedValue:
    """Return the name of the variable that an attribute such as `out_x="{name}"` holds."""
    found = read_reference(attribute)
    at = (attribute.value_line, attribute.value_column)
    if found is None:
        message = f"expected a variable such as '{{name}}', got {quoted(attribute.value)}"
        report(at, message, None)
        return parts.scalar("_", at)
    return parts.scalar(found.data.removeprefix("$"), at)


def refuse_attribute(
    attribute: Attribute, tag: str, known: tuple[str, ...], report: FaultReport
) -> None:
    """Report an attribute that an element does not take."""
    at, name = (attribute.line, attribute.column), attribute.name
    if name.startswith("_"):
        report(at, f"the attribute {quoted(name)} has no counterpart", _instead(name))
        return
    message = f"no attribute {quoted(name)} for {tag} (it takes: {listed(known)})"
    report(at, message, did_you_mean(name, known))


def _instead(name: str) -> str:
    if name == "_autoremap":
        return 'name each port: x="{x}"'
    if name == "_description":
        return "use 'name', or a comment"
    return "use nodes instead: ScriptCondition, Script, Precondition, WhileDoElse"
