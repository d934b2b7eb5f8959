"""What programs import: the names are there, documented, and cost nothing until they are used."""

from __future__ import annotations

import ast
import importlib
import inspect
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import bt_mission
import bt_mission.testing
from bt_mission.base.lazy import lazy_names

PACKAGES = {"bt_mission": bt_mission, "bt_mission.testing": bt_mission.testing}
HEAVY = ("rclpy", "mujoco", "pydantic", "numpy", "yaml", "py_trees", "rich", "textual")
SQUARE = "mission: square\ninputs: {speed: 0.1}\ntree: {wait: 0.1}\n"


@pytest.mark.parametrize(
    ("package", "name"), [(p, n) for p, module in PACKAGES.items() for n in module.__all__]
)
def test_every_public_name_is_there_and_documented(package: str, name: str):
    """Also for `dir`, and so for completion in an editor."""
    module = PACKAGES[package]
    assert name in dir(module)
    if name != "__version__":
        assert inspect.getdoc(getattr(module, name))


@pytest.mark.parametrize("package", PACKAGES)
def test_the_type_checker_knows_the_same_names(package: str):
    """Those that are loaded late are imported for it from the modules that define them."""
    module = PACKAGES[package]
    (block,) = (
        node
        for node in ast.parse(inspect.getsource(module)).body
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
    )
    known: dict[str, Any] = {}
    for node in block.body:
        if isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                known[alias.asname or alias.name] = getattr(
                    importlib.import_module(node.module), alias.name
                )
    names = [name for name in module.__all__ if name != "__version__"]
    assert {name: getattr(module, name) for name in names} == known


def test_importing_loads_neither_ros_nor_the_simulation():
    """Nor anything else that takes long; a fresh process says so."""
    code = "import bt_mission, bt_mission.testing, json, sys; print(json.dumps(list(sys.modules)))"
    done = subprocess.run(
        [sys.executable, "-I", "-c", f"import sys; sys.path[:0] = {sys.path!r}; {code}"],
        capture_output=True,
        text=True,
        check=True,
    )
    loaded = {name.partition(".")[0] for name in json.loads(done.stdout)}
    assert loaded.isdisjoint(HEAVY)


def test_an_unknown_name_is_an_attribute_error():
    """As of any module."""
    with pytest.raises(AttributeError, match="module 'bt_mission' has no attribute 'lode'"):
        bt_mission.lode  # noqa: B018 - it is the reading that raises


def test_a_name_is_loaded_once(monkeypatch: pytest.MonkeyPatch):
    """Then it is an attribute like any other."""
    module = type(sys)("made_up")
    monkeypatch.setitem(sys.modules, "made_up", module)
    find = lazy_names("made_up", {"Note": "bt_mission.base.diagnostics:Diagnostic"})
    assert find("Note") is bt_mission.Diagnostic
    assert module.__dict__["Note"] is bt_mission.Diagnostic


def test_a_mission_is_loaded_and_checked(tmp_path: Path):
    """By the names of the package alone."""
    file = tmp_path / "square.yaml"
    file.write_text(SQUARE)
    mission = bt_mission.load(file, set={"speed": 0.2})
    assert isinstance(mission, bt_mission.Mission)
    assert dict(mission.inputs) == {"speed": 0.2}
    assert bt_mission.examine(file, set={"speed": 0.2}) == (mission, mission.warnings)
    assert bt_mission.load(SQUARE).name == "square"
    with pytest.raises(bt_mission.BtMissionError, match=r"suffix \.yaml, \.yml"):
        bt_mission.convert("square.txt")


def test_a_run_on_the_stage_is_recorded_and_read(tmp_path: Path):
    """A stage of one robot; the recording knows its end."""
    mission = bt_mission.load(SQUARE)
    with (
        bt_mission.Stage(mission, image_folder=tmp_path, say=lambda _: None) as stage,
        bt_mission.record(stage, tmp_path / "run.mcap") as recorder,
    ):
        while not stage.is_done:
            stage.step()
        recorder.finish(stage.runner.report().as_dict())
    run = bt_mission.read_recording(tmp_path / "run.mcap")
    assert run.summary["status"] == "success"
