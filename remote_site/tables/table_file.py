"""Reads and writes calibrated tables as JSON files, with checks and a hash."""

import hashlib
import json
from pathlib import Path
from typing import Any, Self

from pydantic import BaseModel, ConfigDict, ValidationError

from common.files.read_files import read_json


class TableFile(BaseModel):
    """A table in a file with a kind and a version.

    Attributes:
        kind: purpose of the table; a file of another kind is refused.
        schema_version: version of the table's fields.
        sensor_serial: serial number of the calibrated sensor; "unknown" if not given.
        made_on: ISO date of the calibration; "" if not given.
        content_hash: SHA-256 of all other fields; a table edited by hand is refused.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    kind: str
    schema_version: int
    sensor_serial: str = "unknown"
    made_on: str = ""
    content_hash: str = ""

    def _hash(self) -> str:
        fields: dict[str, Any] = self.model_dump(mode="json", exclude={"content_hash"})
        return hashlib.sha256(json.dumps(fields, sort_keys=True).encode()).hexdigest()

    def save(self, path: Path | str) -> None:
        """Write the table with its hash.

        Raises:
            OSError: the file cannot be written.
        """
        fields = self.model_dump(mode="json")
        fields["content_hash"] = self._hash()
        Path(path).write_text(json.dumps(fields, indent=1) + "\n", "utf-8")

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
        version = cls.model_fields["schema_version"].default
        if fields.get("schema_version") != version:
            raise ValueError(
                f"{path}: schema_version {fields.get('schema_version')!r}, this program reads {version}; "
                "calibrate again"
            )
        try:
            table = cls.model_validate(fields)
        except ValidationError as error:
            first = error.errors()[0]
            where = ".".join(str(part) for part in first["loc"])
            raise ValueError(f"{path}: field {where}: {first['msg']}") from None
        if table.content_hash != table._hash():
            raise ValueError(f"{path}: content_hash does not match: the file was changed; calibrate again")
        return table
