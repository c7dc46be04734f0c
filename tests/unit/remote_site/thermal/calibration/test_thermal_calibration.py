"""Calibration names touches that are too short, incomplete or unlike the others."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from remote_site.thermal.calibration.thermal_calibration import calibrate_traces
from remote_site.traces.trace_files import ThermalTrace, read_thermal
from tests.unit.remote_site.made_touches import AMBIENT_C, MadeTouch, free_cooling, made_touches, pressed

Labelled = tuple[str, ThermalTrace, float | None]


def labelled(folder: Path, shorter_s: float) -> list[Labelled]:
    """Touches of 1.5 s, one of which ends earlier."""
    found: list[Labelled] = []
    for name in ("metal", "plastic"):
        for number, touch in enumerate(made_touches(name, 5, 1, 1.5)):
            kept = touch.until(shorter_s if (name, number) == ("plastic", 3) else 1.5)
            path = kept.write(folder / f"{name}_{number}.csv")
            found.append((name, read_thermal(path), touch.object_c))
    return found


def test_a_short_touch_among_longer_ones_is_named(tmp_path: Path) -> None:
    fit = calibrate_traces(labelled(tmp_path, 0.6))
    assert fit.table.lasts_s == pytest.approx(0.6, abs=0.03)
    (warning,) = (each for each in fit.warnings if "lasts only" in each)
    assert warning.startswith(f"{tmp_path / 'plastic_3.csv'} lasts only 0.")
    assert "6 s are better" in warning


def test_a_touch_that_is_too_short_is_named(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"labels: .*plastic_3.csv lasts 0\.4. s after contact, needs 0.5 s or more"):
        calibrate_traces(labelled(tmp_path, 0.45))


def trace_of(touch: MadeTouch, name: str) -> Labelled:
    ambient_c = np.full(len(touch.time_s), AMBIENT_C)
    return touch.name, ThermalTrace(touch.time_s, touch.sensor_c, touch.force_n, ambient_c, name=name), touch.object_c


def usual(name: str, count: int = 5) -> list[Labelled]:
    return [trace_of(touch, f"{name} {number}") for number, touch in enumerate(made_touches(name, count, 1, 1.5))]


def test_a_touch_ends_where_the_finger_leaves() -> None:
    """What follows is no contact: a plate in the air, which the heater may warm again."""
    (lifted,) = made_touches("plastic", 1, 2, 1.5, force=lambda t_s: np.where(t_s < 1.1, pressed()(t_s), 0.0))
    fit = calibrate_traces([*usual("metal"), *usual("plastic"), trace_of(lifted, "lifted")])
    assert fit.table.lasts_s == pytest.approx(1.1, abs=0.03)
    assert any(warning.startswith("lifted lasts only 1.1") for warning in fit.warnings)


def test_a_touch_without_readings_for_a_while_is_refused() -> None:
    (gap,) = made_touches("plastic", 1, 2, 1.5)
    gap = gap.where((gap.time_s < 0.495) | (gap.time_s > 0.795))
    with pytest.raises(ValueError, match=r"gap: no reading for 0\.31 s, 0\.49 s after contact"):
        calibrate_traces([*usual("metal"), *usual("plastic"), trace_of(gap, "gap")])


def test_touches_that_begin_in_contact_or_are_unlike_the_others_are_named() -> None:
    late, bad = made_touches("plastic", 2, 2, 1.6)
    late = late.where(late.time_s > -0.005)
    reading_c = np.where(np.abs(bad.time_s - 0.5) < 0.004, 28.0, bad.sensor_c)
    labelled_touches = [trace_of(late, "late"), trace_of(replace(bad, sensor_c=reading_c), "bad")]
    fit = calibrate_traces([*usual("metal"), *usual("plastic"), *labelled_touches])
    assert fit.in_contact == ["late"]
    assert fit.unlike == ["bad"]
    assert any("late: begins in contact" in warning and "record from" in warning for warning in fit.warnings)
    assert any("bad: the model fits this touch much worse" in warning for warning in fit.warnings)


def test_touches_without_an_unheated_sensor_among_others_with_one_are_named() -> None:
    first, second, *others = [*usual("metal"), *usual("plastic")]
    beside = [(label, replace(trace, reference_c=trace.sensor_c), object_c) for label, trace, object_c in others]
    fit = calibrate_traces([first, second, *beside])
    assert fit.table.reference is None
    assert (
        "metal 0: column reference_c is missing in 2 of 10 touches, so that the unheated sensor of the others was not "
        "calibrated; add the column, or leave these touches out"
    ) in fit.warnings
    assert not any("reference_c" in warning for warning in calibrate_traces([first, second, *others]).warnings)


def test_two_labels_of_one_material_are_named() -> None:
    plastic = usual("plastic", 12)
    other = [
        ("cover" if number % 2 else "plastic", trace, object_c) for number, (_, trace, object_c) in enumerate(plastic)
    ]
    fit = calibrate_traces([*usual("metal"), *other])
    assert [warning for warning in fit.warnings if "distinguish" in warning] == [
        "this sensor cannot distinguish plastic and cover; give them one label, or both stay ambiguous"
    ]


@pytest.mark.long
def test_a_touch_with_another_label_is_named_by_its_material() -> None:
    wrong = [("metal", trace, object_c) for _, trace, object_c in usual("plastic", 1)]
    fit = calibrate_traces([*usual("metal"), *usual("stone"), *wrong])
    assert any(warning.startswith("metal: its touches differ in effusivity by") for warning in fit.warnings)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda air: replace(air, sensor_c=np.full(len(air.time_s), 33.0)), "with the heater off"),
        (lambda air: replace(air, force_n=np.full(len(air.time_s), 1.0)), "a free cool-down touches nothing"),
        (lambda air: replace(air, sensor_c=AMBIENT_C + 9.0 * np.exp(-0.7 * np.minimum(air.time_s, 4.0))), "this one"),
    ],
)
def test_a_cool_down_that_is_none_is_refused(change: Callable[[MadeTouch], MadeTouch], why: str) -> None:
    with pytest.raises(ValueError, match=why):
        calibrate_traces([*usual("metal"), *usual("plastic"), trace_of(change(free_cooling()), "air")])
