"""Runs the operator site on a virtual environment, without a remote site."""

import logging
from collections.abc import Callable
from contextlib import ExitStack

from common.config.site_models import OperatorConfig
from common.link.keys import load_keys
from common.scenes.scene import Scene
from operator_site.site import run_operator_site
from operator_site.thermal.scene_skin import prepare
from operator_site.virtual.virtual_environment import VirtualEnvironment
from operator_site.virtual.virtual_session import VirtualSession

log = logging.getLogger(__name__)


def run_virtual(config: OperatorConfig, stop: Callable[[], bool], *, scene: Scene, seed: int) -> None:
    """Run the operator site on a scene until `stop()`.

    Raises:
        ValueError, OSError: keys or devices cannot be used.
    """
    prepare(scene.materials.values())

    def begin(_: ExitStack) -> tuple[VirtualSession, Callable[[], None]]:
        environment = VirtualEnvironment(scene, config.fingers, seed)
        name = f"scene {scene.name}, seed {seed}"
        log.info("touching %s", name)
        return VirtualSession(environment, name, config.engage, config.link.gap_s), lambda: None

    run_operator_site(config, load_keys(config.link.keys), begin, stop, scene=scene.name, seed=str(seed))
