"""A cable is pulled in full work and put back: the site names the device, and finds it again by itself."""

import pytest

from tests.virtual.configurations import FINGER
from tests.virtual.session import VirtualSession

pytestmark = pytest.mark.long

CABLES = (
    ("operator", f"{FINGER} tacttip", f"{FINGER} tacttip"),
    ("operator", "can", "exoskeleton"),
    ("remote", f"{FINGER} texture", f"{FINGER} texture_sensor"),
    ("remote", f"{FINGER} thermal", f"{FINGER} thermal_sensor"),
    ("remote", "can", "telemanipulator"),
)
"""Site, device in the simulator's words, and in those of the site."""


@pytest.mark.parametrize(("site", "device", "name"), CABLES, ids=[name for _, _, name in CABLES])
def test_an_unplugged_device_is_named_and_found(working: VirtualSession, site: str, device: str, name: str) -> None:
    its_site = working.remote if site == "remote" else working.operator
    working.break_device(f"{site}: unplug {device}")
    working.until(lambda _: str(its_site.figures()["missing"]).startswith(name), 2.0)
    working.run(1.0)
    working.break_device(f"{site}: plug {device}")
    working.until(lambda _: its_site.figures()["missing"] == "", 10.0)
    working.resume()
    figures = its_site.figures()
    assert (figures["state"], figures["fault"]) == ("engaged", None)
    assert figures["devices"][name]["times_lost"] == 1
