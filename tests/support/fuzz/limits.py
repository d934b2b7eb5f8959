"""Limits of time and memory around one case, and what is found when it goes beyond them."""

from __future__ import annotations

import re
import resource
import signal
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from types import FrameType

from tests.support.fuzz import verdict
from tests.support.fuzz.finding import Finding, Verdict, crash

CPU_S = 10.0
"""What one case may take of the processor, s."""

MEMORY_MB = 200
"""What one case may take of memory, beyond what the process had before it."""

_THE_PEAK = "5"
"""What `/proc/PID/clear_refs` is told to reset; see proc_pid_clear_refs(5)."""


class OutOfTime(BaseException):
    """A case took too long; no `except Exception` holds it up."""


def _out_of_time(_signal: int, _frame: FrameType | None) -> None:
    raise OutOfTime


def resident_mb() -> float:
    """Return the memory that this process has now."""
    return _memory_mb("VmRSS")


def peak_mb() -> float:
    """Return the most memory that this process has had at a time since the peak was forgotten."""
    return _memory_mb("VmHWM")


def _memory_mb(what: str) -> float:
    status = Path("/proc/self/status").read_text(encoding="ascii")
    match = re.search(rf"{what}:\s*(\d+) kB", status)
    return int(match[1]) / 1024 if match else 0.0


def forget_peak() -> None:
    """Have `peak_mb` begin anew, with what this process has now.

    A kernel that does not let itself be asked leaves the peak of the process' life: what a case
    takes beneath that is then not seen, which is little where the process does nothing else.
    """
    with suppress(OSError):
        Path("/proc/self/clear_refs").write_text(_THE_PEAK, encoding="ascii")


def limit_memory() -> None:
    """Have this process get no more than twice what a case may take; the machine stays usable."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    size = pages * resource.getpagesize() + 2 * MEMORY_MB * 2**20
    resource.setrlimit(resource.RLIMIT_AS, (size, resource.RLIM_INFINITY))


def limit_processor() -> None:
    """End this process where a case holds the interpreter up, so that it hears no signal."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    seconds = int(used.ru_utime + used.ru_stime + 3 * CPU_S)
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, resource.RLIM_INFINITY))


def judge_within(
    path: Path, cpu_s: float = CPU_S, judge: Callable[[Path], Verdict] = verdict.judge
) -> Verdict:
    """Judge a case; an exception, too much time and too much memory are findings."""
    forget_peak()
    had_mb = peak_mb()
    before = signal.signal(signal.SIGVTALRM, _out_of_time)
    signal.setitimer(signal.ITIMER_VIRTUAL, cpu_s)
    try:
        judged = judge(path)
    except OutOfTime as error:
        what = f"more than {cpu_s:g} s of the processor"
        judged = Verdict(accepted=False, finding=Finding(what, _way(error)))
    except MemoryError as error:
        what = f"more than {2 * MEMORY_MB} MB"
        judged = Verdict(accepted=False, finding=Finding(what, _way(error)))
    except Exception as error:  # noqa: BLE001 - whatever comes out here is what is looked for
        judged = Verdict(accepted=False, finding=crash(error))
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)
    taken_mb = peak_mb() - had_mb
    if judged.finding is None and taken_mb > MEMORY_MB:
        finding = Finding(f"more than {MEMORY_MB} MB", f"{taken_mb:.0f} MB")
        return replace(judged, finding=finding)
    return judged


def _way(error: BaseException) -> str:
    """Return where it was, from the outside in."""
    frames = []
    trace = error.__traceback__
    while trace:
        frames.append(f"{Path(trace.tb_frame.f_code.co_filename).name}:{trace.tb_lineno}")
        trace = trace.tb_next
    return " > ".join(frames[-25:])
