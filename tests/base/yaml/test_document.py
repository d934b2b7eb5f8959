"""Documents: files read with their places, or refused with one clear message."""

import os

import pytest

from bt_mission.base.diagnostics import InputError
from bt_mission.base.yaml.document import MAX_BYTES, read, read_text


def refusal(path):
    """Return what is said of a file that is refused."""
    with pytest.raises(InputError) as caught:
        read(path)
    return str(caught.value)


def test_a_file_is_read_with_its_name(tmp_path):
    """The document knows the file as it was named."""
    path = tmp_path / "a.yaml"
    path.write_text("a: 1\n", encoding="utf-8")
    document = read(path)
    assert document.data == {"a": 1}
    assert document.file == str(path)


def test_a_byte_order_mark_is_no_part_of_the_text(tmp_path):
    """Editors on other systems write one."""
    path = tmp_path / "a.yaml"
    path.write_bytes(b"\xef\xbb\xbfa: .nan\n")
    assert refusal(path).startswith(f"{path}:1:4: error: expected a finite number")


def test_files_that_cannot_be_read_are_refused(tmp_path):
    """Missing, a folder, a pipe: each in words, without a traceback."""
    missing, folder, pipe = tmp_path / "x.yaml", tmp_path / "folder", tmp_path / "pipe"
    folder.mkdir()
    os.mkfifo(pipe)
    assert refusal(missing) == f"{missing}: error: no such file [BT-101]"
    assert refusal(folder) == f"{folder}: error: expected a file, got a folder [BT-101]"
    assert refusal(pipe) == f"{pipe}: error: expected a file, got a device or pipe [BT-101]"
    assert "cannot read the file" in refusal(tmp_path / ("x" * 5000))
    assert refusal("a\0b") == "a\\x00b: error: no such file [BT-101]"


def test_a_loop_of_links_is_refused(tmp_path):
    """A link to itself leads nowhere."""
    loop = tmp_path / "loop.yaml"
    loop.symlink_to(loop)
    assert refusal(loop) == f"{loop}: error: no such file [BT-101]"


def test_a_large_file_is_refused_unread(tmp_path):
    """Ten megabytes: the message says the size."""
    path = tmp_path / "large.yaml"
    path.write_bytes(b"a" * 10_000_000)
    expected = "the file is too large: 10,000,000 bytes, the limit is 1,000,000 [BT-103]"
    assert refusal(path) == f"{path}: error: {expected}"


def test_the_limit_counts_bytes():
    """A text of wide characters is larger than it is long."""
    with pytest.raises(InputError, match="too large: 1,200,000 bytes"):
        read_text("前" * 400_000)
    assert len("前" * 400_000) < MAX_BYTES


def test_other_encodings_are_refused_where_they_begin(tmp_path):
    """Line and column of the first byte that is no UTF-8."""
    path = tmp_path / "latin.yaml"
    path.write_bytes("a: 1\nb: héllo\n".encode("latin-1"))
    assert refusal(path) == f"{path}:2:5: error: expected text in UTF-8, got the byte 0xe9 [BT-102]"


def test_a_position_is_found_by_path():
    """At the value, at the key, or at the deepest part that exists."""
    document = read_text("a:\n  - {b: 1}\n", "a.yaml")
    assert document.position(("a", 0, "b")) == (2, 9)
    assert document.position(("a", 0, "b"), key=True) == (2, 6)
    assert document.position(("a", 0, "c")) == (2, 5)
    assert document.position(("a", 7, "c")) == (2, 3)
    assert document.position(("a", 0, "c"), key=True) == (2, 5)


@pytest.mark.parametrize(
    ("line", "column"),
    [
        ("a: one + two", 10),
        ("a: 'one + two'", 11),
        ('a: "one + two"', 11),
        ('a: "one\\x20+ two"', 4),
        ("a: >\n  one + two", 4),
    ],
)
def test_a_caret_goes_into_a_text_where_it_stands_as_written(line, column):
    """With escapes or folding the place inside is not known, and the text itself is shown."""
    document = read_text(line)
    assert document.diagnostic("BT-100", ("a",), "here", offset=6).column == column
