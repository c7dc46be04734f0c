import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.files.printable import LONGEST, printable, printable_lines

ANY_TEXT = st.text(st.characters(exclude_categories=()), max_size=300) | st.text(
    st.characters(categories=("L", "N", "P", "S")), max_size=100
)


@given(ANY_TEXT, st.integers(0, 40))
def test_any_text_is_one_printable_line_of_bounded_length_and_lines_of_a_note_stay_lines(
    text: str, longest: int
) -> None:
    shown = printable(text, longest)
    assert shown.isprintable()
    assert len(shown.splitlines()) <= 1
    assert len(shown) <= longest + len(f"... ({len(text)} characters)")
    shown.encode("utf-8")
    if text.isprintable():
        assert printable(text) == text
    assert [line.isprintable() for line in printable_lines(text).split("\n")] == [True] * (text.count("\n") + 1)


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("a\nb\r\n", r"a\nb\r\n"),
        ("\x1b[2J\x9b31m\x7f", r"\x1b[2J\x9b31m\x7f"),
        ("\u202eabc\u2066\u2028", r"\u202eabc\u2066\u2028"),
        ("\udc80", r"\udc80"),
        ("Übergröße 42 °C", "Übergröße 42 °C"),
        ("x" * (LONGEST + 1), "x" * LONGEST + f"... ({LONGEST + 1} characters)"),
    ],
)
def test_terminal_control_characters_are_escaped(text: str, shown: str) -> None:
    assert printable(text) == shown
