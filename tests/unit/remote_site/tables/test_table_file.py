"""A table that cannot be written leaves the one before; one that a session cannot use is refused."""

import errno
import os
import resource
from collections.abc import Iterator
from pathlib import Path

import pytest

from remote_site.thermal.material_table import MaterialTable
from teletaction.session.demo_files import TABLES

SHIPPED = TABLES / "materials.json"


@pytest.fixture
def full_disk() -> Iterator[None]:
    """Files have room for 1000 bytes."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.usefixtures("full_disk")
def test_a_full_disk_keeps_the_table_and_is_named(tmp_path: Path) -> None:
    table, path = MaterialTable.load(SHIPPED), tmp_path / "table.json"
    path.write_bytes(b"before")
    with pytest.raises(OSError, match="too large") as failed:
        table.save(path)
    assert (failed.value.errno, failed.value.filename) == (errno.EFBIG, str(path))
    assert path.read_bytes() == b"before"
    assert [file.name for file in tmp_path.iterdir()] == ["table.json"]


def test_a_table_whose_names_no_packet_can_carry_is_refused(tmp_path: Path) -> None:
    table, path = MaterialTable.load(SHIPPED), tmp_path / "table.json"
    for length in (40, 41):
        named = table.materials[0].model_copy(update={"name": "x" * length})
        table.model_copy(update={"materials": [named, *table.materials[1:]]}).save(path)
        if length == 40:
            assert MaterialTable.load(path).names()[0] == "x" * 40
    with pytest.raises(ValueError, match=r"table.json: field materials.0.name: .*40 characters; calibrate again"):
        MaterialTable.load(path)


def test_a_link_to_a_table_stays_a_link(tmp_path: Path) -> None:
    table, path = MaterialTable.load(SHIPPED), tmp_path / "table.json"
    path.symlink_to("there.json")
    table.save(path)
    assert path.is_symlink()
    assert MaterialTable.load(tmp_path / "there.json") == table


def test_a_table_may_go_to_a_device() -> None:
    MaterialTable.load(SHIPPED).save(os.devnull)
    assert Path(os.devnull).is_char_device()


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"noise_k"', '"noise"', "field noise_k: Field required"),
        ('"half_force_n": 0', '"half_force_n": -0', "field half_force_n: Input should be greater than 0"),
        ('"half_force_n": 0', '"half_force_n": 1', "content_hash does not match"),
        ('"pvc"', '"pine"', "a material is listed twice"),
    ],
)
def test_a_table_that_was_edited_by_hand_is_refused_with_what_to_do(
    tmp_path: Path, old: str, new: str, said: str
) -> None:
    path, text = tmp_path / "table.json", SHIPPED.read_text("utf-8")
    assert old in text
    path.write_text(text.replace(old, new, 1), "utf-8")
    advice = "the file was changed after its calibration: take the original, or calibrate again"
    with pytest.raises(ValueError, match=rf"^{path}: {said}; {advice}$"):
        MaterialTable.load(path)
