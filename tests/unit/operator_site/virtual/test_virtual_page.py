"""The examples of docs/howto/virtual.md are read by the program as they stand."""

import re
from pathlib import Path

import pytest

from common.config.file import load_config
from common.config.simulation_models import SimOperatorConfig
from common.config.site_models import OperatorConfig
from common.fingers import FINGERS
from common.scenes.scene import SceneObject, load_scene, scene_names
from common.wire.packets import LinkState
from operator_site.virtual.virtual_environment import VirtualEnvironment
from tests.places import ROOT

PAGE = (ROOT / "docs" / "howto" / "virtual.md").read_text("utf-8")
EXAMPLES = dict(re.findall(r"^```toml (\S+)[^\n]*\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL))


def example(name: str, folder: Path) -> Path:
    path = folder / f"{name}.toml"
    path.write_text(EXAMPLES[name], "utf-8")
    return path


def test_the_configurations_fit_together(tmp_path: Path) -> None:
    operator = load_config(example("operator", tmp_path), OperatorConfig)
    simulated = load_config(example("sim-operator", tmp_path), SimOperatorConfig)
    assert operator.fingers == simulated.fingers
    assert operator.exoskeleton.port == simulated.can_port
    listening = {finger: address.removeprefix("tcp:") for finger, address in simulated.tacttip.items()}
    assert listening == {finger: address.removeprefix("socket://") for finger, address in operator.tacttip.items()}
    assert operator.link.keys == tmp_path / "keys"
    assert f"--scene {simulated.scene} " in PAGE


def test_the_scene_loads_and_feels_as_described(tmp_path: Path) -> None:
    environment = VirtualEnvironment(load_scene(str(example("scene", tmp_path))), FINGERS, 0)
    environment.step(1.0, 0.04, 0.0, (0.005,) * len(FINGERS))
    rows = environment.packet(1, 1, 1, LinkState.ENGAGED).rows
    middle = FINGERS.index("middle")
    assert [finger for finger, row in enumerate(rows) if any(row)] == [middle]
    assert rows[middle].object_c == 12.0
    assert rows[middle].conductivity_w_mk == pytest.approx(0.05)
    assert rows[middle].stiffness_n_m == 1500.0


def test_every_scene_and_every_field_of_an_object_is_named() -> None:
    named = set(re.findall(r"`(\w+)`", PAGE))
    assert set(scene_names()) <= named
    assert set(SceneObject.model_fields) - {"name"} <= named
