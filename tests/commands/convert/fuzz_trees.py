"""BehaviorTree.CPP's and Nav2's XML, mutated and made up, converted to YAML and back, and run."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from random import Random
from xml.etree import ElementTree as ET

from bt_mission.base.diagnostics import Diagnostic, InputError
from bt_mission.base.yaml.document import read_text
from bt_mission.commands.convert import document, xml_format
from bt_mission.commands.convert.mission_writer import mission_xml
from bt_mission.requirements.mission_file import read_mission
from bt_mission.sessions.load import convert, document_of, load
from tests.commands.convert import xml_missions
from tests.commands.convert.btcpp_rules import CHILDREN, PORTS
from tests.support.fuzz import cases, verdict
from tests.support.fuzz.expressions import expression
from tests.support.fuzz.finding import Case, Finding, Verdict
from tests.support.fuzz.targets import Target
from tests.support.missions import meaning
from tests.support.project import ROOT

MADE_SHARE, YAML_SHARE, RUN_SHARE = 0.3, 0.1, 0.2
TO_RUN = "run.xml"
"""A case of this name is judged as a mission: it is checked and run."""
EVERYTHING = ROOT / "tests/commands/convert/everything.xml"
DEEPEST = 6
VALUES = (
    *("0", "1", "-1", "3", "0.5", "500", "true", "false", "{x}", "{y}", "turn", "x; y", "", "-5.0"),
    *("1e999", "nan", "{", "9" * 400, "a := 1; b := a + 1", "x > 2 && y", "0;0;1.57", "é"),
    "json:{}",
)
COMMON = (
    *("name", "_skipIf", "_successIf", "_failureIf", "_while", "_onSuccess", "_post", "_onHalted"),
)


@dataclass(frozen=True)
class Corpus:
    """XML files, and everything that mutated missions begin with."""

    xml: tuple[str, ...]
    missions: cases.Corpus


def corpus() -> Corpus:
    """Read the shipped missions as XML, and one file of everything."""
    return Corpus(xml_missions.texts(cases.FOLDERS[:-1], EVERYTHING), cases.corpus())


def samples(known: Corpus) -> Iterator[Case]:
    """Yield what is sound."""
    for name in ("m.xml", TO_RUN):
        yield from (Case(name, text.encode()) for text in known.xml)


def case(known: Corpus, seed: int, number: int) -> Case:
    """Return a file that is mutated, or made up by the rules."""
    rng = Random(f"{seed}/{number}")
    chance = rng.random()
    if chance < YAML_SHARE:
        return cases.case(known.missions, seed, number)
    if chance < YAML_SHARE + RUN_SHARE:
        contents = xml_missions.mutated(rng, rng.choice(known.xml)).encode("utf-8", "surrogatepass")
        return Case(
            TO_RUN, cases.with_bytes(rng, contents) if chance < YAML_SHARE + 0.01 else contents
        )
    chance -= RUN_SHARE
    text = made(rng) if chance < YAML_SHARE + MADE_SHARE else rng.choice(known.xml)
    if chance >= YAML_SHARE + MADE_SHARE or rng.random() < 0.3:
        text = xml_missions.mutated(rng, text)
    return Case("m.xml", text.encode("utf-8", "surrogatepass"))


def made(rng: Random) -> str:
    """Return a file of nodes of BehaviorTree.CPP and Nav2, with the children they may have."""
    root = ET.Element("root", {"BTCPP_format": rng.choice(("4", "4", "4", "4", "3", ""))})
    names = ("Main", "Sub", "Other")[: rng.randint(1, 3)]
    if rng.random() < 0.9:
        root.set("main_tree_to_execute", rng.choice((*["Main"] * 9, "nobody")))
    for name in names:
        tree = ET.SubElement(root, "BehaviorTree", {"ID": name})
        _grow(rng, tree, 0)
    if rng.random() < 0.3:
        model = ET.SubElement(ET.SubElement(root, "TreeNodesModel"), "SubTree", {"ID": "Sub"})
        kind = rng.choice(("input_port", "output_port", "inout_port"))
        ET.SubElement(model, kind, {"name": rng.choice(("x", "y", "")), "default": "1"})
    return ET.tostring(root, encoding="unicode")


def _grow(rng: Random, parent: ET.Element, depth: int) -> None:
    leaves = [tag for tag, (_, most) in CHILDREN.items() if most == 0]
    inner = [tag for tag in CHILDREN if tag not in leaves]
    tag = rng.choice(leaves if depth >= DEEPEST or rng.random() < 0.4 else inner)
    node = ET.SubElement(parent, tag)
    ports = PORTS.get(tag) or ("ID", "x", "value", "output_key")
    for port in sorted(ports):
        if rng.random() < 0.7:
            node.set(port, _value(rng))
    if tag == "SubTree":
        node.set("ID", rng.choice(("Sub", "Other", "Main", "nobody")))
    if rng.random() < 0.15:
        node.set(rng.choice(COMMON), _value(rng))
    least, most = CHILDREN.get(tag, (0, 0))
    if rng.random() < 0.03:
        least += 1
    for _ in range(rng.randint(least, max(least, min(most or 4, 4) if most != 0 else 0))):
        _grow(rng, node, depth + 1)


def _value(rng: Random) -> str:
    return rng.choice(VALUES) if rng.random() < 0.8 else expression(rng, ("x", "y"))


def judge(path: Path) -> Verdict:
    """Convert a file, or run it."""
    return verdict.judge(path) if path.name == TO_RUN else _converted(path)


def _converted(path: Path) -> Verdict:
    """Convert a file; what comes of it means the same, in both forms."""
    try:
        converted = convert(path)
    except InputError as error:
        return Verdict(accepted=False, finding=_misplaced(error.diagnostics))
    if path.suffix == ".yaml":
        mission, _ = read_mission(document_of(path))
        if mission is None:  # mission_xml reads more than is sound
            return Verdict(accepted=False)
        return _compared(converted, meaning(mission), "XML")
    mission, faults = read_mission(document_of(path))
    if mission is None:
        return Verdict(accepted=False, finding=Finding("converted with faults", str(faults)))
    meant = meaning(mission)
    try:
        again = load(converted)
    except InputError as error:
        return Verdict(True, finding=Finding("YAML that is not read", f"{error}\n{converted}"))
    if meaning(again) != meant:
        return Verdict(True, finding=Finding("YAML means something else", converted))
    ET.fromstring(xml_format.palette(path))  # noqa: S314 - our own
    try:
        xml = mission_xml(read_text(converted, "m.yaml"))
    except InputError as error:
        return Verdict(True, finding=_misplaced(error.diagnostics))
    return _compared(xml, meant, "XML again")


def _compared(xml: str, meant: object, what: str) -> Verdict:
    try:
        mission, faults = read_mission(document.document_of(xml, "m.xml"))
    except InputError as error:
        return Verdict(True, finding=Finding(f"{what} that is not read", f"{error}\n{xml}"))
    if mission is None:
        return Verdict(True, finding=Finding(f"{what} with faults", f"{faults}\n{xml}"))
    if meaning(mission) != meant:
        return Verdict(True, finding=Finding(f"{what} means something else", xml))
    return Verdict(accepted=True)


def _misplaced(faults: tuple[Diagnostic, ...]) -> Finding | None:
    for fault in faults:
        lines = str(fault).split("\n")
        is_whole = "too large" in fault.message or "UTF-8" in fault.message
        if len(lines) not in (1, 3) or (fault.line < 1 and not is_whole):
            return Finding("a fault without a place", str(fault))
    return None


TARGET = Target(corpus, samples, case, judge, cases.prepare)
PLANTED = (
    (xml_format, "XML_FORMAT"),
    replace(xml_format.XML_FORMAT, to_yaml=lambda _: "mission: m\ntree: {wait: 1}\n"),
    "YAML means",
)
"""A fault in the product: what is replaced, by what, and the finding that it leads to."""
