"""How long the forward legs of explore.yaml are that a condition cuts at 2 m, by the true pose.

Run it as: python benchmarks/legs.py [--seeds N] [--world NAME]
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import tempfile
from itertools import pairwise
from pathlib import Path
from typing import Any

from measuring import figure

from bt_mission.sessions.drive import drive
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.views.terminal.speech import Speech


def cut_legs(seed: int, world: str) -> list[float]:
    """True lengths of the legs that were cancelled at 2 m, m."""
    mission = load(Path("missions/explore.yaml"), seed=seed, world=world)
    events: list[dict[str, Any]] = []
    with (
        tempfile.TemporaryDirectory() as folder,
        Stage(mission, image_folder=Path(folder), say=lambda _: None) as stage,
    ):
        stage.trace.lines.subscribe(lambda line: events.append(json.loads(line)))
        drive(stage, [Speech()])
    poses = [event for event in events if event["event"] == "pose"]
    legs = [e for e in events if e["event"] == "status" and e["node"] == "drive"]
    return [
        sum(
            math.hypot(b["x"] - a["x"], b["y"] - a["y"])
            for a, b in pairwise(p for p in poses if start["t"] <= p["t"] <= end["t"])
        )
        for start, end in zip(legs[::2], legs[1::2], strict=True)
        if end["message"].startswith("canceled by condition")
    ]


def main() -> None:
    """Measure, and print median and worst."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--world", default="empty_arena")
    options = parser.parse_args()
    legs = [leg for seed in range(options.seeds) for leg in cut_legs(seed, options.world)]
    if not legs:
        raise SystemExit("no leg was long enough to be cut")
    figure("legs cut at 2 m", legs, "m")
    print(
        f"{len(legs)} legs cut at 2 m in {options.world}, {options.seeds} seeds: "
        f"median {statistics.median(legs):.4f} m, longest {max(legs):.4f} m; "
        "one control step at 0.2 m/s is 0.0100 m, braking at 1 m/s^2 0.0200 m"
    )


if __name__ == "__main__":
    main()
