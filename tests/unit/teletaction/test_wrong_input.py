"""Wrong input answers in one line with exit 2, and names what is wrong."""

import fcntl
import json
import os
import shlex
import socket
import tomllib
from pathlib import Path

import pytest

from common.config.advice import COMMANDS
from common.link.keys import TrustedKeys
from teletaction.session.demo_files import SURFACES, TABLES
from tests.commands import command, one_line

THERMAL = "time_s,sensor_c,force_n\n" + "".join(f"{0.01 * n:.2f},33.0,0.0\n" for n in range(50))
IDENTIFY = f"identify thermal --table {TABLES / 'materials.json'}"
VIRTUAL = "virtual --config operator.toml"


def refused(line: str) -> str:
    """The one line that a command ends with that must be refused."""
    return one_line(command(*shlex.split(line)), 2)


def edit(path: Path, old: str, new: str) -> None:
    text = path.read_text("utf-8")
    assert old in text
    path.write_text(text.replace(old, new), "utf-8")


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("frobnicate", "frobnicate"),
        ("demo --frobnicate", "--frobnicate"),
        ("demo --fingers 9", "--fingers"),
        (
            "demo --headless --scene atlantis --out o",
            "unknown scene 'atlantis'; known: abdomen, materials, paper_iron_wood",
        ),
        *(
            (
                f"demo --headless --rates 200,200 --out o --seconds {seconds}",
                f"--seconds {seconds}: must be a time above 0",
            )
            for seconds in ("-1", "0", "inf", "nan")
        ),
        ("demo --headless --rates 200,200 --out o --patient-stop inf", "--patient-stop inf: must be a time"),
        (f"{VIRTUAL} --scene atlantis", "unknown scene 'atlantis'; known: abdomen, materials, paper_iron_wood"),
        (f"{VIRTUAL} --scene none.toml", "none.toml: cannot read"),
        (f"{VIRTUAL} --scene own.toml", "own.toml: materials: balsa: conductivity_w_mk is missing"),
        (VIRTUAL, "--scene"),
        (f"{VIRTUAL} --scene materials --seed -1", "--seed"),
        ("virtual --scene materials --config remote.toml", "remote.toml"),
        # A table that cannot be written is refused before the fit, which takes minutes.
        ("calibrate thermal --traces none --out none/table.json", "none/table.json: No such file or directory"),
        ("calibrate thermal --traces none --out .", ".: Is a directory"),
        ("calibrate thermal --traces none --out t --report a.csv", "'--report': a.csv is a file. Name a folder"),
        ("report absent.mcap --out none/report.html", "none/report.html: No such file or directory"),
        ("calibrate thermal --traces none --out /proc/table.json", "/proc/table.json: "),
        ("calibrate temperature --table t --traces none --out none/t.json", "none/t.json: No such file or directory"),
        ("remote --config absent.toml", "absent.toml"),
        ("remote --config sim-remote.toml", "sim-remote.toml"),
        ("keys init --keys ../keys/remote", "exists"),
        ("identify thermal --table no.json a.csv", "cannot be read"),
        (f"identify thermal --table {SURFACES} a.csv", "table"),
        (f"{IDENTIFY} --at 1,soon a.csv", "--at"),
        (IDENTIFY, "nothing to identify"),
        ("identify stiffness none.csv", "none.csv: cannot be read"),
        ("identify stiffness a.csv", "a.csv: line 1: column press is missing"),
        ("identify stiffness", "presses"),
        *(
            (f"export a.mcap --to csv --out o --began {began}", f"--began {began!r}: expected date, time and offset")
            for began in ("12:00", "yesterday", "2026-11-27", "2026-11-27T10:00:00")
        ),
        ("render thermal --object adamant --object-c 20 --air-c 25 --seconds 1", "adamant"),
        ("simulate thermal --material adamant --out t", "adamant"),
        ("simulate stroke --surface velvet --out t", "teletaction: unknown surface 'velvet'; known: aluminium, "),
        ("simulate stroke --surface foam --force 0.4 --out t", "--force"),
        ("calibrate thermal --traces . --out t", "labels.csv"),
        (f"calibrate temperature --table {TABLES / 'materials.json'} --traces . --out t", "labels.csv"),
        ("calibrate temperature --table no.json --traces . --out t", "no.json: cannot be read"),
        ("calibrate temperature --traces . --out t", "--table"),
    ],
)
def test_an_impossible_command_is_reported(
    line: str, words: str, configs: dict[str, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(configs["remote"].parent)
    Path("own.toml").write_text('name = "own"\n[materials.balsa]\ndensity_kg_m3 = 160.0\n', "utf-8")
    Path("a.csv").write_text(THERMAL, "utf-8")
    assert words in refused(line)


@pytest.mark.parametrize("out", ["thesis.txt", "thesis.txt/new", "./thesis.txt/new/newer"])
@pytest.mark.parametrize(
    "line",
    [
        "demo --headless",
        "export s.mcap --to csv",
        "map p.csv",
        "replay s.mcap",
        "simulate stroke --surface foam",
        "simulate thermal --material pvc",
        "study vibration --quick",
        "summarise --recordings .",
    ],
)
def test_a_file_in_place_of_a_folder_is_named(
    line: str, out: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("thesis.txt").write_text("years of work", "utf-8")
    said = "teletaction: Invalid value for '--out': thesis.txt is a file. Name a folder that exists or can be created."
    assert refused(f"{line} --out {out}") == said
    assert Path("thesis.txt").read_text("utf-8") == "years of work"


@pytest.mark.parametrize("process", sorted(COMMANDS))
def test_each_configuration_has_its_command(process: str, tmp_path: Path) -> None:
    line = one_line(command(process, "--config", tmp_path / "missing.toml"), 2)
    assert line == f"teletaction: {tmp_path / 'missing.toml'}: No such file or directory"


def test_folder_with_other_things_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "thesis.txt").write_text("years of work", "utf-8")
    (tmp_path / "config").mkdir()
    assert "other things" in refused(f"demo --headless --out {tmp_path}")
    assert (tmp_path / "thesis.txt").read_text("utf-8") == "years of work"


def test_an_impossible_demo_keeps_the_results_of_the_one_before(tmp_path: Path) -> None:
    for part in ("config", "keys/remote"):
        (tmp_path / part).mkdir(parents=True)
    (tmp_path / "session.mcap").write_bytes(b"of the session before")
    assert "unknown network" in refused(f"demo --headless --rates 200,200 --network nowhere --out {tmp_path}")
    assert (tmp_path / "session.mcap").exists()


def test_a_folder_of_a_running_demo_is_left_alone(tmp_path: Path) -> None:
    for part in ("config", "keys/remote"):
        (tmp_path / part).mkdir(parents=True)
    (tmp_path / "operator.mcap").write_bytes(b"of the running session")
    running = os.open(tmp_path, os.O_RDONLY)
    try:
        fcntl.flock(running, fcntl.LOCK_EX)
        said = refused(f"demo --headless --rates 200,200 --seconds 0.1 --network lan --out {tmp_path}")
    finally:
        os.close(running)
    assert said == f"teletaction: --out {tmp_path}: another demo uses it; choose another folder"
    assert (tmp_path / "operator.mcap").read_bytes() == b"of the running session"


def test_configuration(configs: dict[str, Path]) -> None:
    remote = configs["remote"]
    edit(remote, "rate_hz =", "rate_hertz =")
    line = refused(f"remote --config {remote}")
    assert "rate_hertz" in line
    assert "remote.toml:2" in line
    edit(remote, "rate_hertz = 250.0", "rate_hz = 5.0")
    line = refused(f"remote --config {remote}")
    assert "rate_hz" in line
    assert "100" in line


def test_a_port_in_use_is_named_by_site_and_simulator(configs: dict[str, Path]) -> None:
    port = tomllib.loads(configs["remote"].read_text("utf-8"))["link"]["base_port"]
    with socket.create_server(("127.0.0.1", port + 1)):
        assert f"{port + 1}" in refused(f"remote --config {configs['remote']}")
    address = tomllib.loads(configs["sim-operator"].read_text("utf-8"))["tacttip"]["index"]
    with socket.create_server(("127.0.0.1", int(address.rsplit(":", 1)[1]))):
        assert "index" in refused(f"sim-operator --config {configs['sim-operator']}")


def test_device_absent(configs: dict[str, Path]) -> None:
    edit(configs["operator"], "wait_for_devices_s = 20.0", "wait_for_devices_s = 0.5")
    line = refused(f"operator --config {configs['operator']}")
    assert "exoskeleton" in line or "tacttip" in line


def test_key_problems(configs: dict[str, Path], tmp_path: Path) -> None:
    (tmp_path / "keys" / "remote" / "site.key_secret").chmod(0o644)
    assert "0644" in refused(f"remote --config {configs['remote']}")
    TrustedKeys(tmp_path / "keys" / "operator").revoke("remote")
    assert "-- remote KEY" in refused(f"operator --config {configs['operator']}")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("time_s,force_n\n0.0,0.0\n0.1,0.0\n", "column sensor_c is missing"),
        (THERMAL.replace("0.20,33.0", "0.20,warm"), "line 22: column sensor_c"),
        (THERMAL.replace("0.20,33.0", "0.20,nan"), "line 22: column sensor_c"),
        (THERMAL.replace("0.20,33.0", "0.20,"), "line 22: column sensor_c"),
        ("", "line 1: no header"),
    ],
)
def test_a_thermal_trace_that_cannot_be_read_is_answered_and_so_are_the_others(
    tmp_path: Path, text: str, expected: str
) -> None:
    bad, free = tmp_path / "a.csv", tmp_path / "b.csv"
    bad.write_text(text, "utf-8")
    free.write_text(THERMAL, "utf-8")
    outcome = command(*shlex.split(IDENTIFY), bad, free)
    assert outcome.code == 0
    lines = [json.loads(line) for line in outcome.out.splitlines()]
    of_bad = [line for line in lines if line["trace"] == str(bad)]
    assert {line["status"] for line in of_bad} == {"unidentifiable"}
    assert [line["final"] for line in of_bad].count(True) == 1
    for line in of_bad:
        assert line["material"] is None
        assert str(bad) in line["reason"]
        assert expected in line["reason"]
    assert {line["status"] for line in lines if line["trace"] == str(free)} == {"no_contact"}


def test_a_stroke_without_an_answer_is_named(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    assert command("identify", "texture", pulled(tmp_path / "pulled.csv")).said == (0, "", "")
    assert caplog.messages == [
        f"{tmp_path / 'pulled.csv'}: no answer: force_n never shows contact, or the stroke is too short"
    ]


def pulled(path: Path) -> Path:
    """A stroke without contact."""
    rows = "".join(f"{n / 2000.0:.4f},0.0,-1.2,50.0\n" for n in range(1000))
    path.write_text("time_s,pressure_v,force_n,speed_mm_s\n" + rows, "utf-8")
    return path


def test_a_stroke_of_any_column_is_rendered(tmp_path: Path) -> None:
    fast = pulled(tmp_path / "fast.csv").read_text("utf-8").replace("pressure_v", "piezo_v")
    (tmp_path / "fast.csv").write_text(fast, "utf-8")
    assert "--signal names another" in refused(f"render vibration {tmp_path / 'fast.csv'}")
    assert command("render", "vibration", tmp_path / "fast.csv", "--signal", "piezo_v").code == 0


PRESS = "press,depth_mm,force_n\n" + "".join(f"1,{0.1 * n:.1f},{0.2 * n:.1f}\n" for n in range(20))


@pytest.mark.parametrize(("kind", "lines"), [("thermal", 7), ("texture", 2), ("stiffness", 1)])
def test_a_missing_file_is_an_error_after_the_others_were_identified(tmp_path: Path, kind: str, lines: int) -> None:
    good, gone = tmp_path / "good.csv", tmp_path / "gone.csv"
    stroke = pulled(tmp_path / "stroke.csv").read_text("utf-8").replace("-1.2", "1.2")
    good.write_text({"thermal": THERMAL, "texture": stroke, "stiffness": PRESS}[kind], "utf-8")
    table = ("--table", TABLES / "materials.json") if kind == "thermal" else ()
    outcome = command("identify", kind, *table, gone, good)
    assert outcome.code == 2
    assert sum(f"{good}" in line for line in outcome.out.splitlines()) == lines
    (said,) = outcome.err.splitlines()
    assert said == (f"teletaction: {gone}: cannot be read: No such file or directory (1 of 2 files cannot be used)")


@pytest.mark.parametrize("kind", ["thermal --traces", "temperature --table t --traces", "texture --strokes"])
@pytest.mark.parametrize("content", ["file,material\na.csv,pvc\n", '{"mine": 1}', "[1]", "\0"])
def test_a_calibration_overwrites_nothing_but_a_table(tmp_path: Path, kind: str, content: str) -> None:
    (tmp_path / "labels.csv").write_text(content, "utf-8")
    line = refused(f"calibrate {kind} {tmp_path} --out {tmp_path / 'labels.csv'}")
    assert line == f"teletaction: {tmp_path / 'labels.csv'}: exists and is no table; name another file with --out"
    assert (tmp_path / "labels.csv").read_text("utf-8") == content


def test_a_full_disk_is_named_without_the_systems_number(tmp_path: Path) -> None:
    render = "render thermal --object pvc --object-c 20 --air-c 20 --seconds 0.1 --parameters /dev/full"
    assert refused(render) == "teletaction: No space left on device"


@pytest.mark.parametrize("verb", ["report", "replay"])
def test_a_file_that_is_not_there_is_named_without_the_systems_number(verb: str, tmp_path: Path) -> None:
    absent = tmp_path / "absent.mcap"
    said = one_line(command(verb, absent, "--out", tmp_path / "out"), 2)
    assert said == f"teletaction: {absent}: No such file or directory"
