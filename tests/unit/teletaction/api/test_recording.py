"""The Python interface: a simulated session, its streams, and errors that list the choices."""

import subprocess
import sys
from typing import Any

import numpy as np
import pytest

import teletaction as tt
from teletaction.export.named_recording import NamedRecording
from tests.places import ROOT

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> tt.Recording:
    return tt.simulate(seconds=2.0, fingers=2, seed=3, out=tmp_path_factory.mktemp("session"))


def test_a_stream_has_columns_with_units_and_times(recording: tt.Recording) -> None:
    touch = recording.touch
    assert len(touch) == len(touch.time_s) == len(touch.array("index.object_c")) > 100
    assert touch.unit("index.object_c") == "C"
    assert touch["index"].unit("stiffness_n_m") == "N/m"
    np.testing.assert_array_equal(touch["index"].array("contact_force_n"), touch.array("index.contact_force_n"))
    assert (np.diff(touch.wall_ns) >= 0).all()
    assert touch.time_s[0] >= 0.0


def test_the_same_seed_gives_the_same_session(recording: tt.Recording) -> None:
    again = tt.simulate(seconds=2.0, fingers=2, seed=3)
    for column in ("middle.force_n", "middle.motor_rpm", "middle.plate_set_c"):
        np.testing.assert_array_equal(again.rendered.array(column), recording.rendered.array(column))


def test_all_streams_are_read_with_one_check_of_the_file(
    recording: tt.Recording, monkeypatch: pytest.MonkeyPatch
) -> None:
    checked = []

    def open_counted(*arguments: Any) -> NamedRecording:
        checked.append(arguments)
        return NamedRecording(*arguments)

    again = tt.Recording(recording.path)
    monkeypatch.setattr("teletaction.api.recording.NamedRecording", open_counted)
    again.read()
    assert len(again.touch) == len(recording.touch)
    assert len(checked) == 1


def test_a_wrong_name_lists_the_choices(recording: tt.Recording) -> None:
    with pytest.raises(KeyError, match=r"there are .*operator/rendered"):
        recording["operator/rendering"]
    with pytest.raises(KeyError, match=r"index\.object_c"):
        recording.touch.array("object_c")
    with pytest.raises(KeyError, match="thumb, index"):
        recording.touch["pinky"]


@pytest.mark.parametrize("seconds", [0.0, -1.0, float("nan"), 1e6])
def test_a_duration_out_of_range_is_refused(seconds: float) -> None:
    with pytest.raises(ValueError, match="seconds"):
        tt.simulate(seconds=seconds)


@pytest.mark.parametrize("seed", [-1, 1.5])
def test_a_seed_that_is_none_is_refused_in_one_line(seed: Any) -> None:
    with pytest.raises(ValueError, match=f"^seed must be a whole number of 0 or more, not {seed}$"):
        tt.simulate(seconds=0.1, seed=seed)


def test_the_package_lists_its_names_and_loads_nothing_before() -> None:
    assert all(hasattr(tt, name) for name in tt.__all__)
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        tt.nothing  # noqa: B018 - the access is the test


def test_reading_recordings_loads_neither_rendering_nor_devices() -> None:
    loaded = "import sys, teletaction.api.recording; print(*{'scipy', 'can', 'zmq', 'pydantic'} & sys.modules.keys())"
    run = subprocess.run([sys.executable, "-c", loaded], cwd=ROOT, capture_output=True, text=True, check=True)
    assert run.stdout == "\n"
