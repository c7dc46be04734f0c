"""Removes web addresses of packages from a bill of materials: `python -m tests.packaging.trim_sbom FILE`."""

import json
import sys
from pathlib import Path
from typing import Any


def trimmed(value: Any) -> Any:
    """The same JSON value without the external references of components and tools."""
    if isinstance(value, dict):
        return {name: trimmed(part) for name, part in value.items() if name != "externalReferences"}
    return [trimmed(part) for part in value] if isinstance(value, list) else value


if __name__ == "__main__":
    path = Path(sys.argv[1])
    path.write_text(json.dumps(trimmed(json.loads(path.read_text("utf-8"))), indent=2) + "\n", "utf-8")
