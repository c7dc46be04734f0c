"""Runs a session with injected faults on the test bed, where virtual time keeps every tick punctual."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from common.config.file import to_toml
from common.recording.recorder import Recorder
from operator_site.site_recording import SCHEMAS
from remote_site.site_recording import open_recorder
from robustness.fault_session import prepare_session
from robustness.faulted_session import WORKING_S, FaultedSession, NotWorking
from teletaction.testbed.network_faults import NetworkFaults
from teletaction.testbed.testbed import COARSE_STEP_S, SITES, Extras, SessionConfigs, Testbed

_PATIENCE_S = 20.0
_RECOVERY_STEP_S = 0.008
"""No hold time ends while a session recovers."""
_FINE_S = 0.5
"""Part of a wait that passes in fine steps, s: all hold times end within it."""


class VirtualFaultSession(FaultedSession):
    """Both sites, all devices and the network in this process. Every tick is punctual, so a session settles sooner."""

    settled_s = 0.3

    def __init__(self, bed: Testbed) -> None:
        """Prepare a session on the test bed for faults."""
        self.bed = bed
        self._network = NetworkFaults(bed.network)

    @classmethod
    @contextmanager
    def open(cls, out: Path, *, patient_switch: bool = False) -> "Iterator[VirtualFaultSession]":
        """Engage a session that is recorded in `out`, with or without a patient's switch; it ends with the context."""
        configs = SessionConfigs.read(prepare_session(out, patient_switch=patient_switch))
        with ExitStack() as opened:
            remote = open_recorder(configs.remote, {"configuration": to_toml(configs.remote)})
            assert remote is not None
            assert configs.operator.record is not None
            recorders = {
                "remote": opened.enter_context(remote),
                "operator": opened.enter_context(
                    Recorder(configs.operator.record, SCHEMAS, {"configuration": to_toml(configs.operator)})
                ),
            }
            bed = Testbed(configs, 0, Extras(recorders=recorders))
            opened.callback(bed.close)
            bed.until(lambda bed: bed.both_engaged, _PATIENCE_S)
            yield cls(bed)

    def wait_until_working(self, seconds: float = WORKING_S) -> None:
        """As for every session, in longer steps."""
        with self.bed.stepping(_RECOVERY_STEP_S):
            super().wait_until_working(seconds)

    def clear_and_engage(self) -> None:
        """As for every session, in longer steps."""
        with self.bed.stepping(_RECOVERY_STEP_S):
            super().clear_and_engage()

    def now_s(self) -> float:
        """Virtual time, s."""
        return self.bed.time_s

    def wait(self, seconds: float) -> None:
        """Advance virtual time by `seconds`; what is longer than 0.5 s passes coarsely."""
        end_s = self.bed.time_s + seconds
        coarse_s = self.bed.time_s + _FINE_S
        while self.bed.time_s < end_s:
            self._network.step()
            if self.bed.time_s < coarse_s:
                self.bed.tick()
            else:
                self.bed.run_coarsely(COARSE_STEP_S)

    def command(self, process: str, line: str) -> float:
        """Inject or end a fault of a simulation; return the virtual time, s.

        Raises:
            NotWorking: the simulation does not know the command.
        """
        try:
            if process == "network":
                self._network.obey(line)
            else:
                self.bed.break_device(f"{process.removeprefix('sim-')}: {line}")
        except ValueError as error:
            raise NotWorking(f"{process}: {line}: {error}") from None
        return self.bed.time_s

    def acts_since(self, begin_s: float) -> bool:
        """As for every session, and a motor vibrates."""
        return super().acts_since(begin_s) and any(m.motor_mv > 0 for m in self.bed.sim_operator.modules.values())

    def mend(self) -> None:
        """End every fault."""
        self.bed.mend_devices()
        self._network.obey("clear")

    def stop(self, process: str, seconds: float) -> tuple[float, float]:
        """Stop a site or its simulated devices for `seconds`; return start and end of the stop, s."""
        begin_s = self.bed.time_s
        self.bed.stop(process, seconds)
        return begin_s, self.bed.time_s

    def ask(self, site: str, verb: str) -> dict[str, Any]:
        """Send a request to the desk of a site, as a person there would, while time passes; raise Refused."""
        return self.bed.ask_desk(site, verb)

    def figures(self, process: str) -> dict[str, Any]:
        """Return the current status of a process."""
        bed = self.bed
        parts: dict[str, Any] = dict(zip(SITES, (bed.remote, bed.operator), strict=True))
        figures = parts.get(process, bed.sim_operator).figures()
        return {"time_ns": round(bed.time_s * 1e9), **figures}
