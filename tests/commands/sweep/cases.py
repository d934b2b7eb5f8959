"""What the tests of all commands take from these: see `tests/support/command_cases.py`."""

from tests.support.command_cases import InFolder

IN_FOLDER = {
    "sweep": InFolder("sweep m.yaml --seeds 2 --workers 2"),
    "sweep-report": InFolder("sweep-report nothing"),
}
PIPES = ("sweep pipe.yaml", "sweep square --fault-plan pipe.yaml")
FOLDERS_OF_OPTIONS = ("sweep-report folder",)
COMPLETED = ((["sweep", "explore", "--vary", "sto"], ["stopping_distance="]),)
STAYS_ON_PAGES = {r"dask scheduler": "Scheduler at", r"dask worker": "Start worker"}
NOT_RUN_ON_PAGES = {
    "needs a cluster": (r"helm |.*tls://", r"export DASK|for who|dask scheduler --protocol tls"),
}
SHORTER_ON_PAGES = {
    "--seeds 1000": "--seeds 2",
    "--seeds 300": "--seeds 2",
    "--seeds 200": "--seeds 2",
    "--seeds 100": "--seeds 2",
    "--seeds 50": "--seeds 1",
    "--seeds 20": "--seeds 1",
    "--sample 500": "--sample 2",
    "sweep explore": "sweep explore --set legs=1",
    "--fail-below 0.95": "--fail-below 0.3",
}
WRITERS = {
    "bt_mission/commands/sweep/store.py": "a lock",
}
