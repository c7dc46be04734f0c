"""Errors of misspelt and misplaced fields and tables, to the letter."""

from pathlib import Path

import pytest
from pydantic import BaseModel

from common.config.file import ConfigProblem, load_config, load_site
from common.config.link_models import ObserverConfig
from common.config.page_models import ConsoleConfig
from common.config.site_models import OperatorConfig, RemoteConfig
from tests.unit.common.config.test_file import OPERATOR, REMOTE


def problem_of(path: Path, text: str, model: type[BaseModel]) -> str:
    """The error of a file with this text, without the file's name."""
    path.write_text(text, "utf-8")
    with pytest.raises(ConfigProblem) as caught:
        load_config(path, model)
    return str(caught.value).replace(str(path), "FILE")


@pytest.mark.parametrize(
    ("text", "model", "expected"),
    [
        (f"{REMOTE}[patint]\n", RemoteConfig, "FILE:18: patint: no such table; did you mean patient?"),
        (
            f"{REMOTE}[safty]\n",
            RemoteConfig,
            "FILE:18: safty: no such table; there are [recording], [consent], [link], [texture], [thermal_sensors], "
            "[telemanipulator], [calibration], [patient], [patient_switch]",
        ),
        (
            REMOTE.replace("[link]", "[remote.link]"),
            RemoteConfig,
            "FILE:3: remote: no such table; write [link] instead of [remote.link]; FILE:3: link: Field required",
        ),
        (
            f'{REMOTE}[tacttip]\nindex = "/dev/ttyUSB0"\n',
            RemoteConfig,
            "FILE:18: tacttip: no such table here; it belongs in a configuration for `teletaction operator` or "
            "`teletaction sim-operator`",
        ),
        (
            f"{REMOTE}contact_force_n = 2.0\n",
            RemoteConfig,
            "FILE:18: calibration.contact_force_n: no such field here; it belongs in [patient]",
        ),
        (
            f"{REMOTE}rate_hz = 500.0\n",
            RemoteConfig,
            "FILE:18: calibration.rate_hz: no such field here; it belongs at the top of the file, above all tables",
        ),
        (
            REMOTE.replace('keys = "keys"', 'keys = "keys"\nhost = "192.0.2.7"'),
            RemoteConfig,
            "FILE:5: link.host: no such field here; it belongs in [telemanipulator], or in a configuration for "
            "`teletaction operator` or `teletaction observe`",
        ),
        (
            f"{OPERATOR}[rendering.link]\n",
            OperatorConfig,
            "FILE:18: rendering.link: no such table here; it belongs at [link]",
        ),
        (
            f"{OPERATOR}max_ages_s = 0.1\n",
            OperatorConfig,
            "FILE:18: rendering.max_ages_s: no such field here; did you mean link.max_age_s?",
        ),
        (f"colour = 1\n{OPERATOR}", OperatorConfig, "FILE:1: colour: no such field"),
        (
            REMOTE.replace('[link]\nkeys = "keys"\n', "").replace("[texture]", "link = 3\n[texture]"),
            RemoteConfig,
            "FILE:4: link: must be a table: [link]",
        ),
        (
            REMOTE.replace("[texture]\nindex", "[texture]\nindx"),
            RemoteConfig,
            "FILE:7: texture.indx: Input should be 'thumb', 'index', 'middle', 'ring' or 'little'",
        ),
    ],
)
def test_a_misplaced_name_gets_its_place(text: str, model: type[BaseModel], expected: str, tmp_path: Path) -> None:
    assert problem_of(tmp_path / "site.toml", text, model) == expected


@pytest.mark.parametrize(
    ("text", "model", "command"),
    [(REMOTE, OperatorConfig, "remote"), (OPERATOR, ObserverConfig, "operator"), (OPERATOR, ConsoleConfig, "operator")],
)
def test_a_file_of_another_command_is_recognised(
    text: str, model: type[BaseModel], command: str, tmp_path: Path
) -> None:
    expected = f"FILE: a configuration for `teletaction {command}`, not for this command"
    assert problem_of(tmp_path / "site.toml", text, model) == expected


def test_the_file_of_a_site_is_recognised_although_a_table_is_misspelt(tmp_path: Path) -> None:
    path = tmp_path / "site.toml"
    path.write_text(OPERATOR.replace("[tacttip]", "[tactip]"), "utf-8")
    with pytest.raises(ConfigProblem, match="tactip: no such table; did you mean tacttip"):
        load_site(path)


def test_a_long_name_is_cut(tmp_path: Path) -> None:
    said = problem_of(tmp_path / "site.toml", f"[{'a' * 5000}.link]\n", RemoteConfig)
    assert f"write [link] instead of [{'a' * 60}... (5000 characters).link]" in said
    assert len(said) < 2000
