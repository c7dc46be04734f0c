"""The tables that the remote site ships with, and identification with them."""

from collections.abc import Iterable

from remote_site.identification.perception import Perception
from remote_site.texture.surface_table import SurfaceTable
from remote_site.thermal.material_table import MaterialTable
from tests.places import TABLES

SURFACES = SurfaceTable.load(TABLES / "surfaces.json")


def perception(fingers: Iterable[str], materials: str = "materials") -> Perception:
    """Identification by these fingers of the materials of one table."""
    return Perception(fingers, MaterialTable.load(TABLES / f"{materials}.json"), SURFACES)
