"""Reads and writes calibrated tables as JSON files, with checks and a hash."""

import hashlib
import json
import os
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any, Self, get_args

from pydantic import Field, ValidationError

from common.files.read_files import read_json
from common.files.strict_model import StrictModel

Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]


_CHANGED = "the file was changed after its calibration: take the original"


class TableFile(StrictModel):
    """A table in a file with a kind and a version.

    Attributes:
        kind: purpose of the table; a file of another kind is refused.
        schema_version: version of the table's fields.
        sensor_serial: serial number of the calibrated sensor; "unknown" if not given.
        made_on: ISO date of the calibration; "" if not given.
        content_hash: SHA-256 of all other fields; a table edited by hand is refused.
    """

    kind: str
    schema_version: int
    sensor_serial: str = "unknown"
    made_on: str = ""
    content_hash: str = ""

    def save(self, path: Path | str) -> None:
        """Write the table with its hash; a file before it is replaced once the table is written.

        Raises:
            OSError: the file cannot be written.
        """
        fields = self.model_dump(mode="json")
        fields["content_hash"] = _hash(fields)
        text = json.dumps(fields, indent=1) + "\n"
        file = Path(os.path.realpath(path))
        if file.exists() and not file.is_file():  # a device
            file.write_text(text, "utf-8")
            return
        part = file.with_name(f"{file.name}.part")
        try:
            part.write_text(text, "utf-8")
            part.replace(file)
        except OSError as error:
            with suppress(OSError):
                part.unlink(missing_ok=True)
            raise OSError(error.errno, error.strerror, str(path)) from None

    @classmethod
    def load(cls, path: Path | str) -> Self:
        """Read a table.

        Raises:
            ValueError: the file is missing, not JSON, of another kind or version, lacks a field, or was changed after
                it was written.
        """
        kind = cls.model_fields["kind"].default
        try:
            fields = read_json(Path(path))
        except OSError as error:
            raise ValueError(f"{path}: cannot be read: {error.strerror}") from None
        except ValueError:
            raise ValueError(f"{path}: not JSON; make a {kind} table with `teletaction calibrate`") from None
        if not isinstance(fields, dict) or fields.get("kind") != kind:
            raise ValueError(f"{path}: not a {kind} table; make one with `teletaction calibrate`")
        versions = get_args(cls.model_fields["schema_version"].annotation)
        if fields.get("schema_version") not in versions:
            raise ValueError(
                f"{path}: schema_version {fields.get('schema_version')!r}, this program reads "
                f"{' and '.join(map(str, versions))}; calibrate again"
            )
        try:
            table = cls.model_validate(fields)
        except ValidationError as error:
            first = error.errors()[0]
            where = ".".join(str(part) for part in first["loc"])
            what = f"{f'field {where}: ' if where else ''}{first['msg'].removeprefix('Value error, ')}"
            changed = "" if fields.get("content_hash") == _hash(fields) else f"{_CHANGED}, or "
            raise ValueError(f"{path}: {what}; {changed}calibrate again") from None
        if table.content_hash != _hash(fields):
            raise ValueError(f"{path}: content_hash does not match; {_CHANGED}, or calibrate again")
        return table


def _hash(fields: dict[str, Any]) -> str:
    """Return the hash of a table's fields as they are in its file."""
    hashed = {name: value for name, value in fields.items() if name != "content_hash"}
    return hashlib.sha256(json.dumps(hashed, sort_keys=True).encode()).hexdigest()
