"""The keys of the full-screen view, once: what they do, and how the help tells it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Key:
    """A key, or several that do the same.

    :param keys: as Textual names them, with commas between.
    :param action: the method of the application, without ``action_``.
    :param shown: how people call them.
    :param help: what they do; empty for those that the help leaves out.
    """

    keys: str
    action: str
    shown: str
    help: str


KEYS = (
    Key("p", "pause", "p", "pause; running goals are cancelled, and start anew later"),
    Key("P", "pause_keeping", "P", "pause, while running goals run on, unwatched"),
    Key("r", "resume", "r", "resume"),
    Key("s", "step", "s", "step: one tick of a paused mission"),
    Key("x", "stop", "x x", "stop the mission; every goal is seen to its end"),
    Key("b", "breakpoint", "b", "pause before the selected node starts, or no longer"),
    Key("up,k", "move(-1)", "up down", "select a node; k and j do, too"),
    Key("down,j", "move(1)", "", ""),
    Key("pageup", "page(-1)", "PgUp PgDn", "a page up, down"),
    Key("pagedown", "page(1)", "", ""),
    Key("home", "move(-1000000)", "Home End", "the first node, the last"),
    Key("end", "move(1000000)", "", ""),
    Key("left,h", "fold", "left right", "fold, unfold; h and l do, too"),
    Key("right,l", "unfold", "", ""),
    Key("enter,space", "fold_or_unfold", "Enter", "fold or unfold"),
    Key("asterisk", "fold_all", "*", "fold or unfold everything"),
    Key("slash", "search", "/", "search names, classes and words"),
    Key("n", "again(1)", "n N", "the next one found, the one before"),
    Key("N", "again(-1)", "", ""),
    Key("f", "follow", "f", "select what runs, and go with it"),
    Key("tab", "next_panel(1)", "Tab", "the next panel: log, goals, variables, map, node"),
    Key("shift+tab", "next_panel(-1)", "", ""),
    Key("z", "enlarge", "z", "give the panel the whole screen, and back"),
    Key("c", "choose", "c", "choose another executive"),
    Key("question_mark,f1", "help", "?", "this help"),
    Key("q,ctrl+c,ctrl+q", "leave", "q", "leave"),
)
