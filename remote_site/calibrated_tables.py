"""The calibrated tables of a remote site, as its configuration names them."""

from common.config import RemoteConfig
from remote_site.material_table import MaterialTable
from remote_site.surface_class import SurfaceTable


def load_tables(config: RemoteConfig) -> tuple[MaterialTable, SurfaceTable]:
    """Read the site's calibrated tables; raises ValueError when one cannot be used."""
    return MaterialTable.load(config.calibration.materials), SurfaceTable.load(config.calibration.surfaces)
