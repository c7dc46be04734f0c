"""Names the environment variable with the secret keys that open encrypted recordings."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

KEY_VARIABLE = "TELETACTION_KEY"
"""Files of secret keys or key folders, separated by `:`."""


@contextmanager
def given_key(path: Path) -> Iterator[None]:
    """Give this process, and those that it starts, one key; the environment is restored at the end."""
    before = os.environ.get(KEY_VARIABLE)
    os.environ[KEY_VARIABLE] = str(path)
    try:
        yield
    finally:
        if before is None:
            del os.environ[KEY_VARIABLE]
        else:
            os.environ[KEY_VARIABLE] = before
