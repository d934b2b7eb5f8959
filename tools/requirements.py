"""Print what to install beside the project, from pyproject.toml: `run` or the name of an extra."""

import sys
import tomllib
from pathlib import Path

PROJECT = tomllib.loads(
    Path(__file__).parents[1].joinpath("pyproject.toml").read_text(encoding="utf-8")
)

extra = sys.argv[1]
if extra == "run":  # what the wheel is built with, in the environment itself, and what it needs
    wanted = PROJECT["build-system"]["requires"] + PROJECT["project"]["dependencies"]
else:
    wanted = PROJECT["project"]["optional-dependencies"][extra]
print(*wanted, sep="\n")
