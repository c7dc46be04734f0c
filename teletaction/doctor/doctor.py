"""Checks a site's devices, keys, tables, files, clock and loop rate, and says what to do about each failure."""

import shutil
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from shlex import quote
from tempfile import TemporaryFile

from common.buses.can_address import CanAddress
from common.buses.can_frames import FrameReceiver
from common.buses.can_port import CanPort
from common.buses.serial_device import open_line, plain_name
from common.buses.serial_messages import DeviceKind, FrameReader
from common.config.file import load_site
from common.config.site_models import OperatorConfig, RemoteConfig
from common.faults.texts import fault_text
from common.files.private_file import refuse_link
from common.fingers import FINGERS
from common.link.keys import TrustedKeys, fingerprint, load_keys
from common.runtime.reference_step import reference_step_s
from common.runtime.scheduling import has_real_time, take_ordinary, take_realtime
from common.timing.timeouts import FASTEST_RATE_HZ
from operator_site.session.remote_key import remote_public_key
from remote_site.calibrated_tables import load_tables
from teletaction.conformance.checklist import How, Verdict
from teletaction.conformance.examination import opened
from teletaction.conformance.find_devices import PORTS, find_modules, in_words, require_interface
from teletaction.conformance.node_talk import EXOSKELETON, TELEMANIPULATOR, NodeKind, NodeName
from teletaction.session.session_rates import LARGEST, taken

_LEAST_GB = 1.0
"""Free space for the recording of an hour, GB; with five fingers 0.9 GB were measured."""
CONGESTION_CONTROL = Path("/proc/sys/net/ipv4/tcp_congestion_control")
RATE_S = 1.0
"""Time over which a device's message rate is measured, s."""
EXERCISES = frozenset({"X1", "X2", "D4", "D5", "D6", "T2", "N7", "N8", "E1", "M2", "P1", "P2"})
"""Numbers of the duties in docs/protocols.md that `exercise` checks.

They show that a device obeys, moves in the right direction and releases by itself.
"""


@dataclass(frozen=True, slots=True)
class Finding:
    """One check and its result as text."""

    what: str
    good: bool
    result: str


@dataclass(frozen=True, slots=True)
class _Serial:
    """One serial device of a configuration."""

    kind: DeviceKind
    finger: str
    address: str

    @property
    def name(self) -> str:
        return plain_name(self.kind, self.finger)


def examine(config: Path, exercise: bool = False, ports: Path = PORTS) -> Iterator[Finding]:
    """Check everything that a site's configuration names; yield each check once it is done.

    Args:
        config: TOML file of a site.
        exercise: also drive each device that passes its check a little.
        ports: folder of serial ports to search for devices that do not answer at their addresses.

    Raises:
        ConfigProblem: the file is neither a remote nor an operator configuration.
    """
    site = load_site(config)
    if isinstance(site, RemoteConfig):
        yield from _remote(site)
        sensors = {DeviceKind.TEXTURE_SENSOR: site.texture, DeviceKind.THERMAL_SENSOR: site.thermal_sensors}
        devices = [_Serial(kind, *one) for kind, addresses in sensors.items() for one in addresses.items()]
        if site.patient_switch is not None:
            devices.append(_Serial(DeviceKind.PATIENT_SWITCH, FINGERS[0], site.patient_switch.port))
        process, node, bus = "remote", TELEMANIPULATOR, site.telemanipulator
    else:
        yield from _operator(site)
        devices = [_Serial(DeviceKind.TACTTIP, *one) for one in site.tacttip.items()]
        process, node, bus = "operator", EXOSKELETON, site.exoskeleton
    for what, path, least_gb in (("recording", site.record, _LEAST_GB), ("status file", site.status, 0.0)):
        if path is not None:
            yield _check(what, partial(_writable, path, least_gb))
    yield _clock()
    yield _rate(process, site.rate_hz)
    yield _priority()
    yield _congestion_control()
    lost = []
    for device in devices:
        found = _device(device)
        yield found
        if not found.good:
            lost.append(device)
        elif exercise:
            yield _exercised(device.name, device.address, device.kind)
    yield from _elsewhere(lost, ports)
    found = _can(node, bus)
    yield found
    if found.good and exercise:
        yield _exercised(node.name, str(bus), node.name)


def _remote(config: RemoteConfig) -> Iterator[Finding]:
    keys = config.link.keys
    yield _check("own key", lambda: fingerprint(load_keys(keys).public))
    yield _check("trusted keys", lambda: _trusted(keys))
    yield _check("calibrated tables", lambda: ", ".join(load_tables(config)[0].names()))


def _operator(config: OperatorConfig) -> Iterator[Finding]:
    yield _check("own key", lambda: fingerprint(load_keys(config.link.keys).public))
    yield _check("remote site's key", lambda: fingerprint(remote_public_key(config.link)))


def _writable(path: Path, least_gb: float) -> str:
    """Check by a file in the same folder that a process can write `path`; return the free space, of at least that."""
    try:
        refuse_link(path)
        with TemporaryFile(dir=path.parent) as file:
            file.write(b"x")
    except OSError as error:
        raise ValueError(f"{path}: cannot be written: {error.strerror}") from None
    if path.is_dir():
        raise ValueError(f"{path}: is a folder; name a file in it")
    free_gb = 1e-9 * shutil.disk_usage(path.parent).free
    if free_gb < least_gb:
        raise ValueError(f"{path}: {free_gb:.1f} GB free; an hour of a session takes {least_gb:g} GB: make room")
    return f"{path}: {free_gb:.0f} GB free"


def _exercised(name: str, address: str, expected: DeviceKind | NodeName) -> Finding:
    def move() -> str:
        with opened(address, expected) as device:
            results = device.only(EXERCISES).tried({How.LISTEN, How.EXERCISE}, lambda _: None)
        words = [f"{tried.duty.number} {tried.verdict}: {tried.came}" for tried in results]
        if any(tried.verdict is not Verdict.PASS for tried in results):
            raise ValueError("; ".join(words))
        return "; ".join(words)

    return _check(f"{name}, exercised", move)


def _elsewhere(lost: list[_Serial], ports: Path) -> Iterator[Finding]:
    """Find lost devices at other serial ports."""
    if not lost:
        return
    for found in find_modules(ports):
        for device in lost:
            identity = found.identity
            if Path(found.address).resolve() == Path(device.address).resolve():
                continue
            if identity and (identity.kind, FINGERS[identity.finger]) == (device.kind, device.finger):
                field = "port" if device.kind is DeviceKind.PATIENT_SWITCH else device.finger
                yield Finding(device.name, False, f'found elsewhere: write {field} = "{found.address}"')


def _check(what: str, look: Callable[[], str]) -> Finding:
    try:
        return Finding(what, True, look())
    except (ValueError, OSError) as error:
        return Finding(what, False, str(error))


def _trusted(keys: Path) -> str:
    trusted = TrustedKeys(keys)
    owners = trusted.owners()
    if not owners:
        raise ValueError(
            f"{trusted.file}: nobody is trusted; `teletaction keys trust --keys {quote(str(keys))} -- NAME KEY`"
        )
    return ", ".join(f"{owner.name} ({owner.role.value}) {fingerprint(key)}" for key, owner in owners.items())


def _device(device: _Serial) -> Finding:
    address, kind = device.address, device.kind

    def look() -> str:
        line = open_line(address)
        try:
            found = line.identity
            if (found.kind, FINGERS[found.finger]) != (kind, device.finger):
                raise ValueError(f"{address}: is the {in_words(found)}; expected the {device.name}")
            reader, received, until_s = FrameReader(), 0, time.monotonic() + RATE_S
            while time.monotonic() < until_s:
                if line.port.wait(0.05):
                    received += len(reader.feed(line.port.read()))
            rate_hz, damaged_hz = received / RATE_S, reader.damaged / RATE_S
            # A texture message carries ten readings.
            promised_hz = found.rate_hz / (10.0 if found.kind is DeviceKind.TEXTURE_SENSOR else 1.0)
            if not (_near(rate_hz, promised_hz) and _near(rate_hz + damaged_hz, promised_hz)):
                came = f"{rate_hz:.0f} messages and {damaged_hz:.0f} damaged a second"
                raise ValueError(f"{address}: {came}, the device promises {promised_hz:.0f}")
            return f"{address}: serial number {found.serial}, firmware {found.firmware}, {rate_hz:.0f} messages/s"
        finally:
            line.port.close()

    return _check(device.name, look)


def _near(rate_hz: float, promised_hz: float) -> bool:
    return 0.7 * promised_hz <= rate_hz <= 1.3 * promised_hz


def _can(node: NodeKind, address: CanAddress) -> Finding:
    receivers = tuple(FrameReceiver(name) for name in node.sends_hz)

    def look() -> str:
        require_interface(address)
        line = CanPort(address, receivers)
        try:
            _listen(line, 2.0 * RATE_S, lambda: all(receiver.taken for receiver in receivers))
            before = [receiver.taken for receiver in receivers]
            if line.connected:
                _listen(line, RATE_S)
            if not line.connected:
                raise ValueError(str(line.problem or f"CAN {address}: it does not answer"))
            if line.fault:
                raise ValueError(f"CAN {address}: {fault_text(line.fault)}")
            missing = [receiver.name for receiver in receivers if not receiver.taken]
            if missing:
                raise ValueError(f"CAN {address}: open, but no {', '.join(missing)}")
            rates_hz = [(receiver.taken - begun) / RATE_S for receiver, begun in zip(receivers, before, strict=True)]
            came = zip(node.sends_hz, rates_hz, strict=True)
            return f"CAN {address}: " + ", ".join(f"{name} {rate_hz:.0f}/s" for name, rate_hz in came)
        finally:
            line.close()

    return _check(node.name, look)


def _listen(line: CanPort, seconds: float, heard: Callable[[], bool] = lambda: False) -> None:
    until_s = time.monotonic() + seconds
    while time.monotonic() < until_s and not heard():
        line.poll()
        time.sleep(0.01)


def _clock() -> Finding:
    resolution_s = time.get_clock_info("monotonic").resolution
    good = resolution_s <= 1e-5
    return Finding("monotonic clock", good, f"resolution {resolution_s * 1e9:.0f} ns")


def _rate(process: str, rate_hz: float) -> Finding:
    """Check that this machine is fast enough for the loop's rate with five fingers in contact."""
    step_s = reference_step_s()
    share, fastest = taken(process, rate_hz, step_s), taken(process, FASTEST_RATE_HZ, step_s)
    words = f"{rate_hz:g} ticks a second take {share:.2f} of a processor of this machine"
    if share > LARGEST:
        return Finding("loop's rate", False, f"{words}, at most {LARGEST:g} fit: lower rate_hz, or a faster machine")
    if fastest <= LARGEST and rate_hz < FASTEST_RATE_HZ:
        words += f"; rate_hz = {FASTEST_RATE_HZ:g} fits, too ({fastest:.2f}), and shortens the way from touch to finger"
    return Finding("loop's rate", True, words)


def _priority() -> Finding:
    """Find the scheduling priority that a loop would get here. Ordinary priority is no failure."""
    if has_real_time():
        return Finding(
            "loop's priority", True, "real-time, inherited from the parent process; a loop started this way keeps it"
        )
    if take_realtime():
        take_ordinary()
        return Finding("loop's priority", True, "real-time is allowed: the loop runs before all ordinary work")
    words = "ordinary: beside other work the loop is late more often. LimitRTPRIO=10 in its unit, or `ulimit -r 10`"
    return Finding("loop's priority", True, words)


def _congestion_control() -> Finding:
    """Find how this host's TCP reacts to lost packets; none of the ways is a failure."""
    name = "TCP congestion control"
    try:
        control = CONGESTION_CONTROL.read_text().strip()
    except OSError as error:
        return Finding(name, True, f"unknown: {error.strerror}")
    if control.startswith("bbr"):
        return Finding(name, True, control)
    words = f"{control}: where packets are lost, the link gets too slow; use bbr (deploy/network/README.md)"
    return Finding(name, True, words)
