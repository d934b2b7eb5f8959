"""Files that commands write: an old one stays until the new one is whole."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from bt_mission.base.errors import BtMissionError
from bt_mission.base.output import OutputFile, new_file, write_file
from tests.support.full_disk import full_after

OLD = b"the only copy"


@pytest.fixture
def old(tmp_path: Path) -> Path:
    """A file that is there already."""
    path = tmp_path / "page.html"
    path.write_bytes(OLD)
    return path


def names_in(folder: Path) -> list[str]:
    """Everything in a folder, hidden files too."""
    return sorted(path.name for path in folder.iterdir())


def test_a_file_is_written_with_the_permissions_of_any_new_one(tmp_path: Path) -> None:
    """Texts are UTF-8."""
    (tmp_path / "plain").touch()
    write_file(tmp_path / "a.txt", "größer")
    assert (tmp_path / "a.txt").read_bytes() == "größer".encode()
    assert (tmp_path / "a.txt").stat().st_mode == (tmp_path / "plain").stat().st_mode
    assert names_in(tmp_path) == ["a.txt", "plain"]


def test_an_old_file_is_replaced_and_its_permissions_stay(old: Path) -> None:
    """As where it is written over."""
    old.chmod(0o640)
    write_file(old, b"new")
    assert old.read_bytes() == b"new"
    assert old.stat().st_mode & 0o777 == 0o640
    assert names_in(old.parent) == ["page.html"]


def test_a_link_is_followed(old: Path) -> None:
    """It stays a link."""
    link = old.parent / "link.html"
    link.symlink_to(old.name)
    write_file(link, b"new")
    assert link.is_symlink()
    assert old.read_bytes() == b"new"


def test_on_a_full_disk_the_old_file_stays(old: Path) -> None:
    """Nothing else is left."""
    with full_after(1000), pytest.raises(BtMissionError, match=r"cannot write .*page\.html: File"):
        write_file(old, bytes(2000))
    assert old.read_bytes() == OLD
    assert names_in(old.parent) == ["page.html"]


def test_what_raises_while_it_is_written_leaves_the_old_file(old: Path) -> None:
    """Whatever it was."""

    def write_half() -> None:
        with new_file(old) as stream:
            stream.write(b"half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_half()
    assert old.read_bytes() == OLD
    assert names_in(old.parent) == ["page.html"]


def test_a_device_is_written_to() -> None:
    """It is not a file that could be replaced; one that is full says so."""
    write_file(Path("/dev/null"), b"anything")
    with pytest.raises(BtMissionError, match="cannot write /dev/full: No space left on device"):
        write_file(Path("/dev/full"), b"anything")
    assert Path("/dev/null").is_char_device()


# ---- files that grow -------------------------------------------------------------------------


def test_a_new_file_has_its_name_from_the_start(tmp_path: Path) -> None:
    """So that a process that is killed leaves it under that name."""
    file = OutputFile(tmp_path / "run.mcap")
    file.stream.write(b"half")
    file.stream.flush()
    assert file.path.read_bytes() == b"half"
    file.close()
    assert (file.write_error, file.remark, file.place) == (None, "", file.path)


def test_beside_an_old_file_it_grows_until_it_is_whole(old: Path) -> None:
    """A killed process leaves both."""
    old.chmod(0o600)
    file = OutputFile(old)
    part = old.parent / "page.part.html"
    file.stream.write(b"half")
    file.stream.flush()
    assert (old.read_bytes(), part.read_bytes(), file.place) == (OLD, b"half", part)
    file.stream.write(b", whole")
    file.close()
    assert old.read_bytes() == b"half, whole"
    assert old.stat().st_mode & 0o777 == 0o600
    assert (names_in(old.parent), file.remark) == (["page.html"], "")
    file.close()


def test_a_grown_file_that_is_not_whole_replaces_nothing(old: Path) -> None:
    """What it has is kept beside the old one, and that is said."""
    file = OutputFile(old)
    with full_after(1000):
        file.attempt(lambda: (file.stream.write(bytes(500)), file.stream.flush()))
        faults = [file.write_error]
        file.attempt(lambda: (file.stream.write(bytes(1000)), file.stream.flush()))
        faults.append(file.write_error)
        file.attempt(lambda: pytest.fail("nothing more is written"))
        file.close()
    assert faults == [None, "File too large"]
    assert old.read_bytes() == OLD
    assert file.place == old.parent / "page.part.html"
    assert file.place.stat().st_size == 1000
    assert file.remark == f"{old} is unchanged"


def test_a_file_that_its_writer_gives_up_replaces_nothing(old: Path) -> None:
    """Such as where the run has raised an exception."""
    file = OutputFile(old)
    file.stream.write(b"half")
    file.close(replaces=False)
    assert old.read_bytes() == OLD
    assert file.place.read_bytes() == b"half"


def test_a_file_that_somebody_deletes_is_known_to_be_gone(old: Path) -> None:
    """It cannot replace the old one."""
    file = OutputFile(old)
    deleted = [file.is_deleted]
    file.place.unlink()
    deleted.append(file.is_deleted)
    file.close()
    assert deleted == [False, True]
    assert (file.write_error, old.read_bytes()) == ("No such file or directory", OLD)


@pytest.mark.process(always=True)
def test_a_killed_process_leaves_the_old_file(old: Path) -> None:
    """Of a page nothing is seen under its name before it is whole."""
    code = (
        "import os, pathlib, sys\n"
        "from bt_mission.base.output import new_file\n"
        "with new_file(pathlib.Path(sys.argv[1])) as stream:\n"
        "    stream.write(b'half')\n"
        "    stream.flush()\n"
        "    os.kill(os.getpid(), 9)\n"
    )
    killed = subprocess.run([sys.executable, "-c", code, old], env=os.environ, check=False)
    assert killed.returncode == -9
    assert old.read_bytes() == OLD
