"""Names of code and files on the pages exist, and stated values of constants are right."""

import re
from importlib import import_module
from pathlib import Path

import pytest

from tests.docs.pages import NAMES, blocks, code_spans, tokens
from tests.places import ROOT

ROOMS = ("common", "remote_site", "operator_site", "sim_sensors", "teletaction", "studies")
_NAME = re.compile(rf"({'|'.join(ROOMS)})(\.\w+)+")
_FILE = re.compile(rf"({'|'.join(ROOMS)}|tests|docs|docker|deploy)/[\w./-]+\.\w+")
_NUMBER = re.compile(r"\s*=\s*(-?[\d.]+)")
HOW_IT_WORKS = [name for name in NAMES if name.startswith("docs/how-it-works/")]


def found(name: str) -> object:
    """What a dotted name stands for.

    Raises:
        LookupError: nothing of this name.
    """
    parts = name.split(".")
    for count in range(len(parts), 0, -1):
        try:
            thing: object = import_module(".".join(parts[:count]))
        except ModuleNotFoundError as missing:
            if missing.name is None or not name.startswith(missing.name):
                raise
            continue
        for attribute in parts[count:]:
            thing = getattr(thing, attribute, None) or _annotated(thing, attribute, name)
        return thing
    raise LookupError(name)


def _annotated(thing: object, attribute: str, name: str) -> object:
    """An attribute that instances have: one of its slots or annotations; or one that is zero."""
    if hasattr(thing, attribute):
        return getattr(thing, attribute)
    if attribute in {*getattr(thing, "__slots__", ()), *getattr(thing, "__annotations__", {})}:
        return attribute
    raise LookupError(name)


@pytest.mark.parametrize("name", NAMES)
def test_every_named_thing_exists(name: str) -> None:
    for span, after, line in code_spans(name):
        if _NAME.fullmatch(span) and not span.endswith((".py", ".toml", ".json", ".md")):
            thing = found(span)
            if number := _NUMBER.match(after):
                assert thing == float(number[1].rstrip(".")), f"{name}:{line}: {span} is {thing}"
        elif _FILE.fullmatch(span):
            # The page of evidence names tests by their place in the folder of tests.
            folder = ROOT / "tests" if "/test_" in span and not span.startswith("tests/") else ROOT
            assert (folder / span).exists(), f"{name}:{line}: {span}"


@pytest.mark.parametrize("name", HOW_IT_WORKS)
def test_an_equation_has_its_code_beside_it(name: str) -> None:
    # Between one equation and the next there is a piece of code, or a name of it.
    text = (ROOT / name).read_text("utf-8")
    parts = re.split(r"(?m)^\$\$$", text)
    assert len(parts) % 2 == 1, "an equation does not end"
    for number, after in enumerate(parts[2::2]):
        before = parts[2 * number]
        named = _NAME.search(after) or "{literalinclude}" in after or _NAME.search(before.rsplit("\n\n", 2)[-1])
        assert named, f"{name}: equation {number + 1} has no code"


def test_code_is_cut_from_files_that_exist() -> None:
    for name in HOW_IT_WORKS:
        for block in blocks(name):
            if block.info[:1] == ("{literalinclude}",):
                path = ((ROOT / name).parent / block.info[1]).resolve()
                wanted = re.search(r":pyobject: (\S+)", block.text)
                assert wanted, block.where
                found(".".join([*path.relative_to(ROOT).with_suffix("").parts, wanted[1]]))


def test_each_page_begins_with_its_title() -> None:
    for name in NAMES:
        first = next(token for token in tokens(name) if token.type != "html_block")
        assert (first.type, first.tag) == ("heading_open", "h1"), name


def test_wrong_names_are_noticed() -> None:
    assert found("common.limits.GAP_S") == 0.1
    for wrong in ("common.limits.NOTHING", "common.nothing.at_all", "remote_site.texture.roughness.Roughness.nothing"):
        with pytest.raises(LookupError):
            found(wrong)
    assert Path(ROOT / "docs" / "index.md").exists()
