"""Breaks the code on purpose in ten places that protect people, and checks that tests of `make test` fail.

`python -m tests.breaks` does so in a copy of the tree. It fails where a break is not noticed.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from tests.places import ROOT

FAST = "not (session or long or containers)"
FAILED = 1


@dataclass(frozen=True, slots=True)
class Break:
    """One change for the worse.

    Attributes:
        name: what is wrong then.
        file: where.
        right, wrong: the text that is there once, and what replaces it.
        tests: those that should notice.
    """

    name: str
    file: str
    right: str
    wrong: str
    tests: str


BREAKS = (
    Break(
        "timeout doubled",
        "operator_site/safety/operator_gate.py",
        "fresh = 0.0 <= last_input_age_s <= GAP_S",
        "fresh = 0.0 <= last_input_age_s <= 2.0 * GAP_S",
        "tests/unit/operator_site/safety/test_operator_gate.py",
    ),
    Break(
        "limit raised by 5 %",
        "remote_site/safety/patient_gate.py",
        "if not 0.0 < contact_force_n <= CONTACT_FORCE_N:",
        "if not 0.0 < contact_force_n <= 1.05 * CONTACT_FORCE_N:",
        "tests/unit/remote_site/safety/test_patient_gate.py",
    ),
    Break(
        "stale packet accepted",
        "common/link/packet_filter.py",
        "if age_ns > self.max_age_ns:",
        "if age_ns > 2 * self.max_age_ns:",
        "tests/unit/common/link/test_packet_filter.py",
    ),
    Break(
        "wrong finger",
        "operator_site/devices/devices.py",
        "module.drive(t_s, output.motor_rpm[finger],",
        "module.drive(t_s, output.motor_rpm[finger - 1],",
        "tests/virtual/test_steady.py",
    ),
    Break(
        "CRC ignored",
        "common/buses/serial_messages.py",
        'return checked if binascii.crc_hqx(checked, _CRC_INIT) == body[-1] << 8 | body[-2] else b""',
        "return checked",
        "tests/unit/common/buses/test_serial_framing.py",
    ),
    Break(
        "ramp removed",
        "operator_site/safety/force_limits.py",
        "self._ceiling_n = min(FINGER_FORCE_N, self._ceiling_n + FORCE_RAMP_UP_N_S * dt_s)",
        "self._ceiling_n = FINGER_FORCE_N",
        "tests/unit/operator_site/safety/test_operator_gate.py",
    ),
    Break(
        "latch cleared by itself",
        "common/link/session_state.py",
        "if self.state is not LinkState.FAULT:\n            self.state = LinkState.CONNECTED\n",
        "self.state = LinkState.CONNECTED\n",
        "tests/unit/common/link/test_session_state.py",
    ),
    Break(
        "dose halved",
        "common/safety/thermal_dose.py",
        "self._total += over_k * dt_s",
        "self._total += 0.5 * over_k * dt_s",
        "tests/unit/operator_site/safety/test_operator_gate.py",
    ),
    Break(
        "deadband without refresh",
        "common/link/deadband.py",
        "t_s - self._sent_s <= quiet_s",
        "t_s - self._sent_s",
        "tests/unit/common/link/test_deadband.py",
    ),
    Break(
        "clock offset with the wrong sign",
        "common/link/clock_offset.py",
        "((t2_ns - t1_ns) + (t3_ns - t4_ns)) // 2",
        "((t1_ns - t2_ns) + (t4_ns - t3_ns)) // 2",
        "tests/unit/common/link/test_clock_offset.py",
    ),
)


def noticed(tree: Path, one: Break) -> bool:
    """Whether the tests turn red in a tree with this break, which is mended again.

    Raises:
        ValueError: the text that is to be broken is not there, or not once.
    """
    file = tree / one.file
    whole = file.read_text("utf-8")
    if whole.count(one.right) != 1:
        raise ValueError(f"{one.file}: {one.right!r} is there {whole.count(one.right)} times")
    file.write_text(whole.replace(one.right, one.wrong), "utf-8")
    try:
        return outcome(tree, one.tests) == FAILED
    finally:
        file.write_text(whole, "utf-8")


def outcome(tree: Path, *tests: str) -> int:
    """The exit code of some tests in a tree: 0, or 1 where one of them failed."""
    words = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "-m", FAST, *tests]
    environment = os.environ | {"PYTHONPATH": str(tree)}
    return subprocess.run(words, cwd=tree, env=environment, capture_output=True, check=False).returncode


def copy_tree(folder: Path) -> Path:
    """A copy of all tracked files as they are."""
    names = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for name in filter(None, names.split("\0")):
        if (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, folder / name)
    return folder


def main() -> int:
    """Do every break; returns 1 where one is not noticed."""
    missed = 0
    with tempfile.TemporaryDirectory(prefix="breaks-") as folder:
        tree = copy_tree(Path(folder))
        if outcome(tree, *sorted({one.tests for one in BREAKS})) != 0:
            print("FAILED these tests do not pass without a break either")
            return 1
        for one in BREAKS:
            red = noticed(tree, one)
            missed += not red
            print(f"{'red   ' if red else 'MISSED'} {one.name} ({one.file}; {one.tests})", flush=True)
    print(f"{len(BREAKS) - missed} passed, {missed} failed")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
