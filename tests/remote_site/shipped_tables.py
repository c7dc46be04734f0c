"""The tables that the remote site ships with, and identification with them."""

from collections.abc import Iterable
from pathlib import Path

from remote_site.material_table import MaterialTable
from remote_site.perception import Perception
from remote_site.surface_class import SurfaceTable

TABLES = Path(__file__).parents[2] / "remote_site" / "tables"
SURFACES = SurfaceTable.load(TABLES / "surfaces.json")


def perception(fingers: Iterable[str], materials: str = "materials") -> Perception:
    """Identification by these fingers of the materials of one table."""
    return Perception(fingers, MaterialTable.load(TABLES / f"{materials}.json"), SURFACES)
