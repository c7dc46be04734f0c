"""The processes of the streams continue where the work of a second fails, as when strangers take all descriptors."""

import errno
import json
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from common.config.link_models import RemoteLinkConfig
from common.config.stream_models import CameraConfig, VoiceConfig
from remote_site.camera.camera import run_camera
from remote_site.stream_server import StreamServer
from remote_site.voice.voice import run_voice
from tests.conftest import Contained, Keys
from tests.ports import free_port

CONFIGS: dict[Callable[..., None], tuple[type[CameraConfig | VoiceConfig], dict[str, object]]] = {
    run_camera: (CameraConfig, {"source": "/dev/none"}),
    run_voice: (VoiceConfig, {"source": "tone:440", "sink": "none", "desk_port": free_port()}),
}


@pytest.mark.timeout(60)
@pytest.mark.parametrize("run", CONFIGS)
def test_a_second_without_a_free_descriptor_does_not_end_the_process(
    run: Callable[..., None],
    keys: Keys,
    base_port: int,
    tmp_path: Path,
    contained: Contained,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(os, "nice", lambda by: None)  # it would stay for the other tests
    failures = [OSError(errno.EMFILE, os.strerror(errno.EMFILE), "/proc/self/fd")]

    def recheck_keys(_: StreamServer) -> None:
        if failures:
            raise failures.pop()

    monkeypatch.setattr(StreamServer, "recheck_keys", recheck_keys)
    model, values = CONFIGS[run]
    status = tmp_path / "status.json"
    link = RemoteLinkConfig(base_port=base_port, keys=keys.remote)
    end_s = time.monotonic() + 20.0
    run(
        model.model_validate({"link": link, "status": status, **values}),
        lambda: status.exists() or time.monotonic() > end_s,
    )
    written: dict[str, Any] = json.loads(status.read_text("utf-8"))
    (place,) = contained.take()
    assert place.startswith("each second: OSError")
    assert len(written["contained"]) == 1
