"""Roughness is shown in um where the sensor was calibrated for it, else as a level of ten."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.wire.roughness_um import RoughnessUm
from operator_site.console.map.roughness_shown import LEVEL_0_V, LEVEL_10_V, roughness_shown

SCALE = RoughnessUm(ln_um=4.0, exponent=0.8, ln_sd=0.1, least_v=0.01, most_v=1.0)


def test_the_level_runs_from_0_to_10_in_equal_ratios() -> None:
    middle_v = math.sqrt(LEVEL_0_V * LEVEL_10_V)
    levels = [roughness_shown(value_v, 0.1 * value_v, None).value for value_v in (LEVEL_0_V, middle_v, LEVEL_10_V)]
    assert levels == pytest.approx([0.0, 5.0, 10.0])
    assert [roughness_shown(value_v, 0.01, None).value for value_v in (1e-6, 3.0)] == [0.0, 10.0]
    assert roughness_shown(middle_v, 0.1 * middle_v, None).sd == pytest.approx(10.0 * 0.1 / math.log(100.0))


def test_a_calibrated_roughness_is_in_um_with_the_error_of_the_scale() -> None:
    shown = roughness_shown(0.05, 0.005, SCALE)
    assert shown.value == pytest.approx(math.exp(4.0 + 0.8 * math.log(0.05)))
    assert shown.sd == pytest.approx(shown.value * math.hypot(0.8 * 0.1, 0.1))
    assert shown.unit == "µm"


@pytest.mark.parametrize("value_v", [0.007, 1.3])
def test_a_roughness_outside_the_calibrated_range_is_a_level(value_v: float) -> None:
    assert roughness_shown(value_v, 0.1 * value_v, SCALE) == roughness_shown(value_v, 0.1 * value_v, None)
    near_v = {0.007: 0.008, 1.3: 1.2}[value_v]  # as offline, the scale holds a little beyond
    assert roughness_shown(near_v, 0.1 * near_v, SCALE).unit == "µm"


def test_a_scale_comes_back_as_it_was_sent() -> None:
    assert RoughnessUm.of(SCALE._asdict()) == SCALE


def test_a_scale_of_an_older_site_holds_for_every_roughness() -> None:
    older = RoughnessUm.of({"ln_um": 4.0, "exponent": 0.8, "ln_sd": 0.1})
    assert older is not None
    assert [roughness_shown(value_v, 1e-5, older).unit for value_v in (1e-4, 99.0)] == ["µm", "µm"]


@pytest.mark.parametrize("wrong", [{"least_v": 2.0}, {"most_v": None}, {"least_v": -0.1}, {"most_v": "1"}])
def test_a_scale_without_a_sound_range_is_none(wrong: dict[str, object]) -> None:
    assert RoughnessUm.of(SCALE._asdict() | wrong) is None


JUNK = st.recursive(
    st.none() | st.booleans() | st.floats() | st.text(max_size=3),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(RoughnessUm._fields), inner),
)


@given(JUNK)
def test_what_is_no_scale_is_none(received: object) -> None:
    scale = RoughnessUm.of(received)
    assert scale is None or (all(map(math.isfinite, scale)) and scale.exponent > 0.0 and scale.ln_sd > 0.0)
