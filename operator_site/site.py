"""The operator site's loop: read the hand, render the touch of the remote site, pass the gate, write."""

import logging
import math
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from functools import partial
from typing import Any

from msgspec import structs

from common.buses.device_startup import wait_for_devices
from common.config.file import to_toml
from common.config.site_models import OperatorConfig
from common.faults.fault import contained
from common.faults.texts import fault_figures, fault_text
from common.fingers import FINGERS
from common.limits import FINGER_FORCE_N, MOTOR_FLOOR_RPM, MOTOR_MAX_RPM, PLATE_PROFILES
from common.link.capabilities import capabilities
from common.link.clock_offset import ReadClock
from common.link.deadband import Deadband
from common.link.keys import KeyPair, fingerprint, load_keys
from common.link.link import OperatorLink
from common.link.link_sides import OperatorSide
from common.link.local_control import LocalControl, LocalControlSocket
from common.recording.recorder import Recorder
from common.runtime.containment import Containment, MakeContainment
from common.runtime.site_loop import run_site_loop
from common.site_status import site_figures, staleness
from common.timing.standstill import HostClock
from common.timing.timeouts import TICK_AGE_S
from common.wire.packets import LinkState
from operator_site.coupling.motion_coupling import MotionCoupling
from operator_site.devices.devices import OperatorDevices
from operator_site.devices.exoskeleton import Hand
from operator_site.gated_rendering import GatedRendering
from operator_site.recorded_rows import RenderingInput
from operator_site.safety.gated_output import GatedOutput, released
from operator_site.safety.limit_flags import limit_names
from operator_site.session.admission import Admission
from operator_site.session.console_feed import ConsoleFeed, ConsoleFeedSocket
from operator_site.session.console_presence import ConsolePresence
from operator_site.session.local_control import answer_desk
from operator_site.session.remote_key import remote_public_key
from operator_site.session.session_client import SessionClient
from operator_site.session.session_protocol import SessionProtocol
from operator_site.site_recording import SCHEMAS, SiteRecording

log = logging.getLogger(__name__)

_HAND_AGE_S = 0.020
"""Maximum age of a pose that is sent, s; after a longer gap the remote site stops."""
ENGAGE_PATIENCE_S = 5.0
"""Maximum wait of a person's request to engage, s; nothing may start to act long after it, with nobody there."""
_GATE_RESTS_S = 2.0 * TICK_AGE_S
"""Time for which a gate that raised is not stepped, s; after more than TICK_AGE_S it starts from neutral."""


class OperatorSite:
    """Runs one tick at a time; all computation is pure and in other files.

    An exception in a step of the tick is contained: outputs go to neutral through the gate, and the fault latches. If
    the gate itself raises, neutral outputs are written without it, and it is stepped again only when it starts from
    neutral. If a device's driver raises, the device's own time-out turns it off. An exception of recording or console
    feed is reported and stops nothing.
    """

    def __init__(
        self,
        config: OperatorConfig,
        client: SessionProtocol,
        devices: OperatorDevices,
        recorder: Recorder | None = None,
        desk: LocalControl | None = None,
        feed: ConsoleFeed | None = None,
        containment: MakeContainment = Containment,
    ):
        """Use opened devices.

        Args:
            config: configuration of the site.
            client: this site's end of a session, with a remote site or with a virtual environment.
            devices: devices to read and write.
            recorder: recorder with SCHEMAS; None records nothing.
            desk: source of local requests; None takes none.
            feed: feed of consoles; None feeds none.
            containment: creates the containment from the function that latches a fault.
        """
        self.client = client
        self._devices = devices
        self._recorder = recorder
        self._recording = None if recorder is None and feed is None else SiteRecording(recorder, feed)
        self.attendance = ConsolePresence(config.console_required_s)
        self.coupling = MotionCoupling(client.session.note)
        self._desk = desk
        self._gap_s = config.link.gap_s
        self._engages_itself = config.engage
        self._asked_ns = 0
        """Time of the person's request to engage that is not fulfilled yet; without one, that of this tick, ns."""
        self.contain = containment(client.session.latch)
        self.rendering = GatedRendering(config.rendering, 1.0 / config.rate_hz, config.link.gap_s, self.contain)
        self._feed = feed
        self._gate_raised_s = -math.inf
        self._now_ns = 0
        self._hand = Hand()
        self._limited: list[int] = []
        self.motions_sent = 0

    def tick(self, now_ns: int) -> None:
        """Read, serve the session, send motion, render, gate, write, record."""
        client, contain = self.client, self.contain
        if client.session.state is not LinkState.FAULT:
            contain.not_latched()
        hand = None
        with contain.step("read"):
            hand = self._hand = self._devices.read(now_ns * 1e-9)
        now_ns += self._devices.tick.stood_still_ns
        now_s = now_ns * 1e-9
        self._now_ns = now_ns
        with contain.step("session"):
            self._serve(now_ns)
        motion = self._motion(now_ns, now_s, hand)
        given, output = self._gated(now_ns, now_s)
        self._limited = output.limited
        if output.fault is not None:
            client.session.latch(output.fault)
        with contain.step("write"):
            self._devices.write(now_s, output, client.both_engaged)
        happenings = client.session.take_happenings()
        if self._recording is not None:
            with contain.step("record", latches=False):
                self._recording.session(now_ns, happenings)
                if given is not None:
                    self._recording.tick(
                        now_ns, client, given, output, motion, self.rendering.fingertips, self.coupling.now
                    )
        if self._feed is not None:
            with contain.step("feed", latches=False):
                self._feed.step(now_ns)

    def _serve(self, now_ns: int) -> None:
        """Take local requests and the packets of the remote site, and step the session."""
        client = self.client
        missing = self._devices.missing()
        not_ready = fault_text(self.rendering.fault) or missing
        if self._desk is not None:
            self._desk.serve(now_ns, partial(self._answer_desk, now_ns, not_ready))
        client.session.equipped(missing)
        if why := self.attendance.step(now_ns, client.session.engaged):
            client.disengage(now_ns, why)
        client.step(now_ns, not_ready, self._devices.unconfirmed)
        self._end_old_request(now_ns)
        session, hand = client.session, self._hand
        self.coupling.step(session.engaged, session.ident, hand.place)
        if self.coupling.now.open and session.engaged and (session.silent or client.remote_stale):
            # The remote fingers have retreated, and no hand lowers them.
            lost = "the link was silent" if session.silent else "motion was lost"
            client.disengage(now_ns, f"{lost} while the clutch was open")

    def _end_old_request(self, now_ns: int) -> None:
        """End a person's request to engage that could not be fulfilled in time."""
        client = self.client
        if self._engages_itself or client.session.engaged or not client.want_engaged:
            self._asked_ns = now_ns
        elif not 0 <= now_ns - self._asked_ns <= ENGAGE_PATIENCE_S * 1e9:
            log.warning("not engaged within %g s: the request has ended", ENGAGE_PATIENCE_S)
            client.disengage(now_ns)

    def _answer_desk(self, now_ns: int, not_ready: str, verb: str, details: dict[str, Any]) -> dict[str, Any]:
        with self.contain.request("desk"):
            self.coupling.pressed_n = max(self.rendering.pushed_n)
            return answer_desk(self.client, self.attendance, self.coupling, now_ns, not_ready, verb, details)

    def _gated(self, now_ns: int, now_s: float) -> tuple[RenderingInput | None, GatedOutput]:
        """Return the input of rendering and the gate's output; None and neutral if the gate has raised."""
        given, fault = None, self.client.session.fault
        if not 0.0 <= now_s - self._gate_raised_s < _GATE_RESTS_S:
            with self.contain.step("gate"):
                given = self._rendering_input(now_ns, now_s, self._hand)
                return given, self.rendering.step(given, self.client.touch, self.coupling.now)
            self._gate_raised_s = now_s
            fault = contained(self.contain.latest["gate"])
        return None, released(fault)

    def figures(self) -> dict[str, object]:
        """Return the figures for the status file."""
        client = self.client
        limited = [limit_names(bits) for bits in self._limited]
        sent, spared = {"motion": self.motions_sent}, {"motion": client.spared}
        stale = staleness(client, "touch", self._now_ns, self._gap_s)
        if client.session.state is LinkState.DISCONNECTED:
            stale = client.refusal or "no remote site"
        elif client.remote_stale and not stale:
            stale = f"at the remote site: {client.remote_stale}"
        return {
            **site_figures(
                client,
                self._devices,
                self._recorder,
                limited,
                sent=sent,
                spared=spared,
                contain=self.contain,
                acts_on="touch",
                stale=stale,
            ),
            "stiffest_n_m": self.rendering.wall.stiffest_n_m,
            "produced_mj": self.rendering.produced_mj,
            "remote_fault": fault_figures(client.remote_fault),
            "remote_recording": client.remote_recording,
            "remote_stale": client.remote_stale,
            "refusal": client.refusal,
            "calibrated": client.calibrated,
            "roughness_um": client.roughness_um,
            "remote_consent": None if client.remote_consent is None else client.remote_consent.details(),
            "wanted": client.want_engaged,
            "session": client.session.ident,
            "coupling": structs.asdict(self.coupling.now),
            "clock": {
                "offset_ns": client.clock.offset_ns,
                "uncertainty_ns": client.clock.uncertainty_ns,
                "steps": client.clock.steps,
            },
        }

    def publish(self, now_ns: int, figures: Mapping[str, object]) -> None:
        """Send these figures to the recording and the consoles."""
        if self._recording is not None:
            self._recording.figures(now_ns, figures)

    def goodbye(self) -> None:
        """Leave the session, so that the next operator need not wait for a time-out."""
        with self.contain.step("goodbye", latches=False):
            self.client.goodbye(self._now_ns)

    def _rendering_input(self, now_ns: int, now_s: float, hand: Hand) -> RenderingInput:
        client, touch = self.client, self.client.touch
        plate_c, plate_age_s = self._devices.plates(now_s)
        return RenderingInput(
            now_s,
            client.session.ident,
            # A person has cleared the session, and with it the gate.
            self.rendering.fault is not None and client.session.state is not LinkState.FAULT,
            # Drives that went off by themselves, as without commands, begin from zero force.
            client.both_engaged and self._devices.pushes,
            None if touch is None else client.acceptance.gap_ns(now_ns),
            None if touch is None else touch.sequence,
            *hand.place,
            hand.pose_s,
            hand.heights_s,
            tuple(plate_c),
            tuple(plate_age_s),
            tuple(self._devices.faults()),
        )

    def _motion(self, now_ns: int, now_s: float, hand: Hand | None) -> bytes | None:
        """Send the hand; if reading or sending fails, send a motion with this site's fault and no place."""
        if hand is not None:
            with self.contain.step("motion"):
                return self._send_motion(now_ns, now_s, hand)
        with self.contain.step("motion"):
            return self.client.send_motion(now_ns, 0.0, 0.0, [0.0] * len(FINGERS))
        return None

    def _send_motion(self, now_ns: int, now_s: float, hand: Hand) -> bytes | None:
        if now_s - hand.oldest_s > _HAND_AGE_S:
            return None
        packet = self.client.send_motion(now_ns, *self.coupling.now.command(hand.place))
        self.motions_sent += packet is not None
        return packet


def session_with(link: OperatorSide, config: OperatorConfig, stamp_ns: ReadClock | None = None) -> SessionClient:
    """Return this site's end of a session with the remote site at the other end of `link`."""
    plates = PLATE_PROFILES[config.rendering.profile]
    able = capabilities(
        config.fingers,
        config.rate_hz,
        force_n=FINGER_FORCE_N,
        motor_rpm=[MOTOR_FLOOR_RPM, MOTOR_MAX_RPM],
        plate_c=[plates.low_c, plates.high_c],
        max_age_s=config.link.max_age_s,
    )
    return SessionClient(
        link,
        able,
        config.link.max_age_s,
        want_engaged=config.engage,
        engages_itself=config.engage,
        calibration=config.link.calibration or "",
        gap_s=config.link.gap_s,
        stamp_ns=stamp_ns,
        deadband=Deadband(1.0 / config.rate_hz) if config.link.deadband else None,
    )


def run_operator(config: OperatorConfig, stop: Callable[[], bool]) -> None:
    """Run the operator site until `stop()`; raises ValueError or OSError where keys or devices cannot be used."""
    keys = load_keys(config.link.keys)
    remote_key = remote_public_key(config.link)
    clock = HostClock()

    def connect(opened: ExitStack) -> tuple[SessionClient, Callable[[], None]]:
        link = opened.enter_context(OperatorLink(config.link.host, config.link.base_port, keys, remote_key))
        remote = f"{config.link.host}:{config.link.base_port}"
        log.info("connecting to %s as %s", remote, fingerprint(keys.public))
        client = session_with(link, config, clock.now_ns)
        return client, Admission(client, link, remote).each_second

    run_operator_site(config, keys, connect, stop, clock)


def run_operator_site(
    config: OperatorConfig,
    keys: KeyPair,
    begin: Callable[[ExitStack], tuple[SessionProtocol, Callable[[], None]]],
    stop: Callable[[], bool],
    clock: HostClock | None = None,
    **about: str,
) -> None:
    """Run the operator site until `stop()`, in the session that `begin` opens after all devices have answered.

    Args:
        config: configuration of the site.
        keys: keys of the site.
        begin: opens the session on a stack that closes it; also returns a function to call each second.
        stop: returns whether to end; called before each tick.
        clock: clock of the site; a new one by default.
        about: further metadata of the recording.
    """
    with ExitStack() as opened:
        desk = opened.enter_context(LocalControlSocket(config.desk_port, keys))
        feed = None if config.feed_port is None else opened.enter_context(ConsoleFeedSocket(config.feed_port, keys))
        clock = clock or HostClock()
        devices = OperatorDevices(config, clock)
        opened.callback(devices.close)
        if not wait_for_devices(devices, config.wait_for_devices_s, stop):
            return
        client, each_second = begin(opened)
        recorder = None
        if config.record is not None:
            metadata = {"configuration": to_toml(config), "key": fingerprint(keys.public), **about}
            encrypt_for = keys.public if config.recording.encrypt else None
            recorder = opened.enter_context(Recorder(config.record, SCHEMAS, metadata, encrypt_for=encrypt_for))
        site = OperatorSite(config, client, devices, recorder, desk, feed)
        run_site_loop(
            site,
            "operator",
            config.rate_hz,
            stop,
            status=config.status,
            each_second=each_second,
            report=site.publish,
            clock_ns=clock.now_ns,
        )
        site.goodbye()
