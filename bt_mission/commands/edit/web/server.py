"""The server of the editor: requests and answers of its page are JSON objects."""

from __future__ import annotations

import asyncio
import difflib
import json
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket
from typing_extensions import override

from bt_mission.base import files
from bt_mission.base.diagnostics import InputError
from bt_mission.base.errors import BtMissionError
from bt_mission.base.files import kind_of_text
from bt_mission.base.text import lines_of
from bt_mission.base.wall_clock import Stopwatch
from bt_mission.base.yaml.composer import split_lines
from bt_mission.base.yaml.document import MAX_BYTES
from bt_mission.cli.children import ChildCommand, Spare
from bt_mission.commands.edit import patches
from bt_mission.commands.edit.checks import check_text
from bt_mission.commands.edit.completion import completion, definition, hover
from bt_mission.commands.edit.fault_forms import OUTCOMES, fault_kinds, fault_text, scenario_text
from bt_mission.commands.edit.merge import hunks
from bt_mission.commands.edit.new_files import NEW_FILES
from bt_mission.commands.edit.plan import plan_of
from bt_mission.commands.edit.scalars import as_text
from bt_mission.commands.edit.source import Edits, applied
from bt_mission.commands.edit.vocabulary import as_json
from bt_mission.commands.edit.web.marks import boxes, explanation, marks
from bt_mission.commands.edit.web.relay import relay
from bt_mission.commands.edit.web.workspace import ConflictError, EditError, Workspace
from bt_mission.commands.edit.world_patches import SECTIONS, add_thing, move_thing, world_forms
from bt_mission.views.html.pages import render
from bt_mission.views.web.gate import FRAMED_HEADERS
from bt_mission.views.web.server import PageServer, WebOptions

LONGEST_BODY = 8 * MAX_BYTES
"""Of a request: three texts as JSON, in which a line feed takes two bytes."""

MOST_LEFT = 1000
"""Pages that are remembered after they have left a file."""

ASLEEP_S = 4.0
"""Wall time without a message of a page after which it sleeps, or was closed silently."""

MOST_FAULTS = 50
FURTHEST_M = 1e9
"""Of a place that a request names."""
MOST_LINES = 20_000
"""Lines of a text of which differences are shown."""

SPEEDS = ("1", "4", "16")
PROOF_BUDGET = "20s"


class RequestError(BtMissionError):
    """A request that is not one of our page, or whose text is invalid."""

    code = "BT-1302"


class _Turn:
    """What is done one at a time: others are told so, and do not wait."""

    def __init__(self, what: str) -> None:
        self._what = what
        self._is_taken = False

    def __enter__(self) -> None:
        if self._is_taken:
            raise EditError(f"{self._what} is being started or stopped: try again in a moment")
        self._is_taken = True

    def __exit__(self, *_: object) -> None:
        self._is_taken = False


@dataclass
class _Shared:
    """A file that pages have open: one of them edits it, the others follow.

    Another page edits it when a person says so there, or when this one was closed or has opened
    another file; never because it sleeps, since it may have unsaved text.
    """

    leader: str = ""
    text: str | None = None
    seen: Stopwatch = field(default_factory=Stopwatch)


class EditServer(PageServer):
    """Serves the editor of a workspace.

    Args:
        workspace: Its files.
        options: See :class:`PageServer`.
        keeps_ready: Keep a process ready for the next run, so that it starts sooner.
    """

    headers = FRAMED_HEADERS

    def __init__(
        self, workspace: Workspace, options: WebOptions, *, keeps_ready: bool = False
    ) -> None:
        self._workspace = workspace
        self._shared: dict[str, _Shared] = {}
        self._left: deque[tuple[str, str]] = deque(maxlen=MOST_LEFT)
        self._run: ChildCommand | None = None
        self._proof: ChildCommand | None = None
        self._turns = {what: _Turn(what) for what in ("a run", "a proof", "a revision")}
        self._is_closing = False
        self._keeps_ready = keeps_ready and not options.is_read_only
        self._spare: Spare | None = None
        self._folder: Path | None = None
        """That of the recordings, while the editor is served."""
        self._runs = 0
        self._recording: Path | None = None
        """That of the last run."""
        self._watch = render("views/web/page/index.html").encode()
        self._is_read_only = options.is_read_only
        if not options.is_read_only:
            workspace.drop_trials()
        acts: Mapping[str, Callable[[dict[str, Any]], Any]] = {
            "vocabulary": lambda _: _vocabulary(),
            "files": self._list,
            "open": self._open,
            "state": self._state,
            "leave": self._leave,
            "keep": self._keep,
            "drop": self._drop,
            "check": self._check,
            "look": self._look_at,
            "act": _act,
            "complete": self._complete,
            "hover": self._hover,
            "define": _define,
            "explain": lambda asked: {"entry": explanation(_text(asked, "code"))},
            "differ": _differ,
            "save": self._save,
            "merge": _merge,
            "create": self._create,
            "rename": self._rename,
            "delete": self._delete,
            "plan": self._plan,
            "faults": lambda _: {"kinds": fault_kinds()},
            "forms": lambda _: {"forms": world_forms()},
            "fault": _fault,
            "scenario": self._scenario,
            "run": self._start_run,
            "fork": self._start_fork,
            "ran": self._ran,
            "revise": self._revise,
            "prove": self._start_proof,
            "proved": self._proved,
        }
        routes = [
            Route(f"/api/{name}", self._answer(act), methods=["POST"]) for name, act in acts.items()
        ]
        super().__init__(
            render("views/web/page/edit.html"),
            options,
            *routes,
            Route("/run/", self._page_of_run),
            Route("/run/{name}", self._file),
            WebSocketRoute("/run/live", self._live),
        )

    @override
    async def serve(self, until: Callable[[], bool]) -> None:
        """Serve until a condition is true, then end the run and the proof."""
        with TemporaryDirectory(ignore_cleanup_errors=True) as folder:
            self._folder = Path(folder)
            self._get_ready()
            try:
                await super().serve(until)
            finally:
                self._is_closing = True
                for child in (self._run, self._proof):
                    if child is not None:
                        await child.stop()
                if self._spare is not None:
                    await self._spare.drop()

    def _get_ready(self) -> None:
        if self._keeps_ready and self._spare is None:
            self._spare = Spare()

    def _answer(self, act: Callable[[dict[str, Any]], Any]) -> Callable[[Request], Any]:
        async def answer(request: Request) -> Response:
            try:
                given = act(await _body(request))
                facts = await given if asyncio.iscoroutine(given) else given
            except ClientDisconnect:
                return Response(status_code=400)
            except RequestError as error:
                return JSONResponse({"error": str(error), "code": error.code}, status_code=400)
            except RecursionError:
                facts = {"error": "the text is nested too deeply", "code": "BT-103"}
                return JSONResponse(facts, status_code=400)
            except ConflictError as error:
                facts = {"error": str(error), "code": error.code, "theirs": error.theirs}
            except InputError as error:
                facts = {"error": error.on_one_line, "code": error.diagnostics[0].code}
            except BtMissionError as error:
                facts = {"error": str(error), "code": error.code}
            return JSONResponse(facts)

        return answer

    # ---- files ---------------------------------------------------------------------------

    def _list(self, _: dict[str, Any]) -> dict[str, Any]:
        return {
            **self._workspace.listing(),
            "is_read_only": self._is_read_only,
            "is_single": self._workspace.only is not None,
        }

    def _open(self, asked: dict[str, Any]) -> dict[str, Any]:
        """Return a file, with the unsaved texts of pages that do not edit it now."""
        name = _text(asked, "name")
        shared = self._shared.get(name)
        editing = shared.leader if shared else None
        drafts = [asdict(each) for each in self._workspace.drafts(name) if each.page != editing]
        return {"name": name, "text": self._workspace.read(name).text, "drafts": drafts}

    def _state(self, asked: dict[str, Any]) -> dict[str, Any]:
        """Return who edits a file, with the text for pages that follow."""
        name, page = _text(asked, "name"), _text(asked, "page")
        disk = self._workspace.read(name).text if self._workspace.path(name).exists() else None
        shared = self._shared.setdefault(name, _Shared())
        is_free = not shared.leader and (name, page) not in self._left
        if is_free or shared.leader == page or asked.get("take"):
            shared.leader, shared.seen = page, Stopwatch()
            if isinstance(asked.get("text"), str):
                shared.text = asked["text"]
            is_changed = "base" in asked and (disk or "") != asked["base"]
            return {"leads": True, "is_changed": is_changed, "exists": disk is not None}
        text = (disk or "") if shared.text is None else shared.text
        return {"leads": False, "text": text, "is_asleep": shared.seen.elapsed_s > ASLEEP_S}

    def _leave(self, asked: dict[str, Any]) -> dict[str, Any]:
        """Let other pages edit a file that a page does not show any more.

        A page has a new name for each file that it opens. What it sent before it left may arrive
        after that.
        """
        name, page = _text(asked, "name"), _text(asked, "page")
        self._left.append((name, page))
        shared = self._shared.get(name)
        if shared is not None and shared.leader == page:
            del self._shared[name]
        return {}

    def _keep(self, asked: dict[str, Any]) -> dict[str, Any]:
        """Keep the unsaved text of a page beside its file."""
        name, page, text = (_text(asked, key) for key in ("name", "page", "text"))
        if self._is_read_only:
            return {"lost": ""}
        return {"lost": self._workspace.keep_draft(name, page, text)}

    def _drop(self, asked: dict[str, Any]) -> dict[str, Any]:
        """Delete unsaved texts that a person does not want."""
        self._refuse_read_only()
        self._workspace.drop_drafts(_text(asked, "name"), _texts(asked, "pages"))
        return {}

    def _save(self, asked: dict[str, Any]) -> dict[str, Any]:
        """Write a file. The unsaved texts of the page that it was made of are deleted."""
        self._refuse_read_only()
        name, text, base, page = (_text(asked, key) for key in ("name", "text", "base", "page"))
        shared = self._shared.get(name)
        if shared is not None and shared.leader not in ("", page):
            raise EditError("another page edits this file; take over to save it")
        self._workspace.save(name, text, base, is_forced=bool(asked.get("is_forced")))
        self._workspace.drop_drafts(name, [page, *_texts(asked, "restored")])
        return {"text": text}

    def _create(self, asked: dict[str, Any]) -> dict[str, Any]:
        self._refuse_read_only()
        self._workspace.create(name := _text(asked, "name"))
        return {"name": name}

    def _rename(self, asked: dict[str, Any]) -> dict[str, Any]:
        self._refuse_read_only()
        name, other = _text(asked, "name"), _text(asked, "other")
        self._workspace.rename(name, other)
        self._shared.pop(name, None)
        return {"name": other}

    def _delete(self, asked: dict[str, Any]) -> dict[str, Any]:
        """Delete a file that a page has open, with the text with which it was opened."""
        self._refuse_read_only()
        name = _text(asked, "name")
        self._workspace.delete(name, _text(asked, "base"))
        self._shared.pop(name, None)
        return {}

    # ---- the text ------------------------------------------------------------------------

    def _check(self, asked: dict[str, Any]) -> dict[str, Any]:
        """Check a text, and keep it beside its file as long as it is not saved."""
        kept = self._keep(asked)  # whatever the check finds
        return self._look_at(asked) | kept

    def _look_at(self, asked: dict[str, Any]) -> dict[str, Any]:
        """Return the marks and the nodes of a text."""
        text, path = _text(asked, "text"), self._workspace.path(_text(asked, "name"))
        kind = kind_of_text(text)
        units = _units(text)
        notes = marks(check_text(text, path, kind, self._workspace.root), text, path)
        for mark in notes:
            mark["from"], mark["to"] = units(mark["from"]), units(mark["to"])
        shown = _boxes(text) if kind == "mission" else []
        return {"kind": kind, "marks": notes, "boxes": shown, "lost": ""}

    def _complete(self, asked: dict[str, Any]) -> dict[str, Any]:
        text, offset = _placed(asked)
        path = self._workspace.path(_text(asked, "name"))
        words = completion(text, offset, path, self._workspace.root)
        options = [asdict(option) for option in words.options]
        return {"from": _units(text)(words.start), "options": options}

    def _hover(self, asked: dict[str, Any]) -> dict[str, Any]:
        text, offset = _placed(asked)
        path = self._workspace.path(_text(asked, "name"))
        option = hover(text, offset, path, self._workspace.root)
        return {"option": None if option is None else asdict(option)}

    def _plan(self, asked: dict[str, Any]) -> dict[str, Any]:
        """Return the plan of the world of a text."""
        path = self._workspace.path(_text(asked, "name"))
        text = _text(asked, "text")
        return {"plan": plan_of(text, path, kind_of_text(text), self._workspace.root)}

    def _scenario(self, asked: dict[str, Any]) -> dict[str, Any]:
        """Return the scenario file of a mission with faults, with its errors, or write it."""
        name, text = _text(asked, "name"), _text(asked, "text")
        if "file" in asked:
            self._refuse_read_only()
            file = _text(asked, "file")
            self._workspace.save_beside(file, _text(asked, "scenario"))
            return {"file": file}
        outcome = _text(asked, "outcome")
        if outcome not in OUTCOMES:
            raise RequestError(f"expected one of the outcomes {', '.join(OUTCOMES)}")
        file = self._workspace.free_name(name, "faults")
        path = self._workspace.path(name)
        if not path.exists() or self._workspace.read(name).text != text:
            raise EditError(f"save {path.name} first: the scenario runs the file")
        title = Path(file).stem.replace("_", " ")
        written = scenario_text(title, path.name, _faults(asked), outcome)
        beside = path.with_name(Path(file).name)
        wrong = check_text(written, beside, "scenario", self._workspace.root)
        errors = [str(each.message) for each in wrong if each.severity == "error"]
        return {"file": file, "scenario": written, "errors": errors}

    # ---- runs and proofs -----------------------------------------------------------------

    async def _start_run(self, asked: dict[str, Any]) -> dict[str, Any]:
        with self._turns["a run"]:
            await self._stop_run()
            if asked.get("stop"):
                return {}
            words = [*_on_page(asked), *(f"--fault={fault}" for fault in _faults(asked))]
            if asked.get("is_editable"):
                words.append("--editable")
            if asked.get("before"):
                words.append(f"--pause-before={_text(asked, 'before')}")
            self._run = self._child(asked, "run", [*words, *self._to_new_recording()])
        return {}

    def _to_new_recording(self) -> list[str]:
        """Return the option for the recording of a run; that of the last run is deleted."""
        if self._folder is None:
            return []
        if self._recording is not None:
            self._recording.unlink(missing_ok=True)
        self._runs += 1
        self._recording = self._folder / f"run_{self._runs}.mcap"
        return [f"--record={self._recording}"]

    async def _start_fork(self, asked: dict[str, Any]) -> dict[str, Any]:
        """Continue the recorded run from an instant, with the text as another version of it."""
        at = asked.get("at")
        if type(at) not in (int, float):
            raise RequestError("'at' is not an instant")
        with self._turns["a run"]:
            await self._stop_run()
            recording = self._recording
            if recording is None or not recording.exists():
                raise EditError("there is no run to continue: run the mission first")
            words = [str(recording), f"--at={at}", *_on_page(asked), "--import-python"]
            words += [*(f"--fault={fault}" for fault in _faults(asked)), "--mission"]
            self._run = self._child(asked, "fork", words)
        return {}

    async def _stop_run(self) -> None:
        if self._run is not None:
            await self._run.stop()
            self._run = None

    async def _revise(self, asked: dict[str, Any]) -> dict[str, Any]:
        """Send the text to the run; return what `bt-mission revise` prints."""
        words = [key for key in ("--dry-run", "--keep-goals") if asked.get(key)]
        executive = _text(asked, "executive")
        if executive.startswith("-"):
            raise RequestError("an invalid name")
        with self._turns["a revision"]:
            child = self._child(asked, "revise", [*words, executive])
            try:
                await child.wait()
            finally:
                await child.stop()
        lines = [*lines_of(child.output), *child.lines]
        return {"is_possible": child.code == 0, "lines": lines}

    def _ran(self, _: dict[str, Any]) -> dict[str, Any]:
        run = self._run
        if run is None:
            return {"state": "none"}
        state = "over" if run.is_over else "served" if run.link else "starting"
        if state != "starting":  # getting ready takes time from a run that starts
            self._get_ready()
        return {"state": state, "lines": run.lines[-20:]}

    async def _start_proof(self, asked: dict[str, Any]) -> dict[str, Any]:
        with self._turns["a proof"]:
            if self._proof is not None:
                await self._proof.stop()
            self._proof = self._child(asked, "prove", ["--json", f"--budget={PROOF_BUDGET}"])
        return {}

    def _proved(self, _: dict[str, Any]) -> dict[str, Any]:
        proof = self._proof
        if proof is None or not proof.is_over:
            return {"is_over": False}
        return {"is_over": True, "result": proof.result, "lines": proof.lines[-20:]}

    def _child(self, asked: dict[str, Any], command: str, words: Sequence[str]) -> ChildCommand:
        """Run a command with the text of a page."""
        self._refuse_read_only()
        if self._is_closing:
            raise EditError("the editor ends")
        trial = self._workspace.trial(_text(asked, "name"), _text(asked, "text"), command)
        spare = None
        if command in ("run", "fork"):
            spare, self._spare = self._spare, None
        return ChildCommand(trial, (command, *words, str(trial)), spare)

    def _refuse_read_only(self) -> None:
        if self._is_read_only:
            raise EditError("this page is read-only: start it without --read-only")

    async def _page_of_run(self, _: Request) -> Response:
        return Response(self._watch, media_type="text/html; charset=utf-8")

    async def _live(self, socket: WebSocket) -> None:
        run = self._run
        if run is None or not run.link:
            await socket.close(1013, "no mission runs")
            return
        await relay(socket, run.link)


def _faults(asked: Mapping[str, Any]) -> list[str]:
    faults = asked.get("faults", [])
    is_valid = isinstance(faults, list) and all(isinstance(fault, str) for fault in faults)
    if not is_valid or len(faults) > MOST_FAULTS:
        raise RequestError(f"expected at most {MOST_FAULTS} faults as text")
    return list(faults)


def _fault(asked: dict[str, Any]) -> dict[str, Any]:
    """Return a fault of a form as text."""
    values = asked.get("values")
    if not isinstance(values, dict):
        raise RequestError("'values' is missing")
    written = {key: _text(values, key) for key in values}
    return fault_text(_text(asked, "begins"), _text(asked, "fault"), written)


def _on_page(asked: dict[str, Any]) -> list[str]:
    speed = _text(asked, "speed")
    if speed not in SPEEDS:
        raise RequestError(f"expected one of the speeds {', '.join(SPEEDS)}")
    return ["--web", "--port=0", f"--speed={speed}"]


def _vocabulary() -> dict[str, Any]:
    named = {"worlds": files.names("worlds"), "robots": files.names("robots")}
    return {**as_json(), **named, "new_files": list(NEW_FILES.items())}


async def _body(request: Request) -> dict[str, Any]:
    body = bytearray()
    async for chunk in request.stream():
        body += chunk
        if len(body) > LONGEST_BODY:
            raise RequestError(f"the request exceeds {LONGEST_BODY:,} bytes")
    try:
        asked = json.loads(body or b"{}")
        json.dumps(asked, ensure_ascii=False).encode()
    except UnicodeEncodeError as error:
        before = error.object[: error.start]
        raise RequestError(
            f"the text has half a character, U+{ord(error.object[error.start]):04X}, which no file "
            f"can hold, behind {json.dumps(before[-20:])}: delete it"
        ) from None
    except (ValueError, RecursionError):
        raise RequestError("the request is not JSON") from None
    if not isinstance(asked, dict):
        raise RequestError("expected a JSON object")
    return asked


def _text(asked: Mapping[str, Any], key: str) -> str:
    value = asked.get(key)
    if not isinstance(value, str):
        raise RequestError(f"'{key}' is missing")
    return value


def _texts(asked: Mapping[str, Any], key: str) -> list[str]:
    value = asked.get(key, [])
    if not isinstance(value, list) or not all(isinstance(part, str) for part in value):
        raise RequestError(f"'{key}' is not a list of texts")
    return list(value)


def _path(asked: Mapping[str, Any], key: str) -> tuple[str | int, ...]:
    value = asked.get(key)
    if not isinstance(value, list) or not all(type(part) in (str, int) for part in value):
        raise RequestError(f"'{key}' is not a path")
    return tuple(value)


def _section(asked: Mapping[str, Any]) -> str:
    section = _text(asked, "section")
    if section not in SECTIONS:
        raise RequestError(f"expected one of {', '.join(SECTIONS)}")
    return section


def _pair(asked: Mapping[str, Any], key: str) -> tuple[float, float]:
    value = asked.get(key)
    if not isinstance(value, list) or [_is_length(part) for part in value] != [True] * 2:
        raise RequestError(f"'{key}' is not a place")
    return float(value[0]), float(value[1])


def _is_length(value: Any) -> bool:
    """Return whether it is a number of metres that a float can hold."""
    return type(value) in (int, float) and abs(value) < FURTHEST_M


def _boxes(text: str) -> list[dict[str, Any]] | None:
    rows = boxes(text)
    units = _units(text)
    for row in rows or ():
        row["start"], row["end"] = units(row["start"]), units(row["end"])
    return rows


def _act(asked: dict[str, Any]) -> dict[str, Any]:
    """Return an act as edits of the text, and the nodes afterwards."""
    text = _text(asked, "text")
    do = _ACTS.get(_text(asked, "do"))
    if do is None:
        raise RequestError("unknown act")
    edits = do(text, asked)
    units = _units(text)
    return {
        "edits": [
            {"from": units(edit.start), "to": units(edit.end), "insert": edit.text}
            for edit in edits
        ],
        "boxes": _boxes(applied(text, edits)),
    }


def _set_field(text: str, asked: Mapping[str, Any]) -> Edits:
    value = asked.get("value")
    if value is not None:
        value = _text(asked, "value")
        value = as_text(value) if asked.get("is_text") else value
    keys = [str(key) for key in _path(asked, "keys")]
    return patches.set_field(text, _path(asked, "path"), keys, value)


_ACTS: Mapping[str, Callable[[str, Mapping[str, Any]], Edits]] = {
    "begin": lambda text, asked: patches.begin(text, _text(asked, "value")),
    "add": lambda text, asked: patches.add(text, _path(asked, "target"), _text(asked, "value")),
    "move": lambda text, asked: patches.move(text, _path(asked, "path"), _path(asked, "target")),
    "copy": lambda text, asked: patches.copy(text, _path(asked, "path")),
    "delete": lambda text, asked: patches.delete(text, _path(asked, "path")),
    "wrap": lambda text, asked: patches.wrap(
        text, _path(asked, "path"), _text(asked, "kind"), _text(asked, "value")
    ),
    "unwrap": lambda text, asked: patches.unwrap(text, _path(asked, "path")),
    "place": lambda text, asked: add_thing(
        text, _section(asked), _pair(asked, "begin"), _pair(asked, "end")
    ),
    "shift": lambda text, asked: move_thing(text, _path(asked, "path"), _pair(asked, "by")),
    "set": _set_field,
}
"""The acts of the page, by their names."""


def _placed(asked: Mapping[str, Any]) -> tuple[str, int]:
    text, at = _text(asked, "text"), asked.get("at")
    if type(at) is not int or at < 0:
        raise RequestError("'at' is not an offset")
    return text, len(text.encode("utf-16-le")[: 2 * at].decode("utf-16-le", "ignore"))


def _define(asked: dict[str, Any]) -> dict[str, Any]:
    text, offset = _placed(asked)
    place = definition(text, offset)
    return {"at": None if place is None else _units(text)(place)}


def _differ(asked: dict[str, Any]) -> dict[str, Any]:
    """Return the lines that differ between two texts, with some around them."""
    before, after = (split_lines(_text(asked, key)) for key in ("before", "after"))
    if max(len(before), len(after)) > MOST_LINES:
        raise EditError(f"differences are shown of at most {MOST_LINES:,} lines")
    lines: Sequence[str] = list(difflib.unified_diff(before, after, lineterm="", n=2))[2:]
    return {"lines": lines}


def _merge(asked: dict[str, Any]) -> dict[str, Any]:
    """Return the text on disk and that of the page beside the one with which both began."""
    base, theirs, mine = (_text(asked, key) for key in ("base", "theirs", "mine"))
    cut = hunks(base, theirs, mine)
    return {"hunks": [asdict(hunk) | {"choice": hunk.choice} for hunk in cut]}


def _units(text: str) -> Callable[[int], int]:
    """Return what turns offsets in characters into those of JavaScript, in units of UTF-16."""
    if text.isascii() or max(text, default="") < "\U00010000":
        return lambda offset: offset
    return lambda offset: len(text[:offset].encode("utf-16-le")) // 2
