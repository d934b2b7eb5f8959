"""MuJoCo's own viewer."""

import sys
from contextlib import closing, nullcontext
from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest

from sim.views import window
from sim.views.window import DISPLAYS, NoDisplayError, Window, check_display
from tests.support.simulated import wait

REFUSING = SimpleNamespace(
    init=lambda: False, get_error=lambda: (65550, b"X11: Failed to open display :99")
)


@pytest.mark.parametrize(
    ("variable", "glfw", "expected"),
    [
        (None, None, r"no display here .*bt-mission watch.*--report"),
        ("DISPLAY", REFUSING, r"can be opened \(X11: Failed to open display :99\)"),
        ("WAYLAND_DISPLAY", None, "no window can be opened"),
    ],
    ids=["no display", "a display that does not answer", "no libraries of windows"],
)
def test_without_a_display_the_error_says_what_to_do(
    monkeypatch: pytest.MonkeyPatch, variable: str | None, glfw: Any, expected: str
) -> None:
    """In one line, with what GLFW says of it."""
    for name in DISPLAYS:
        monkeypatch.delenv(name, raising=False)
    if variable:
        monkeypatch.setenv(variable, "99")
    monkeypatch.setitem(sys.modules, "glfw", glfw)
    with pytest.raises(NoDisplayError, match=expected) as raised:
        check_display()
    assert "\n" not in str(raised.value)


class Viewer:
    """Stands in for MuJoCo's: keeps what it is given."""

    def __init__(self, model: Any, data: Any, **_: Any) -> None:
        self.model, self.data = model, data
        self.cam = mujoco.MjvCamera()
        self.synced = 0
        self.open = True

    def lock(self) -> Any:
        return nullcontext()

    def sync(self) -> None:
        self.synced += 1

    def is_running(self) -> bool:
        return self.open

    def close(self) -> None:
        self.open = False


@pytest.fixture
def viewers(monkeypatch: pytest.MonkeyPatch) -> list[Viewer]:
    """The viewers that are opened, on a machine that has a display."""
    opened: list[Viewer] = []

    def launch_passive(*arguments: Any, **options: Any) -> Viewer:
        opened.append(Viewer(*arguments, **options))
        return opened[-1]

    module: Any = SimpleNamespace(launch_passive=launch_passive)
    monkeypatch.setattr(window, "check_display", lambda: None)
    monkeypatch.setattr(mujoco, "viewer", module, raising=False)
    monkeypatch.setitem(sys.modules, "mujoco.viewer", module)
    return opened


def test_it_shows_the_present(simulate, viewers: list[Viewer]) -> None:
    """What stands where, and since when."""
    simulation = simulate()
    with closing(Window(simulation.physics)) as shown:
        for _ in range(20):
            simulation.command(0.2, 0.0)
            wait(simulation, 0.05)
        shown.look()
        (viewer,) = viewers
        assert np.array_equal(viewer.data.qpos, simulation.physics.data.qpos)
        assert viewer.data.time == pytest.approx(1.0)
        assert viewer.synced == 2
    assert not viewer.open


def test_what_people_do_in_it_changes_nothing(simulate, viewers: list[Viewer]) -> None:
    """The viewer has a model and a state of its own."""
    simulation = simulate()
    before = simulation.record()
    with closing(Window(simulation.physics)):
        viewers[0].model.opt.gravity[:] = 0.0
        viewers[0].data.qpos[:] = 7.0
        viewers[0].data.xfrc_applied[:] = 9.0
    assert simulation.physics.model.opt.gravity[2] == pytest.approx(-9.81)
    assert not simulation.physics.data.xfrc_applied.any()
    assert simulation.record() == before


def test_once_people_have_closed_it_nothing_is_shown(simulate, viewers: list[Viewer]) -> None:
    """The simulation goes on."""
    with closing(Window(simulate().physics)) as shown:
        viewers[0].open = False
        shown.look()
        assert not shown.is_open
    assert viewers[0].synced == 1
