"""A start of the console that fails names the reason and changes no file."""

import socket
import subprocess
from pathlib import Path

import pytest

from common.config.page_models import ConsoleConfig
from common.link.keys import create_keys
from common.web.access import AccessProblem
from operator_site.console.run import run_console


@pytest.fixture(scope="module")
def certificates(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A certificate with its key, a key of another one, the key with a password, and a file of text."""
    folder = tmp_path_factory.mktemp("certificates")
    new = "openssl genpkey -algorithm ec -pkeyopt ec_paramgen_curve:prime256v1 -out"
    for command in (
        f"{new} key.pem",
        f"{new} other.pem",
        "openssl req -x509 -key key.pem -subj /CN=localhost -days 1 -out certificate.pem",
        "openssl ec -aes128 -passout pass:secret -in key.pem -out locked.pem",
    ):
        subprocess.run(command.split(), cwd=folder, capture_output=True, check=True)
    (folder / "text.pem").write_text("no certificate", "utf-8")
    return folder


def test_a_second_start_leaves_the_journal_of_the_running_console_in_its_place(tmp_path: Path) -> None:
    create_keys(tmp_path / "keys")
    record = tmp_path / "console.mcap"
    record.write_bytes(b"of the running console")
    with socket.create_server(("127.0.0.1", 0)) as page:
        config = ConsoleConfig(keys=tmp_path / "keys", port=page.getsockname()[1], record=record)
        with pytest.raises(OSError, match="in use"):
            run_console(config, lambda: True)
    assert [path.name for path in tmp_path.glob("*.mcap")] == ["console.mcap"]
    assert record.read_bytes() == b"of the running console"


@pytest.mark.parametrize(
    ("wrong", "named", "why"),
    [
        ("certificate", "no.pem", "No such file"),
        ("certificate_key", "no.pem", "No such file"),
        ("certificate", "text.pem", "not PEM"),
        ("certificate_key", "text.pem", "not PEM"),
        ("certificate_key", "other.pem", "key values mismatch"),
        ("certificate_key", "locked.pem", "the key has a password"),
    ],
)
def test_an_unusable_certificate_is_named_before_a_file_is_created(
    tmp_path: Path, certificates: Path, wrong: str, named: str, why: str
) -> None:
    create_keys(tmp_path / "keys")
    files = {"certificate": certificates / "certificate.pem", "certificate_key": certificates / "key.pem"}
    config = ConsoleConfig.model_validate(
        {
            "keys": tmp_path / "keys",
            "port": 0,
            "record": tmp_path / "console.mcap",
            **files,
            wrong: certificates / named,
        }
    )
    with pytest.raises(AccessProblem, match=f"{named}.*: .*{why}"):
        run_console(config, lambda: True)
    assert not (tmp_path / "console.mcap").exists()
