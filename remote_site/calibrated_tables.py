"""Loads the calibrated tables that a remote site's configuration names."""

from common.config.site_models import RemoteConfig
from remote_site.texture.surface_table import SurfaceTable
from remote_site.thermal.material_table import MaterialTable


def load_tables(config: RemoteConfig) -> tuple[MaterialTable, SurfaceTable]:
    """Read the site's calibrated tables; raises ValueError where a table cannot be used."""
    return MaterialTable.load(config.calibration.materials), SurfaceTable.load(config.calibration.surfaces)
