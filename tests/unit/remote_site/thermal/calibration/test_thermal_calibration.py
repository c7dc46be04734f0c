"""Calibration names touches that are too short."""

from pathlib import Path

import pytest

from remote_site.thermal.calibration.thermal_calibration import calibrate_traces
from remote_site.traces.trace_files import ThermalTrace, read_thermal
from tests.unit.remote_site.made_touches import made_touches


def labelled(folder: Path, shorter_s: float) -> list[tuple[str, ThermalTrace, float | None]]:
    """Touches of 1.5 s, one of which ends earlier."""
    found: list[tuple[str, ThermalTrace, float | None]] = []
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
