"""Renders one fingertip without devices, and yields the results of a stated case as rows for a CSV file."""

import json
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from common.limits import COMFORT
from common.wire.messages import Event
from operator_site.thermal.model_selection import choose
from operator_site.thermal.plates import PlateSetpoint
from operator_site.thermal.scene_skin import SceneSkin
from operator_site.thermal.skin_model import STEP_S, SkinModel, Touched
from operator_site.thermal.tissue import BLOOD_DENSITY_KG_M3, BLOOD_SPECIFIC_HEAT_J_KGK, LAYERS, Body, rest
from operator_site.vibration.vibration import FingerVibration, PlayedEvents, Surface

CONTACT_S = 1.0
"""Time at which the contact begins, s."""
LONGEST_S = 3600.0
"""Longest rendered case, s."""
THERMAL_COLUMNS = ("time_s", "skin1_c", "skin2_c", "skin3_c", "surface_c", "flux_w_m2")
PLATE_COLUMN = "plate_c"
VIBRATION_COLUMNS = ("time_s", "mode", "motor_rpm")


def _object(name: str) -> Touched:
    try:
        return Touched.of(name)
    except KeyError as error:
        raise ValueError(error.args[0]) from None


def _temperature(value_c: float, name: str) -> float:
    if not -50.0 <= value_c <= 150.0:
        raise ValueError(f"{name} must be a temperature in -50..150 C, not {value_c}")
    return value_c


def _model(name: str | None, touched: Touched, object_c: float, body: Body) -> SkinModel:
    """Return the named model, or the smallest one that is accurate enough for the touch."""
    if name is not None:
        return SkinModel.parse(name)
    return choose(touched, object_c - rest(body).surface_c).model


def render_thermal(
    object_name: str,
    object_c: float,
    air_c: float,
    seconds: float,
    *,
    model: str | None = None,
    plate: bool = False,
) -> Iterator[tuple[float, ...]]:
    """Return rows of THERMAL_COLUMNS every 10 ms, with `plate` also its set-point within the comfort profile.

    The finger moves freely in steady state until CONTACT_S and is in contact afterwards. Flux is positive into the
    finger.

    Raises:
        ValueError: an object or model is unknown, or a number is out of range (before the first row).
    """
    touched = _object(object_name)
    _temperature(object_c, "object_c")
    body = Body(air_c=_temperature(air_c, "air_c"))
    cells = _model(model, touched, object_c, body)
    if not 0.0 < seconds <= LONGEST_S:
        raise ValueError(f"seconds must be above 0 and at most {LONGEST_S:g}, not {seconds}")
    skin = SceneSkin(cells, body, fingers=1)
    return _thermal_rows(skin, touched, object_c, round(seconds / STEP_S), plate=plate)


def _thermal_rows(
    skin: SceneSkin, touched: Touched, object_c: float, steps: int, *, plate: bool
) -> Iterator[tuple[float, ...]]:
    state = skin.state()
    display = PlateSetpoint(COMFORT, state.surface_c) if plate else None
    contact = round(CONTACT_S / STEP_S)
    for step in range(steps + 1):
        if step == contact:
            skin.touch(0, touched, object_c)
            state = skin.state()
        elif step:
            state = skin.step()
        columns = (state.epidermis_c, state.dermis_c, state.subcutis_c, state.surface_c, state.flux_w_m2)
        row = (step / round(1.0 / STEP_S), *(column[0] for column in columns))
        if display:
            display.aim(state, [step >= contact], {})
            row = (*row, display.step(STEP_S if step else 0.0)[0])
        yield row


def write_parameters(path: Path, object_name: str, object_c: float, air_c: float, *, model: str | None = None) -> None:
    """Write all constants of the same case as JSON, so that it can be computed independently.

    Raises:
        ValueError: as `render_thermal`.
    """
    touched = _object(object_name)
    body = Body(air_c=_temperature(air_c, "air_c"))
    parameters = {
        "skin": [asdict(layer) for layer in LAYERS],
        "blood": {"density_kg_m3": BLOOD_DENSITY_KG_M3, "specific_heat_j_kgk": BLOOD_SPECIFIC_HEAT_J_KGK},
        "arterial_c": body.arterial_c,
        "deep_c": body.deep_c,
        "air_c": body.air_c,
        "air_w_m2k": body.air_w_m2k,
        "object": {
            "name": object_name,
            "conductivity_w_mk": touched.conductivity_w_mk,
            "density_kg_m3": touched.density_kg_m3,
            "specific_heat_j_kgk": touched.specific_heat_j_kgk,
            "thickness_m": None,
            "start_c": _temperature(object_c, "object_c"),
        },
        "contact_resistance_m2k_w": touched.contact_m2k_w,
        "contact_s": CONTACT_S,
        "model": str(_model(model, touched, object_c, body)),
        "step_s": STEP_S,
    }
    path.write_text(json.dumps(parameters, indent=2) + "\n", encoding="utf-8")


@dataclass(frozen=True, slots=True)
class StrokeSample:
    """Identified surface of one finger and motion of the hand at one time."""

    t_s: float
    mode: int
    speed_m_s: float
    force_n: float
    surface: Surface
    events: Sequence[Event] = ()


def render_vibration(samples: Iterable[StrokeSample]) -> Iterator[tuple[float, int, float]]:
    """Yield a row of VIBRATION_COLUMNS for each sample; a repeated event is played once.

    Raises:
        ValueError: a sample's time is not after the one before, or one of its numbers is not finite.
    """
    vibration, played = FingerVibration(), PlayedEvents()
    last_s = -math.inf
    for sample in samples:
        if not math.isfinite(sample.t_s + sample.speed_m_s + sample.force_n):
            raise ValueError(f"sample at {sample.t_s} s: time, speed and force must be finite numbers")
        if sample.t_s <= last_s:
            raise ValueError(f"sample at {sample.t_s} s does not come after {last_s} s")
        last_s = sample.t_s
        rpm = vibration.step(
            sample.t_s,
            sample.mode,
            sample.speed_m_s,
            sample.force_n,
            surface=sample.surface,
            events=played.new(sample.events),
        )
        yield sample.t_s, sample.mode, rpm
