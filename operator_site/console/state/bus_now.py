"""Reports the state and errors of the CAN controllers of this site's devices, from the figures of each second."""

from collections.abc import Mapping
from typing import Any

HELD_S = 10.0
"""Time for which an error is shown after its count has grown, s."""
_SOUND = ("", "error-active")


class BusNow:
    """Newest state of the CAN controllers. Pure: time is an argument, s."""

    def __init__(self) -> None:
        """Begin without a report."""
        self._state: dict[str, str] = {}
        self._counts: dict[str, Mapping[str, Any]] = {}
        self._latest: dict[str, tuple[float, str]] = {}

    def take(self, t_s: float, device: str, line: Mapping[str, Any]) -> None:
        """Take a device's figures; a missing figure is no error."""
        self._state[device] = str(line.get("controller", ""))
        counts = line.get("controller_errors")
        if not isinstance(counts, Mapping):
            return
        before = self._counts.get(device)
        self._counts[device] = counts
        if before is not None and (grown := [str(name) for name, count in counts.items() if count != before.get(name)]):
            self._latest[device] = t_s, ", ".join(grown)

    def trouble(self, now_s: float) -> dict[str, str]:
        """Return the error or abnormal controller state of each device with one."""
        found = {device: errors for device, (at_s, errors) in self._latest.items() if 0.0 <= now_s - at_s <= HELD_S}
        return found | {device: state for device, state in self._state.items() if state not in _SOUND}
