"""Rows of a recording: one definition of a row's fields serves its writer, its readers and the stream's schema."""

import sys
from typing import Annotated, Self, TypeVar

import msgspec
from msgspec import Meta, Struct, inspect

from common.fingers import FINGERS
from common.wire.misfit import misfit

T = TypeVar("T")
Finite = Annotated[float, Meta(ge=-sys.float_info.max, le=sys.float_info.max)]
"""A finite number; a plain float may be infinite or NaN where a value is unknown."""
Whole = Annotated[int, Meta(ge=-(2**63), le=2**63 - 1)]
FingerNumber = Annotated[int, Meta(ge=0, le=len(FINGERS) - 1)]
_EACH = Meta(min_length=len(FINGERS), max_length=len(FINGERS))
Five = Annotated[list[T], _EACH]
"""A list with one value for each finger."""
FixedFive = Annotated[tuple[T, ...], _EACH]
"""An immutable sequence with one value for each finger."""
_pack = msgspec.msgpack.Encoder().encode


class Row(Struct, array_like=True, forbid_unknown_fields=True):
    """A message that is recorded as a list of its fields, in order. No field has a default value."""

    def pack(self) -> bytes:
        """Return the bytes for the recording; values are not rounded."""
        return _pack(self)

    @classmethod
    def unpack(cls, payload: bytes) -> Self:
        """Read the bytes that `pack` returned.

        Raises:
            ValueError: the payload is no such row; the message names the first field that does not fit.
        """
        try:
            return msgspec.msgpack.decode(payload, type=cls)
        except Exception as error:  # exceptions over damaged bytes have no common base
            raise ValueError(misfit(cls.__struct_fields__, str(error))) from None

    @classmethod
    def schema(cls) -> dict[str, object]:
        """Return the schema of a stream of these rows: the fields' names and types."""
        return {"type": "array", "description": f"{_layout(inspect.type_info(cls))}: {cls.__doc__}"}


def _layout(kind: inspect.Type) -> str:
    """Return the fields of a row, such as "[time_s, z_m x 5, gap_ns or null]"."""
    assert isinstance(kind, inspect.StructType | inspect.NamedTupleType)
    return f"[{', '.join(field.encode_name + _shape(field.type) for field in kind.fields)}]"


def _shape(kind: inspect.Type) -> str:
    match kind:
        case inspect.UnionType(types=parts):
            return "".join(map(_shape, parts)) + " or null"
        case inspect.ListType(item_type=item) | inspect.VarTupleType(item_type=item) if kind.max_length:
            return f" x {kind.max_length}{_shape(item)}"
        case inspect.StructType() | inspect.NamedTupleType():
            return f" ({_layout(kind)})"
    return ""
