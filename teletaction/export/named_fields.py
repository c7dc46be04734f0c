"""Names the values of recorded rows: fields by name, fingers by name, codes as text, unknown numbers as None.

The type of a row gives its names and its JSON schema. So neither can miss a field.
"""

import math
import re
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from msgspec import inspect

from common.fingers import FINGERS

Named = dict[str, Any]
Naming = Callable[[Any], Any]
Schema = dict[str, Any]
UNITS = {
    "_c": "C",
    "_k": "K",
    "_s": "s",
    "_ms": "ms",
    "_ns": "ns",
    "_us": "us",
    "_m": "m",
    "_n": "N",
    "_v": "V",
    "_mv": "mV",
    "_hz": "Hz",
    "_rpm": "rpm",
    "_permille": "1/1000",
    "_m_s": "m/s",
    "_rad_s": "rad/s",
    "_per_s": "1/s",
    "_n_m": "N/m",
    "_n_s_m": "N s/m",
    "_w_m2": "W/m2",
    "_w_mk": "W/(m K)",
    "_kg_m3": "kg/m3",
    "_j_kgk": "J/(kg K)",
}
"""Unit of a quantity by the end of its field's name; the longest end that fits counts."""
_DEVIATION = re.compile("_sd(?=_|$)")


def unit_of(name: str) -> str:
    """Return the unit of a field by its name, such as "N/m" of `stiffness_n_m`; empty where the name has none."""
    if "_ln_sd" in name:
        return "1"
    plain = _DEVIATION.sub("", name)
    ends = [end for end in UNITS if plain.endswith(end)]
    return UNITS[max(ends, key=len)] if ends else ""


def finite(value: float | None) -> float | None:
    """Return a finite number, or None for one that is unknown or infinite."""
    return value if value is not None and math.isfinite(value) else None


def grouped(plain: Named, by_finger: Mapping[str, Any]) -> Named:
    """Return the plain values of the whole hand, then for each finger a map of its values, in the order of FINGERS."""
    if not by_finger:
        return plain
    return plain | {
        finger: {name: values[number] for name, values in by_finger.items()} for number, finger in enumerate(FINGERS)
    }


def naming_of(kind: inspect.Type) -> Naming:
    """Return the function that names a value of this type."""
    match kind:
        case inspect.StructType() | inspect.NamedTupleType():
            return _row_naming(kind)
        case inspect.UnionType():
            naming = naming_of(_present(kind))
            return lambda value: None if value is None else naming(value)
        case inspect.ListType(item_type=item) | inspect.VarTupleType(item_type=item):
            naming = naming_of(item)
            return lambda values: list(map(naming, values))
        case inspect.BytesType():
            return lambda counts: np.frombuffer(counts, "<i2").tolist()
        case inspect.FloatType():
            return finite
        case inspect.EnumType():
            return str
    return lambda value: value


def _row_naming(kind: inspect.StructType | inspect.NamedTupleType) -> Naming:
    plain = {field.encode_name: naming_of(field.type) for field in kind.fields if not _five(field.type)}
    fingers = {field.encode_name: naming_of(field.type) for field in kind.fields if _five(field.type)}

    def named(row: Any) -> Named:
        return grouped(
            {name: naming(getattr(row, name)) for name, naming in plain.items()},
            {name: naming(getattr(row, name)) for name, naming in fingers.items()},
        )

    return named


def schema_of(kind: inspect.Type, name: str = "") -> Schema:
    """Return the JSON schema of what `naming_of` returns; a number has its `unit`. A value of None is left out."""
    match kind:
        case inspect.StructType() | inspect.NamedTupleType():
            plain = {f.encode_name: schema_of(f.type, f.encode_name) for f in kind.fields if not _five(f.type)}
            fingers = {f.encode_name: schema_of(f.type, f.encode_name)["items"] for f in kind.fields if _five(f.type)}
            return object_schema(plain, fingers)
        case inspect.UnionType():
            return schema_of(_present(kind), name)
        case inspect.ListType(item_type=item) | inspect.VarTupleType(item_type=item):
            return {"type": "array", "items": schema_of(item, name)}
        case inspect.BytesType():
            return {"type": "array", "items": {"type": "integer"}}
        case inspect.FloatType():
            return number_schema(name)
        case inspect.IntType():
            return {**number_schema(name), "type": "integer"}
        case inspect.BoolType():
            return {"type": "boolean"}
    return {"type": "string"}


def object_schema(plain: Mapping[str, Schema], by_finger: Mapping[str, Schema]) -> Schema:
    """Return the JSON schema of a map that `grouped` returns."""
    fingers = {finger: {"type": "object", "properties": dict(by_finger)} for finger in FINGERS if by_finger}
    return {"type": "object", "properties": {**plain, **fingers}}


def number_schema(name: str, unit: str | None = None, meaning: str = "") -> Schema:
    """Return the JSON schema of a number: its unit, by default that of its name, and its meaning."""
    unit = unit_of(name) if unit is None else unit
    schema = {"type": "number", "unit": unit, "description": ", ".join(filter(None, (unit, meaning)))}
    return {key: text for key, text in schema.items() if text}


def _five(kind: inspect.Type) -> bool:
    return isinstance(kind, inspect.ListType | inspect.VarTupleType) and kind.max_length == len(FINGERS)


def _present(kind: inspect.UnionType) -> inspect.Type:
    """The type of a value that may be None."""
    (present,) = (each for each in kind.types if not isinstance(each, inspect.NoneType))
    return present
