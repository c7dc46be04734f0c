"""Makes the tables that ship with the remote site, calibrated on simulated touches and strokes."""

import tempfile
from pathlib import Path

from common.scenes.scene import load_scene
from common.scenes.surfaces import surface_kind
from remote_site.texture.calibration.texture_calibration import calibrate_texture
from remote_site.thermal.calibration.thermal_calibration import calibrate_thermal
from sim_sensors.traces.simulate import simulate_stroke_set, simulate_thermal_set, write_thermal_csv
from sim_sensors.traces.simulated_touch import simulate_thermal

TOUCHES = 40
"""Number of calibration touches of each material at each force."""
FORCES_N = (0.7, 1.2, 1.8)
"""Forces of the calibration touches, N.

They cover the forces of a session because contact conductance rises with force.
"""
SECONDS = 8.1
"""Time in contact of a calibration touch, s."""
AIR_SECONDS = 12.0
"""Length of a free cool-down, s."""
SERIAL = "simulated"
"""Sensor serial number in the tables."""
LIVING = "skin_dermis"
"""Living material, calibrated at body temperature. All other materials are calibrated near room temperature."""
BODY_OFFSETS_C = (9.0, 13.0)
"""Temperature range of living skin above ambient, K."""
BODY_PREHEAT_K = 17.0
"""Pre-heat of the sensor above ambient for living skin, K. It must exceed the skin's temperature."""
STROKED = (
    "foam",
    "plain_pvc",
    "sandpaper",
    "closely_grooved_pvc",
    "widely_grooved_pvc",
    "arbitrarily_grooved_pvc",
)
"""Reference surfaces of the texture calibration."""
STROKES = ((25.0, 1.2), (50.0, 1.2), (100.0, 1.2), (50.0, 0.6), (80.0, 2.5), (140.0, 3.5))
"""Pairs of speed (mm/s) and force (N) of the calibration strokes."""


def make_tables(out: Path, *, made_on: str = "") -> list[Path]:
    """Write the tables of materials, material blocks, phantom and surfaces into `out`.

    This takes about a minute.

    Raises:
        OSError: `out` cannot be written.
    """
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        four = load_scene("materials").calibrated
        _touches(work / "materials", four, 11_000)
        calibrate_thermal(work / "materials", out / "materials.json", sensor_serial=SERIAL, made_on=made_on)
        _touches(work / "blocks", four, 11_500, block=True)
        calibrate_thermal(work / "blocks", out / "materials_blocks.json", sensor_serial=SERIAL, made_on=made_on)
        _touches(work / "phantom", tuple(n for n in load_scene("phantom").calibrated if n != LIVING), 12_000)
        _skin(work / "phantom", 12_500)
        calibrate_thermal(work / "phantom", out / "phantom.json", sensor_serial=SERIAL, made_on=made_on)
        constants = {name: (surface_kind(name).k_stroke_v, surface_kind(name).k_stroke_f) for name in STROKED}
        for number, surface in enumerate(constants):
            for variant, (speed_mm_s, force_n) in enumerate(STROKES):
                simulate_stroke_set(
                    surface,
                    strokes=2,
                    speed_mm_s=speed_mm_s,
                    force_n=force_n,
                    seed=13_000 + 10 * number + variant,
                    out=work / "strokes",
                )
        calibrate_texture(
            work / "strokes", out / "surfaces.json", constants=constants, sensor_serial=SERIAL, made_on=made_on
        )
    return [out / name for name in ("materials.json", "materials_blocks.json", "phantom.json", "surfaces.json")]


def _touches(folder: Path, materials: tuple[str, ...], seed: int, *, block: bool = False) -> None:
    """Simulate touches near room temperature and free cool-downs.

    With `block`, all touches of a material meet one block; otherwise each meets a new piece.
    """
    for number, material in enumerate(materials):
        for variant, force_n in enumerate(FORCES_N):
            simulate_thermal_set(
                material,
                TOUCHES,
                seconds=SECONDS,
                seed=seed + 10 * number + variant,
                force_n=force_n,
                block=block,
                out=folder,
            )
    simulate_thermal_set("air", 5, seconds=AIR_SECONDS, seed=seed + 100, out=folder)


def _skin(folder: Path, seed: int) -> None:
    """Simulate touches of skin at body temperature and add them to the labels of `folder`."""
    traces = [
        trace
        for variant, force_n in enumerate(FORCES_N)
        for trace in simulate_thermal(
            LIVING,
            seed + variant,
            touches=TOUCHES,
            seconds=SECONDS,
            force_n=force_n,
            preheat_k=BODY_PREHEAT_K,
            offset_c=BODY_OFFSETS_C,
            thickness_m=None,
        )
    ]
    with (folder / "labels.csv").open("a", encoding="utf-8") as labels:
        for number, trace in enumerate(traces):
            file = f"{LIVING}_{number:03d}.csv"
            write_thermal_csv(folder / file, trace)
            labels.write(f"{file},{LIVING},{trace.object_c:.4f}\n")
