"""Records a session on the test bed: the same files as a real session, on a virtual clock."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from common.config.file import to_toml
from common.config.site_models import OperatorConfig, RemoteConfig
from common.link.keys import load_keys
from common.recording.clock_anchor import ClockAnchor
from common.recording.recorder import Recorder
from operator_site.session.console_feed import ConsoleFeed
from operator_site.site_recording import SCHEMAS
from remote_site.site_recording import open_recorder
from teletaction.recordings.merge import merge_recordings
from teletaction.session.demo_files import PROCESSES, DemoOptions, prepare
from teletaction.testbed.site_clock import SiteClock
from teletaction.testbed.testbed import Extras, SessionConfigs, Testbed

PATIENCE_S = 20.0
"""Longest virtual time until both sites are engaged, s."""


@contextmanager
def recorded_testbed(
    configs: SessionConfigs, seed: int = 0, remote_clock: SiteClock | None = None, feed: ConsoleFeed | None = None
) -> Iterator[Testbed]:
    """Yield a test bed whose sites record to the files that their configurations name.

    The recordings' clock anchors put virtual time 0 at the present time.

    Args:
        configs: configurations, with a file to record to for each site.
        seed: seed of the network's randomness.
        remote_clock: monotonic clock of the remote site's host; without one, both sites are on one host.
        feed: feed of the operator's site to a console.

    Raises:
        ValueError: a configuration is unusable or names no file.
        OSError: a file cannot be created.
    """
    here = ClockAnchor.now()._replace(monotonic_ns=0)
    there = here
    if remote_clock is not None:
        there = here._replace(clock_id="remote host", monotonic_ns=remote_clock.now_ns(0.0))
    facts = {"configuration": to_toml(configs.remote), **there.metadata()}
    remote = open_recorder(configs.remote, facts, _encrypt_for(configs.remote))
    if remote is None or configs.operator.record is None:
        raise ValueError("record: a site has no file to record to")
    facts = {"configuration": to_toml(configs.operator), **here.metadata()}
    with (
        remote,
        Recorder(configs.operator.record, SCHEMAS, facts, encrypt_for=_encrypt_for(configs.operator)) as operator,
    ):
        recorders = {"remote": remote, "operator": operator}
        bed = Testbed(configs, seed, Extras(remote_clock or SiteClock(), recorders=recorders, feed=feed))
        try:
            yield bed
        finally:
            bed.close()


def _encrypt_for(config: RemoteConfig | OperatorConfig) -> str | None:
    return load_keys(config.link.keys).public if config.recording.encrypt else None


def record_session(options: DemoOptions, out: Path) -> Path:
    """Run a session on the test bed and write `session.mcap` with both sites and the true values.

    Args:
        options: scene, seed, fingers, and duration of the exploration, s.
        out: folder for the files; it is created.

    Returns:
        Path of the merged recording.

    Raises:
        ValueError: the options are invalid, or have no duration.
        OSError: a file cannot be written.
    """
    if options.seconds is None:
        raise ValueError("a recorded session on the test bed needs a duration")
    files = prepare(options, out)
    with recorded_testbed(SessionConfigs.read(files), options.seed) as bed:
        bed.until(lambda bed: bed.both_engaged, PATIENCE_S)
        bed.run(options.seconds)
    session = out / "session.mcap"
    merge_recordings([out / f"{process}.mcap" for process in PROCESSES], session)
    return session
