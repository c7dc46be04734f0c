"""Checks the fields of a recorded map: type, length, and finiteness where the stream requires it."""

from typing import Any, get_args

import msgpack
import msgspec

Map = type[msgspec.Struct]
"""Fields of a map, as `map_of` defines them."""


def map_of(**fields: Any) -> Map:
    """Return a map's definition from the type of each field; a field that may be None may also be absent."""
    return msgspec.defstruct(
        "Map",
        [(name, kind, None) if type(None) in get_args(kind) else (name, kind) for name, kind in fields.items()],
        kw_only=True,
    )


def unpack(payload: bytes) -> Any:
    """Return the value of a MessagePack payload; raises ValueError where it is invalid."""
    try:
        return msgpack.unpackb(payload)
    except Exception as error:  # the library's exceptions have no common base
        raise ValueError(f"no MessagePack ({str(error) or type(error).__name__})") from None


def read_map(payload: bytes, fields: Map) -> dict[str, Any]:
    """Return a recorded map with at least these fields.

    Raises:
        ValueError: the payload is no such map; the message names the first field that does not fit.
    """
    found: dict[str, Any] = unpack(payload)
    try:
        msgspec.convert(found, fields)
    except msgspec.ValidationError as error:
        raise ValueError(str(error)) from None
    return found
