"""What keeps a site from working: each device found and named, keys, tables, the network; and what to do."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from common.can_frames import FrameReceiver
from common.can_line import CanAddress, CanLine
from common.config import OperatorConfig, RemoteConfig, load_site
from common.keys import TrustedKeys, fingerprint, load_keys
from common.serial_line import open_line
from common.serial_messages import DeviceKind
from operator_site.remote_key import remote_public_key
from remote_site.calibrated_tables import load_tables

RATE_S = 1.0
"""How long a device's own rate is measured."""


@dataclass(frozen=True, slots=True)
class Finding:
    """One check and its result for a person."""

    what: str
    good: bool
    result: str


def examine(config: Path) -> list[Finding]:
    """Check everything that a site's configuration names.

    Raises:
        ConfigProblem: the file is neither a remote nor an operator configuration.
    """
    site = load_site(config)
    return _remote(site) if isinstance(site, RemoteConfig) else _operator(site)


def _remote(config: RemoteConfig) -> list[Finding]:
    keys = config.link.keys
    findings = [
        _check("own key", lambda: fingerprint(load_keys(keys).public)),
        _check("trusted keys", lambda: _trusted(keys)),
        _check("calibrated tables", lambda: ", ".join(load_tables(config)[0].names())),
        _clock(),
    ]
    sensors = {DeviceKind.TEXTURE_SENSOR: config.texture, DeviceKind.THERMAL_SENSOR: config.thermal_sensors}
    for kind, addresses in sensors.items():
        findings += [_device(kind, finger, address) for finger, address in addresses.items()]
    frames = ("HandPoseMeasured", "FingerHeightsMeasured", "ContactForces", "TelemanipulatorState")
    return [*findings, _can("telemanipulator", config.telemanipulator, frames)]


def _operator(config: OperatorConfig) -> list[Finding]:
    findings = [
        _check("own key", lambda: fingerprint(load_keys(config.link.keys).public)),
        _check("remote site's key", lambda: fingerprint(remote_public_key(config.link))),
        _clock(),
    ]
    findings += [_device(DeviceKind.TACTTIP, finger, address) for finger, address in config.tacttip.items()]
    return [*findings, _can("exoskeleton", config.exoskeleton, ("HandPose", "FingerHeights", "ExoskeletonState"))]


def _check(what: str, look: Callable[[], str]) -> Finding:
    try:
        return Finding(what, True, look())
    except (ValueError, OSError) as error:
        return Finding(what, False, str(error))


def _trusted(keys: Path) -> str:
    trusted = TrustedKeys(keys)
    owners = trusted.owners()
    if not owners:
        raise ValueError(f"{trusted.file}: nobody is trusted; `teletaction keys trust --keys {keys} -- NAME KEY`")
    return ", ".join(f"{owner.name} ({owner.role.value}) {fingerprint(key)}" for key, owner in owners.items())


def _device(kind: DeviceKind, finger: str, address: str) -> Finding:
    def look() -> str:
        opened = open_line(address, 921_600)
        try:
            found = opened.identity
            if found.kind is not kind:
                raise ValueError(f"{address}: is a {found.kind.name.lower()}, expected a {kind.name.lower()}")
            received, until_s = 0, time.monotonic() + RATE_S
            opened.port.timeout = 0.05
            while time.monotonic() < until_s:
                # Every frame ends with a zero byte that stands nowhere else.
                received += opened.port.read(4096).count(0)
            rate_hz = received / RATE_S
            if not 0.7 * found.rate_hz <= _values(found.kind, rate_hz) <= 1.3 * found.rate_hz:
                raise ValueError(f"{address}: {rate_hz:.0f} messages a second, the device promises {found.rate_hz} Hz")
            return f"{address}: serial number {found.serial}, firmware {found.firmware}, {rate_hz:.0f} messages/s"
        finally:
            opened.port.close()

    return _check(f"{finger} {kind.name.lower().replace('_', ' ')}", look)


def _values(kind: DeviceKind, messages_hz: float) -> float:
    """Readings a second: a texture message carries ten."""
    return messages_hz * 10.0 if kind is DeviceKind.TEXTURE_SENSOR else messages_hz


def _can(what: str, address: CanAddress, frames: tuple[str, ...]) -> Finding:
    def look() -> str:
        line = CanLine(address, tuple(FrameReceiver(name) for name in frames))
        seen: dict[str, Any] = {}
        try:
            until_s = time.monotonic() + 2.0 * RATE_S
            while time.monotonic() < until_s and len(seen) < len(frames):
                seen |= line.poll()
                time.sleep(0.01)
            missing = [name for name in frames if name not in seen]
            if missing:
                raise ValueError(f"CAN {address}: {line.problem or 'open, but no ' + ', '.join(missing)}")
            return f"CAN {address}: {', '.join(frames)} arrive"
        finally:
            line.close()

    return _check(what, look)


def _clock() -> Finding:
    resolution_s = time.get_clock_info("monotonic").resolution
    good = resolution_s <= 1e-5
    return Finding("monotonic clock", good, f"resolution {resolution_s * 1e9:.0f} ns")
