"""The tactile map's colours: the page's tables are the report's, and each goes one way in brightness."""

import base64
import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from operator_site.console.map import colours


def brightness(colour: str) -> float:
    red, green, blue = bytes.fromhex(colour)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def test_the_page_has_the_same_tables_and_puts_between_what_is_as_near_as_can_be_seen() -> None:
    page = (Path(colours.__file__).parents[1] / "page" / "colours.js").read_text("utf-8")
    assert page == colours.javascript()
    for name, table in colours.TABLES.items():
        found = re.search(rf'{name}: table\("([^"]+)"\)', page)
        assert found is not None
        few = np.frombuffer(base64.b64decode(found[1]), np.uint8).reshape(-1, 3).astype(float)
        whole = np.array([list(bytes.fromhex(colour)) for colour in table])
        assert whole.shape == (256, 3)
        for part in range(3):
            between = np.interp(np.arange(256), np.linspace(0, 255, len(few)), few[:, part])
            assert np.abs(np.round(between) - whole[:, part]).max() <= 1


@pytest.mark.parametrize(("name", "sign"), [("roughness", 1.0), ("stiffness", -1.0)])
def test_in_grey_print_a_scale_still_goes_one_way(name: str, sign: float) -> None:
    every_sixteenth = [brightness(colour) for colour in colours.TABLES[name][::16]]
    assert all(sign * (after - before) > 0.0 for before, after in pairwise(every_sixteenth))


def test_what_differs_from_the_middle_is_darker() -> None:
    grey = [brightness(colour) for colour in colours.TABLES["temperature"]]
    assert max(grey) == pytest.approx(max(grey[120:136]))
    assert grey[0] < 0.2 * max(grey)
    assert grey[-1] < 0.2 * max(grey)


def test_without_confidence_there_is_the_ground_alone_and_with_all_of_it_the_colour() -> None:
    assert colours.shown("590008", 0) == colours.BACKGROUND
    assert colours.shown("590008", 3) == "590008"
    assert colours.shown("000000", 1) == "404448"
