#!/usr/bin/env python3
"""Make docs/images/requirement.png: the margin of a violated requirement against time.

Runs explore.yaml with a requirement that it does not keep, and reads its recording.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib as mpl

from bt_mission.recording.verification import recorded_requirements

mpl.use("Agg")

from matplotlib import pyplot as plt  # after the choice of what draws

ROOT = Path(__file__).resolve().parent.parent
PICTURE = ROOT / "docs" / "images" / "requirement.png"
REQUIREMENT = "requirements:\n  keeps 15 cm: always clearance > 15 cm\n"


def main() -> int:
    """Run the mission, and draw the picture."""
    with TemporaryDirectory() as folder:
        recording, require = Path(folder) / "run.mcap", Path(folder) / "require.yaml"
        require.write_text(REQUIREMENT, encoding="utf-8")
        mission = str(ROOT / "missions" / "explore.yaml")
        options = ["--require", str(require), "--record", str(recording)]
        command = [sys.executable, "-m", "bt_mission", "run", mission, *options]
        found = subprocess.run(command, check=False, cwd=folder)  # noqa: S603 - ourselves
        assert found.returncode == 1, "the requirement was to be violated"
        requirements = recorded_requirements(recording)
    one = next(one for one in requirements if one.result.name == "keeps 15 cm")
    result = one.result
    figure, axes = plt.subplots(figsize=(8, 2.8), layout="constrained")
    lowest = min(one.margins) - 0.05
    axes.plot(one.times, one.margins, color="#2563eb", linewidth=1.5)
    axes.axhspan(lowest, 0, color="#dc2626", alpha=0.12)
    axes.axvline(result.violated_at, color="#dc2626", linestyle=":", label="violation noticed")
    axes.axvline(result.at, color="#111827", linestyle="--", label="the instant that decides")
    axes.set(xlabel="s", ylabel="margin, m", ylim=(lowest, None), title=f"{result}")
    axes.margins(x=0)
    axes.legend(loc="upper right")
    figure.savefig(PICTURE, dpi=110)
    print(PICTURE, f"{PICTURE.stat().st_size / 1e3:.0f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
