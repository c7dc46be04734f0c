"""A whole session over the real transports, replayed to the last bit from what it left."""

import subprocess
import sys
from pathlib import Path

import pytest

from teletaction.recordings.recover import recover
from teletaction.replay.replay import replay

pytestmark = [pytest.mark.session, pytest.mark.timeout(180)]


def test_a_session_replays_identically_whole_and_cut(tmp_path: Path) -> None:
    out = tmp_path / "out"
    demo = [sys.executable, "-m", "teletaction", "demo", "--headless", "--seconds", "6", "--fingers", "2", "--out"]
    run = subprocess.run([*demo, str(out)], capture_output=True, text=True, timeout=100, check=False)
    assert run.returncode == 0, run.stderr
    session = out / "session.mcap"
    result = replay(session, tmp_path / "replay")
    remote, operator = result["remote"]["remote"], result["operator"]["operator"]
    assert remote["first_difference"] is None
    assert operator["first_difference"] is None
    assert remote["identical"] == remote["touch_packets"] > 100
    assert operator["identical"] == operator["rendered_rows"] == operator["ticks"] > 100
    assert operator["missing_touch_packets"] == 0

    whole = session.read_bytes()
    for share in (0.7, 0.95):
        cut = tmp_path / f"cut-{share}.mcap"
        cut.write_bytes(whole[: int(len(whole) * share)])
        recovered = recover(cut)
        assert recovered is not None
        result = replay(recovered.out, tmp_path / "replay-cut")
        for part in (*result["remote"].values(), *result["operator"].values()):
            assert part["ticks"] > 100
            assert part["first_difference"] is None
