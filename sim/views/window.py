"""MuJoCo's viewer, for people at a screen.

It has a thread, and lets people drag things. So it gets a separate model and state, in which the
recorded states are shown: the simulation is the same with and without it.
"""

from __future__ import annotations

import os
import threading
import warnings
from typing import Any

import mujoco

from bt_mission.base.errors import BtMissionError
from sim.physics.history import ModelCopy
from sim.physics.physics import Physics

_PATIENCE_S = 5.0
"""The limit of the wait for the thread's end, s of the wall clock."""

DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY")
"""The environment variables of a desktop."""

_SHADOW_MAP = 4096
"""Texels each way."""


class NoDisplayError(BtMissionError):
    """No window can be opened on this machine."""

    code = "BT-907"

    def __init__(self, why: str) -> None:
        super().__init__(
            f"--view: {why}; use `bt-mission watch` in a terminal, or generate a report with "
            f"`bt-mission run MISSION --report FILE.html`"
        )


def check_display() -> None:
    """Try to open a window.

    In the viewer's thread a failure would be a traceback, after which its caller waits forever.
    Raises NoDisplayError.
    """
    if not any(os.environ.get(name) for name in DISPLAYS):
        raise NoDisplayError(f"there is no display here (none of {', '.join(DISPLAYS)} is set)")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # GLFW's binding warns of what is raised here
        try:
            import glfw  # noqa: PLC0415 - loads the system's libraries of windows

            can = glfw.init()
            if can:
                glfw.window_hint(glfw.VISIBLE, glfw.FALSE)
                window = glfw.create_window(64, 64, "", None, None)
                can = bool(window)
                if can:
                    glfw.destroy_window(window)
                glfw.default_window_hints()
            _, why = glfw.get_error()
        except Exception as error:  # any error of a machine without windows
            raise NoDisplayError(f"no window can be opened ({error})") from error
    if not can:
        raise NoDisplayError(f"no window can be opened ({_words(why)})")


class Window:
    """Shows a world and everything in it. Raises NoDisplayError."""

    def __init__(self, physics: Physics) -> None:
        check_display()
        from mujoco import viewer  # noqa: PLC0415 - loads the system's libraries of windows

        self._physics = physics
        self._start_ns = physics.time_ns
        self._copy = ModelCopy(physics.model)
        model = self._copy.model
        model.vis.quality.shadowsize = _SHADOW_MAP
        model.light_castshadow[:] = True
        self._update()
        before = threading.enumerate()
        self._viewer: Any = viewer.launch_passive(
            model, self._copy.data, show_left_ui=False, show_right_ui=False
        )
        self._threads = [thread for thread in threading.enumerate() if thread not in before]
        with self._viewer.lock():
            camera = self._viewer.cam
            camera.lookat[:] = 0.0
            camera.azimuth, camera.elevation = 90.0, -60.0
            camera.distance = 1.3 * max(physics.world.size)
        self._viewer.sync()

    @property
    def is_open(self) -> bool:
        """Whether the window is still open."""
        return bool(self._viewer.is_running())

    def look(self) -> None:
        """Show the present instant."""
        if self.is_open:
            with self._viewer.lock():
                self._update()
            self._viewer.sync()

    def close(self) -> None:
        """Close it, if nobody has, and wait for its thread.

        A process that ends while the thread still draws hangs in the system's libraries.
        """
        self._viewer.close()
        for thread in self._threads:
            thread.join(timeout=_PATIENCE_S)

    def _update(self) -> None:
        state = self._physics.record()
        self._copy.show(state)
        self._copy.data.time = (state.time_ns - self._start_ns) / 1e9
        mujoco.mj_forward(self._copy.model, self._copy.data)


def _words(why: bytes | str | None) -> str:
    text = why.decode(errors="replace") if isinstance(why, bytes) else why
    return text or "GLFW does not say why"
