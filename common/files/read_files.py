"""Reads TOML and JSON files that people write; an invalid file gives an error of one line."""

import json
import re
import tomllib
from pathlib import Path
from typing import Any

from common.files.whole_file import read_whole

MOST_JSON_BYTES = 64 << 20
"""Maximum size of a JSON file, bytes; a table of spectra has 1 MiB."""
_ZERO = re.compile(r"\\u0000|\\U00000000")


class NotToml(ValueError):
    """Text that is no usable TOML; the message names the line."""


def read_toml(path: Path) -> tuple[str, dict[str, Any]]:
    """Return the text and the content of a TOML file.

    Raises:
        OSError: the file cannot be read, is not a regular file, or is too large.
        NotToml: the file is not TOML in UTF-8.
    """
    content, _ = read_whole(path)
    try:
        text = content.decode("utf-8-sig")  # some editors begin a file with a byte order mark
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise NotToml(f"not TOML: not UTF-8 (at line {line})") from None
    return text, parse_toml(text)


def read_tables(path: Path) -> dict[str, Any]:
    """Return the content of a TOML file; raises ValueError that names the file where it cannot be used."""
    try:
        return read_toml(path)[1]
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror}") from None
    except NotToml as error:
        raise ValueError(f"{path}: {error}") from None


def parse_toml(text: str) -> dict[str, Any]:
    """Return the content of a TOML text.

    Raises:
        NotToml: the text is not TOML, is nested too deeply, or has too long a number or a string with a zero byte.
    """
    if zero := _ZERO.search(text):
        line = text.count("\n", 0, zero.start()) + 1
        raise NotToml(f"not TOML: a zero byte (at line {line})")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        hint = "; put a path with \\ between single quotes" if "\\" in str(error) or "hex value" in str(error) else ""
        raise NotToml(f"not TOML: {error}{hint}") from None
    except RecursionError:
        line = _first_line(text, RecursionError)
        raise NotToml(f"not TOML: nested too deeply (at line {line})") from None
    except ValueError:
        line = _first_line(text, ValueError)
        raise NotToml(f"not TOML: a number of too many digits (at line {line})") from None


def read_json(path: Path) -> Any:
    """Return the content of a JSON file.

    Raises:
        OSError: the file cannot be read, is not a regular file, or is too large.
        ValueError: the file is not JSON in UTF-8, is nested too deeply, or has an integer with too many digits.
    """
    content, _ = read_whole(path, MOST_JSON_BYTES)
    try:
        return json.loads(content.decode("utf-8-sig"))
    except RecursionError:
        raise ValueError("nested too deeply") from None


def _first_line(text: str, kind: type[Exception]) -> int:
    """Return the first line at whose end the parser raises `kind`; bisection works, as parsing begins at the start."""
    lines = text.splitlines(keepends=True)
    low, high = 1, len(lines)
    while low < high:
        middle = (low + high) // 2
        if _raises(kind, "".join(lines[:middle])):
            high = middle
        else:
            low = middle + 1
    return low


def _raises(kind: type[Exception], text: str) -> bool:
    try:
        tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return False
    except kind:
        return True
    return False
