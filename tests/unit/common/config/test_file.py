import math
import re
from pathlib import Path

import pytest
from pydantic import BaseModel

from common.config.file import ConfigProblem, load_config, to_toml
from common.config.link_models import RendezvousConfig
from common.config.page_models import ConsoleConfig
from common.config.simulation_models import SimOperatorConfig
from common.config.site_models import OperatorConfig, RemoteConfig
from common.fingers import FINGERS

OPERATOR = """\
fingers = ["thumb", "index"]
rate_hz = 500.0

[link]
keys = "keys"
max_age_s = 0.2

[tacttip]
thumb = "/dev/ttyUSB0"
index = "socket://sim:7001"

[exoskeleton]
interface = "socketcand"
host = "sim"

[rendering]
profile = "comfort"
"""
REMOTE = """\
fingers = ["index"]

[link]
keys = "keys"

[texture]
index = "socket://sim:7001"

[thermal_sensors]
index = "socket://sim:7002"

[telemanipulator]
interface = "socketcan"

[calibration]
materials = "materials.json"
surfaces = "/tables/surfaces.json"
"""


def write(folder: Path, text: str) -> Path:
    file = folder / "site.toml"
    file.write_text(text, "utf-8")
    return file


@pytest.mark.parametrize(
    ("old", "new", "line", "says"),
    [
        ('profile = "comfort"', 'profile = "hot"', 17, "rendering.profile: Input should be 'comfort' or 'wide'"),
        ("rate_hz = 500.0", "rate_hz = 50.0", 2, "rate_hz: .*greater than or equal to 100"),
        ("rate_hz = 500.0", "rate_hz = nan", 2, "rate_hz: "),
        ("rate_hz = 500.0", 'rate_hz = "fast"', 2, "rate_hz: .*number"),
        ("max_age_s = 0.2", "max_age_s = 0.6", 6, r"link\.max_age_s: .*less than or equal to 0\.5"),
        ("max_age_s = 0.2", "gap_s = 0.2", 6, r"link\.gap_s: .*less than or equal to 0\.1"),
        ("max_age_s = 0.2", "gap_s = 0.004", None, r"link\.gap_s: gap of 4 ms .* 3 x loop \(rate_hz\) of 2 ms = 6 ms"),
        ("max_age_s = 0.2", "max_age_s = 0.005", None, r"link\.max_age_s: age of 5 ms .* = 6 ms"),
        ("rate_hz = 500.0", 'log = "xml"', 2, "log: Input should be 'text' or 'json'"),
        ("max_age_s = 0.2", 'remote_key = "abc"', 6, r"link\.remote_key: .*at least 40"),
        ("max_age_s = 0.2", "base_port = 65530", 6, r"link\.base_port: .*65529"),
        ("max_age_s = 0.2", "colour = 1", 6, r"link\.colour: no such field$"),
        ('keys = "keys"\n', "", 4, r"link\.keys: Field required"),
        ('interface = "socketcand"', 'interface = "usb"', 13, r"exoskeleton\.interface: Input should be"),
        ('host = "sim"', "port = 0", 14, r"exoskeleton\.port: "),
        ('fingers = ["thumb", "index"]', 'fingers = ["thumb", "toe"]', 1, "fingers"),
        ('fingers = ["thumb", "index"]', "fingers = []", 1, "fingers: .*at least 1"),
        ('"index"]', '"index", "index"]', 1, "fingers: a finger is named twice"),
        (OPERATOR[OPERATOR.index("[tacttip]") :], "", 1, "tacttip: Field required"),
        ('fingers = ["thumb", "index"]', 'fingers = ["thumb"]', None, "tacttip: has addresses for index, thumb"),
        ('index = "socket://sim:7001"', 'index = "/dev/ttyUSB0"', None, "/dev/ttyUSB0 is given to two devices"),
        ('profile = "comfort"', "exoskeleton_damping_n_s_m = inf", 17, r"rendering\.exoskeleton_damping_n_s_m"),
    ],
)
def test_each_kind_of_wrong_input_gives_one_line_with_file_line_and_field(
    tmp_path: Path, old: str, new: str, line: int | None, says: str
) -> None:
    assert old in OPERATOR
    file = write(tmp_path, OPERATOR.replace(old, new))
    with pytest.raises(ConfigProblem) as caught:
        load_config(file, OperatorConfig)
    message = str(caught.value)
    assert "\n" not in message
    assert re.match(rf"{re.escape(str(file))}:\d+: ", message)
    assert re.search(says, message), message
    if line is not None:
        assert f":{line}: " in message, message


def problem_of(path: Path, text: str, model: type[BaseModel] = RemoteConfig) -> str:
    path.write_text(text, "utf-8")
    with pytest.raises(ConfigProblem) as caught:
        load_config(path, model)
    return str(caught.value)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('port = 5640\n[rooms]\nclinic = "clinic.secret"\n12 = 3\n', ":4: rooms.12: "),
        ('port = 5640\n"²" = 1\n[rooms]\nclinic = "clinic.secret"\n', ":2: ²: no such field"),
    ],
)
def test_a_name_of_digits_is_no_number_of_a_table(tmp_path: Path, text: str, says: str) -> None:
    assert says in problem_of(tmp_path / "rendezvous.toml", text, RendezvousConfig)


def test_relative_paths_of_a_table_start_at_the_folder_of_the_file(tmp_path: Path) -> None:
    file = write(tmp_path, '[rooms]\nclinic = "clinic.secret"\nward = "/etc/ward.secret"\n')
    rooms = load_config(file, RendezvousConfig).rooms
    assert rooms == {"clinic": tmp_path / "clinic.secret", "ward": Path("/etc/ward.secret")}


def test_a_duration_without_a_limit_is_left_out_and_not_infinite(tmp_path: Path) -> None:
    text = 'can_port = 5000\nseconds = inf\n[tacttip]\nindex = "pty"\n'
    assert ":2: seconds: Input should be a finite number" in problem_of(tmp_path / "sim.toml", text, SimOperatorConfig)


def test_all_problems_of_a_file_are_named_misspelt_fields_first(tmp_path: Path) -> None:
    path = tmp_path / "site.toml"
    said = problem_of(path, 'rate_hz = 1e9\nrecrod = "x"\nfoo = 1\nmax_age_s = 0.1\n[link]\nbse_port = 3\n')
    for expected in (
        ":2: recrod: no such field; did you mean record?",
        ":3: foo: no such field",
        ":4: max_age_s: no such field here; it belongs in [link]",
        ":6: link.bse_port: no such field; did you mean link.base_port?",
    ):
        assert f"{path}{expected}" in said
    assert re.search(r"; and \d+ more$", said)


def test_a_path_with_backslashes_gets_a_hint(tmp_path: Path) -> None:
    assert "put a path with \\ between single quotes" in problem_of(tmp_path / "site.toml", 'record = "C:\\Data"\n')


def test_a_byte_order_mark_changes_nothing(tmp_path: Path) -> None:
    path, marked = tmp_path / "site.toml", tmp_path / "marked.toml"
    text = "rate_hz = 1e9\n"
    said = problem_of(path, text)
    assert problem_of(marked, "\ufeff" + text) == said.replace(str(path), str(marked))


def test_paths_count_from_the_files_own_folder(tmp_path: Path) -> None:
    config = load_config(write(tmp_path, REMOTE), RemoteConfig)
    assert config.link.keys == tmp_path / "keys"
    assert config.calibration.materials == tmp_path / "materials.json"
    assert config.calibration.surfaces == Path("/tables/surfaces.json")
    assert config.record is None


@pytest.mark.parametrize(("text", "model"), [(OPERATOR, OperatorConfig), (REMOTE, RemoteConfig)])
def test_the_resolved_configuration_reads_back(
    tmp_path: Path, text: str, model: type[OperatorConfig | RemoteConfig]
) -> None:
    config = load_config(write(tmp_path, text), model)
    (tmp_path / "other").mkdir()
    assert load_config(write(tmp_path / "other", to_toml(config)), model) == config


def test_a_configuration_that_would_not_read_back_is_not_written(tmp_path: Path) -> None:
    config = load_config(write(tmp_path, OPERATOR), OperatorConfig)
    with pytest.raises(ValueError, match="not JSON compliant"):
        to_toml(config.model_copy(update={"rate_hz": math.nan}))


def test_texts_of_any_kind_read_back(tmp_path: Path) -> None:
    text = 'scene = "a \\"b\\" \\\\ é \\t\\u007f #x"\nseconds = 1e-7\n[tacttip]\n' + "".join(
        f'{finger} = "pty"\n' for finger in FINGERS
    )
    config = load_config(write(tmp_path, text), SimOperatorConfig)
    assert load_config(write(tmp_path, to_toml(config)), SimOperatorConfig) == config


@pytest.mark.parametrize(("text", "model"), [(OPERATOR, OperatorConfig), (REMOTE, RemoteConfig)])
def test_a_patient_who_does_not_agree_is_not_recorded(
    tmp_path: Path, text: str, model: type[OperatorConfig | RemoteConfig]
) -> None:
    assert load_config(write(tmp_path, text), model).consent is None, "nobody has asked"
    no = f"{text}[consent]\ntouch = false\npain = false\n"
    assert load_config(write(tmp_path, no), model).record is None
    with pytest.raises(ConfigProblem, match=r"consent\.touch is false"):
        load_config(write(tmp_path, f'record = "session.mcap"\n{no}'), model)


def test_the_consoles_picture_is_recorded_only_with_consent(tmp_path: Path) -> None:
    camera, consent = "[camera]\nrecord = true\n", "[consent]\ntouch = true\npain = false\n"
    for answer in ("", consent, f"{consent}picture = false\n"):
        with pytest.raises(ConfigProblem, match="no consent to pictures is noted: ask the patient and note the answer"):
            load_config(write(tmp_path, f'keys = "keys"\n{camera}{answer}'), ConsoleConfig)
    config = load_config(write(tmp_path, f'keys = "keys"\n{camera}{consent}picture = true\n'), ConsoleConfig)
    assert config.consent is not None
    assert (config.consent.picture, config.consent.voice) == (True, False)


def test_a_recording_is_plain_unless_it_is_to_be_encrypted(tmp_path: Path) -> None:
    for text, model in ((OPERATOR, OperatorConfig), (REMOTE, RemoteConfig), ('keys = "keys"\n', ConsoleConfig)):
        assert not load_config(write(tmp_path, text), model).recording.encrypt
        assert load_config(write(tmp_path, f"{text}[recording]\nencrypt = true\n"), model).recording.encrypt


@pytest.mark.parametrize(
    ("text", "model"), [(REMOTE, RemoteConfig), (OPERATOR, OperatorConfig), ('keys = "keys"\n', ConsoleConfig)]
)
def test_a_status_file_does_not_replace_the_recording(tmp_path: Path, text: str, model: type[BaseModel]) -> None:
    load_config(write(tmp_path, f'record = "a.mcap"\nstatus = "a.json"\n{text}'), model)
    with pytest.raises(ConfigProblem, match="record and status name the same file"):
        load_config(write(tmp_path, f'record = "a.mcap"\nstatus = "a.mcap"\n{text}'), model)


@pytest.mark.parametrize("agreed", [False, True])
def test_sound_is_recorded_only_with_consent(tmp_path: Path, agreed: bool) -> None:
    text = (
        f'keys = "keys"\n[voice]\nrecord = true\n[consent]\ntouch = true\npain = true\nvoice = {str(agreed).lower()}\n'
    )
    if agreed:
        assert load_config(write(tmp_path, text), ConsoleConfig).voice is not None
    else:
        with pytest.raises(ConfigProblem, match=r"voice\.record is true, but no consent to sound"):
            load_config(write(tmp_path, text), ConsoleConfig)
