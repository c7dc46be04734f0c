"""Checks the fields of a recorded message: type, length, and finiteness where the stream requires it."""

import math
from collections.abc import Callable, Mapping
from typing import Any

import msgpack

from common.fingers import FINGERS

Fits = Callable[[Any], bool]
_LARGEST_WHOLE = 1 << 63


def real(value: Any) -> bool:
    """Return whether `value` is a number; NaN and infinity stand for unknown numbers."""
    return type(value) is float or whole(value)


def number(value: Any) -> bool:
    """Return whether `value` is a finite number."""
    return real(value) and math.isfinite(value)


def whole(value: Any) -> bool:
    """Return whether `value` is a whole number of 64 bits."""
    return type(value) is int and -_LARGEST_WHOLE <= value < _LARGEST_WHOLE


def flag(value: Any) -> bool:
    """Return whether `value` is true or false."""
    return type(value) is bool


def text(value: Any) -> bool:
    """Return whether `value` is a text."""
    return type(value) is str


def maybe(fits: Fits) -> Fits:
    """Return a check that accepts null and values that fit."""
    return lambda value: value is None or fits(value)


def five(fits: Fits) -> Fits:
    """Return a check for a list with one fitting value for each finger."""
    return lambda value: type(value) is list and len(value) == len(FINGERS) and all(map(fits, value))


def unpack(payload: bytes) -> Any:
    """Return the value of a MessagePack payload; raises ValueError where it is invalid."""
    try:
        return msgpack.unpackb(payload)
    except Exception as error:  # the library's exceptions have no common base
        raise ValueError(f"no MessagePack ({str(error) or type(error).__name__})") from None


def read_map(payload: bytes, fields: Mapping[str, Fits]) -> dict[str, Any]:
    """Return a map with at least these fields; a field that may be null may also be absent.

    Raises:
        ValueError: the payload is no such map; the message names the first field that does not fit.
    """
    found = unpack(payload)
    if type(found) is not dict or not all(map(text, found)):
        raise ValueError("not a map of named fields")
    _check(found, fields)
    return found


def _check(found: Mapping[str, Any], fields: Mapping[str, Fits]) -> None:
    for name, fits in fields.items():
        if not fits(found.get(name)):
            value = repr(found.get(name))
            raise ValueError(f"field {name} cannot be {value if len(value) <= 60 else value[:59] + '…'}")
