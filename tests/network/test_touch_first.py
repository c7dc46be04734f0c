"""Touch with and without picture and voice beside it, over one network of limited rate: touch comes first."""

import json
import sys
import time
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from common.config.file import to_toml
from common.config.link_models import RemoteLinkConfig
from common.config.stream_models import CameraConfig, VoiceConfig
from common.limits import VOICE_AGE_S
from common.link.keys import load_keys
from tests.conftest import Keys
from tests.network.link_bench import BASE_PORT, Bench
from tests.network.operator_end import EVERY
from tests.network.two_hosts import REMOTE

pytestmark = [pytest.mark.netns, pytest.mark.timeout(300)]

MEASURED_S = 20.0
"""Duration of each measurement, s."""
SOURCE_PORT = 5660
ALIGNED_S = 0.005
"""Largest error of a picture's time of capture against times of touch, s."""
YOUNG = 1.10
"""Largest ratio of touch's age at 99 % with a picture to that without one."""
NETWORKS = {
    "lan": (0.3, 0.1, 0.0, 100_000.0),
    "mobile": (40.0, 15.0, 0.01, 20_000.0),
    "bad evening's slowest phase": (90.0, 30.0, 0.005, 4_000.0),
    "6 Mbit/s": (20.0, 2.0, 0.0, 6_000.0),
}
"""Delay, jitter (ms), loss and rate (kbit/s) of networks as in `sim_sensors/networks`."""


@dataclass(frozen=True)
class Pictures:
    """The pictures of a measurement: times of the operator's clock, s."""

    arrived_s: np.ndarray
    captured_s: np.ndarray
    stamped_s: np.ndarray
    touch_error_s: np.ndarray
    """Error of the clock by which touch is dated."""
    size_bytes: np.ndarray
    width: np.ndarray

    @property
    def error_s(self) -> np.ndarray:
        """Error of each time of capture."""
        return self.captured_s - self.stamped_s

    @property
    def apart_s(self) -> np.ndarray:
        """Error of each time of capture against times of touch."""
        return self.error_s - self.touch_error_s

    def row(self) -> str:
        """Ages in ms at the median and 95 %, errors of the time of capture, pictures and bits a second."""
        age_ms = 1e3 * (self.arrived_s - self.stamped_s)
        error_ms, apart_ms = (1e3 * float(np.percentile(np.abs(of), 95)) for of in (self.error_s, self.apart_s))
        seconds = self.arrived_s[-1] - self.arrived_s[0]
        return (
            f"picture age {np.percentile(age_ms, 50):.1f} / {np.percentile(age_ms, 95):.1f} ms, "
            f"time of capture off by {error_ms:.1f} ms at 95 %, {apart_ms:.1f} ms against touch, "
            f"{len(age_ms) / seconds:.1f} pictures/s, {8e-3 * self.size_bytes.sum() / seconds:.0f} kbit/s, "
            f"widths {sorted(set(self.width.astype(int).tolist()))}"
        )


class CameraBench(Bench):
    """The two hosts with the link's ends, and a camera and its reader beside them."""

    def show(self, folder: Path, keys: Keys, width: int = 640, height: int = 360, rate_hz: int = 15) -> None:
        """Start camera and reader, and wait for the first picture."""
        run = (sys.executable, "-m")
        scene = self.hosts.remote.start(
            *run, "tests.network.camera_scene", *map(str, (SOURCE_PORT, width, height, rate_hz))
        )
        assert scene.hear() == "bound"
        config = CameraConfig(
            link=RemoteLinkConfig(bind=REMOTE, base_port=BASE_PORT, keys=keys.remote),
            source=f"tcp://127.0.0.1:{SOURCE_PORT}",
            width=width,
            height=height,
            rate_hz=rate_hz,
        )
        (folder / "camera.toml").write_text(to_toml(config))
        self.hosts.remote.start(
            *run, "tests.network.host_process", "0", "0", "camera", "--config", str(folder / "camera.toml")
        ).hear()
        public = load_keys(keys.remote).public
        self.pictures = self.hosts.operator.start(
            *run, "tests.network.picture_end", REMOTE, str(BASE_PORT), str(keys.operator), public
        )
        assert self.pictures.hear() == "first picture"

    def talk(self, folder: Path, keys: Keys) -> None:
        """Start the voice, which says a tone, and its reader, which says another; wait for the first sound."""
        run = (sys.executable, "-m")
        link = RemoteLinkConfig(bind=REMOTE, base_port=BASE_PORT, keys=keys.remote)
        (folder / "voice.toml").write_text(to_toml(VoiceConfig(link=link, source="tone:440", sink="none")))
        self.hosts.remote.start(
            *run, "tests.network.host_process", "0", "0", "voice", "--config", str(folder / "voice.toml")
        ).hear()
        public = load_keys(keys.remote).public
        self.sounds = self.hosts.operator.start(
            *run, "tests.network.sound_end", REMOTE, str(BASE_PORT), str(keys.operator), public
        )
        assert self.sounds.hear() == "first sound"


def measure(
    keys: Keys, network: tuple[float, float, float, float], folder: Path | None, *, voice: bool = False
) -> tuple[np.ndarray, Pictures | None, np.ndarray]:
    """Return the ages of touch over a network, ms, the pictures, and duration and ages of the sounds, s.

    A camera is beside it where there is a `folder` for its files, and a `voice` as well where that is wanted.
    """
    with ExitStack() as ends:
        bench = CameraBench(keys, ends)
        bench.hosts.impair(*network)
        bench.connect()
        if folder is not None:
            bench.show(folder, keys)
            if voice:
                bench.talk(folder, keys)
        begun_ns = time.monotonic_ns()
        while time.monotonic_ns() - begun_ns < MEASURED_S * 1e9:
            bench.accept(EVERY)
        pictures = None
        if folder is not None:
            pictures = Pictures(*np.array(json.loads(bench.pictures.end().splitlines()[-1])).T)
        sounds_s = np.array(json.loads(bench.sounds.end().splitlines()[-1]) if voice else [])
        found = bench.finish()
        return found.age_ns[found.arrived_ns >= begun_ns] / 1e6, pictures, sounds_s


@pytest.mark.parametrize("network", NETWORKS)
def test_touch_is_as_young_with_a_picture_as_without(
    keys: Keys, table: list[str], tmp_path: Path, network: str
) -> None:
    alone, _, _ = measure(keys, NETWORKS[network], None)
    beside, pictures, _ = measure(keys, NETWORKS[network], tmp_path)
    assert pictures is not None
    ages_ms = [np.percentile(found, [50, 99]) for found in (alone, beside)]
    table.append(
        f"{network}: touch alone {ages_ms[0][0]:.2f} / {ages_ms[0][1]:.2f} ms of {len(alone)}, "
        f"beside a picture {ages_ms[1][0]:.2f} / {ages_ms[1][1]:.2f} ms of {len(beside)}; {pictures.row()}"
    )
    assert ages_ms[1][1] <= YOUNG * ages_ms[0][1]
    assert not np.isnan(pictures.error_s).any(), "a stamp could not be read"
    assert np.percentile(np.abs(pictures.apart_s), 95) <= ALIGNED_S


@pytest.mark.parametrize("network", ["mobile", "bad evening's slowest phase"])
def test_touch_is_as_young_with_picture_and_voice_as_without(
    keys: Keys, table: list[str], tmp_path: Path, network: str
) -> None:
    alone, _, _ = measure(keys, NETWORKS[network], None)
    beside, _, sounds_s = measure(keys, NETWORKS[network], tmp_path, voice=True)
    ages_ms = [np.percentile(found, [50, 99]) for found in (alone, beside)]
    seconds, sounds_s = sounds_s[0], sounds_s[1:]
    sound_ms = np.percentile(1e3 * sounds_s, [50, 99])
    table.append(
        f"{network}: touch alone {ages_ms[0][0]:.2f} / {ages_ms[0][1]:.2f} ms of {len(alone)}, beside picture and "
        f"voice {ages_ms[1][0]:.2f} / {ages_ms[1][1]:.2f} ms of {len(beside)}; voice {sound_ms[0]:.1f} / "
        f"{sound_ms[1]:.1f} ms, {len(sounds_s) / seconds:.1f} sounds/s"
    )
    assert ages_ms[1][1] <= YOUNG * ages_ms[0][1]
    assert len(sounds_s) > 10
    assert sounds_s.max() <= VOICE_AGE_S
