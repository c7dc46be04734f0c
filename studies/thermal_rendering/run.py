"""Thermal rendering at the finger: error against cost of every model and integrator, and errors of plate and loop.

Each touch lasts 10 s. For models and integrators the object has 25 C and the resting finger 33.1 C. Errors are those of
the felt temperature. The reference of models is an independent finger (`reference_finger`). The reference of
integrators is the exact solution of the same model. The reference of plates is the simulators' finger on the object
itself. Costs are those of one step of five fingers, in bare products of the usual model's size, in the same run.
"""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from common.fingers import FINGERS
from operator_site.thermal.model_selection import RUNGS, choose
from operator_site.thermal.scene_skin import SceneSkin
from operator_site.thermal.skin_model import STEP_S, SkinModel, SkinStep, Touched, skin_rates, skin_step
from operator_site.thermal.tissue import Body, Floats, rest
from studies.compared import Compared
from studies.pieces import HERE, Piece, Work, part_of, rows_of
from studies.running import Progress, tables_of
from studies.thermal_rendering.felt_error import tolerance_k
from studies.thermal_rendering.naive_inverse import inverse_rows
from studies.thermal_rendering.plate_in_loop import loop_pieces
from studies.thermal_rendering.plate_strategies import OBJECTS, colder_rows, rate_rows, strategy_rows
from studies.thermal_rendering.reference_finger import felt_course
from teletaction.session.step_cost import quickest_s

OBJECT_C = 25.0
SECONDS = 10.0
MODELS = (
    "1+1+1",
    "1+1+1+10",
    *(str(model) for model in RUNGS[1:3]),
    "4+2+2+6",
    "3+3+4+10",
    str(RUNGS[3]),
    "10+10+10+20",
)
USUAL = SkinModel(4, 1, 1, 6)
QUICK_LOOP = ("copper", "ceramic_tile", "skin_dermis", "pvc", "pu_foam")
INTEGRATED = tuple((name, model) for name in ("iron", "pine") for model in (USUAL, RUNGS[-1]))
EXPLICIT_EULER, IMPLICIT_EULER, EXACT = "explicit Euler", "implicit Euler", "matrix exponential"
SUBSTEPS = (1, 2, 5, 10, 20, 50)
"""Numbers of steps of the Euler methods within 10 ms."""
SOLVERS = ("RK45", "LSODA", "BDF")
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-6)
REACH = {EXPLICIT_EULER: 2.0, "RK45": 3.3}
"""Length of a method's stability region on the negative real axis (RK45: Dormand & Prince 1980)."""
tables = tables_of("models", "integrators", "rates", "strategies", "told_apart", "inverse", "loop")
COMPARED = (
    Compared("models", "share_of_tolerance", "less", ("object", "model"), absolute=0.01, relative=0.02),
    Compared("models", "products", "less", ("object", "model"), relative=0.5),
    Compared(
        "loop",
        "share_where_rate_allows",
        "less",
        ("object", "object_c", "tick_s", "noise_k"),
        absolute=0.05,
        relative=0.02,
    ),
)


def run(quick: bool, seed: int, progress: Progress, work: Work = HERE) -> dict[str, Any]:
    """Run all parts; `seed` sets the thermistors' noise, the only random part.

    Models and integrators are timed in this process before all other work.
    """
    progress(0.0)
    unit_us = _product_us()
    models = list(_models(unit_us))
    progress(0.1)
    integrators = list(_integrators(unit_us, 1.0 if quick else SECONDS))
    few: dict[str, Any] = {"names": QUICK_LOOP, "temperatures_c": (25.0,), "ticks_s": (0.002, 0.05)} if quick else {}
    pieces: dict[str, list[Piece]] = {
        "rates": [(rate_rows, ())],
        "strategies": [(strategy_rows, ())],
        "told_apart": [(colder_rows, ())],
        "inverse": [(inverse_rows, (seed,))],
        "loop": loop_pieces(seed=seed, **few),
    }
    return {
        "product_us": unit_us,
        "models": models,
        "integrators": integrators,
        **rows_of(pieces, work, part_of(progress, 0.3, 1.0)),
    }


def _product_us() -> float:
    """Return the time of a bare product for five fingers, us."""
    n = USUAL.states
    a, x = np.random.default_rng(0).standard_normal((5, n, n)), np.ones((5, n, 1))
    return 1e6 * quickest_s(lambda: np.matmul(a, x), 2000)


def _felt(model: SkinModel, name: str) -> Floats:
    skin = SceneSkin(model, fingers=1)
    felt = [skin.state().epidermis_c[0]]
    skin.touch(0, Touched.of(name), OBJECT_C)
    felt += [skin.step().epidermis_c[0] for _ in range(round(SECONDS / STEP_S))]
    return np.array(felt)


def _models(unit_us: float) -> Iterator[dict[str, Any]]:
    times_s = STEP_S * np.arange(round(SECONDS / STEP_S) + 1)
    resting = rest(Body())
    for name in OBJECTS:
        it = Touched.of(name)
        course = felt_course(it.conductivity_w_mk, it.density_kg_m3 * it.specific_heat_j_kgk, it.contact_m2k_w)
        true = np.interp(times_s, course.time_s, course.at(OBJECT_C))
        tolerance = tolerance_k(true - true[0])
        chosen = choose(it, OBJECT_C - resting.surface_c).model
        for text in MODELS:
            model = SkinModel.parse(text)
            error = np.abs(_felt(model, name) - true)
            skin = SceneSkin(model)
            for finger in range(len(FINGERS)):
                skin.touch(finger, it, OBJECT_C)
            step_us = 1e6 * quickest_s(skin.step, 200)
            yield {
                "object": name,
                "model": text,
                "states": model.states,
                "error_k": float(error.max()),
                "share_of_tolerance": float((error / tolerance).max()),
                "step_us": step_us,
                "products": step_us / unit_us,
                "chosen": model == chosen,
            }


def _integrators(unit_us: float, seconds: float) -> Iterator[dict[str, Any]]:
    """Call each method every 10 ms as a loop does; yield its error against the exact step of the same model."""
    steps = round(seconds / STEP_S)
    for name, model in INTEGRATED:
        rates, exact = skin_rates(model, Touched.of(name)), skin_step(model, Touched.of(name), Body().air_w_m2k)
        resting = rest(Body())
        start = np.zeros(model.states)
        start[model.skin_cells :] = OBJECT_C - resting.surface_c
        inputs = np.array([resting.flux_w_m2, OBJECT_C - resting.surface_c])
        true = _course(rates, start, steps, _repeated(exact.a, exact.b @ inputs))
        fastest_per_s = float(np.abs(np.linalg.eigvals(rates.a)).max())
        for method, setting, advance in _methods(rates, exact, inputs):
            felt = _course(rates, start, steps, advance)
            error = float(np.abs(felt - true).max()) if np.isfinite(felt).all() else np.inf
            us = 1e6 * quickest_s(partial(advance, start), 30 if method in SOLVERS else 300, 5)
            yield {
                "object": name,
                "model": str(model),
                "method": method,
                "setting": setting,
                "error_k": error if error < 1e3 else None,
                "step_us": us,
                "products": us / unit_us,
                "diverges_above_s": REACH[method] / fastest_per_s if method in REACH else None,
            }


def _methods(
    rates: SkinStep, exact: SkinStep, inputs: Floats
) -> Iterator[tuple[str, float, Callable[[Floats], Floats]]]:
    drive = rates.b @ inputs
    yield EXACT, STEP_S, _repeated(exact.a, exact.b @ inputs)
    one = np.eye(len(rates.a))
    for substeps in SUBSTEPS:
        h = STEP_S / substeps
        yield EXPLICIT_EULER, h, _repeated(one + h * rates.a, h * drive, substeps)
        implicit: Floats = np.asarray(np.linalg.inv(one - h * rates.a), dtype=np.float64)
        yield IMPLICIT_EULER, h, _repeated(implicit, implicit @ (h * drive), substeps)
    for method in SOLVERS:
        for tolerance in TOLERANCES:
            yield method, tolerance, _solver(rates, drive, method, tolerance)


def _repeated(a: Floats, offset: Floats, times: int = 1) -> Callable[[Floats], Floats]:
    def advance(x: Floats) -> Floats:
        for _ in range(times):
            x = a @ x + offset
        return x

    return advance


def _solver(rates: SkinStep, drive: Floats, method: str, tolerance: float) -> Callable[[Floats], Floats]:
    def advance(x: Floats) -> Floats:
        solved = solve_ivp(
            lambda _, y: rates.a @ y + drive, (0.0, STEP_S), x, method=method, rtol=tolerance, atol=0.1 * tolerance
        )
        return np.asarray(solved.y[:, -1])

    return advance


def _course(rates: SkinStep, start: Floats, steps: int, advance: Callable[[Floats], Floats]) -> Floats:
    """Return the course of the felt temperature as a deviation from rest, K."""
    x, felt = start, []
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(steps):
            x = advance(x)
            felt.append(rates.c[0] @ x)
    return np.array(felt)
