"""The keys of the full-screen views, once: what they do, and how the help tells it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Key:
    """A key, or several that do the same.

    Args:
        keys: As Textual names them, with commas between.
        action: The method of the application, without ``action_``.
        shown: How people call them.
        help: What they do; empty for those that the help leaves out.
    """

    keys: str
    action: str
    shown: str
    help: str


WISHES = (
    Key("p", "send('PAUSE')", "p", "pause; running goals are cancelled, and start anew later"),
    Key(
        "P",
        "send('PAUSE_KEEPING_GOALS')",
        "P",
        "pause, while running goals run on within their limits",
    ),
    Key("r", "send('RESUME')", "r", "resume"),
    Key("s", "send('STEP')", "s", "step: one tick of a paused mission"),
    Key("x", "stop", "x x", "stop the mission; every goal is seen to its end"),
    Key("b", "breakpoint", "b", "pause before the selected node starts, or no longer"),
)
"""What a mission that runs is asked for."""

PLAYING = (
    Key("p", "play", "p", "play, pause; at the end, play from the start"),
    Key("r", "reverse", "r", "play the other way: backwards, forwards"),
    Key("plus,equals_sign", "speed(2)", "+ -", "faster, slower"),
    Key("minus", "speed(0.5)", "", ""),
    Key("s", "step(1)", "s S", "to the next change of the tree, to the one before"),
    Key("S", "step(-1)", "", ""),
    Key("b", "start(1)", "b B", "to the next start of the selected node, to the one before"),
    Key("B", "start(-1)", "", ""),
    Key("greater_than_sign", "skip(10)", "> <", "ten seconds on, ten seconds back"),
    Key("less_than_sign", "skip(-10)", "", ""),
    Key("g", "go(0)", "g G", "to the start, to the end"),
    Key("G", "go(1)", "", ""),
    Key("t", "time", "t", "to a time, in seconds"),
    Key("F", "fork", "F", "fork: run it again up to here, and on with a change"),
)
"""Where in a recording to be."""

LOOKING = (
    Key("up,k", "move(-1)", "up down", "select a node; k and j do, too"),
    Key("down,j", "move(1)", "", ""),
    Key("pageup", "page(-1)", "PgUp PgDn", "a page up, down"),
    Key("pagedown", "page(1)", "", ""),
    Key("home", "move(-1000000)", "Home End", "the first node, the last"),
    Key("end", "move(1000000)", "", ""),
    Key("left,h", "tree('fold')", "left right", "fold, unfold; h and l do, too"),
    Key("right,l", "tree('unfold')", "", ""),
    Key("enter,space", "tree('toggle')", "Enter", "fold or unfold"),
    Key("asterisk", "tree('fold_all')", "*", "fold or unfold everything"),
    Key("slash", "search", "/", "search names, classes and words"),
    Key("n", "again(1)", "n N", "the next one found, the one before"),
    Key("N", "again(-1)", "", ""),
    Key("f", "tree('follow')", "f", "select what runs, and go with it"),
    Key(
        "tab",
        "next_panel(1)",
        "Tab",
        "the next panel: log, requirements, goals, variables, map, node",
    ),
    Key("shift+tab", "next_panel(-1)", "", ""),
    Key("z", "enlarge", "z", "give the panel the whole screen, and back"),
)
"""What is looked at."""

CHOOSING = (Key("c", "choose", "c", "choose another executive"),)
LEAVING = (
    Key("question_mark,f1", "help", "?", "this help"),
    Key("q,ctrl+c,ctrl+q", "leave", "q", "leave"),
)

KEYS = (*WISHES, *LOOKING, *CHOOSING, *LEAVING)
"""Of a mission that runs."""

REPLAY_KEYS = (*PLAYING, *LOOKING, *LEAVING)
"""Of a recording."""
