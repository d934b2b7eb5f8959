"""`bt-mission convert` writes the other form of a file; its words are in transcripts/."""

from __future__ import annotations

from pathlib import Path

from tests.support.command_line import CommandLine


def test_a_mission_as_xml_comes_back_as_the_file_that_it_was(cli: CommandLine) -> None:
    """`check` and `run` take the XML as it is."""
    yaml = "mission: short\n\ntree:\n  sequence:\n    - wait: 0.5\n    - log: done\n"
    cli.write("m.yaml", yaml)
    cli("convert m.yaml -o m.xml")
    cli("check m.xml")
    cli("run m.xml")
    cli("convert m.xml -o n.yaml")
    assert Path("n.yaml").read_text("utf-8") == yaml


def test_a_shipped_mission_is_converted_by_its_name(cli: CommandLine) -> None:
    """As `run` and `check` take it."""
    assert '<BehaviorTree ID="square"' in cli("convert square")


def test_the_palette_of_a_mission_has_the_ports_that_it_uses(cli: CommandLine) -> None:
    """The palette alone does not know the fields of a service of any type."""
    port = '<input_port name="request__enabled"/>'
    service = "{name: /lamp, type: my_msgs/srv/Lamp, request: {enabled: true}}"
    cli.write("m.yaml", f"mission: m\ntree: {{service: {service}}}\n")
    palette = cli("convert --palette")
    assert '<input_port name="request__data"' in palette
    assert port not in palette
    assert port in cli("convert --palette m.yaml")
