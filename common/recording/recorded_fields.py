"""Checks the fields of a recorded message: kind, length, and where a stream promises it, finiteness."""

import math
from collections.abc import Callable, Mapping
from typing import Any

import msgpack

from common.fingers import FINGERS

Fits = Callable[[Any], bool]
_LARGEST_WHOLE = 1 << 63


def real(value: Any) -> bool:
    """A number; not-a-number and infinity are numbers that are not known."""
    return type(value) is float or whole(value)


def number(value: Any) -> bool:
    """A finite number."""
    return real(value) and math.isfinite(value)


def whole(value: Any) -> bool:
    """A whole number of 64 bits."""
    return type(value) is int and -_LARGEST_WHOLE <= value < _LARGEST_WHOLE


def flag(value: Any) -> bool:
    """True or false."""
    return type(value) is bool


def text(value: Any) -> bool:
    """A text."""
    return type(value) is str


def maybe(fits: Fits) -> Fits:
    """Null, or what fits."""
    return lambda value: value is None or fits(value)


def five(fits: Fits) -> Fits:
    """A list with one for each finger."""
    return lambda value: type(value) is list and len(value) == len(FINGERS) and all(map(fits, value))


def unpack(payload: bytes) -> Any:
    """The value of a MessagePack payload; raises ValueError where it is none."""
    try:
        return msgpack.unpackb(payload)
    except Exception as error:  # what the library raises has no common base
        raise ValueError(f"no MessagePack ({str(error) or type(error).__name__})") from None


def read_map(payload: bytes, fields: Mapping[str, Fits]) -> dict[str, Any]:
    """A map that has these fields, and perhaps more; one that may be null may also be absent.

    Raises:
        ValueError: it is something else; the message names the first field that does not fit.
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
