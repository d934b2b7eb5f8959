"""`bt-mission prove -o` writes a page of the result, and one of the run of each finding."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_mission.cli import main
from tests.support.report_pages import data_of

MISSION = """\
mission: <m>
tree:
  sequence:
    - fallback:
        - turn: {angle: 90}
          name: <turn>
          timeout: 9
          outputs: {error_code: code}
        - log: no turn
    - log: $code
"""


def test_the_page_names_properties_findings_and_outcomes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Names are text, not markup; the run of the finding can be played."""
    monkeypatch.chdir(tmp_path)
    Path("m.yaml").write_text(MISSION, encoding="utf-8")
    assert main(["prove", "m.yaml", "-o", "out"]) == 1
    assert "the page: out/proof.html" in capsys.readouterr().err
    page = Path("out/proof.html").read_text(encoding="utf-8")
    assert "<m>" not in page
    assert '<td>unset_variable</td><td class="violated">violated</td>' in page
    assert '<td>ends</td><td class="proved">proved</td>' in page
    assert "<li>/turn rejects the goal</li>" in page
    assert '<span class="yes">rejected</span>' in page
    assert '<span class="no">canceled by another client</span>' in page
    (run,) = Path("out").glob("*_unset_variable.html")
    assert f'<a href="{run.name}">the run, step by step</a>' in page
    assert data_of(run)[""]["messages"]
