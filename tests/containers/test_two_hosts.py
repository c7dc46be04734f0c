"""Two hosts set up by their how-to, on two networks joined by a link that delays, loses and breaks."""

import socket
import ssl
import time
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from common import limits
from common.wire.messages import Touch
from robustness.faults import read_truth
from tests.containers.checkout import Checkout, run, wait_for
from tests.containers.console_page import assert_closed_to_strangers, read_tokens
from tests.containers.howto import blocks
from tests.containers.two_networks import TwoNetworks, two_networks
from tests.network.two_hosts import why_not
from tests.system.page import opened
from tests.system.truth import LATE_S, Floats, Truth, between, packets, written

pytestmark = [pytest.mark.containers, pytest.mark.timeout(600)]

PAGE = "docs/howto/containers.md"
DELAY_MS, JITTER_MS, LOSS = 20.0, 5.0, 0.01
PARTITION_S = 5.0
STOPS_WITHIN_S = 2.0
PAUSE_S = 0.020
"""Nothing that works for a session rests for longer."""
RESTARTED = (
    ("remote", "remote", "remote"),
    ("remote", "devices", "sim-remote"),
    ("operator", "operator", "operator"),
    ("operator", "devices", "sim-operator"),
    ("operator", "operator-console", "console"),
)
"""Host, service and process."""
NOTICED_S = {"sim-remote": 0.150, "revoked": 1.0}
"""Dead devices of the far side are noticed from what its site then says; the list of keys is read once a second."""
COME_FIRST = "from common.runtime.scheduling import take_realtime; print(take_realtime())"
SESSION = "docker-compose exec -T operator python -m teletaction session {} --config /config/operator.toml"
HEALTH = "docker-compose exec -T {} python -m common.health /session/{}.json --state engaged"


@dataclass
class Story:
    """What was done when, s, and what was seen."""

    folder: Path
    cut_s: float = 0.0
    healed_s: float = 0.0
    stopped: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    """Times of each process: stop command, end, and new start."""
    stops_s: dict[str, float] = field(default_factory=dict)
    revoked_s: float = 0.0
    rotated_s: float = 0.0
    shares: list[float] = field(default_factory=list)
    engine_may: bool = False
    may_take_realtime: dict[str, bool] = field(default_factory=dict)
    """Whether the engine may allow real-time priority, and whether it is allowed in each site's container."""
    came_first: str = ""
    """What the how-to's command says of the operator's loop."""


@pytest.fixture(scope="module")
def story(tmp_path_factory: pytest.TempPathFactory) -> Story:
    reason = why_not()
    if reason:
        pytest.skip(reason)
    folder = tmp_path_factory.mktemp("hosts")
    with two_networks(folder) as hosts:
        return carried_out(hosts, Story(folder))


def carried_out(hosts: TwoNetworks, story: Story) -> Story:
    steps = blocks(PAGE)
    set_up(hosts, steps)
    time.sleep(5.0)
    wait_until_engaged(hosts, time.monotonic())
    use_console(hosts, read_tokens(hosts.operator(steps["Start"][1])))
    for checkout, name in ((hosts.remote, "remote"), (hosts.operator, "operator")):
        said = run("docker", "exec", checkout.container(name), "python", "-c", COME_FIRST)
        story.may_take_realtime[name] = {"True\n": True, "False\n": False}[said]
    story.engine_may = hosts.real_time
    story.came_first = hosts.operator(*steps["Real-time priority"]).strip()
    part(hosts, story)
    for host, service, process in RESTARTED:
        restart(hosts, story, host, service, process)
    hosts.operator(*steps["Restart one service"])
    wait_until_engaged(hosts, time.monotonic())
    rotate_keys(hosts, story, steps["A new key"])
    passed = hosts.impair(DELAY_MS, JITTER_MS, LOSS)
    story.shares = [way.dropped / (way.dropped + way.passed) for way in passed]
    operator_end, remote_end = steps["Stop"]
    hosts.operator(operator_end)
    hosts.remote(remote_end)
    assert {line for made in steps.values() for block in made for line in block.splitlines()} <= {
        *hosts.remote.ran,
        *hosts.operator.ran,
    }, "the how-to has commands that nobody tried"
    return story


def set_up(hosts: TwoNetworks, steps: dict[str, list[str]]) -> None:
    """As a person would, but for the addresses of devices, which are simulated."""
    for checkout in (hosts.remote, hosts.operator):
        for name in ("remote", "operator"):
            config = checkout.folder / "docker" / f"{name}.toml"
            (config.parent / "hardware" / config.name).write_text(config.read_text("utf-8"), "utf-8")
    remote_key = key_printed(hosts.remote(*steps["The remote site's host"]))
    operator_key = key_printed(hosts.operator(*steps["The operator's host"]))
    to_remote, to_operator = steps["Trust"]
    hosts.remote(to_remote, OPERATOR_KEY=operator_key)
    hosts.operator(to_operator, REMOTE_KEY=remote_key)
    begin_s = time.monotonic()
    hosts.remote(steps["Start"][0])
    hosts.operator(steps["Start"][0], REMOTE_ADDRESS=hosts.address("remote", hosts.remote.container("host")))
    hosts.connect()
    hosts.impair(DELAY_MS, JITTER_MS, LOSS)
    wait_until_engaged(hosts, begin_s)
    print(f"from up to engaged: {time.monotonic() - begin_s:.1f} s")
    wait_for(lambda: hosts.remote.healthy("remote"), "a healthy remote site", 30.0)
    wait_for(lambda: hosts.operator.healthy("operator"), "a healthy operator site", 30.0)
    wait_for(lambda: hosts.operator.healthy("operator-console"), "a healthy console", 30.0)
    wait_for(lambda: hosts.operator(*steps["Health"]) == "", "a healthy site in words", 30.0)


def key_printed(said: str) -> str:
    """A public key stands alone in its line."""
    return next(line for line in said.splitlines() if len(line) == 40 and " " not in line)


def wait_until_engaged(hosts: TwoNetworks, since_s: float) -> None:
    """Both sites say so, and have said it after `since_s`."""

    def engaged() -> bool:
        status = hosts.remote.status("remote", "remote"), hosts.operator.status("operator", "operator")
        if any(site["fault"] for site in status):
            for verb in ("clear", "engage"):  # as a person does; whether there may be a fault is judged in the end
                hosts.operator(SESSION.format(verb))
        return all(site["state"] == "engaged" and site["time_ns"] * 1e-9 > since_s + 1.0 for site in status)

    wait_for(engaged, "both engaged", 60.0)


def use_console(hosts: TwoNetworks, tokens: dict[str, str]) -> None:
    """From another machine of its network, only with a token; an observer's does nothing; nothing else is open."""
    trust = ssl.create_default_context(cafile=hosts.operator.folder / "secrets" / "certificate.pem")
    trust.check_hostname = False  # here its name leads nowhere
    host = hosts.address("operator", hosts.operator.container("host"))
    address = f"https://{host}:8090"
    assert_closed_to_strangers(address, trust)
    with (
        opened(address, ssl=trust, Cookie=f"teletaction={tokens['act']}") as page,
        opened(address, ssl=trust, Cookie=f"teletaction={tokens['observe']}") as observer,
    ):
        page.until(lambda: page.state and page.state["session"]["state"] == "engaged", "an engaged session")
        observer.until(lambda: observer.state, "a session to look at")
        for verb in ("estop", "pause", "begin", "engage"):
            assert not observer.ask(verb)["ok"], verb
        assert page.ask("begin", pseudonym="P-0418")["ok"]
        observer.until(lambda: observer.state["session"]["pseudonym"] == "P-0418", "what the other one did")
    for port in (5609, 5610):
        with pytest.raises(ConnectionRefusedError):
            socket.create_connection((host, port), timeout=5.0)


def part(hosts: TwoNetworks, story: Story) -> None:
    """Nothing passes for five seconds."""
    wait_until_engaged(hosts, time.monotonic())
    story.cut_s = time.monotonic()
    hosts.cut()
    time.sleep(PARTITION_S - 2.0)
    with pytest.raises(AssertionError, match="stale: no "):
        hosts.operator(HEALTH.format("operator", "operator"))
    time.sleep(max(0.0, story.cut_s + PARTITION_S - time.monotonic()))
    hosts.heal()
    story.healed_s = time.monotonic()
    wait_until_engaged(hosts, story.healed_s)


def restart(hosts: TwoNetworks, story: Story, host: str, service: str, process: str) -> None:
    """One service is stopped and started; the session continues by itself."""
    checkout = hosts.remote if host == "remote" else hosts.operator
    begin_s = time.monotonic()
    story.stops_s[process] = checkout.stop(service)
    gone_s = time.monotonic()
    time.sleep(1.0)
    run("docker", "start", checkout.container(service))
    story.stopped[process] = begin_s, gone_s, time.monotonic()

    wait_until_fresh(checkout, service, process, story.stopped[process][2])
    wait_until_engaged(hosts, story.stopped[process][2])


def wait_until_fresh(checkout: Checkout, service: str, process: str, since_s: float) -> None:
    """It has said after `since_s` that it lacks nothing."""

    def fresh() -> bool:
        status = checkout.status(service, process)
        return status["time_ns"] * 1e-9 > since_s and not status.get("stale")

    wait_for(fresh, f"{process} again", 60.0)


def rotate_keys(hosts: TwoNetworks, story: Story, steps: list[str]) -> None:
    """While all runs: the old key is refused, the new one works."""
    new_key, at_remote, afterwards = steps
    operator_key = key_printed(hosts.operator(new_key))
    revoke, trust = at_remote.splitlines()
    hosts.remote(revoke)
    story.revoked_s = time.monotonic()

    def refused() -> bool:
        status = hosts.operator.status("operator", "operator")
        return status["state"] == "disconnected" and "does not trust" in status["stale"]

    wait_for(refused, "the old key refused", 20.0)
    hosts.remote(trust, OPERATOR_KEY=operator_key)
    time.sleep(2.0)
    assert refused(), "the old key is let in with the new one"
    begin_s = time.monotonic()
    hosts.operator(afterwards)
    wait_until_engaged(hosts, begin_s)
    story.rotated_s = time.monotonic()
    wait_until_fresh(hosts.operator, "operator-console", "console", story.rotated_s)  # starts later


@pytest.fixture(scope="module")
def truth(story: Story) -> Truth:
    """What the simulated devices of both hosts wrote down."""
    return read_truth(recordings(story))


def recordings(story: Story) -> Path:
    """Of both hosts, in one folder."""
    folder = story.folder / "recordings"
    folder.mkdir(exist_ok=True)
    for host in ("remote", "operator"):
        for path in (story.folder / host / f"session-{host}").glob("*.mcap"):
            if not (folder / path.name).exists():
                path.rename(folder / path.name)
    return folder


def happened_s(story: Story, what: str) -> list[Floats]:
    """When each site, remote and operator, noted something, s."""
    return [
        np.sort(
            [
                t
                for path in recordings(story).glob(f"{site}*.mcap")
                for t, entry in written(path, f"{site}/session", may_be_cut=True)
                if entry[0] == what
            ]
        )
        for site in ("remote", "operator")
    ]


def engaged_again_s(story: Story, since_s: float) -> float:
    """When both were engaged again after something that ended the session, s."""
    return max(float(times[times > since_s][0]) for times in happened_s(story, "engaged"))


def back_s(story: Story) -> dict[str, float]:
    """When the session worked again after each restart: sites were engaged, or all devices there, s."""
    found = {}
    for process, (_, gone_s, _) in story.stopped.items():
        if process in ("remote", "operator"):
            found[process] = engaged_again_s(story, gone_s)
        elif process.startswith("sim-"):
            times = happened_s(story, "complete")[process == "sim-operator"]
            found[process] = float(times[times > gone_s][0])
    return found


def starved_s(truth: Truth, begin_s: float, end_s: float) -> float:
    """For how long the machine gave one of its processes no time, s: one that works in jerks shakes fingers."""
    pauses_s = [np.diff(ticks_s[(ticks_s >= begin_s) & (ticks_s <= end_s)]) for ticks_s in truth.ticks_s.values()]
    return max(float(pause_s[pause_s > PAUSE_S].sum()) for pause_s in pauses_s)


def test_packets_were_delayed_and_lost_as_configured(story: Story) -> None:
    """Both hosts read one clock. One packet with unbounded jitter proves nothing; the median of all does."""
    ages_ms = [
        time_s * 1e3 - Touch.decode(packet).time_ns * 1e-6
        for path in recordings(story).glob("operator*.mcap")
        for time_s, packet in packets(path, "operator/touch", may_be_cut=True)
    ]
    print(f"lost: {story.shares}; age of touch, median of {len(ages_ms)}: {np.median(ages_ms):.1f} ms")
    assert all(LOSS / 2.0 <= share <= 2.0 * LOSS for share in story.shares)
    assert np.median(ages_ms) > DELAY_MS


def test_the_operator_never_underestimated_the_clock_uncertainty(story: Story) -> None:
    """The true offset is zero."""
    compared = [
        (offset_ns, uncertainty_ns)
        for path in recordings(story).glob("operator*.mcap")
        for _, (offset_ns, uncertainty_ns, _) in written(path, "operator/clock", may_be_cut=True)
        if uncertainty_ns is not None
    ]
    worst_ms = max(abs(offset_ns) for offset_ns, _ in compared) * 1e-6
    print(f"offset of the far clock wrong by {worst_ms:.1f} ms at most, in {len(compared)} reports")
    assert all(abs(offset_ns) <= uncertainty_ns for offset_ns, uncertainty_ns in compared)


def test_both_loops_have_real_time_priority_where_the_engine_allows_it(story: Story) -> None:
    """Whether one does when it is asked, is up to how busy the machine is."""
    print(f"allowed: {story.may_take_realtime}, the operator's loop: {story.came_first}")
    assert story.may_take_realtime == {"remote": story.engine_may, "operator": story.engine_may}
    assert story.came_first in ('"real_time": true', '"real_time": false')


def test_every_service_stops_within_two_seconds(story: Story) -> None:
    print("stopped within, s:", {process: round(took_s, 2) for process, took_s in story.stops_s.items()})
    assert len(story.stops_s) == len(RESTARTED)
    assert max(story.stops_s.values()) < STOPS_WITHIN_S


def test_the_session_recovers_from_the_partition_and_each_restart(story: Story) -> None:
    healed_s = engaged_again_s(story, story.cut_s + 1.5) - story.healed_s
    recovered = {process: round(time_s - story.stopped[process][2], 1) for process, time_s in back_s(story).items()}
    print(f"engaged {healed_s:.1f} s after the partition, and at work after each start, s: {recovered}")
    console_s = story.stopped["console"]
    lost = [times[(times > console_s[0]) & (times < console_s[2] + 1.0)] for times in happened_s(story, "disconnected")]
    assert not any(len(times) for times in lost), "the console's restart has ended the session"


def test_nothing_acts_while_the_sites_are_apart(story: Story, truth: Truth) -> None:
    spans = {"partition": (story.cut_s, story.healed_s)} | {
        process: (story.stopped[process][1], time_s) for process, time_s in back_s(story).items()
    }
    # Of the operator's devices the exoskeleton comes back first: with the hand's motion the far side acts again.
    gone_s, complete_s = spans["sim-operator"]
    heard_s = happened_s(story, "heard")[0]
    spans["sim-operator"] = gone_s, min([complete_s, *heard_s[heard_s > gone_s][:1]])
    spans["revoked"] = story.revoked_s, engaged_again_s(story, story.revoked_s)
    for name, (begin_s, end_s) in spans.items():
        late_s = LATE_S + NOTICED_S.get(name, 0.0) + truth.pause_s(begin_s - 0.2, begin_s + 1.0, name)
        # A simulation that the machine held back writes down too early a time for its next commands.
        until_s = end_s - LATE_S - truth.pause_s(end_s - 0.2, end_s + 0.2, name)
        for what, time_s, outputs, hold_s, own in (
            ("force", truth.finger_s, truth.force_n, limits.FORCE_SAFE_S, "sim-operator"),
            ("motor", truth.finger_s, truth.motor_mv, limits.MOTOR_SAFE_S, "sim-operator"),
            ("peltier", truth.finger_s, truth.peltier, limits.THERMAL_SAFE_S, "sim-operator"),
            ("heater", truth.patient_s, truth.heater, limits.THERMAL_SAFE_S, "sim-remote"),
        ):
            # With its devices gone the remote site still says what was felt last; plates go there gently, and are safe.
            if name != own and (name, what) != ("sim-remote", "peltier"):
                after = between(time_s, outputs, begin_s + hold_s + late_s, until_s)
                assert not after.any(), f"{name}: {what} up to {np.abs(after).max()}"


def test_no_output_was_ever_beyond_its_limit(story: Story, truth: Truth) -> None:
    touched = [
        max(entry["force_n"])
        for path in recordings(story).glob("sim-remote*.mcap")
        for _, entry in written(path, "truth_contact", may_be_cut=True)
    ]
    print(
        f"force {truth.force_n.max():.2f} N, on the object {max(touched):.2f} N, plates {truth.plate_c.min():.1f} to "
        f"{truth.plate_c.max():.1f} C, sensors' plates {truth.sensor_plate_c.max():.1f} C, faults {truth.faults}"
    )
    assert 0.0 < truth.force_n.max() <= limits.FINGER_FORCE_N
    assert 0.0 < max(touched) <= limits.CONTACT_FORCE_N
    assert truth.plate_c.max() <= limits.PLATE_FAULT_C
    assert truth.sensor_plate_c.max() <= limits.SENSOR_PLATE_C
    assert truth.motor_rpm.max() <= limits.MOTOR_MAX_RPM
    for time_s, words in truth.faults:
        assert starved_s(truth, time_s - 1.0, time_s) > limits.GAP_S, words
