"""Requests of a process to the scheduler, as the system then reports them; each in a process of its own."""

import os
import platform
import re
import subprocess
import sys
from pathlib import Path

import pytest

from common.runtime.scheduling import _SLICE_NS, _SWITCH_S

LOOK = """
import os
from pathlib import Path
group = Path("/proc/self/autogroup")
words = group.read_text("ascii").split() if group.exists() else []  # empty: a child of init's, in the group of all
print(os.getpriority(os.PRIO_PROCESS, 0), os.sched_getscheduler(0) & ~os.SCHED_RESET_ON_FORK)
print(words[-1] if words else "none")
print(next((line.split()[-1] for line in open("/proc/self/sched") if line.startswith("se.slice")), 0))
"""
SHORT = "from common.runtime.scheduling import become_timely; become_timely()"
GIVES_WAY = "from common.runtime.scheduling import give_way; give_way(7)"
KNOWS_SLICES = tuple(int(part) for part in re.findall(r"\d+", platform.release())[:2]) >= (6, 12)
KNOWS_GROUPS = Path("/proc/self/autogroup").exists()
TICK_S = 0.002
DEFAULT_NICE = os.getpriority(os.PRIO_PROCESS, 0)


def said(code: str, *, leads: bool = False) -> list[str]:
    """The words that a program prints."""
    run = [sys.executable, "-c", code]
    return subprocess.run(run, capture_output=True, text=True, check=True, start_new_session=leads).stdout.split()


def scheduling(does: str, *, leads: bool = False) -> list[str]:
    """Nice, policy, nice of the group, and slice in ns, after doing something."""
    return said(f"{does}\n{LOOK}", leads=leads)


@pytest.mark.skipif(not KNOWS_SLICES, reason="this kernel gives no slices that were asked for (Linux 6.12 does)")
def test_a_loop_has_short_slices_and_everything_else_stays() -> None:
    before, after = scheduling(""), scheduling(SHORT)
    assert after == [*before[:3], str(_SLICE_NS)]
    assert scheduling(f"import os; os.nice(2)\n{SHORT}")[0] == str(DEFAULT_NICE + 2)


def test_other_threads_give_up_the_interpreter_within_a_small_part_of_a_tick() -> None:
    (interval_s,) = said(f"{SHORT}; import sys; print(sys.getswitchinterval())")
    assert float(interval_s) == pytest.approx(_SWITCH_S)
    assert _SWITCH_S <= 0.1 * TICK_S


def test_a_real_time_policy_stays() -> None:
    real_time = "os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(1))"
    try:
        plain = scheduling(f"import os; {real_time}")
    except subprocess.CalledProcessError:
        pytest.skip("no real-time policy may be set here")
    assert scheduling(f"import os; {real_time}\n{SHORT}")[1] == plain[1] == str(os.SCHED_RR)


FIRST = "from common.runtime.scheduling import take_realtime; print(take_realtime())"
POLICIES = """
import os, subprocess, sys, threading
from common.runtime.scheduling import policy
ask = "import os; print(os.sched_getscheduler(0))"
inside = []
thread = threading.Thread(target=lambda: inside.append(os.sched_getscheduler(0)))
thread.start(); thread.join()
print(policy(), *inside, subprocess.run(
    [sys.executable, "-c", ask], capture_output=True, text=True, check=True).stdout)
"""


def test_a_loop_has_real_time_priority_where_allowed_and_its_children_do_not() -> None:
    allowed, *policies = said(f"{SHORT}\n{FIRST}\n{POLICIES}")
    own = os.SCHED_RR if allowed == "True" else os.SCHED_OTHER
    assert policies == [str(own), str(os.SCHED_OTHER), str(os.SCHED_OTHER)]


def test_a_loop_returns_to_ordinary_priority_with_its_nice_and_short_slices() -> None:
    both = (
        "from common.runtime.scheduling import take_realtime, take_ordinary; first = take_realtime(); take_ordinary()"
    )
    assert scheduling(f"import os; os.nice(2)\n{SHORT}\n{both}") == scheduling(f"import os; os.nice(2)\n{SHORT}")


@pytest.mark.skipif(os.getuid() != 0, reason="only root can become an ordinary user, who is denied a right for sure")
def test_an_ordinary_user_gets_real_time_priority_only_within_the_limit() -> None:
    first, *then = said(f"""
import os, resource
from common.runtime.scheduling import take_realtime, policy, take_ordinary
{SHORT}
print(take_realtime())
resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))
os.setuid(65534)
take_ordinary()
print(policy(), take_realtime(), policy())
""")
    if first == "False":
        pytest.skip("no real-time policy may be set here")
    assert then == [str(os.SCHED_OTHER), "False", str(os.SCHED_OTHER)]


def test_a_process_lowers_itself_and_the_session_that_it_leads() -> None:
    nice = str(DEFAULT_NICE + 7)
    leads, follows = scheduling(GIVES_WAY, leads=True), scheduling(GIVES_WAY)
    assert leads[0] == follows[0] == nice
    if KNOWS_GROUPS:
        assert leads[2] == "7"
        assert follows[2] == scheduling("")[2], "the group is another process's affair"


STARVED = """
import hashlib, os, subprocess, sys, threading, time
from common.runtime.scheduling import Starved
processor = min(os.sched_getaffinity(0))
started = threading.Event()
def work():
    global number
    number = threading.get_native_id()
    os.sched_setaffinity(0, {processor})
    os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
    started.set()
    hashlib.pbkdf2_hmac("sha256", b"", b"", 2**31 - 1)  # for hours, and without the interpreter
busy = f"import os; os.sched_setaffinity(0, {{{processor}}}); print(flush=True); exec('while True: pass')"
with subprocess.Popen([sys.executable, "-c", busy], stdout=subprocess.PIPE) as other:
    other.stdout.readline()
    threading.Thread(target=work, daemon=True).start()
    started.wait()
    looks = Starved(number), Starved(threading.get_native_id()), Starved(0)
    seen = []
    for _ in range(31):
        seen.append([look.look() for look in looks])
        time.sleep(0.05)
    other.kill()
print(*(sum(column) for column in zip(*seen)), flush=True)
os._exit(0)
"""


def test_a_thread_that_another_keeps_from_its_processor_is_seen() -> None:
    starved, looking, unknown = map(int, said(STARVED))
    assert starved >= 15
    assert looking == unknown == 0
