"""Plans of faults: which ones go wrong together, in files of their own."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from bt_mission.core.diagnostics import Diagnostic, InputError, describe, quoted
from bt_mission.core.yaml.document import Document, read
from bt_mission.scenarios.faults import FaultReader

EXAMPLE = "'faults: [at 5.0: drop scan lasting 2]' or 'plans: {blind: [...], slow: [...]}'"


def read_fault_plans(paths: Sequence[Path]) -> dict[str, list[Any]]:
    """Read plans of faults; each point of a sweep is run with each of them.

    A file has either one plan, ``faults``, which is called after the file, or several with names,
    ``plans``. Faults are written as in a scenario file.

    Raises:
        InputError: With everything that is wrong in a file, or a name that is there twice.
    """
    plans: dict[str, list[Any]] = {}
    for path in paths:
        for name, faults in _plans_in(read(path)).items():
            if name in plans:
                message = f"a plan {quoted(name)} is there already"
                raise InputError([Diagnostic(message, str(path))])
            plans[name] = faults
    return plans


def _plans_in(document: Document) -> dict[str, list[Any]]:
    data = document.data
    if isinstance(data, dict) and set(data) == {"faults"}:
        return {Path(document.file).stem: _faults(document, ("faults",), data["faults"])}
    if isinstance(data, dict) and set(data) == {"plans"} and isinstance(data["plans"], dict):
        if not data["plans"]:
            raise InputError([document.fault(("plans",), f"expected plans: {EXAMPLE}")])
        return {
            str(name): _faults(document, ("plans", name), faults)
            for name, faults in data["plans"].items()
        }
    raise InputError([document.fault((), f"expected {EXAMPLE}, got {describe(data)}")])


def _faults(document: Document, path: tuple[str, ...], written: Any) -> list[Any]:
    if not isinstance(written, list):
        message = f"expected a list of faults, got {describe(written)}"
        raise InputError([document.fault(path, message)])
    reader = FaultReader(document)
    for number, one in enumerate(written):
        reader.fault(one, (*path, number))
    if reader.wrong:
        raise InputError(reader.wrong)
    return written
