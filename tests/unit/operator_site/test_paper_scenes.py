"""The paper's objects in a virtual environment: each feels as intended, and differs from the others."""

import numpy as np
import pytest

from common.scenes.scene import load_scene
from common.wire.messages import EventKind
from tests.unit.operator_site.virtual_touch import INDEX, Working


def centre(scene: str, name: str) -> float:
    return load_scene(scene).object_named(name).x_at(0.5)


def stroked(name: str) -> tuple[float, float, int]:
    """Force on the finger, N, mean motor speed, rpm, and grooves, of a stroke at 50 mm/s over an object."""
    working, x_m = Working("paper_textures"), centre("paper_textures", name)
    working.press(x_m - 0.02)
    grooves, outputs = 0, []
    for place in np.linspace(x_m - 0.02, x_m + 0.02, 400):
        outputs += working.go(0.002, x_m=float(place))
        touch = working.client.touch
        assert touch is not None
        grooves += sum(event.kind is EventKind.GROOVE for event in touch.events)
    return (
        outputs[-1].force_n[INDEX],
        float(np.mean([output.motor_rpm[INDEX] for output in outputs[100:]])),
        grooves,
    )


@pytest.mark.long
def test_textures_differ_in_vibration_and_not_in_force() -> None:
    sensed = {thing.name: stroked(thing.name) for thing in load_scene("paper_textures").objects}
    assert [force_n for force_n, _, _ in sensed.values()] == pytest.approx([1.2] * 6)
    rpm = {name: mean for name, (_, mean, _) in sensed.items()}
    assert rpm["foam"] < rpm["plain"] < min(rpm["widely_grooved"], rpm["arbitrarily_grooved"])
    assert rpm["widely_grooved"] < rpm["closely_grooved"]
    assert rpm["plain"] < rpm["sandpaper"]
    grooves = {name: count for name, (_, _, count) in sensed.items()}
    assert grooves["foam"] == grooves["sandpaper"] == grooves["plain"] == 0
    assert grooves["closely_grooved"] == pytest.approx(20, abs=1)
    assert grooves["widely_grooved"] == pytest.approx(5, abs=1)
    assert grooves["widely_grooved"] < grooves["arbitrarily_grooved"] < grooves["closely_grooved"]


def held(scene: str, name: str, seconds: float) -> tuple[float, float]:
    """Felt temperature by the model, and temperature of the plate, as change since before the touch, K."""
    working = Working(scene)
    working.be_at(centre(scene, name), 0.006)
    plate_c = working.go(0.2)[-1].plate_set_c[INDEX]
    before_c = working.site.rendering.fingertips.skin.epidermis_c[INDEX]
    working.go(0.2, z_m=-0.003)
    shown = working.go(seconds)[-1].plate_set_c[INDEX]
    return working.site.rendering.fingertips.skin.epidermis_c[INDEX] - before_c, shown - plate_c


@pytest.mark.long
def test_materials_of_one_temperature_differ_in_how_cold_they_feel() -> None:
    sensed = {thing.name: held("paper_materials", thing.name, 5.0) for thing in load_scene("paper_materials").objects}
    for kelvin in ({name: each[n] for name, each in sensed.items()} for n in (0, 1)):
        assert kelvin["aluminium"] < kelvin["ceramic"] < kelvin["pvc"] < kelvin["wood"] < -0.5


@pytest.mark.long
def test_iron_of_35_c_feels_warmer_than_wood_of_35_c() -> None:
    iron, wood = (held("paper_iron_wood", name, 10.0)[0] for name in ("iron", "wood"))
    assert iron > 1.2 * wood > 0.0


@pytest.mark.parametrize("name", ["paper_textures", "paper_materials", "paper_iron_wood"])
def test_the_scripts_touch_every_object(name: str) -> None:
    scene = load_scene(name)
    targets = {getattr(step, "object", None) for step in scene.script} - {None}
    assert targets == {thing.name for thing in scene.objects}
