"""Commands about keys, and binds without keys: output, exit code, and errors in one line."""

from collections.abc import Callable
from itertools import islice
from pathlib import Path
from typing import Protocol

import pytest
import zmq

from common.config.file import load_config, to_toml
from common.config.link_models import ObserverConfig, OperatorLinkConfig
from common.config.site_models import RemoteConfig
from common.link.bind_address import check_bind
from common.link.curve import LinkProblem
from common.link.keys import Role, TrustedKeys, create_keys, fingerprint, load_keys
from common.link.link import OperatorLink, RemoteLink
from teletaction.doctor.doctor import examine
from tests.commands import command, one_line
from tests.waiting import wait_until

OPEN_TO_A_NETWORK = ("0.0.0.0", "::", "*", "192.0.2.7", "remote.example")


@pytest.mark.parametrize("host", OPEN_TO_A_NETWORK)
def test_a_bind_beyond_loopback_without_trusted_keys_is_refused_before_any_socket_exists(
    host: str, configs: dict[str, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    config = load_config(configs["remote"], RemoteConfig)
    TrustedKeys(config.link.keys).revoke("operator")
    link = config.link.model_copy(update={"bind": host})
    configs["remote"].write_text(to_toml(config.model_copy(update={"link": link})), "utf-8")

    def no_socket(*_: object, **__: object) -> None:
        raise AssertionError("nothing may be opened")

    monkeypatch.setattr(zmq, "Context", no_socket)
    monkeypatch.setattr("socket.socket", no_socket)
    line = one_line(command("remote", "--config", configs["remote"]), 2)
    for words in (f"{host} is open to a network", "trusts nobody", "teletaction keys trust"):
        assert words in line


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost", "127.1.2.3", "::1"])
def test_loopback_may_be_bound_without_trusted_keys(host: str, tmp_path: Path) -> None:
    check_bind(host, TrustedKeys(tmp_path))


class Keys(Protocol):
    remote: Path
    operator: Path


def test_with_a_trusted_key_a_bind_to_every_interface_is_accepted_and_serves_it(keys: Keys, base_port: int) -> None:
    remote = load_keys(keys.remote)
    for host in OPEN_TO_A_NETWORK:
        check_bind(host, TrustedKeys(keys.remote))
    with (
        RemoteLink("0.0.0.0", base_port, remote, TrustedKeys(keys.remote)) as link,
        OperatorLink("127.0.0.1", base_port, load_keys(keys.operator), remote.public) as operator,
    ):
        wait_until(lambda: operator.send("control", b"?") and link.requests("control"), every_s=0.001)
    TrustedKeys(keys.remote).revoke("operator")
    with pytest.raises(LinkProblem, match=r"0\.0\.0\.0 is open to a network"):
        RemoteLink("0.0.0.0", base_port, remote, TrustedKeys(keys.remote))


def test_observing_with_a_wrong_configuration_is_reported(configs: dict[str, Path], tmp_path: Path) -> None:
    assert "absent.toml" in one_line(command("observe", "--config", tmp_path / "absent.toml"), 2)
    assert "operator.toml" in one_line(command("observe", "--config", configs["operator"]), 2)
    observer = tmp_path / "observer.toml"
    observer.write_text(to_toml(ObserverConfig(link=OperatorLinkConfig(keys=tmp_path / "student"))), "utf-8")
    assert "no key; make one with" in one_line(command("observe", "--config", observer), 2)
    create_keys(tmp_path / "student")
    assert "no key named `remote`" in one_line(command("observe", "--config", observer), 2)


def test_keys_are_made_shown_trusted_and_revoked(tmp_path: Path) -> None:
    site, other = tmp_path / "site", create_keys(tmp_path / "other")
    code, public, _ = command("keys", "init", "--keys", site).said
    assert code == 0
    assert public.strip() == load_keys(site).public
    assert command("keys", "trust", "--keys", site, "--observer", "--", "student", other).said == (0, "", "")
    assert TrustedKeys(site).role(other) is Role.OBSERVER
    code, shown, _ = command("keys", "show", "--keys", site).said
    assert code == 0
    assert shown.splitlines() == [
        f"own {fingerprint(public.strip())} {public.strip()}",
        f"trusted student (observer) {fingerprint(other)} {other}",
    ]
    assert load_keys(site).secret.decode() not in shown
    assert command("keys", "revoke", "student", "--keys", site).said == (0, "", "revoked 1 key of student\n")
    assert TrustedKeys(site).role(other) is None


def test_a_changed_role_or_name_of_a_trusted_key_is_reported(tmp_path: Path) -> None:
    site, other = tmp_path / "site", create_keys(tmp_path / "other")
    create_keys(site)

    def trust(*words: str) -> tuple[int, str, str]:
        return command("keys", "trust", "--keys", site, *words, other).said

    assert trust("--observer", "--", "student") == trust("--observer", "--", "student") == (0, "", "")
    changed = f"changed {fingerprint(other)}: was student (observer), is student (partner)\n"
    assert trust("--", "student") == (0, "", changed)
    assert trust("--", "student") == (0, "", "")
    assert trust("--", "tutor") == (0, "", changed.replace("(observer)", "(partner)").replace("is student", "is tutor"))
    assert TrustedKeys(site).owners()[other].name == "tutor"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("show",), "no key; make one with"),
        (("revoke", "student"), "trusts no 'student'; known: nobody"),
        (("trust", "student", "short"), "is no public key"),
        (("trust", "--", "student", "y.+gd8$@Hc[Uz@+FH1lzOuP#7@N*2>/jvK/M0V@#"), "no key; make one with"),
    ],
)
def test_a_wrong_key_command_is_one_line(arguments: tuple[str, ...], words: str, tmp_path: Path) -> None:
    verb, *others = arguments
    assert words in one_line(command("keys", verb, "--keys", tmp_path / "absent", *others), 2)
    assert not (tmp_path / "absent").exists()


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (lambda file: file.write_text("operator\n"), "trusted:1: expected NAME PUBLIC_KEY"),
        (lambda file: file.write_bytes(b"\xff\n"), "trusted:1: not UTF-8; remove this line"),
        (lambda file: file.write_bytes(b"operator " + b"#" * 40), "trusted:1: "),
        (lambda file: file.chmod(0o666), "trusted: mode 0666 lets others change it; `chmod go-w` it"),
        (lambda file: file.parent.chmod(0o777), "remote: mode 0777 lets others change it; `chmod go-w` it"),
    ],
)
def test_a_damaged_list_is_reported_by_site_show_and_doctor(
    configs: dict[str, Path], damage: Callable[[Path], object], words: str
) -> None:
    folder = load_config(configs["remote"], RemoteConfig).link.keys
    damage(folder / "trusted")
    assert words in one_line(command("remote", "--config", configs["remote"]), 2)
    code, _, said = command("keys", "show", "--keys", folder).said
    assert code == 2
    assert words in said
    (found,) = (found for found in islice(examine(configs["remote"]), 2) if found.what == "trusted keys")
    assert not found.good
    assert words in found.result
