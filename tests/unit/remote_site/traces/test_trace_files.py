"""Trace files: every error names file, line and column."""

import os
import threading
from contextlib import nullcontext

import numpy as np
import pytest

from remote_site.traces import trace_files
from remote_site.traces.trace_files import StrokeTrace, ThermalTrace, TraceFile, read_labels, read_stroke, read_thermal

GOOD = "time_s,sensor_c,force_n,note\n0.00,30.0,0.0,a\n0.01,30.0,0.5,b\n0.06,29.9,0.5,c\n"


def trace(tmp_path, text):
    path = tmp_path / "t.csv"
    path.write_text(text)
    return path


def test_extra_columns_may_hold_anything(tmp_path):
    read = read_thermal(trace(tmp_path, GOOD))
    assert read.contact() == 1
    assert read.ambient_c is None


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("sensor_c", "plate", "line 1: column sensor_c is missing"),
        ("29.9", "warm", "line 4: column sensor_c: not a finite number: 'warm'"),
        ("29.9", "", "line 4: column sensor_c: missing value"),
        ("29.9", "nan", "line 4: column sensor_c: not a finite number"),
        ("0.06", "0.01", "line 4: column time_s does not ascend: 0.01 follows 0.01; write more decimals"),
        (",c\n", "\n", "line 4: 3 values under 4 columns$"),
        ("29.9", "29,9", "line 4: 5 values under 4 columns; write decimal points, not commas"),
        ("sensor_c", "Sensor_C", "line 1: column sensor_c is missing; rename Sensor_C"),
        ("time_s,", "# made by a robot\ntime_s,", "line 1: is a comment; the first line must name the columns"),
        ("note", "force_n", "named twice"),
        ("0.5,b\n0.06,29.9", '0.5,"b\nb"\n0.06,warm', "line 5: column sensor_c: not a finite number: 'warm'"),
    ],
)
def test_errors_name_file_line_and_column(tmp_path, old, new, message):
    path = trace(tmp_path, GOOD.replace(old, new))
    with pytest.raises(ValueError, match=message) as error:
        read_thermal(path)
    assert str(error.value).startswith(str(path))


@pytest.mark.parametrize("cell", ['"5 mm', '"5" mm'])
def test_a_quotation_mark_hides_no_lines(tmp_path, cell):
    """All lines after it would be one cell of a column that nobody reads."""
    with pytest.raises(
        ValueError, match=r"not a CSV file after line 2: .*; look for a quotation mark without its pair"
    ):
        read_thermal(trace(tmp_path, GOOD.replace(",b\n", f",{cell}\n")))


def test_messages_quote_little_of_a_file_of_another_kind(tmp_path):
    for text in ("\0" * 10_000, "{" * 10_000 + "\n1\n", GOOD.replace("29.9", "9" * 5000 + "x")):
        with pytest.raises(ValueError, match="column") as error:
            read_thermal(trace(tmp_path, text))
        assert len(str(error.value)) < 600


@pytest.mark.parametrize("separator", [";", "\t", " "])
def test_another_separator_is_named(tmp_path, separator):
    text = GOOD.replace(",", separator).replace(".", ",")
    with pytest.raises(ValueError, match="line 1: columns are separated by") as error:
        read_thermal(trace(tmp_path, text))
    assert repr(separator) in str(error.value)
    assert "commas between columns and decimal points" in str(error.value)


def test_a_file_that_is_too_long_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(trace_files, "MOST_BYTES", len(GOOD))
    assert len(read_thermal(trace(tmp_path, GOOD)).time_s) == 3
    with pytest.raises(ValueError, match=r"t\.csv: longer than 0 MiB; split it into several files"):
        read_thermal(trace(tmp_path, GOOD + "0.07,29.8,0.5,d\n"))


@pytest.mark.parametrize("more", ["0.07,29.8,0.5,d\n", "," * 10_000])
def test_a_pipe_is_read_up_to_the_limit(tmp_path, monkeypatch, more):
    monkeypatch.setattr(trace_files, "MOST_BYTES", len(GOOD))
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    for text, is_read in ((GOOD, True), (GOOD + more, False)):
        writer = threading.Thread(target=pipe.write_text, args=(text,))
        writer.start()
        with nullcontext() if is_read else pytest.raises(ValueError, match="pipe: longer than 0 MiB"):
            assert len(read_thermal(pipe).time_s) == 3
        writer.join()


def test_a_line_written_twice_is_one_sample(tmp_path):
    read = read_thermal(trace(tmp_path, GOOD + "0.06,29.9,0.5,c\n"))
    assert read.time_s.tolist() == [0.0, 0.01, 0.06]
    with pytest.raises(ValueError, match="line 5: column time_s does not ascend"):
        read_thermal(trace(tmp_path, GOOD + "0.06,29.8,0.5,c\n"))


def test_equal_steps_without_a_time_are_two_samples(tmp_path):
    file = TraceFile(
        trace(tmp_path, "press,time_s,depth_mm,force_n\n1,,0.5,0.2\n1,,0.5,0.2\n2,0.1,0.5,0.2\n2,0.1,0.5,0.2\n")
    )
    assert file.numbers("press").tolist() == [1, 1, 2]


def test_a_short_touch_is_no_contact(tmp_path):
    text = "time_s,sensor_c,force_n\n" + "".join(f"{0.01 * k:.2f},30,{0.5 if 3 <= k < 6 else 0}\n" for k in range(20))
    assert read_thermal(trace(tmp_path, text)).contact() is None


@pytest.mark.parametrize("step_s", [0.01, 0.04, 0.1, 0.5])
def test_a_single_sample_of_force_is_no_contact_at_any_rate(step_s):
    time_s = step_s * np.arange(20)
    spike = np.where(np.arange(20) == 3, 2.0, 0.0)
    assert ThermalTrace(time_s, np.full(20, 30.0), spike).contact() is None
    pressed = np.where(np.arange(20) >= 10, 2.0, spike)
    assert ThermalTrace(time_s, np.full(20, 30.0), pressed).contact() == 10


def test_signals_by_name_best_and_mean(tmp_path):
    path = trace(tmp_path, "time_s,a,b,force_n\n0,1,3,0\n0.1,2,4,0\n")
    assert read_stroke(path, "b").signals[:, 0].tolist() == [3, 4]
    assert read_stroke(path, "best").signal_names == ("a", "b")
    assert read_stroke(path, "mean").signals[:, 0].tolist() == [2, 3]
    with pytest.raises(ValueError, match="pressure_v is missing"):
        read_stroke(path)


def test_labels_must_name_files_that_exist(tmp_path):
    (tmp_path / "labels.csv").write_text("file,material\ngone.csv,pvc\n")
    with pytest.raises(ValueError, match="line 2: column file"):
        read_labels(tmp_path, "material")


@pytest.mark.parametrize("word", ["x" * 41, "pvc\x1b[31m", '"pvc\nhard"', "\u202epvc"])
def test_a_label_that_no_packet_or_line_can_carry_is_refused(tmp_path, word):
    (tmp_path / "a.csv").write_text("")
    (tmp_path / "labels.csv").write_text(f"file,object_c,material\na.csv,20,{word}\n")
    with pytest.raises(ValueError, match=r"is no label: use at most 40 printable characters") as error:
        read_labels(tmp_path, "material", "object_c")
    assert f"{error.value}".isprintable()


@pytest.mark.parametrize("again", ["a.csv", "./a.csv", "../{folder}/a.csv"])
def test_labels_name_a_file_once(tmp_path, again):
    (tmp_path / "a.csv").write_text("")
    again = again.format(folder=tmp_path.name)
    (tmp_path / "labels.csv").write_text(f"file,material\na.csv,pvc\n{again},pine\n")
    with pytest.raises(ValueError, match=r"labels.csv: column file: a.csv is listed twice"):
        read_labels(tmp_path, "material")


@pytest.mark.parametrize("begin_s", [0.0, 0.5, 1.234])
def test_a_stroke_of_1000_samples_a_second_has_that_rate(begin_s):
    """Rounded times must not make it a slow stroke."""
    rates = {StrokeTrace((begin_s + np.arange(n) / 1000).round(3), np.zeros(n)).rate_hz for n in range(1000, 1200)}
    assert rates == {1000.0}
