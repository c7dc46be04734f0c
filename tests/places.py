"""Folders and files of the repository that tests read."""

import os
from pathlib import Path

ROOT = Path(__file__).parents[1]
GOLDEN = ROOT / "tests" / "golden" / "session.mcap"
TABLES = ROOT / "remote_site" / "tables"
DATA = Path(os.environ.get("TELETACTION_DATA", ROOT.parent / "shared" / "data"))
"""Real recordings. They are not in the repository."""
