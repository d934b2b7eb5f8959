"""What the tests of all commands take from these: see `tests/support/command_cases.py`."""

from tests.support.command_cases import InFolder

IN_FOLDER = {
    "actions": InFolder("actions list"),
    "topics": InFolder("topics list"),
    "services": InFolder("services list"),
}
HELP = ("actions", "actions send", "services")
WITHOUT_A_COMMAND = (("actions", "  send "),)
COMPLETED = (
    (["actions", "se"], ["send"]),
    (["actions", "send", "/turn", "--f"], ["--form"]),
)
COMPLETED_BY_FISH = (("bt-mission actions se", "send"),)
TAKE_A_CONSOLE = ("bt_mission.commands.graph.goal_views",)
WORDS_BELOW = ("send", "echo", "call")
STAYS_ON_PAGES = {
    r"bt-mission actions watch": "Ctrl-C ends it",
    r"bt-mission actions send .*3600": "accepted",
}
