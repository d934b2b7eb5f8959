"""Paths in a folder of results that comes from others."""

from __future__ import annotations

import pytest

from bt_mission.core.errors import BtMissionError
from bt_mission.core.output import within
from bt_mission.sweeps.bundle import Bundle


def test_a_path_lies_in_the_folder(tmp_path):
    """Whether it is there or not."""
    assert within(tmp_path, "missions/go.yaml") == tmp_path / "missions" / "go.yaml"


@pytest.mark.parametrize("name", ["../x", "a/../../x", "/etc/x", ""])
def test_a_name_that_leads_out_is_refused(tmp_path, name):
    """Wherever it comes from."""
    with pytest.raises(BtMissionError, match="is outside the folder"):
        within(tmp_path, name)
    with pytest.raises(BtMissionError):
        Bundle({name: "x"}, "m", {}, {}).write_to(tmp_path)


@pytest.mark.parametrize("link", ["missions", "missions/go.yaml"])
def test_a_link_on_the_way_is_refused(tmp_path, link):
    """Nothing is written where it leads to."""
    folder, victim = tmp_path / "results", tmp_path / "victim"
    victim.mkdir()
    path = folder / link
    path.parent.mkdir(parents=True)
    path.symlink_to(victim if link == "missions" else victim / "file")
    with pytest.raises(BtMissionError, match="a symbolic link"):
        Bundle({"missions/go.yaml": "x"}, "missions/go.yaml", {}, {}).write_to(folder)
    assert list(victim.iterdir()) == []
