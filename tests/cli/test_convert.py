"""``bt-mission convert`` writes the other form of a file, or says why it cannot."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_mission.cli import main

YAML = "mission: short\n\ntree:\n  sequence:\n    - wait: 0.5\n    - log: done\n"


def test_yaml_becomes_xml_that_runs_and_comes_back(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """'run' takes it as it is; converted back it is the file that it was."""
    yaml, xml, again = (tmp_path / name for name in ("m.yaml", "m.xml", "n.yaml"))
    yaml.write_text(YAML, encoding="utf-8")
    assert main(["convert", str(yaml), "-o", str(xml)]) == 0
    assert capsys.readouterr().out == f"{xml}: written\n"
    assert main(["check", str(xml)]) == 0
    assert capsys.readouterr().out == f"{xml}: mission 'short' is valid (3 nodes)\n"
    assert main(["run", str(xml)]) == 0
    assert "short: success" in capsys.readouterr().out
    assert main(["convert", str(xml), "-o", str(again)]) == 0
    assert again.read_text(encoding="utf-8") == YAML


def test_without_a_file_to_write_it_goes_to_the_terminal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """And nothing else does."""
    xml = tmp_path / "m.xml"
    xml.write_text(
        '<root BTCPP_format="4"><BehaviorTree ID="m"><Sleep msec="5"/></BehaviorTree></root>'
    )
    assert main(["convert", str(xml)]) == 0
    assert capsys.readouterr().out == "mission: m\n\ntree: {wait: 0.005}\n"


def test_a_shipped_mission_is_converted_by_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As `run` and `check` take it; an unknown name is answered with those that are known."""
    monkeypatch.chdir(tmp_path)
    assert main(["convert", "square"]) == 0
    assert '<BehaviorTree ID="square"' in capsys.readouterr().out
    assert main(["convert", "squares"]) == 2
    assert "did you mean 'square'?" in capsys.readouterr().err


def test_what_cannot_be_said_exits_with_2_and_writes_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """All places at once, each with its line and a caret."""
    yaml, xml = tmp_path / "m.yaml", tmp_path / "m.xml"
    yaml.write_text("mission: m\ntree:\n  choose: [{log: a}, {log: b}]\n", encoding="utf-8")
    assert main(["convert", str(yaml), "-o", str(xml)]) == 2
    err = capsys.readouterr().err
    assert err.startswith(f"{yaml}:3:3: error: 'choose': XML has no counterpart; write its nodes")
    assert err.endswith("    choose: [{log: a}, {log: b}]\n      ^\n")
    assert not xml.exists()


@pytest.mark.parametrize("command", ["check", "run", "convert"])
def test_a_file_that_is_no_xml_exits_with_2_and_points_at_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    """No traceback, whatever the file holds."""
    path = tmp_path / "m.xml"
    path.write_text("<root>\n<a", encoding="utf-8")
    assert main([command, str(path)]) == 2
    assert (
        f"{path}:2:1: error: this tag, text or comment is never closed" in capsys.readouterr().err
    )


def test_the_palette_of_a_mission_has_the_ports_that_it_uses(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Beside all that every palette has: of a service of any type they are not known otherwise."""
    port = '<input_port name="request__enabled"/>'
    yaml = tmp_path / "m.yaml"
    service = "{name: /lamp, type: my_msgs/srv/Lamp, request: {enabled: true}}"
    yaml.write_text(f"mission: m\ntree: {{service: {service}}}\n", encoding="utf-8")
    assert main(["convert", "--palette"]) == 0
    plain = capsys.readouterr().out
    assert '<input_port name="request__data"' in plain
    assert port not in plain
    assert main(["convert", "--palette", str(yaml)]) == 0
    assert port in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "expected the file of a mission, or --palette"),
        (["no/such.yaml", "--palette"], "no/such.yaml: error: no such file"),
        (["x.txt"], "x.txt: expected a file with the suffix .yaml, .yml, .xml"),
        (["no/such.xml"], "no/such.xml: error: no such file"),
        (
            ["--palette", "-o", "no/such/folder/x.xml"],
            ": there is no folder no/such/folder",
        ),
    ],
)
def test_wrong_uses_exit_with_2(
    capsys: pytest.CaptureFixture[str], arguments: list[str], words: str
) -> None:
    """And say what was expected."""
    assert main(["convert", *arguments]) == 2
    assert words in capsys.readouterr().err
