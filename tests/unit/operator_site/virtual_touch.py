"""The operator site on a virtual environment, with devices and hand in the test's own hands."""

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

from common.buses.can_address import CanAddress
from common.config.link_models import OperatorLinkConfig
from common.config.site_models import OperatorConfig
from common.faults.fault import Fault
from common.fingers import FINGERS
from common.recording.recorder import Recorder
from common.scenes.scene import load_scene
from common.timing.tick_age import TickAge
from common.wire.packets import LinkState
from operator_site.coupling.coupling import Places
from operator_site.devices.devices import OperatorDevices
from operator_site.devices.exoskeleton import Hand
from operator_site.safety.gated_output import GatedOutput
from operator_site.session.console_feed import ConsoleFeedSocket
from operator_site.session.local_control import answer_desk
from operator_site.site import OperatorSite
from operator_site.virtual.virtual_environment import VirtualEnvironment
from operator_site.virtual.virtual_session import VirtualSession

MS = 1_000_000
INDEX = FINGERS.index("index")
CONFIG = OperatorConfig(
    fingers=("index",),
    link=OperatorLinkConfig(keys=Path("keys")),
    tacttip={"index": "pty"},
    exoskeleton=CanAddress(interface="virtual"),
    engage=True,
)


@dataclass
class Devices:
    """Devices that do what the test says, and remember what reached them."""

    hand: Hand = field(default_factory=Hand)
    seen: bool = True
    pushes: bool = True
    lacking: str = ""
    cut: list[Fault] = field(default_factory=list)
    on: dict[str, str] = field(default_factory=dict)
    written: list[GatedOutput] = field(default_factory=list)
    engaged: list[bool] = field(default_factory=list)
    plate_c: float = 33.0
    tick: TickAge = field(default_factory=TickAge)

    def read(self, t_s: float) -> Hand:
        if self.seen:
            self.hand.pose_s = self.hand.heights_s = t_s
        return self.hand

    def missing(self) -> str:
        return self.lacking

    def faults(self) -> list[Fault]:
        return self.cut

    def plates(self, t_s: float) -> tuple[list[float], list[float]]:
        plate_c, age_s = [math.nan] * len(FINGERS), [math.inf] * len(FINGERS)
        plate_c[INDEX], age_s[INDEX] = self.plate_c, 0.0
        return plate_c, age_s

    def write(self, t_s: float, output: GatedOutput, engaged: bool) -> None:
        self.written.append(output)
        self.engaged.append(engaged)
        self.plate_c += 0.002 * (4.0 * output.peltier_drive[INDEX] + 0.2 * (33.0 - self.plate_c))

    def unconfirmed(self, since_s: float) -> dict[str, str]:
        return self.on

    def figures(self) -> dict[str, object]:
        return {}


class Working:
    """The operator site on a scene, and a hand that a test moves."""

    def __init__(
        self,
        scene: str = "materials",
        recorder: Recorder | None = None,
        *,
        engage: bool = True,
        feed: ConsoleFeedSocket | None = None,
        required_s: float = 0.0,
    ):
        self.devices = Devices()
        environment = VirtualEnvironment(load_scene(scene), CONFIG.fingers, 0)
        self.client = VirtualSession(environment, scene, engage)
        config = CONFIG.model_copy(update={"console_required_s": required_s, "engage": engage})
        self.site = OperatorSite(config, self.client, cast(OperatorDevices, self.devices), recorder, feed=feed)
        self.now_ns = 1_000 * MS
        self.be_at(0.0, 0.006)

    def be_at(self, x_m: float, z_m: float) -> None:
        self.devices.hand.place = Places(x_m, 0.0, (z_m,) * len(FINGERS))

    def go(self, seconds: float, x_m: float | None = None, z_m: float | None = None) -> list[GatedOutput]:
        """Let time pass, moving evenly; returns what reached the devices."""
        hand, first = self.devices.hand.place, len(self.devices.written)
        ticks = round(seconds / 0.002)
        from_x, from_z = hand.x_m, hand.z_m[0]
        to_x, to_z = from_x if x_m is None else x_m, from_z if z_m is None else z_m
        for tick in range(1, ticks + 1):
            self.be_at(from_x + (to_x - from_x) * tick / ticks, from_z + (to_z - from_z) * tick / ticks)
            self.now_ns += 2 * MS
            self.site.tick(self.now_ns)
        return self.devices.written[first:]

    def press(self, x_m: float) -> list[GatedOutput]:
        """Touch at a place for 0.5 s."""
        self.be_at(x_m, 0.006)
        return self.go(0.5, z_m=-0.003) + self.go(0.5)

    def ask(self, verb: str, **details: Any) -> dict[str, Any]:
        return answer_desk(self.client, self.site.attendance, self.site.coupling, self.now_ns, "", verb, details)

    @property
    def state(self) -> LinkState:
        return self.client.session.state
