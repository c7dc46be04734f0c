"""Runs the process that offers a running session to one of the tools of TOOLS."""

import logging
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass

from common.config.site_models import OperatorConfig
from common.link.keys import fingerprint, load_keys
from common.runtime.containment import Containment
from common.runtime.scheduling import give_way
from common.timing.interval import Interval
from operator_site.session.console_feed import FeedReader
from teletaction.export.optional_package import load_optional
from teletaction.outlets.detached import Detached, Outlet
from teletaction.outlets.live_messages import LiveMessages
from teletaction.outlets.place import LOOPBACK, Place, listening_place

log = logging.getLogger(__name__)

_LOOK_MS = 100
"""Longest wait for the feed, ms; a signal is noticed within it."""
REPORT_S = 10.0
"""Interval between two reports, s."""
_NICE = 5
"""Steps by which this process gives way to the sites and the console."""


@dataclass(frozen=True, slots=True)
class Tool:
    """A live tool: module and class of its server, the extra that it needs, and its usual port.

    A tool without a port chooses its addresses itself, and all of them are open to the network.
    """

    module: str
    server: str
    extra: str
    port: int | None = None

    def load(self) -> Callable[[Place], Outlet]:
        """Import the class of the server.

        Raises:
            ValueError: a package is missing; the message names the extra to install.
        """
        server: Callable[[Place], Outlet] = load_optional(f"teletaction.outlets.{self.module}", self.server, self.extra)
        return server


TOOLS = {
    "foxglove": Tool("foxglove_server", "FoxgloveServer", "foxglove", 8765),
    "rerun": Tool("rerun_server", "RerunServer", "rerun", 9876),
    "lsl": Tool("lsl_streams", "LslStreams", "lsl"),
}


def chosen_place(to: str, site: str, host: str | None, port: int | None, *, open_to_network: bool) -> Place:
    """Return the place where a tool's server listens.

    Args:
        to: a key of TOOLS.
        site: fingerprint of the operator site's key.
        host: IP address or `localhost`; None: loopback.
        port: port, 0 for a free one; None: the tool's usual one.
        open_to_network: whether other hosts may read the session.

    Raises:
        ValueError: the tool is unknown, does not take the options, or would be open to a network without consent.
        OSError: the port is in use.
    """
    if to not in TOOLS:
        raise ValueError(f"no tool {to!r}; choose one of {', '.join(TOOLS)}")
    usual = TOOLS[to].port
    if usual is not None:
        return listening_place(site, host or LOOPBACK, usual if port is None else port, open_to_network=open_to_network)
    if host is not None or port is not None:
        raise ValueError(f"{to} chooses its addresses itself: leave out --host and --port")
    if not open_to_network:
        raise ValueError(
            f"{to} listens at all addresses of this machine, and readers need no key: allow that with --open-to-network"
        )
    return Place(site)


def run_outlet(
    config: OperatorConfig,
    stop: Callable[[], bool],
    *,
    to: str,
    host: str | None = None,
    port: int | None = None,
    open_to_network: bool = False,
) -> None:
    """Offer the session of a running operator site to a tool until `stop()`. The arguments are those of `chosen_place`.

    Raises:
        ValueError, OSError: as `chosen_place`; the keys are unusable, a package is missing, or the site has no feed.
    """
    if config.feed_port is None:
        raise ValueError("the operator site has no feed: set feed_port in its configuration, such as 5610")
    keys = load_keys(config.link.keys)
    place = chosen_place(to, fingerprint(keys.public), host, port, open_to_network=open_to_network)
    outlet = TOOLS[to].load()(place)
    give_way(_NICE)
    live = LiveMessages()
    with ExitStack() as opened:
        detached = opened.enter_context(Detached(outlet))
        feed = FeedReader(config.feed_port, keys)
        opened.callback(feed.close)
        log.info("%s: %s; it reads the feed at port %d", to, outlet.address, config.feed_port)
        reports = Reports(live, detached)
        _pass_on(feed, live, detached, reports, stop)
    log.info("sent %d messages; %s", live.counts.total() - detached.dropped, reports.losses)


def _pass_on(
    feed: FeedReader, live: LiveMessages, detached: Detached, reports: "Reports", stop: Callable[[], bool]
) -> None:
    contained, report_due = Containment(), Interval(REPORT_S)
    report_due(time.monotonic())
    while not stop():
        feed.socket.poll(_LOOK_MS)
        with contained.step("feed", latches=False):
            fed = list(feed.receive())
            here_ns = time.monotonic_ns()  # read last: an earlier time would look like a lead of the site's clock
            if messages := live.take(here_ns, fed):
                detached.offer(messages)
        if report_due(time.monotonic()):
            reports.step()


class Reports:
    """Logs losses and silence, each time they are new."""

    def __init__(self, live: LiveMessages, detached: Detached):
        """Begin before the first message."""
        self._live, self._detached = live, detached
        self._reported = self.losses
        self._heard, self._silent = 0, False

    @property
    def losses(self) -> str:
        """Number of messages that did not reach the tool, in words."""
        return f"{self._detached.dropped} dropped because the tool was behind, {self._live.damaged} unreadable"

    def step(self) -> None:
        """Report what is new since the last call, REPORT_S ago."""
        if (losses := self.losses) != self._reported:
            self._reported = losses
            log.warning("%s", losses)
        heard = self._live.counts.total()
        silent, self._heard = heard == self._heard, heard
        if silent and not self._silent:
            log.warning("no message from the operator site for %g s: is it running?", REPORT_S)
        self._silent = silent
