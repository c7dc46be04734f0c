import pytest
from hypothesis import given
from hypothesis import strategies as st

from teletaction.tunnel.greeting import (
    is_proved,
    new_hello,
    read_hello,
    read_request,
    read_stream,
    refused,
    request,
    stream_line,
)

SECRET = b"x" * 32


@pytest.mark.parametrize("port", [None, 0, 4])
def test_a_request_is_proved_by_the_secret_for_its_own_number_only(port: int | None) -> None:
    hello, number = new_hello()
    asked = read_request(request(SECRET, read_hello(hello), "ward-3", port))
    assert (asked.room, asked.port) == ("ward-3", port)
    assert is_proved(asked, SECRET, number)
    assert not is_proved(asked, b"y" * 32, number)
    assert not is_proved(asked, SECRET, new_hello()[1])
    for other in (asked._replace(text="serve ward-4"), asked._replace(proof="0" * 64)):
        assert not is_proved(other, SECRET, number)


@given(st.text())
def test_any_other_line_is_an_error(line: str) -> None:
    for read in (read_hello, read_request, read_stream):
        with pytest.raises(ValueError, match=r"."):
            read(line)


def test_a_refusal_gives_its_reason() -> None:
    assert read_stream(stream_line(3)) == 3
    with pytest.raises(ValueError, match=r"^not here$"):
        read_stream(refused("not here"))
