"""The program reads each block of the pages; a block that is not run gives its reason."""

import ast
import json
import re
import shutil
import tomllib
from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError

from common.config.advice import COMMANDS
from common.config.file import load_config
from common.scenes.scene import load_scene
from tests.docs.pages import LASTING, NAMES, NOT_RUN, PRINTED, RUN_BY, Block, blocks
from tests.places import ROOT

BLOCKS = [block for name in NAMES for block in blocks(name)]
OTHER = {"golden", "text", "ini", "nginx", "{literalinclude}", "{toctree}", "{eval-rst}"}
"""Blocks with tests of their own, or nothing to test."""


def of(language: str) -> list[Block]:
    return [block for block in BLOCKS if block.info[:1] == (language,)]


def named(found: list[Block]) -> Any:
    return pytest.mark.parametrize("block", found, ids=[block.where for block in found])


def test_every_block_has_a_tested_kind_and_a_known_mark() -> None:
    known = {"sh", "toml", "json", "python", *OTHER}
    assert [block.where for block in BLOCKS if block.info and block.info[0] not in known] == []
    for block in BLOCKS:
        assert block.said.keys() <= {PRINTED, LASTING, RUN_BY, NOT_RUN}, block.where
        assert RUN_BY not in block.said or (ROOT / block.said[RUN_BY]).is_file(), f"{block.where}: by whom?"
        assert NOT_RUN not in block.said or len(block.said[NOT_RUN].split()) >= 3, f"{block.where}: why not?"


def test_every_named_make_target_exists() -> None:
    targets = set(re.findall(r"(?m)^([\w-]+):", (ROOT / "Makefile").read_text("utf-8")))
    for name in NAMES:
        text = (ROOT / name).read_text("utf-8")
        named_here = set(re.findall(r"(?m)^\s*make ([\w-]+)", text)) | set(re.findall(r"`make ([\w-]+)", text))
        assert named_here <= targets, name


@named(of("toml"))
def test_toml_blocks_are_read_by_the_program(block: Block, tmp_path: Path) -> None:
    # The second word behind the fence says what reads it; a third is the file's name, or `part`: not all of the file.
    kind, *rest = block.info[1:] or ("",)
    path = tmp_path / "file.toml"
    path.write_text(block.text, "utf-8")
    if kind == "scene":
        load_scene(str(path))
        return
    assert kind in COMMANDS, f"{block.where}: say behind the fence what reads it"
    if rest != ["part"]:
        for table in re.findall(r'"([\w./-]+\.(?:json|toml))"', block.text):
            (tmp_path / table).parent.mkdir(exist_ok=True, parents=True)
            shutil.copy(ROOT / "remote_site/tables/materials.json", tmp_path / table)
        load_config(path, COMMANDS[kind])
        return
    with pytest.raises(ValidationError) as wrong:  # what it names is right; the rest of the file is missing
        COMMANDS[kind].model_validate(tomllib.loads(block.text) | {"not a field": 0})
    assert {error["type"] for error in wrong.value.errors()} <= {"missing", "extra_forbidden"}
    assert [error["loc"] for error in wrong.value.errors() if error["type"] == "extra_forbidden"] == [("not a field",)]


@named([*of("json"), *of("python")])
def test_json_and_python_can_be_read(block: Block) -> None:
    {"json": json.loads, "python": ast.parse}[block.info[0]](block.text)
