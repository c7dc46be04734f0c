"""The tables that ship with the remote site fit the scenes and the surfaces that ship with the program."""

import pytest

from common.scenes.scene import load_scene, scene_names
from common.scenes.surfaces import surface_kind
from operator_site.session.session_client import LONGEST_DESCRIPTION
from remote_site.texture.surface_table import SurfaceTable
from remote_site.thermal.material_table import MaterialTable
from teletaction.make_tables import STROKED
from teletaction.session.demo_files import SURFACES, calibrated_tables


@pytest.mark.parametrize("name", scene_names())
def test_every_scene_has_a_table_with_its_calibrated_materials(name: str) -> None:
    materials, _ = calibrated_tables(name)
    assert set(MaterialTable.load(materials).names()) == set(load_scene(name).calibrated)


def test_the_description_of_a_table_fits_on_the_page() -> None:
    table = MaterialTable.load(calibrated_tables("phantom")[0])
    described = f"Calibrated {table.made_on} (sensor simulated), 600 touches, effusivity ± 8 %"
    assert table.described() == described
    assert table.model_copy(update={"made_on": ""}).described().startswith("Calibrated at no known date (sensor")
    assert len(described) <= LONGEST_DESCRIPTION


def test_measured_surfaces_have_the_constants_of_virtual_ones() -> None:
    table = SurfaceTable.load(SURFACES)
    assert {surface.name for surface in table.surfaces} == set(STROKED)
    for surface in table.surfaces:
        kind = surface_kind(surface.name)
        assert (surface.k_stroke_v, surface.k_stroke_f) == (kind.k_stroke_v, kind.k_stroke_f)
        assert (surface.period_mm is not None) == (kind.grooves is not None)
