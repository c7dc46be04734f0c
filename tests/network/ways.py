"""Ways to a remote site that only connects outwards. Each returns the site's address, the same at both hosts."""

import sys
from pathlib import Path

from common.config.file import to_toml
from common.config.link_models import RendezvousConfig, TunnelConfig
from common.wire.streams import STREAMS
from teletaction.tunnel.room_secret import create_secret
from tests.network.link_bench import BASE_PORT
from tests.network.two_hosts import OPERATOR, Host, TwoHosts
from tests.waiting import wait_until

RENDEZVOUS_PORT, SSH_PORT, WIREGUARD_PORT = 5640, 22, 51820
LOOPBACK = "127.0.0.1"
REMOTE_INSIDE, OPERATOR_INSIDE = "198.51.100.1", "198.51.100.2"
"""Addresses within WireGuard's network, from a range that is nobody's."""
_UNTIL_INPUT_ENDS = ("sh", "-c", '"$@" & cat >/dev/null; kill $!; wait', "sh")
"""A program that ends with the input, as all programs of a `Host` do."""


def let_out(host: Host, protocol: str, port: int) -> None:
    """Let a host connect only outwards, and only to one port; what it has asked for may return."""
    new = ("-m", "conntrack", "--ctstate", "NEW", "-j", "DROP")
    host.run("iptables", "-I", "INPUT", "-i", "cable", *new)
    host.run("iptables", "-I", "OUTPUT", "-o", "cable", "!", "-p", protocol, *new)
    host.run("iptables", "-I", "OUTPUT", "-o", "cable", "-p", protocol, "!", "--dport", str(port), *new)


def over_rendezvous(hosts: TwoHosts, folder: Path) -> str:
    """Run a rendezvous at the operator's host, and a tunnel at each."""
    let_out(hosts.remote, "tcp", RENDEZVOUS_PORT)
    create_secret(folder / "secret")
    room = {"host": OPERATOR, "port": RENDEZVOUS_PORT, "room": "ward-3", "secret": folder / "secret"}
    for number, (host, name, config) in enumerate(
        (
            (hosts.operator, "rendezvous", RendezvousConfig(bind=OPERATOR, rooms={"ward-3": folder / "secret"})),
            (hosts.remote, "tunnel", TunnelConfig.model_validate(room | {"side": "remote"})),
            (hosts.operator, "tunnel", TunnelConfig.model_validate(room | {"side": "operator"})),
        )
    ):
        file = folder / f"way-{number}.toml"
        file.write_text(to_toml(config))
        run = (sys.executable, "-m", "tests.network.host_process", "0", "0")
        host.start(*run, name, "--config", str(file)).hear()
    return LOOPBACK


def over_ssh(hosts: TwoHosts, folder: Path) -> str:
    """Let the remote host log in at the operator's, which then listens at the ports of the link for it."""
    let_out(hosts.remote, "tcp", SSH_PORT)
    for name in ("host", "user"):
        hosts.remote.run("ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", str(folder / name))
    ports = [BASE_PORT + stream.port for stream in STREAMS.values()]
    listen = "".join(f',permitlisten="localhost:{port}"' for port in ports)
    (folder / "authorized").write_text(f"restrict,port-forwarding{listen} {(folder / 'user.pub').read_text()}")
    (folder / "sshd").write_text(
        f"ListenAddress {OPERATOR}:{SSH_PORT}\nHostKey {folder / 'host'}\nAuthorizedKeysFile {folder / 'authorized'}\n"
        "StrictModes no\nUsePAM no\nPasswordAuthentication no\nPidFile none\n"
    )
    Path("/run/sshd").mkdir(exist_ok=True)
    hosts.operator.start(*_UNTIL_INPUT_ENDS, "/usr/sbin/sshd", "-D", "-f", str(folder / "sshd"))
    _wait_for_port(hosts.operator, SSH_PORT)
    forwards = (word for port in ports for word in ("-R", f"localhost:{port}:127.0.0.1:{port}"))
    options = (
        "ExitOnForwardFailure=yes",
        "ServerAliveInterval=1",
        "StrictHostKeyChecking=no",
        "UserKnownHostsFile=/dev/null",
    )
    said = (word for option in options for word in ("-o", option))
    hosts.remote.start(
        *_UNTIL_INPUT_ENDS, "ssh", "-N", "-q", "-i", str(folder / "user"), *said, *forwards, f"root@{OPERATOR}"
    )
    _wait_for_port(hosts.operator, BASE_PORT)
    return LOOPBACK


def over_wireguard(hosts: TwoHosts, folder: Path) -> str:
    """Join both hosts in one WireGuard network, whose remote end calls the operator's."""
    let_out(hosts.remote, "udp", WIREGUARD_PORT)
    secret = {host: host.run("wg", "genkey").strip() for host in (hosts.remote, hosts.operator)}
    for host, peer, name, inside, rest in (
        (hosts.operator, hosts.remote, "wg-operator", (OPERATOR_INSIDE, REMOTE_INSIDE), ""),
        (
            hosts.remote,
            hosts.operator,
            "wg-remote",
            (REMOTE_INSIDE, OPERATOR_INSIDE),
            f"Endpoint = {OPERATOR}:{WIREGUARD_PORT}\nPersistentKeepalive = 25\n",
        ),
    ):
        public = host.run("sh", "-c", f"echo {secret[peer]} | wg pubkey").strip()
        port = "" if rest else f"ListenPort = {WIREGUARD_PORT}\n"
        (folder / name).write_text(
            f"[Interface]\nPrivateKey = {secret[host]}\n{port}"
            f"[Peer]\nPublicKey = {public}\nAllowedIPs = {inside[1]}/32\n{rest}"
        )
        host.start(*_UNTIL_INPUT_ENDS, "wireguard-go", "-f", name)
        wait_until(Path(f"/var/run/wireguard/{name}.sock").exists, f"{name} does not come up")
        host.run("wg", "setconf", name, str(folder / name))
        host.run("ip", "address", "add", f"{inside[0]}/24", "dev", name)
        host.run("ip", "link", "set", name, "up")
    return REMOTE_INSIDE


def _wait_for_port(host: Host, port: int) -> None:
    wait_until(lambda: host.run("ss", "-Hltn", f"sport = :{port}"), f"nobody listens at {port}")
