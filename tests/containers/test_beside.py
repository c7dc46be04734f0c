"""The services beside the sites in containers: camera, voice, the patient's page, and a rendezvous with a tunnel."""

import re
import ssl
from collections.abc import Iterator
from pathlib import Path
from urllib.error import HTTPError
from urllib.request import Request, urlopen

import pytest

from tests.containers.checkout import Checkout, wait_for

pytestmark = [pytest.mark.image, pytest.mark.timeout(900)]

PROFILES = ("demo", "camera", "voice", "patient-page", "rendezvous", "tunnel")
SITES = ("remote-site", "operator-site", "console")
SET_UP = """install -d -m 0700 -o 10001 -g 10001 secrets
docker-compose build
docker-compose run --rm new-console-access
docker-compose run --rm new-key python -m teletaction keys secret /secrets/room.secret
docker-compose up --detach"""
PATIENT_PORT = 8091


@pytest.fixture(scope="module")
def beside(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Checkout]:
    checkout = Checkout(tmp_path_factory.mktemp("beside") / "teletaction", COMPOSE_PROFILES=",".join(PROFILES))
    use_streams(checkout.folder / "docker" / "console.toml")
    reach_the_rendezvous(checkout.folder / "docker" / "hardware" / "tunnel.toml")
    try:
        checkout(SET_UP, seconds=600.0)
        yield checkout
    finally:
        checkout.remove()


def use_streams(console: Path) -> None:
    """Take the tables that the console's configuration offers for camera and voice."""
    text = console.read_text("utf-8")
    console.write_text(re.sub(r"^# (?=\[(?:camera|voice)\]|host = )", "", text, flags=re.MULTILINE), "utf-8")


def reach_the_rendezvous(tunnel: Path) -> None:
    """Name the host of the rendezvous, which is this one."""
    tunnel.write_text(tunnel.read_text("utf-8").replace("rendezvous.example", "127.0.0.1"), "utf-8")


def test_every_service_is_healthy(beside: Checkout) -> None:
    for service in (*SITES, *PROFILES[1:]):
        wait_for(lambda service=service: beside.healthy(service), f"{service} healthy", 120.0)


def test_the_console_has_picture_and_voice_of_the_remote_site(beside: Checkout) -> None:
    def live() -> bool:
        status = beside.status("console", "console")
        return (status["camera"], status["voice"]) == ("live", "live")

    wait_for(live, "picture and voice", 60.0)
    assert beside.status("camera", "camera")["rung"] is not None


def test_the_patients_page_asks_for_a_token(beside: Checkout) -> None:
    secrets = beside.folder / "secrets"
    trust = ssl.create_default_context(cafile=secrets / "certificate.pem")
    address = f"https://localhost:{PATIENT_PORT}/"
    with pytest.raises(HTTPError, match="401"):
        urlopen(address, context=trust)
    token = next(line.split()[2] for line in (secrets / "tokens").read_text().splitlines() if " act " in line)
    asked = Request(address, headers={"Cookie": f"teletaction={token}"})
    assert "STOP" in urlopen(asked, context=trust).read().decode()


def test_the_tunnel_has_reached_the_rendezvous(beside: Checkout) -> None:
    assert beside.status("tunnel", "tunnel")["missing"] == ""
