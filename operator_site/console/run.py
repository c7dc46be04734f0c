"""Runs the console's process, which serves pages of a running site or of a recording."""

import logging
from collections.abc import Callable
from contextlib import ExitStack, closing
from pathlib import Path
from socket import socket

from common.config.file import to_toml
from common.config.link_models import OperatorLinkConfig
from common.config.page_models import ConsoleCameraConfig, ConsoleConfig, ConsoleVoiceConfig
from common.link.keys import KeyPair, fingerprint, load_keys
from common.privacy.key_variable import given_key
from common.runtime.status_file import StatusFile
from common.runtime.systemd_notify import Supervisor
from common.web.access import Access
from common.web.page_server import Work, address_of, bound, serve_page
from common.wire.camera_messages import MAX_PICTURE
from common.wire.packets import MAX_PACKET
from operator_site.console.camera.camera import Camera
from operator_site.console.examination.journal import Journal
from operator_site.console.live import LiveConsole
from operator_site.console.local_control import LocalControlClient
from operator_site.console.playback.player import PlayedConsole
from operator_site.console.stream_socket import StreamSocket
from operator_site.console.voice.voice import Voice
from operator_site.console.web.server import application
from operator_site.session.console_feed import FeedReader
from operator_site.session.remote_key import remote_public_key

log = logging.getLogger(__name__)

_LOOK_S = 0.008
"""Interval between two reads of the site's feed, s; a batch waits at most this long."""


def run_console(config: ConsoleConfig, stop: Callable[[], bool]) -> None:
    """Serve the page of a running site until `stop()`.

    Raises:
        ValueError, OSError: the access settings are unsafe, the port is in use, the keys are unusable, or the
            recording cannot be created.
    """
    # The emergency stop passes through this process, so it keeps its priority on a busy machine (decision 0041).
    with ExitStack() as opened:
        access = Access(config)
        keys = load_keys(config.keys)
        page = opened.enter_context(bound(config))  # first: a start that fails leaves no file
        feed = FeedReader(config.feed_port, keys)
        opened.callback(feed.close)
        site = LocalControlClient(config.desk_port, keys)
        opened.callback(site.close)
        encrypt_for = keys.public if config.recording.encrypt else None
        # The journal and the report's command open the encrypted recordings of this site.
        opened.enter_context(given_key(config.keys))
        metadata = {"configuration": to_toml(config), "key": fingerprint(keys.public)}
        journal = Journal(config.record, metadata, encrypt_for)
        opened.callback(journal.close)
        camera: Camera | None = None
        voice: Voice | None = None
        if config.camera is not None:
            pictures = _line("camera", config, config.camera, keys, MAX_PICTURE)
            camera = opened.enter_context(closing(Camera(pictures, required=config.camera.required)))
        if config.voice is not None:
            sounds = _line("voice", config, config.voice, keys)
            record = config.voice.record and config.record is not None
            voice = opened.enter_context(closing(Voice(sounds, record=record)))
        live = LiveConsole(config, feed, site, journal, camera=camera, voice=voice)
        _serve(live, config, access, page, stop, opened)


def _line(
    stream: str,
    config: ConsoleConfig,
    far: ConsoleCameraConfig | ConsoleVoiceConfig,
    keys: KeyPair,
    most_bytes: int = MAX_PACKET,
) -> StreamSocket:
    """Return a connection with the process of the remote site that serves a stream."""
    link = OperatorLinkConfig(keys=config.keys, host=far.host, base_port=far.base_port, remote_key=far.remote_key)
    return StreamSocket(stream, far.host, far.base_port, keys, remote_public_key(link), most_bytes)


def run_playback(path: Path, port: int, stop: Callable[[], bool]) -> None:
    """Serve the page of a recording on loopback until `stop()`.

    Raises:
        ValueError, OSError: the recording cannot be read, or the port is in use.
    """
    config = ConsoleConfig(keys=Path(), port=port)
    with ExitStack() as opened:
        played = PlayedConsole(path, opened)
        _serve(played, config, Access(config), opened.enter_context(bound(config)), stop, opened)


def _serve(
    shown: LiveConsole | PlayedConsole,
    config: ConsoleConfig,
    access: Access,
    page: socket,
    stop: Callable[[], bool],
    opened: ExitStack,
) -> None:
    opened.callback(shown.camera_pages.close)
    status = StatusFile(config.status, "console")
    about = {"address": address_of(config, page)}
    app = application(access, shown.pages, shown.camera_pages, shown.voice_pages, config.reports)
    contain = shown.pages.contain
    log.info("the page is at %s", about["address"])

    def each_second() -> None:
        figures = shown.figures()
        status.write(0.0, {**about, **figures, "contained": dict(contain.places)})
        supervisor.alive(f"{figures['clients']} pages")

    with Supervisor() as supervisor:
        supervisor.ready()
        serve_page(app, config, page, contain, Work(stop, shown.step, _LOOK_S, each_second))
