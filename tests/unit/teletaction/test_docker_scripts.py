"""The scripts in the image, without the image."""

import subprocess
from pathlib import Path

import pytest

from tests.places import ROOT


def console_access(folder: Path, name: str) -> "subprocess.CompletedProcess[str]":
    command = ["sh", ROOT / "docker" / "make_console_access.sh", folder, name]
    return subprocess.run(command, capture_output=True, text=True, timeout=50, check=False)


def test_a_second_run_changes_nothing(tmp_path: Path) -> None:
    assert console_access(tmp_path, "console.example").returncode == 0
    made = {file.name: file.read_bytes() for file in tmp_path.iterdir()}
    assert set(made) == {"certificate.pem", "key.pem", "tokens"}
    assert {file.stat().st_mode & 0o777 for file in tmp_path.iterdir()} == {0o600}
    assert console_access(tmp_path, "console.example").returncode == 0
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == made


def test_a_certificate_of_the_hospital_stays_and_gets_tokens(tmp_path: Path) -> None:
    for name in ("certificate.pem", "key.pem"):
        (tmp_path / name).write_text("of the hospital", "utf-8")
    assert console_access(tmp_path, "console.example").returncode == 0
    assert {(tmp_path / name).read_text("utf-8") for name in ("certificate.pem", "key.pem")} == {"of the hospital"}
    assert len((tmp_path / "tokens").read_text("utf-8").splitlines()) == 2


def test_a_failure_says_why_and_can_be_tried_again(tmp_path: Path) -> None:
    failed = console_access(tmp_path, "console." + 60 * "a")
    assert failed.returncode != 0
    assert "too long" in failed.stderr
    assert console_access(tmp_path, "console.example").returncode == 0


@pytest.mark.parametrize(
    ("name", "entry"),
    [("console.example", "DNS:console.example"), ("192.0.2.7", "IP Address:192.0.2.7"), ("2001:db8::7", "2001:DB8")],
)
def test_the_certificate_is_for_a_name_or_an_address(tmp_path: Path, name: str, entry: str) -> None:
    assert console_access(tmp_path, name).returncode == 0
    command = ["openssl", "x509", "-in", tmp_path / "certificate.pem", "-noout", "-ext", "subjectAltName"]
    assert entry in subprocess.run(command, capture_output=True, text=True, check=True).stdout
