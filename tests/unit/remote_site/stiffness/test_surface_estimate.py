"""Surface below a contact: on presses that chose no constant, and where it moves and changes."""

import math
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from common.wire.messages import STIFFNESS_KNOWN_LN_SD
from remote_site.stiffness.surface_estimate import UNKNOWN_LN_SD, SurfaceEstimate
from studies.surface_identification.pressed_surface import STEPS, TICK_S, Touches, sense
from studies.surface_identification.scenes import (
    HAND_STEP_M,
    STROKE_M_S,
    Identified,
    identify,
    pressed,
    pressed_again,
    rested,
    stroked,
)

SEEDS = {100.0: 81_101, 200.0: 81_102, 500.0: 81_103, 3000.0: 81_106}
PRESSES = 2


def identified(felt: Touches, seed: int, steps: str = "12 bits") -> list[Identified]:
    force_n, z_m = sense(felt, np.random.default_rng(seed), STEPS[steps])
    x_m = np.round(felt.x_m / HAND_STEP_M) * HAND_STEP_M
    return [identify(*columns) for columns in zip(force_n.T, z_m.T, x_m.T, strict=True)]


@cache
def presses(stiffness_n_m: float) -> Touches:
    return pressed(np.full(PRESSES, stiffness_n_m), np.random.default_rng(SEEDS[stiffness_n_m]))[0]


@pytest.mark.long
@pytest.mark.parametrize("steps", STEPS)
@pytest.mark.parametrize("stiffness_n_m", SEEDS)
def test_one_press_gives_the_stiffness_only_when_it_is_known(stiffness_n_m: float, steps: str) -> None:
    felt = presses(stiffness_n_m)
    for finger, each in enumerate(identified(felt, 1, steps)):
        pressing = felt.force_n[:, finger] > 1.0
        last = np.flatnonzero(pressing)[-1]
        assert each.known[last], "it is known before the finger leaves"
        assert each.stiffness_n_m[last] == pytest.approx(stiffness_n_m, rel=0.15)
        assert each.stiffness_n_m[each.known] == pytest.approx(stiffness_n_m, rel=0.15)
        assert not each.known[felt.force_n[:, finger] < 0.1][0]


@pytest.mark.long
@given(st.floats(1.0, 3.3), st.floats(0.5, 5.0), st.floats(2e-3, 8e-3), st.floats(2e-3, 0.02))
@settings(max_examples=100, deadline=None)
def test_stiffening_tissue_is_never_shown_harder_than_it_is(
    p: float, n: float, deep_m: float, speed_m_s: float
) -> None:
    """A press into F = K d^p and a rest in it: the shown line exceeds the force of the tissue by its error only."""
    surface, depths_m = SurfaceEstimate(), np.linspace(0.0, 1.5 * deep_m, 60)
    tissue_n = n * (depths_m / deep_m) ** p
    seconds = deep_m / speed_m_s + 0.2
    for t_s in np.arange(0.0, seconds, 0.004).tolist():
        at_m = min(speed_m_s * t_s, deep_m)
        surface.step(t_s, n * (at_m / deep_m) ** p, 0.0, 0.0, -at_m)
        shown_n = surface.stiffness_n_m * np.maximum(0.0, surface.surface_z_m + depths_m)
        if surface.stiffness_n_m:
            assert (shown_n - tissue_n).max() <= 0.1 + 0.02 * n
    assert surface.known or n < 2.0


def test_a_contradicted_stiffness_is_shown_no_harder_than_it_was_known() -> None:
    """A finger that leaves stiffening tissue: the estimate doubts, and the shown stiffness does not rise."""
    surface, known_n_m = SurfaceEstimate(), math.inf
    depths_m = 4e-3 * np.concatenate([np.linspace(0.0, 1.0, 125), np.linspace(1.0, 0.0, 125)])
    doubts = False
    for tick, at_m in enumerate(depths_m.tolist()):
        surface.step(0.004 * tick, 3.0 * (at_m / 4e-3) ** 1.5, 0.0, 0.0, -at_m)
        if surface.known:
            known_n_m = surface.stiffness_n_m
        elif surface.stiffness_n_m and known_n_m < math.inf:
            doubts = True
            assert surface.stiffness_n_m <= known_n_m
    assert doubts


@pytest.mark.long
@pytest.mark.parametrize("stiffness_n_m", SEEDS)
def test_before_it_is_known_no_place_is_pressed_harder_than_by_the_object(stiffness_n_m: float) -> None:
    felt = presses(stiffness_n_m)
    for finger, each in enumerate(identified(felt, 2)):
        until = np.argmax(each.known)
        for below_m in (0.0, 0.5e-3, 2e-3, 10e-3):
            z_m = felt.z_m[:until, finger] - below_m
            shown_n = each.stiffness_n_m[:until] * np.maximum(0.0, each.surface_m[:until] - z_m)
            object_n = stiffness_n_m * np.maximum(0.0, -z_m)
            assert np.all(shown_n <= object_n + 0.02), "but for two standard deviations of the force's noise"


@pytest.mark.long
def test_damping_is_reported_where_a_press_was_fast_enough() -> None:
    shares = []
    for stiffness_n_m in (200.0, 500.0):
        felt = presses(stiffness_n_m)
        for finger, each in enumerate(identified(felt, 3)):
            reported = each.damping_n_s_m > 0.0
            shares += (each.damping_n_s_m / np.maximum(0.1, felt.force_n[:, finger]))[reported].tolist()
    assert np.median(shares) == pytest.approx(1.5, rel=0.2), "Hunt and Crossley's constant"
    assert not any(each.damping_n_s_m.any() for each in identified(rested(np.array([3000.0]), 0.5, 1.0), 3))


@pytest.mark.long
@pytest.mark.parametrize("stiffness_n_m", [50.0, 3000.0])
def test_the_reported_surface_does_not_shake(stiffness_n_m: float) -> None:
    felt = rested(np.array([stiffness_n_m]), 1.0, 3.5)
    force_n, z_m = sense(felt, np.random.default_rng(4), STEPS["12 bits"])
    late = felt.time_s > 1.5
    raw_m = (z_m + force_n / stiffness_n_m)[late, 0]
    (each,) = identified(felt, 4)
    surface_m = each.surface_m[late]
    assert each.known[late].all()
    assert surface_m.std() < 0.03e-3
    assert surface_m.std() < 0.6 * raw_m.std()
    if stiffness_n_m == 50.0:
        assert raw_m.std() > 0.15e-3, "raw, it does"


@pytest.mark.long
@pytest.mark.parametrize(
    ("stiffness_n_m", "late_s", "amplitude_m", "frequency_hz"),
    [(150.0, 0.05, 1e-3, 0.25), (1000.0, 0.03, 3.8e-3, 0.5)],
    ids=["breath", "12 mm/s"],
)
def test_a_moving_surface_is_followed(
    stiffness_n_m: float, late_s: float, amplitude_m: float, frequency_hz: float
) -> None:
    felt = rested(np.array([stiffness_n_m]), 4.0, 4.5, amplitude_m=amplitude_m, frequency_hz=frequency_hz)
    (each,) = identified(felt, 5)
    late = felt.time_s > 1.5
    shown_n = each.stiffness_n_m * (each.surface_m - felt.z_m[:, 0])
    fastest_m_s = 2.0 * math.pi * frequency_hz * amplitude_m
    assert np.abs(shown_n - felt.force_n[:, 0])[late].max() < 0.05 + stiffness_n_m * fastest_m_s * late_s
    assert each.stiffness_n_m[late] == pytest.approx(stiffness_n_m, rel=0.25)
    assert np.ptp(each.stiffness_n_m[late]) < 0.1 * stiffness_n_m, "it is the surface that moves"


@pytest.mark.long
def test_presses_on_a_breathing_surface_make_its_stiffness_known_again() -> None:
    """A contradiction leaves the stiffness unknown until the presses of this contact have identified it again."""
    stiffness_n_m = np.full(6, 150.0)
    felt = pressed_again(stiffness_n_m, np.random.default_rng(81_110), 12.0, breathes=True)
    again = []
    for each in identified(felt, 10):
        doubted = np.flatnonzero((np.diff(each.known.astype(int)) < 0) & (each.stiffness_n_m[1:] > 0.0))
        if len(doubted):
            again.append(each.known[doubted[0] :].mean())
    assert len(again) >= 4
    assert np.mean(again) > 0.7


@pytest.mark.long
def test_a_surface_that_rises_to_a_finger_gives_no_stiffness() -> None:
    felt = rested(np.array([1000.0]), 0.0, 4.0, amplitude_m=-2e-3, frequency_hz=0.5)
    (each,) = identified(felt, 6)
    assert felt.force_n.max() > 0.5
    assert not each.known.any()
    assert np.all(each.stiffness_n_m * np.maximum(0.0, each.surface_m - felt.z_m[:, 0]) <= felt.force_n[:, 0] + 0.03)


@pytest.mark.long
@pytest.mark.parametrize("edge_m", [1e-5, 5e-3])
def test_a_stroke_onto_a_nodule_finds_it_stiffer_and_not_higher(edge_m: float) -> None:
    def tissue_n_m(x_m: np.ndarray) -> np.ndarray:
        return 150.0 + 450.0 * np.clip((x_m - 0.03) / edge_m, 0.0, 1.0)

    felt = stroked(tissue_n_m, np.array([150.0]), 1.0, 3.0)
    (each,) = identified(felt, 7)
    ln_error = np.log(each.stiffness_n_m[500:] / felt.stiffness_n_m[500:, 0])
    upon = felt.x_m[500:, 0] > 0.03 + edge_m + 0.05 * STROKE_M_S
    before = felt.x_m[500:, 0] < 0.03 - 0.001
    assert np.abs(ln_error[upon]).max() < 0.15, "within 50 ms"
    assert np.abs(ln_error[before]).max() < 0.05
    assert np.abs(each.surface_m[500:]).max() < 0.8e-3
    assert each.known[-1]


@pytest.mark.long
@pytest.mark.parametrize("stiffness_n_m", [150.0, 3000.0])
def test_a_stroke_gives_the_slope_and_a_rest_does_not(stiffness_n_m: float) -> None:
    wall = np.array([stiffness_n_m])
    felt = stroked(lambda _: wall, wall, 4.0, 2.0, slope=-0.08)
    (each,) = identified(felt, 8)
    assert not each.slope[felt.time_s < 1.0].any()
    assert each.slope[felt.time_s > 1.5] == pytest.approx(-0.08, abs=0.04)
    assert each.surface_m[felt.time_s > 1.5] == pytest.approx(
        felt.surface_m[felt.time_s > 1.5, 0], abs=0.05e-3 + 0.02 * 4.0 / stiffness_n_m
    )


def test_each_contact_starts_a_new_estimate_and_no_contact_gives_none() -> None:
    surface = SurfaceEstimate()

    def neutral() -> bool:
        values = (surface.stiffness_n_m, surface.surface_z_m, surface.damping_n_s_m, surface.slope_x, surface.slope_y)
        return values == (0.0,) * 5 and surface.stiffness_ln_sd == UNKNOWN_LN_SD and not surface.known

    def press() -> None:
        for _ in range(400):
            deep_m = 0.004 * (1.0 - math.cos(0.02 * len(ticks)))
            ticks.append(0)
            surface.step(TICK_S * len(ticks), 500.0 * deep_m, 0.0, 0.0, -deep_m)

    ticks: list[int] = []
    assert neutral()
    press()
    assert surface.known
    assert surface.stiffness_n_m == pytest.approx(500.0, rel=0.05)
    surface.step(TICK_S * len(ticks) + 0.001, math.nan, 0.0, 0.0, 0.0)
    assert surface.known, "what is not a number is left out"
    surface.step(TICK_S * len(ticks) + 0.2, 2.0, 0.0, 0.0, -0.004)
    assert not surface.known, "after a gap it is another contact"
    surface.step(TICK_S * len(ticks) + 0.202, 0.0, 0.0, 0.0, 0.0)
    assert neutral()
    surface.step(0.0, 1.0, 0.0, 0.0, -0.002)
    assert surface.stiffness_ln_sd >= STIFFNESS_KNOWN_LN_SD, "the clock was set back"


@given(
    st.lists(
        st.tuples(
            st.floats(0.0, 10.23),
            st.floats(-0.011, 0.011),
            st.floats(-0.66, 0.66),
            st.floats(-0.66, 0.66),
            st.sampled_from((0.002, 0.002, 0.002, 0.01, 0.2)),
        ),
        max_size=60,
    )
)
def test_every_estimate_fits_into_a_packet(samples: list[tuple[float, float, float, float, float]]) -> None:
    surface, t_s, ever = SurfaceEstimate(), 0.0, False
    for force_n, z_m, x_m, y_m, dt_s in samples:
        t_s += dt_s
        surface.step(t_s, force_n, x_m, y_m, z_m)
        assert surface.stiffness_n_m == 0.0 or 50.0 * (1 - 1e-9) <= surface.stiffness_n_m <= 20_000.0 * (1 + 1e-9)
        assert 0.0 <= surface.stiffness_ln_sd <= UNKNOWN_LN_SD
        assert surface.damping_n_s_m >= 0.0
        assert math.isfinite(surface.surface_z_m + surface.slope_x + surface.slope_y)
        ever = surface.stiffness_n_m > 0.0 and (surface.known or (ever and dt_s < 0.1))
        if not ever:
            assert surface.stiffness_n_m * max(0.0, surface.surface_z_m - z_m) <= force_n + 1e-9
