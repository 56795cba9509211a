import pytest

from studies.model.plain_text import is_storable, name_problem, one_line, two_digits


def test_seconds_have_no_exponent() -> None:
    assert [two_digits(one) for one in (0.0123, 1.26, 123.4)] == ["0.012", "1.3", "120"]


def test_a_text_is_one_line_of_at_most_so_many_characters() -> None:
    assert one_line("abcd", 4) == "abcd"
    assert one_line("abcde", 4) == "abcd ..."
    assert one_line("a \n\t b\r\nc") == "a b c"
    assert one_line("a\x07b") == r"a\x07b"
    assert one_line("x" * 2000) == "x" * 2000
    assert one_line("x" * 2001) == "x" * 2000 + " ..."

    class Silent:
        def __str__(self) -> str:
            raise ValueError

    assert one_line(Silent()) == "(no text: its __str__ raises ValueError)"


@pytest.mark.parametrize(("text", "storable"), [("a\tb\n", True), ("a\x00", False), ("\x7f", False), ("é", True)])
def test_control_characters_are_not_stored(text: str, storable: bool) -> None:  # noqa: FBT001
    assert is_storable(text) == storable


def test_any_printable_name_up_to_250_bytes_is_taken() -> None:
    assert not any(map(name_problem, ("a" * 250, "é" * 125, "_a", "éa")))
