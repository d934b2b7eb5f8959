"""A stage that is closed gives its ports back at once: a domain has room for 120 participants."""

from __future__ import annotations

import gc
from pathlib import Path

from bt_mission.testing.stages import Stages

TURNS = "mission: turns\ntree: {turn: {angle: 9}, timeout: 9}\n"


def open_sockets() -> int:
    """Sockets that this process has; a DDS participant has five."""
    targets = (link.readlink() for link in Path("/proc/self/fd").iterdir() if link.is_symlink())
    return sum(str(target).startswith("socket:") for target in targets)


def test_closed_stages_hold_no_sockets(tmp_path: Path) -> None:
    """Without the help of the garbage collector, which may not come by for long."""

    def use_a_stage() -> None:
        stages = Stages(tmp_path)
        stages.run(TURNS).until_done()
        stages.close()

    use_a_stage()  # what the first one makes stays for the process
    gc.collect()
    gc.disable()
    try:
        before = open_sockets()
        for _ in range(3):
            use_a_stage()
        assert open_sockets() <= before
    finally:
        gc.enable()
