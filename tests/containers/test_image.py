"""The image by itself: small, made of the pinned packages and of nothing else, and without anything secret."""

import re
from pathlib import Path

import pytest

from tests.containers.checkout import Checkout, run
from tests.places import ROOT

pytestmark = pytest.mark.timeout(600)

LARGEST_MB = 350.0
"""Of what is added to the base image."""
FILES = "find / -xdev -readable -not -path '/proc/*' -not -path '/sys/*' -not -path '/etc/host*'"
HELD = f"{FILES} -printf '%p %m %U:%G %l\\n' | sort; {FILES} -type f -print0 | sort -z | xargs -0 sha256sum"
"""Of all that its user may read: place, permissions, owner, and what is in it. Names of hosts are the container's."""
FREEZE = "from importlib.metadata import distributions; [print(d.name, d.version) for d in distributions()]"


def sizes_mb(image: str) -> float:
    return int(run("docker", "image", "inspect", "-f", "{{.Size}}", image)) * 1e-6


def in_image(*command: str) -> str:
    return run("docker", "run", "--rm", "--network", "none", "--read-only", "teletaction", *command)


@pytest.fixture(scope="module", autouse=True)
def image(tmp_path_factory: pytest.TempPathFactory) -> Checkout:
    """The checkout that it was built from."""
    checkout = Checkout(tmp_path_factory.mktemp("image") / "teletaction")
    checkout("docker-compose build keys", seconds=400.0)
    return checkout


@pytest.mark.containers
def test_the_image_is_small() -> None:
    base, whole = sizes_mb("python:3.11-slim"), sizes_mb("teletaction")
    print(f"base {base:.0f} MB, added {whole - base:.0f} MB")
    print(in_image("sh", "-c", "cd /opt/teletaction/lib/python3.11/site-packages && du -sm * | sort -rn | head -12"))
    assert whole - base < LARGEST_MB


@pytest.mark.containers
def test_each_package_in_the_image_is_pinned() -> None:
    pins = dict(re.findall(r"(?m)^([\w.-]+)==([^\s;]+)", (ROOT / "constraints.txt").read_text("utf-8")))
    pinned = {re.sub(r"[-_.]+", "-", name).lower(): version for name, version in pins.items()}
    found = dict(line.split() for line in in_image("/opt/teletaction/bin/python", "-Ic", FREEZE).splitlines())
    installed = {re.sub(r"[-_.]+", "-", name).lower(): version for name, version in found.items()}
    del installed["teletaction"]
    assert len(installed) > 20
    assert installed.items() <= pinned.items()


@pytest.mark.image
def test_a_second_build_of_the_image_is_identical(image: Checkout) -> None:
    first = in_image("sh", "-c", HELD)
    assert len(first.splitlines()) > 10_000
    image("docker-compose build --no-cache keys", seconds=400.0)
    assert in_image("sh", "-c", HELD) == first


@pytest.mark.containers
def test_the_image_holds_no_key_and_no_token() -> None:
    assert in_image("find", "/keys", "/session", "-type", "f") == ""


@pytest.mark.containers
def test_the_image_is_built_from_the_program_alone() -> None:
    assert Path(ROOT / ".dockerignore").read_text("utf-8").startswith("*\n")
