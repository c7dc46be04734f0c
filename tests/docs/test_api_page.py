"""The page of the Python interface lists each public name once, and each docstring is complete."""

import inspect
import re
from typing import get_type_hints

import pytest

import teletaction as tt
from tests.places import ROOT

_PAGE = (ROOT / "docs" / "api.md").read_text("utf-8")
CANNOT_FAIL = {"render_vibration"}
"""A trace checks itself, so that what takes one cannot fail."""
FUNCTIONS = [name for name in tt.__all__ if inspect.isfunction(getattr(tt, name))]


def test_the_page_lists_each_public_name_once() -> None:
    assert sorted(re.findall(r"auto(?:class|function):: teletaction\.(\w+)", _PAGE)) == sorted(tt.__all__)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_has_types_and_documents_each_argument_and_its_errors(name: str) -> None:
    function = getattr(tt, name)
    parameters = inspect.signature(function).parameters
    assert set(get_type_hints(function, {"Figure": object})) == {*parameters, "return"}
    text = inspect.getdoc(function) or ""
    assert ("Raises:" in text) == (name not in CANNOT_FAIL)
    if len(parameters) > 1:
        described = text.partition("Args:\n")[2]
        assert [each for each in parameters if f"    {each}: " not in described] == []
