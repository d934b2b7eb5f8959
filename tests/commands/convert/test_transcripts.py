r"""XML, scripts and nodes with what they mean in a mission, or what is wrong with them.

One file of `transcripts` for each. `\n` in an input is a new line. An error has its line, its
column, its message and its hint.
"""

from __future__ import annotations

import json
from collections.abc import Callable

import pytest

from bt_mission.base.diagnostics import InputError
from bt_mission.base.yaml.document import read_text
from bt_mission.commands.convert.document import document_of
from bt_mission.commands.convert.elements import parse
from bt_mission.commands.convert.mission_writer import mission_xml
from bt_mission.commands.convert.scripts import (
    ScriptError,
    assignments,
    from_script,
    to_script,
    written_assignments,
)
from tests.support.transcripts import assert_transcript, transcripts_of


def errors_or(result: Callable[[], str]) -> str:
    """Return a result, or the errors in the input."""
    try:
        return result()
    except InputError as error:
        return "\n".join(
            f"{each.line}:{each.column}: {each.message}" + (f"; {each.hint}" if each.hint else "")
            for each in error.diagnostics
        )
    except ScriptError as error:
        return f"{error.column}: {error.message}" + (f"; {error.hint}" if error.hint else "")


def in_tree(nodes: str, models: str = "") -> str:
    """Return the tree of a file with these nodes, or with these ports of its tree."""
    models = f'<TreeNodesModel><SubTree ID="m">{models}</SubTree></TreeNodesModel>'
    text = f'<root BTCPP_format="4">\n<BehaviorTree ID="m">{nodes}</BehaviorTree>\n{models}</root>'
    return errors_or(lambda: json.dumps(document_of(text, "m.xml").data["tree"]))


def node(line: str) -> str:
    """Return the elements of a node, which begins in line 4."""
    text = line.replace("\\n", "\n  ")
    head = "mission: m\ninputs: {x: 2, places: [[1, 2]], words: w}\ntree:\n"

    def body() -> str:
        xml = mission_xml(read_text(f"{head}  {text}\n", "m.yaml"))
        inside = xml.partition('<BehaviorTree ID="m">\n')[2].partition("  </BehaviorTree>")[0]
        return "".join(part.removeprefix("    ") for part in inside.splitlines(keepends=True))

    return errors_or(body)


def mission(line: str) -> str:
    """Return what of a mission has no counterpart in XML."""
    text = line.replace("\\n", "\n") + "\n"
    return errors_or(lambda: mission_xml(read_text(text, "m.yaml")))


def script(line: str) -> str:
    """Return the other form of an expression, a script, assignments or values."""
    kind, _, text = line.partition(":")
    text = text.removeprefix(" ")
    forms: dict[str, Callable[[], object]] = {
        "expression": lambda: to_script(text) or "no script",
        "script": lambda: from_script(text),
        "assignments": lambda: assignments(text),
        "values": lambda: written_assignments(json.loads(text)) or "no script",
    }
    return errors_or(lambda: str(forms[kind]()))


OUTPUTS: dict[str, Callable[[str], str]] = {
    "elements": lambda line: errors_or(lambda: parse(line.replace("\\n", "\n"), "m.xml").root.tag),
    "files": lambda line: errors_or(lambda: json.dumps(document_of(line, "m.xml").data)),
    "missions": mission,
    "nodes": in_tree,
    "ports": lambda line: in_tree("<AlwaysSuccess/>", line),
    "scripts": script,
    "yaml": node,
}


@pytest.mark.parametrize("path", transcripts_of(__file__), ids=lambda path: path.stem)
def test_every_input_gives_the_output_of_its_transcript(path):
    """A node of the other form, or the errors with their places."""
    assert_transcript(path, OUTPUTS[path.stem])
