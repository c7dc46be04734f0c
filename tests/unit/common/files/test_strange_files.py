"""Files that people write, and wrong ones in their place: one line that names the file, never a traceback."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from common.config.file import load_config, load_site
from common.config.page_models import ConsoleConfig
from common.config.simulation_models import SimNetworkConfig
from common.config.site_models import OperatorConfig, RemoteConfig
from common.health import NoStatus, find_problem, read_status
from common.scenes.materials import read_materials
from common.scenes.scene import load_scene
from common.scenes.surfaces import read_surfaces
from remote_site.texture.recorded.identify_texture import load_surfaces
from remote_site.thermal.material_table import MaterialTable
from sim_sensors.network.file import load_network
from tests.places import ROOT
from tests.unit.common.config.test_file import OPERATOR, REMOTE

Reader = Callable[[Path], object]

COMMON = ROOT / "common"
SCENE = (COMMON / "scenes" / "materials.toml").read_text("utf-8")
TOML_READERS: dict[str, tuple[Reader, str]] = {
    "operator": (lambda path: load_config(path, OperatorConfig), OPERATOR),
    "remote": (lambda path: load_config(path, RemoteConfig), REMOTE),
    "site": (load_site, OPERATOR),
    "console": (lambda path: load_config(path, ConsoleConfig), 'keys = "keys"\nport = 1\n'),
    "network process": (lambda path: load_config(path, SimNetworkConfig), 'network = "lan"\nbase_port = 1\n'),
    "scene": (lambda path: load_scene(str(path)), SCENE),
    "network": (lambda path: load_network(str(path)), "[[phase]]\nfrom_s = 0\ndelay_ms = 10\n"),
    "surfaces": (read_surfaces, (COMMON / "scenes" / "constants" / "surfaces.toml").read_text("utf-8")),
    "materials": (read_materials, (COMMON / "scenes" / "constants" / "materials.toml").read_text("utf-8")),
}
JSON_READERS: dict[str, Reader] = {
    "materials": MaterialTable.load,
    "surfaces": load_surfaces,
    "status": lambda path: read_status(path, 0),
}
CSV = "send_time_s,rtt_ms\n0.0,10\n1.0,12\n"
DEEP, DIGITS, HEX = "[" * 3000, "9" * 5000, "0x" + "f" * 5000
SIGNS = ("=", "\n", "[", "]", "[[", "]]", "{", "}", '"', "'", ".", ",", "#", "\x1b[2J", "\u202e", "é", "\0", "\\u0000")
WORDS = ("1e999", "nan", "-1", "true", DEEP, DIGITS, HEX, "a." * 3000, "link", "keys", "thumb", "tacttip", "phase")
PIECES = st.sampled_from(SIGNS + WORDS)
BYTES = st.binary(max_size=200) | st.lists(PIECES, max_size=12).map(lambda pieces: "".join(pieces).encode())
FUZZED = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=60)


def tried(read: Reader, path: Path) -> str:
    """What a reader says of a file that it cannot use, in one line that names the file; empty where it can."""
    try:
        read(path)
    except ValueError as error:
        said = str(error)
    else:
        return ""
    assert str(path) in said
    assert len(said.splitlines()) == 1
    assert len(said) < 5000
    return said


@pytest.mark.parametrize("name", TOML_READERS)
@FUZZED
@given(data=st.data())
def test_any_toml_is_read_or_tried(name: str, data: st.DataObject, tmp_path: Path) -> None:
    read, sound = TOML_READERS[name]
    file = tmp_path / "file.toml"
    content = sound.encode()
    start = data.draw(st.integers(0, len(content)))
    file.write_bytes(data.draw(BYTES))
    tried(read, file)
    file.write_bytes(content[:start] + data.draw(BYTES) + content[start + data.draw(st.integers(0, 20)) :])
    tried(read, file)


@pytest.mark.parametrize("name", JSON_READERS)
@FUZZED
@given(content=BYTES)
@example(content=b"[" * 100_000)
@example(content=b'{"kind": "thermal_materials", "schema_version": ' + b"9" * 5000 + b"}")
@example(content=b"\xff")
def test_any_json_is_read_or_tried(name: str, content: bytes, tmp_path: Path) -> None:
    file = tmp_path / "file.json"
    file.write_bytes(content)
    tried(JSON_READERS[name], file)


@FUZZED
@given(start=st.integers(0, len(CSV)), content=BYTES, end=st.integers(0, len(CSV)))
def test_any_csv_of_round_trips_is_read_or_refused(start: int, content: bytes, end: int, tmp_path: Path) -> None:
    file = tmp_path / "file.csv"
    file.write_bytes(CSV[:start].encode() + content + CSV[end:].encode())
    tried(TOML_READERS["network"][0], file)
    file.unlink()
    os.mkfifo(file)
    assert "is no regular file" in tried(TOML_READERS["network"][0], file)
    file.unlink()


@pytest.mark.parametrize("name", TOML_READERS)
@pytest.mark.parametrize(
    ("line", "says"),
    [
        (f"x = {DEEP}", "nested too deeply (at line 3)"),
        (f"x = {DIGITS}", "a number of too many digits (at line 3)"),
        ('x = "\\u0000"', "a zero byte (at line 3)"),
        ("# \udcff", "not UTF-8 (at line 3)"),
        ("x = = 1", "(at line 3, column 5)"),
        ('x = """', "(at end of document)"),
    ],
)
def test_an_unreadable_file_is_named_with_its_line(name: str, line: str, says: str, tmp_path: Path) -> None:
    file = tmp_path / "file.toml"
    file.write_bytes(b"# one\n# two\n" + line.encode("utf-8", "surrogateescape") + b"\n")
    assert f"{file}: not TOML: " in (said := tried(TOML_READERS[name][0], file))
    assert says in said


def large(path: Path) -> None:
    """Make a file of 65 MiB that takes no place on the disk."""
    with path.open("wb") as file:
        file.truncate(65 << 20)


@pytest.mark.parametrize("name", [*TOML_READERS, *(f"json {name}" for name in JSON_READERS)])
@pytest.mark.parametrize(
    ("make", "says"),
    [
        (os.mkfifo, "is no regular file"),
        (os.mkdir, "Is a directory"),
        (large, "is larger than"),
        (lambda path: path.symlink_to(path), "symbolic links"),
        (lambda path: None, "No such file or directory"),
    ],
)
def test_a_path_that_is_no_file_is_refused_without_waiting(
    name: str, make: Callable[[Path], object], says: str, tmp_path: Path
) -> None:
    json_name = name.removeprefix("json ")
    read, ending = (TOML_READERS[name][0], "toml") if name in TOML_READERS else (JSON_READERS[json_name], "json")
    path = tmp_path / f"file.{ending}"
    make(path)
    assert says in tried(read, path)


def test_a_status_file_that_is_damaged_is_no_status(tmp_path: Path) -> None:
    file = tmp_path / "status.json"
    for content in ("", DEEP, "{}", '{"time_ns": "soon"}', '{"time_ns": null}', '{"time_ns": ' + DIGITS + "}", "[]"):
        file.write_text(content)
        with pytest.raises(NoStatus, match="not a status file"):
            read_status(file, 0)
        assert find_problem(file, 0).endswith("not a status file")


@pytest.mark.parametrize("name", ["bind", "recorded"])
def test_a_key_of_a_table_cannot_forge_a_line(name: str, tmp_path: Path) -> None:
    file = tmp_path / "file.toml"
    file.write_text(f'"{name}\\n\\u001b[2J" = 1\n' + REMOTE, "utf-8")
    assert tried(TOML_READERS["remote"][0], file).isprintable()
