"""Body sites as a person writes them, and where they are allowed."""

from pathlib import Path

import pytest

from teletaction.export.body_site import LONGEST, BodySite
from teletaction.export.export import FORMATS, export
from tests.commands import command, one_line
from tests.packaging.requirements import EXTRAS
from tests.places import GOLDEN


@pytest.mark.parametrize(
    ("written", "site"),
    [
        ("left breast", BodySite("left breast")),
        ("  linke Brust ", BodySite("linke Brust")),
        ("SCT:80248007:left breast", BodySite("left breast", "80248007")),
        ("SCT:80248007: left breast ", BodySite("left breast", "80248007")),
        ("胸" * LONGEST, BodySite("胸" * LONGEST)),
    ],
)
def test_a_body_site_is_a_text_or_a_code_with_its_text(written: str, site: BodySite) -> None:
    assert BodySite.parse(written) == site


@pytest.mark.parametrize(
    "written",
    [
        "",
        "  ",
        "SCT:80248007",
        "SCT:80248007:",
        "SCT:80248007: ",
        "SCT:8024:left breast",
        "SCT:T-04030:left breast",
        "SCT:80248007:left:breast",
        "ICD:C50:breast",
        "sct:80248007:left breast",
        ":80248007:left breast",
        "left\nbreast",
        "left\x00breast",
        "left\\breast",
        "x" * (LONGEST + 1),
        "SCT:80248007:" + "x" * (LONGEST + 1),
        "SCT:" + "1" * 19 + ":left breast",
    ],
)
def test_anything_else_is_refused_with_both_forms(written: str) -> None:
    with pytest.raises(ValueError, match="'SCT:80248007:left breast'"):
        BodySite.parse(written)


def test_the_command_refuses_a_wrong_body_site_in_one_line(tmp_path: Path) -> None:
    said = one_line(command("export", GOLDEN, "--to", "fhir", "--out", tmp_path / "out", "--body-site", "SCT:1"), 2)
    assert "body site 'SCT:1': write 'left breast' or" in said
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("to", [name for name, known in FORMATS.items() if not known.clinical])
def test_only_clinical_formats_take_a_body_site(to: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=f"{to} takes no body site; export to fhir or dicom-sr"):
        export(GOLDEN, to, tmp_path, body_site="left breast")


def test_every_extra_that_a_format_names_exists() -> None:
    assert {known.extra for known in FORMATS.values()} <= {"", *EXTRAS}
