"""Runs a whole telediagnosis session on this machine with simulated devices and a scripted hand."""

import fcntl
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import datetime
from importlib.util import find_spec
from pathlib import Path

from common.config.file import load_config
from common.config.simulation_models import SimNetworkConfig
from common.files.private_file import create_private
from common.files.user_folders import make_private, state_folder
from common.health import NoStatus, read_status, young
from common.link.session_display import SILENT, seconds_old
from common.process import StopSignal
from common.scenes.scene import load_scene
from remote_site.session.pain_file import SUFFIX as PAIN_SUFFIX
from remote_site.session.stop_file import SUFFIX as STOP_SUFFIX
from teletaction.session.demo_files import CAMERA, CONSOLE, NETWORK, PROCESSES, VOICE, DemoOptions, prepare
from teletaction.session.demo_ports import HOST
from teletaction.session.launcher_figures import LAUNCHER, LauncherFigures
from teletaction.session.ping import BarePing
from teletaction.session.processes import KILLED_S, SessionProcesses
from teletaction.session.restarts import Restarts
from teletaction.session.saved import incomplete_recordings, saved_words
from teletaction.session.terminal import say, show

_START_S = 30.0
"""Time within which the hand must start to explore in a session without a console, s."""
_PING_S = 0.05
"""Interval of the bare pings and of the checks of the processes, s."""
_SHOWN_S = 1.0
"""Interval of the progress on a terminal, s."""
_PRODUCED = ("summary.json", "session.mcap", "report.html", LAUNCHER, "summarise.log")
"""Files that a session writes after its end."""


def run_demo(options: DemoOptions) -> str:
    """Run a session and write its output folder; return a description of the failure, empty on success.

    Ctrl-C ends the session, prints what was recorded and if it is complete, and makes the report in the background.

    Raises:
        ValueError: unknown scene, no calibration for it, or an output folder with other files or of a running demo.
        KeyboardInterrupt: it was stopped before the hand explored or a console had an address.
    """
    load_scene(options.scene)
    if options.console and find_spec("starlette") is None:
        raise ValueError("the console needs `pip install teletaction[console]`; --headless runs without it")
    out = _output_folder(options)
    try:
        with _held(out):
            return _run(options, out)
    finally:
        if options.out is None:
            with suppress(OSError):  # only an empty folder can be removed: nothing began
                out.rmdir()


def _run(options: DemoOptions, out: Path) -> str:
    """Run a session in its output folder; return a description of the failure, empty on success."""
    configurations = prepare(options, out)
    _remove_earlier(out)
    stop = StopSignal()
    say(f"session in {out}; {options.rates.words}")
    processes = SessionProcesses(out)
    try:
        for name, configuration in configurations.items():
            processes.start(name, configuration)
        with BarePing() as ping:
            figures = _watch(processes, options, stop, ping)
        if stop():
            say("stopped; the processes are ending")
    except _Failure as failure:
        show("")
        return str(failure)
    finally:
        killed = processes.end()
    figures.write(out)
    if not stop():
        signal.signal(signal.SIGINT, signal.default_int_handler)
        try:
            return _conclude(options, out) or killed_words(killed)
        except KeyboardInterrupt:
            say("stopped")
    incomplete = incomplete_recordings(out)
    say(saved_words(out, figures.wall_s, incomplete))
    _conclude_in_background(options, out)
    return "; ".join(filter(None, (killed_words(killed), *incomplete)))


class _Failure(Exception):
    """The session failed; the text says why."""


def killed_words(names: list[str]) -> str:
    """Return the failure of a session whose processes had to be killed; empty without one."""
    return f"killed, since they did not end within {KILLED_S:g} s: {', '.join(names)}" if names else ""


def _conclude(options: DemoOptions, out: Path) -> str:
    """Write summary and report; return a description of the failure, empty on success."""
    # Late imports: plots and statistics would cost memory and time during the session.
    from teletaction.recordings.machine_verdict import machine_verdict  # noqa: PLC0415
    from teletaction.session.conclude import conclude, incomplete_of  # noqa: PLC0415

    given = {"scene": options.scene, "seed": options.seed, "fingers": options.fingers}
    summary = conclude(out, out, given, show)
    say(machine_verdict(summary))
    say(f"summary {out / 'summary.json'}, report {out / 'report.html'}, recording {out / 'session.mcap'}")
    return "; ".join(incomplete_of(summary))


def _conclude_in_background(options: DemoOptions, out: Path) -> None:
    """Start `teletaction summarise` on the output folder, as a process that outlives this one."""
    words = ["summarise", "--recordings", str(out), "--out", str(out)]
    words += ["--scene", options.scene, "--seed", str(options.seed), "--fingers", str(options.fingers)]
    log = out / "summarise.log"
    with create_private(log, replace=True) as file:
        subprocess.Popen(
            [sys.executable, "-m", "teletaction", *words],
            stdin=subprocess.DEVNULL,
            stdout=file,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
    say(f"{out / 'report.html'} is being made in the background; {log} shows when it is ready")


def _watch(processes: SessionProcesses, options: DemoOptions, stop: StopSignal, ping: BarePing) -> LauncherFigures:
    """Wait for the session's end; return what was measured.

    Raises:
        _Failure: a process has ended, or the session did not begin in time.
        KeyboardInterrupt: it was stopped before it began.
    """
    announced, restarts = False, {CONSOLE: Restarts(), CAMERA: Restarts(), VOICE: Restarts()}
    started_s: float | None = None
    begin_s = shown_s = time.monotonic()
    first: dict[str, tuple[float, float]] = {}
    show("the processes are starting")
    while not stop():
        time.sleep(_PING_S)
        ping.once()
        now_s = time.monotonic()
        ended = processes.ended()
        for name in ended.keys() & restarts if announced else ():
            _restart(processes, name, restarts[name], ended.pop(name), now_s)
        if ended:
            name = next(iter(ended))
            raise _Failure(f"{name} ended with exit code {ended[name]}: {processes.last_words(name)}")
        if options.console and not announced:
            announced = _announce_address(processes.out)
        hand = _status(processes.out / "sim-operator.json")
        if started_s is None:
            if hand.get("script_s"):
                started_s, first = now_s, processes.usage()
                say("both sites are engaged; the hand is exploring")
                if options.network is not None:
                    _start_timetable(processes.out)
            elif now_s - begin_s > _START_S and not options.console:
                raise _Failure(f"the session did not start within {_START_S:g} s: {_waiting_for(processes.out)}")
        elif options.seconds is not None and hand.get("finished"):
            break
        elif now_s - shown_s >= _SHOWN_S:
            shown_s = now_s
            whole = "" if options.seconds is None else f" of {options.seconds:g}"
            show(f"exploring: {now_s - started_s:.0f}{whole} s")
    if started_s is None and not announced:
        say("stopped before the session began")
        raise KeyboardInterrupt
    wall_s = 0.0 if started_s is None else time.monotonic() - started_s
    usage = {
        name: (max(0.0, cpu_s - first[name][0]) / wall_s, peak_mib)
        for name, (cpu_s, peak_mib) in processes.usage().items()
        if name in first
    }
    return LauncherFigures(usage, wall_s, ping.round_trips_s)


def _restart(processes: SessionProcesses, name: str, restarts: Restarts, code: int, now_s: float) -> None:
    """Restart a console, camera or voice that has ended, after a pause; its end never ends the session."""
    count = restarts.count
    pause_s = restarts.ended(now_s)
    if pause_s is None:
        del processes.running[name]
        say(f"the {name} ended with exit code {code} and is not started again: it ended {count} times in a row")
    elif pause_s <= 0.0:
        processes.restart(name)
        restarts.started(now_s)
    elif restarts.count != count:
        say(f"the {name} ended with exit code {code}: {processes.last_words(name)}; it is started again")


def _announce_address(out: Path) -> bool:
    """Print the console's address once it is known; return True then."""
    address = _status(out / f"{CONSOLE}.json").get("address")
    if address:
        say(f"console at {address}: open it in a browser, begin a session there and engage; Ctrl-C ends it")
    return bool(address)


def _start_timetable(out: Path) -> None:
    """Start the timetable of the network's faults and phases together with the exploration."""
    port = load_config(out / "config" / f"{NETWORK}.toml", SimNetworkConfig).fault_port
    assert port is not None
    with socket.create_connection((HOST, port), timeout=5.0) as network:
        network.sendall(b"start\n")
        network.recv(64)


def _status(path: Path) -> dict[str, object]:
    try:
        return read_status(path, 0)[0]
    except NoStatus:
        return {}


def _waiting_for(out: Path) -> str:
    said = []
    for name in ("remote", "operator"):
        try:
            status, age_s = read_status(out / f"{name}.json", time.monotonic_ns())
        except NoStatus:
            status, age_s = {"state": "has not started"}, 0.0
        if not young(age_s):
            status = {"state": f"{SILENT}, {seconds_old(age_s)}"}
        fault, behind = status.get("fault"), status.get("behind")
        state = f"{status.get('state')}: {fault.get('text', fault)}" if isinstance(fault, dict) else status.get("state")
        words = [name, state, status.get("missing"), _refusals(status.get("refused"))]
        line = " ".join(str(word) for word in words if word)
        said.append(f"{line}, loop behind: {behind}" if behind else line)
    return "; ".join(said)


def _refusals(refused: object) -> str:
    """Describe refused packets of the link, such as `refused touch (age 512)` over a slow network."""
    streams = refused.items() if isinstance(refused, dict) else ()
    found = [
        f"refused {stream} ({', '.join(f'{why} {count}' for why, count in reasons.items())})"
        for stream, reasons in streams
        if stream != "damaged" and reasons
    ]
    return ", ".join(found)


def _output_folder(options: DemoOptions) -> Path:
    out = options.out
    if out is None:
        make_private(state_folder())
        out = state_folder() / f"session-{datetime.now():%Y%m%d-%H%M%S}"
    if out.exists() and any(out.iterdir()) and not all((out / part).is_dir() for part in ("config", "keys/remote")):
        raise ValueError(f"--out {out}: holds other things; choose a new or empty folder")
    out = out.resolve()
    out.mkdir(parents=True, exist_ok=True)
    return out


@contextmanager
def _held(out: Path) -> Iterator[None]:
    """Hold the output folder; raises ValueError where another demo holds it."""
    folder = os.open(out, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        with suppress(OSError):  # some network file systems lock no folders
            try:
                fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise ValueError(f"--out {out}: another demo uses it; choose another folder") from None
        yield
    finally:
        os.close(folder)


def _remove_earlier(out: Path) -> None:
    """Remove the results of an earlier session in the folder."""
    for name in (*PROCESSES, NETWORK, CAMERA, VOICE, CONSOLE):
        for part in out.glob(f"{name}-*.mcap"):
            part.unlink()
        for suffix in (".json", ".mcap", ".log", STOP_SUFFIX, PAIN_SUFFIX):
            (out / f"{name}{suffix}").unlink(missing_ok=True)
    for produced in _PRODUCED:
        (out / produced).unlink(missing_ok=True)
