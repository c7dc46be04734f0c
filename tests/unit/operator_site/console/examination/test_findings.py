"""A finding's words: value, uncertainty, and what it differs in from its surroundings."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from operator_site.console.examination.findings import compare, describe, likely_kind, signed, with_sd
from operator_site.console.map.tactile_map import ExploredPlace, Measured

TISSUE = ExploredPlace(
    0.0, 0.0, Measured(33.0, 0.3, 12, 5.0), Measured(0.0045, 0.0005, 9, 5.0), Measured(600.0, 20.0, 12, 5.0), None
)
NOWHERE = ExploredPlace(0.0, 0.0, None, None, None, None)


@pytest.mark.parametrize(
    ("value", "sd", "text"),
    [
        (36.41, 0.21, "36.4 ± 0.2"),
        (612.0, 17.0, "610 ± 20"),
        (0.0923, 0.0041, "0.092 ± 0.004"),
        (36.4, 0.96, "36 ± 1"),
        (36.44, 0.096, "36.4 ± 0.1"),
        (24.1, None, "24.1 ± ?"),
        (24.1, 0.0, "24.1 ± ?"),
        (1e4, 999.0, "10000 ± 1000"),
    ],
)
def test_digits_follow_the_uncertainty(value: float, sd: float | None, text: str) -> None:
    assert with_sd(value, sd) == text


@given(st.floats(-1e5, 1e5), st.floats(1e-6, 1e4))
def test_what_is_shown_is_off_by_no_more_than_half_the_last_digit(value: float, sd: float) -> None:
    shown, spread = (float(part) for part in with_sd(value, sd).split(" ± "))
    assert abs(spread - sd) <= 0.5 * sd
    assert abs(shown - value) <= 0.51 * spread + 1e-9 * abs(value)
    assert with_sd(value, sd).split(" ± ")[1].strip("0.").rstrip("0") in set("123456789")


def test_kind_and_value() -> None:
    assert describe("warm", TISSUE._replace(temperature=Measured(36.41, 0.21, 3, 9.0))) == "warm, 36.4 ± 0.2 °C"
    assert describe("warm", TISSUE._replace(temperature=Measured(31.2, 2.1, 3, 9.0))) == "warm, 31 ± 2 °C, uncertain"
    assert describe("stiff", NOWHERE) == "stiff, stiffness not felt here"
    assert describe(None, TISSUE) == "33.0 ± 0.3 °C, 1.8 ± 0.2 of 10, 600 ± 20 N/m"
    assert describe("other", NOWHERE) == "other, nothing felt here"
    with pytest.raises(ValueError, match="no kind of finding 'tumbling'"):
        describe("tumbling", TISSUE)


def test_against_the_surroundings() -> None:
    warm = TISSUE._replace(temperature=Measured(35.1, 0.3, 3, 9.0))
    assert compare("temperature", warm, TISSUE) == "+2.1 ± 0.4 K against 33.0 ± 0.3 °C around it (12 touches)"
    stiff = TISSUE._replace(stiffness=Measured(1800.0, 60.0, 1, 9.0))
    assert compare("stiffness", stiff, TISSUE) == "3.0 ± 0.1 times the 600 ± 20 N/m around it (12 touches)"
    assert compare("temperature", NOWHERE, TISSUE) == ""
    assert compare(None, warm, TISSUE) == ""
    assert [signed(kelvin, 0.3) for kelvin in (-2.04, 2.04)] == ["−2.0 ± 0.3", "+2.0 ± 0.3"]


@pytest.mark.parametrize(
    ("field", "value", "kind"),
    [
        ("temperature", 35.5, "warm"),
        ("temperature", 31.0, "cold"),
        ("temperature", 33.4, None),
        ("roughness", 0.09, "rough"),
        ("stiffness", 1800.0, "stiff"),
        ("stiffness", 300.0, "soft"),
        ("stiffness", 660.0, None),
    ],
)
def test_a_place_looks_like_what_it_differs_in(field: str, value: float, kind: str | None) -> None:
    here = TISSUE._replace(**{field: Measured(value, 0.03 * value if field != "temperature" else 0.3, 1, 9.0)})
    assert likely_kind(here, TISSUE) == kind
    assert likely_kind(here, NOWHERE) is None


@pytest.mark.parametrize(
    ("stiffness", "lump", "kind"),
    [(660.0, 0.9, "stiff"), (1800.0, 0.1, None), (300.0, 0.0, "soft"), (1800.0, None, "stiff")],
)
def test_the_probability_of_a_lump_decides_where_it_is_known(
    stiffness: float, lump: float | None, kind: str | None
) -> None:
    here = TISSUE._replace(stiffness=Measured(stiffness, 0.03 * stiffness, 1, 9.0), lump=lump)
    assert likely_kind(here, TISSUE) == kind
