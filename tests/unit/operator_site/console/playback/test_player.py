"""A recording under a page's hands: a jump to what is not read yet waits for that, and nothing else does."""

import math
import time
from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import cast

import msgpack
import pytest

from common.recording.recorder import Recorder
from operator_site.console.playback import player as player_module
from operator_site.console.playback.checkpoints import Checkpoints
from operator_site.console.playback.playback import CHECKPOINT_S, Recording
from operator_site.console.playback.player import PlayedConsole, Player
from operator_site.site_recording import SCHEMAS
from tests.unit.operator_site.console.fed import S, rendered, touch

SECONDS = 4.5 * CHECKPOINT_S


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("played") / "session.mcap"
    with Recorder(out, SCHEMAS, {}) as recorder:
        recorder.write("operator/session", 100 * S, bytes(msgpack.packb(["connected", 7, ""])))
        for tick in range(1, round(20 * SECONDS)):
            time_ns = 100 * S + tick * S // 20
            recorder.write("operator/touch", time_ns, touch(tick, time_ns))
            recorder.write("operator/rendered", time_ns, rendered())
    return out


class Reader:
    """Reads ahead when the test lets it."""

    def __init__(self) -> None:
        self.checkpoints: list[bytes] = []

    def made(self) -> Iterator[bytes]:
        while self.checkpoints:
            yield self.checkpoints.pop(0)


def place(player: Player) -> dict[str, float]:
    """The moment of the playback as the page shows it."""
    playback: dict[str, float] = player.state()["session"]["playback"]
    return playback


@pytest.mark.long
def test_a_jump_shows_a_preview_until_its_checkpoints_are_read_and_the_newest_counts(path: Path) -> None:
    with closing(Recording(path)) as recording:
        reader, all_made = Reader(), _read(path)
        player = Player(recording, cast(Checkpoints, reader))
        player.step(0.0)
        assert player.seek(0.5 * CHECKPOINT_S)
        assert player.step(0.1)
        assert not place(player)["partial"], "this needs nothing"
        assert not player.seek(2.9 * CHECKPOINT_S)
        assert not player.seek(2.5 * CHECKPOINT_S)
        assert player.step(0.2)
        assert place(player)["at_s"] == 2.5 * CHECKPOINT_S
        assert place(player)["partial"]
        reader.checkpoints = all_made[:1]
        assert not player.step(0.3)
        reader.checkpoints = all_made[1:2]
        assert player.step(0.4)
        assert place(player)["at_s"] == 2.5 * CHECKPOINT_S
        assert not place(player)["partial"]
        assert not player.step(0.5)
        reader.checkpoints = all_made[2:]
        player.step(0.6)
        assert player.seek(1000.0)
        player.step(0.7)
        assert place(player)["at_s"] == place(player)["length_s"]


@pytest.mark.long
def test_what_another_process_has_read_is_entered_as_if_it_were_played(path: Path) -> None:
    with ExitStack() as opened, closing(Recording(path)) as recording:
        ahead = Checkpoints(path, opened)
        jumped = Player(recording, ahead)
        jumped.seek(at_s := 3.5 * CHECKPOINT_S)
        jumped.step(0.0)
        while place(jumped)["partial"]:  # until it is read
            jumped.step(0.0)
        played = Player(recording, cast(Checkpoints, Reader()), lambda: 0.0)
        played.play(1.0)
        played.step(at_s)
        assert place(jumped)["at_s"] == place(played)["at_s"] == at_s
        pictures = [player.playback.console.picture(player.playback.now_s, 1, None) for player in (jumped, played)]
        assert pictures[0] == pictures[1]
        assert jumped.playback.console.tactile_map.revision == played.playback.console.tactile_map.revision > 0


@pytest.mark.long
def test_the_map_of_a_played_recording_has_its_lumps(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(player_module, "Checkpoints", lambda path, opened: Reader())
    pressed = tmp_path / "session.mcap"
    with Recorder(pressed, SCHEMAS, {}) as recorder:
        places_m = [(0.004 * x, 0.004 * y) for x in range(10) for y in range(10)]
        for number, (x_m, y_m) in enumerate(places_m):
            lift = math.exp(-((math.dist((x_m, y_m), (0.02, 0.016)) / 0.006) ** 2))
            for part, contact in enumerate((1.0, 1.0, 0.0)):
                time_ns = 100 * S + (3 * number + part) * S // 5
                fields = {"contact": contact, "x_m": x_m, "y_m": y_m, "stiffness_n_m": 400.0 * 2.0**lift}
                recorder.write("operator/touch", time_ns, touch(3 * number + part + 1, time_ns, **fields))
    with ExitStack() as opened:
        played = PlayedConsole(pressed, opened)
        played._player.play(8.0)
        now_s = time.monotonic()
        while not (lumps := played._player.playback.console.searched.lumps):
            now_s += 1000.0
            played.step(now_s)
            time.sleep(0.01)  # the search has a thread of its own
        (lump,) = lumps
        assert lump["probability"] > 0.9
        assert played._player.state()["map"]["lumps"]


@pytest.mark.long
def test_after_a_jump_the_pages_get_another_map_with_the_same_step(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(player_module, "Checkpoints", lambda path, opened: Reader())
    with ExitStack() as opened:
        played = PlayedConsole(path, opened)

        def step(by_s: float) -> tuple[int, int]:
            """Step; return the number of the map in the pages' state, and the map's revision."""
            nonlocal now_s
            now_s += by_s
            played.step(now_s)
            return played.pages._state["map"]["number"], played._player.playback.console.tactile_map.revision

        now_s = time.monotonic()
        step(0.1)
        played._player.play(8.0)
        number, revision = step(1.0)
        assert revision > 0
        played._player.pause()
        played._player.seek(0.0)
        # Sooner than the next state is due: pages drop tiles by its number, and get the new ones after it.
        again, nothing = step(0.04)
        assert (again > number, nothing) == (True, 0)


def _read(path: Path) -> list[bytes]:
    """All checkpoints of a recording."""
    found: list[bytes] = []
    with ExitStack() as opened:
        ahead = Checkpoints(path, opened)
        while len(found) < SECONDS // CHECKPOINT_S:
            found += ahead.made()
    return found
