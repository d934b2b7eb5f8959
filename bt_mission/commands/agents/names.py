"""Names in proposals: what looks like another name is refused or marked."""

from __future__ import annotations

import unicodedata

from bt_mission.base.text import category

LONGEST = 60
_EAST_ASIAN = frozenset(
    ("CJK", "HIRAGANA", "KATAKANA", "KATAKANA-HIRAGANA", "IDEOGRAPHIC", "HANGUL", "BOPOMOFO")
)
"""Scripts that are written together, and with Latin letters, which they do not resemble."""
_MOST_NAMED = 3


def why_invalid(name: str) -> str | None:
    """Return why a person could take a name for another one, or for more than a name; or None."""
    if len(name) > LONGEST:
        return f"a name has at most {LONGEST} characters"
    if name != " ".join(name.split(" ")).strip() or "  " in name:
        return "a name has no blanks at its ends, and no two in a row"
    for character in name:
        if not character.isascii() and not _is_of_a_name(character):
            return f"U+{ord(character):04X} in a name: expected letters, digits and signs of ASCII"
    scripts = {script for character in name if (script := _script(character))}
    if len(scripts - _EAST_ASIAN) > 1 or not (
        scripts <= _EAST_ASIAN | {"LATIN"} or len(scripts) == 1
    ):
        return f"a name has letters of one script, got {' and '.join(sorted(scripts))}"
    return None


def shown_name(name: str) -> str:
    """Return a name in quotes, with what in it may look like something else."""
    foreign = dict.fromkeys(character for character in name if not character.isascii())
    if not foreign:
        return f"'{name}'"
    named = [unicodedata.name(each, f"U+{ord(each):04X}") for each in foreign][:_MOST_NAMED]
    more = ", ..." if len(foreign) > _MOST_NAMED else ""
    return f"'{name}' (not ASCII: {', '.join(named)}{more})"


def _is_of_a_name(character: str) -> bool:
    """Return whether it is a letter, a mark or a digit, and can be seen."""
    is_selector = "VARIATION SELECTOR" in unicodedata.name(character, "")
    return category(character)[0] in "LMN" and not is_selector


def _script(character: str) -> str:
    """Return the script of a letter or digit, as its name in Unicode begins; empty without one."""
    if character.isascii():
        return "LATIN" if character.isalpha() else ""
    if category(character)[0] == "M":
        return ""
    return unicodedata.name(character, "?").split()[0]
