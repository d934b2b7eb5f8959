"""Pictures of a MuJoCo model, drawn by its classic renderer on EGL, without a screen or a GPU.

They are drawn in this process: every way of lacking EGL that was tried (no library, no driver, no
device) raises an exception and leaves the process alive.
"""

from __future__ import annotations

import os
from functools import cache
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from bt_mission.base.errors import BtMissionError

Image = npt.NDArray[np.uint8]


class NoCameraError(BtMissionError):
    """No picture can be drawn on this machine."""

    code = "BT-810"


class Canvas:
    """Draws a model from any point of view: 8-bit RGB, `height` x `width` x 3, top row first.

    `view` and `options` are MuJoCo's, to be set before a picture. Pictures may be as large as the
    model's off-screen buffer is when the canvas is made. Raises NoCameraError where there is no
    EGL.
    """

    def __init__(self, model: mujoco.MjModel, *, shadows: bool = False) -> None:
        self._model = model
        try:
            self._gl = _gl_context()
            self._gl.make_current()
            self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100.value)
        # PyOpenGL and the bindings raise ImportError, AttributeError, RuntimeError, EGLError or
        # FatalError, depending on what is missing; none of them may stop a run without images.
        except Exception as error:
            raise NoCameraError(
                "EGL cannot be used on this machine"
                f" ({type(error).__name__}: {_first_line(error)});"
                " install it with: apt-get install libegl1 libgl1-mesa-dri libopengl0"
            ) from error
        self._scene = mujoco.MjvScene(model, maxgeom=model.ngeom + 100)
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = shadows
        self._scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = False
        self.options = mujoco.MjvOption()
        self.view = mujoco.MjvCamera()

    def draw(self, data: mujoco.MjData, out: Image) -> None:
        """Draw into `out`, whose size is the picture's; positions in `data` must be current."""
        self._gl.make_current()
        mujoco.mjv_updateScene(
            self._model,
            data,
            self.options,
            None,
            self.view,
            mujoco.mjtCatBit.mjCAT_ALL.value,
            self._scene,
        )
        height, width, _ = out.shape
        rect = mujoco.MjrRect(0, 0, width, height)
        pixels = np.empty_like(out)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self._context)
        mujoco.mjr_render(rect, self._scene, self._context)
        mujoco.mjr_readPixels(pixels, None, rect, self._context)
        out[:] = pixels[::-1]  # OpenGL's first row is the lowest

    def close(self) -> None:
        """Give the renderer back. Nothing can be drawn afterwards."""
        self._gl.make_current()
        self._context.free()


@cache
def _gl_context() -> Any:
    """Return the GL context of this process; all canvases draw in it, on one thread.

    It is kept: what Mesa compiles for a new one takes as long as eighty images.
    """
    # Mesa's software renderer hands even a small picture round to a thread for every core: on a
    # busy machine waiting for them costs more than the picture.
    os.environ.setdefault("LP_NUM_THREADS", "1")
    # Loads the system's libEGL: only when an image is needed.
    from mujoco.egl import GLContext  # noqa: PLC0415

    return GLContext(0, 0)  # the size is that of the buffer in the model


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or ["no reason given"])[0][:200]
