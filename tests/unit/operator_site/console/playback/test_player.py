"""A recording under a page's hands: a jump to what is not read yet waits for that, and nothing else does."""

from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import cast

import msgpack
import pytest

from common.recording.recorder import Recorder
from operator_site.console.playback.checkpoints import Checkpoints
from operator_site.console.playback.playback import CHECKPOINT_S, Recording
from operator_site.console.playback.player import Player
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


def test_a_jump_waits_for_what_it_starts_from_and_the_newest_counts(path: Path) -> None:
    with closing(Recording(path)) as recording:
        reader, all_made = Reader(), _read(path)
        player = Player(recording, cast(Checkpoints, reader))
        player.step(0.0)
        assert player.seek(0.5 * CHECKPOINT_S)
        assert player.step(0.1), "this needs nothing"
        assert not player.seek(2.9 * CHECKPOINT_S)
        assert not player.seek(2.5 * CHECKPOINT_S)
        assert not player.step(0.2)
        assert place(player)["at_s"] == 0.5 * CHECKPOINT_S
        reader.checkpoints = all_made[:1]
        assert not player.step(0.3)
        reader.checkpoints = all_made[1:2]
        assert player.step(0.4)
        assert place(player)["at_s"] == 2.5 * CHECKPOINT_S
        assert not player.step(0.5)
        reader.checkpoints = all_made[2:]
        player.step(0.6)
        assert player.seek(1000.0)
        player.step(0.7)
        assert place(player)["at_s"] == place(player)["length_s"]


def test_what_another_process_has_read_is_entered_as_if_it_were_played(path: Path) -> None:
    with ExitStack() as opened, closing(Recording(path)) as recording:
        ahead = Checkpoints(path, opened)
        jumped = Player(recording, ahead)
        jumped.seek(at_s := 3.5 * CHECKPOINT_S)
        while not jumped.step(0.0):  # until it is read
            pass
        played = Player(recording, cast(Checkpoints, Reader()), lambda: 0.0)
        played.play(1.0)
        played.step(at_s)
        assert place(jumped)["at_s"] == place(played)["at_s"] == at_s
        pictures = [player.console.picture(player.now_s, 1, None) for player in (jumped, played)]
        assert pictures[0] == pictures[1]
        assert jumped.console.tactile_map.revision == played.console.tactile_map.revision > 0


def _read(path: Path) -> list[bytes]:
    """All checkpoints of a recording."""
    found: list[bytes] = []
    with ExitStack() as opened:
        ahead = Checkpoints(path, opened)
        while len(found) < SECONDS // CHECKPOINT_S:
            found += ahead.made()
    return found
