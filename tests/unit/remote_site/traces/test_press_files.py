"""Files of presses: steps need no times, and every error names file, line and column."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from remote_site.traces.press_files import Press, read_presses

GOOD = (
    "press,depth_mm,force_n,time_s,x_mm,y_mm,z_mm,note\n"
    "3,0.0,0.05,,1,2,3.0,a\n3,0.5,0.30,,1,2,2.5,b\n"
    "1,0.0,0.06,0.0,4,5,3.0,c\n1,1.0,0.80,1.0,4,5,2.0,d\n"
)
CONTACTS = "press,x_mm,y_mm,z_mm,nx,ny,nz,status\n1,4,5,3.1,0,0,2,limit\n3,,,,0,0,0,ok\n7,9,9,9,0,0,0,fail\n"


def write(tmp_path, text=GOOD, contacts=None):
    path = tmp_path / "presses.csv"
    path.write_text(text)
    if contacts is not None:
        (tmp_path / "contacts.csv").write_text(contacts)
    return path


def test_presses_in_the_order_of_the_file(tmp_path):
    stepped, timed = read_presses(write(tmp_path))
    assert [stepped.press, timed.press] == [3, 1]
    assert stepped.time_s is None
    assert stepped.contact is None
    assert stepped.force_n.tolist() == [0.05, 0.30]
    assert timed.time_s.tolist() == [0.0, 1.0]
    assert timed.at_mm.tolist() == [4.0, 5.0, 3.0]


def test_arrays_of_a_press_are_checked():
    assert Press(0, [0, 1], [0, 0.5]).depth_mm.dtype == np.float64
    with pytest.raises(ValueError, match="press 4: column force_n: sample 1 is not a finite number"):
        Press(4, np.array([0.0, 1.0]), np.array([0.0, np.nan]))
    with pytest.raises(ValueError, match=r"press 4: column force_n: shape \(1,\) beside 2 depths"):
        Press(4, np.array([0.0, 1.0]), np.array([0.0]))
    with pytest.raises(ValueError, match=r"press 4: column place_mm: shape \(2, 2\) beside 2 depths"):
        Press(4, np.zeros(2), np.zeros(2), place_mm=np.zeros((2, 2)))


def test_lines_of_several_presses_may_alternate(tmp_path):
    text = "press,depth_mm,force_n\n0,0,0\n1,0,0.1\n0,1,0.5\n1,1,0.6\n"
    assert [press.force_n.tolist() for press in read_presses(write(tmp_path, text))] == [[0.0, 0.5], [0.1, 0.6]]


def test_contacts_beside_the_file(tmp_path):
    first, second, absent = read_presses(write(tmp_path, contacts=CONTACTS))
    assert first.contact.status == "ok"
    assert first.contact.normal is None
    assert first.at_mm.tolist() == [1.0, 2.0, 3.0]
    assert second.contact.status == "limit"
    assert second.contact.normal.tolist() == [0.0, 0.0, 1.0]
    assert second.at_mm.tolist() == [4.0, 5.0, 3.1]
    assert (absent.press, absent.contact.status, len(absent.depth_mm)) == (7, "fail", 0)
    assert np.array_equal(absent.at_mm, [9.0, 9.0, 9.0])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("depth_mm", "depth", "line 1: column depth_mm is missing"),
        (",y_mm", ",yy", "line 1: column y_mm is missing"),
        ("1,1.0,0.80", "1,1.0,", "line 5: column force_n: missing value"),
        ("1,1.0,0.80", "1,deep,0.80", "line 5: column depth_mm: not a finite number: 'deep'"),
        ("1,1.0,0.80", "1.5,1.0,0.80", "line 5: column press: not a whole number from 0: '1.5'"),
        ("1,1.0,0.80", "-1,1.0,0.80", "line 5: column press: not a whole number from 0: '-1'"),
        ("0.80,1.0", "0.80,0.0", "line 5: column time_s: does not ascend within the press"),
        ("0.80,1.0", "0.80,", "line 5: column time_s: missing value beside other times"),
        ("0.80", "80", "column force_n: 80 N is no force of a finger"),
        ("1,1.0,0.80", "1,1000,0.80", "column depth_mm: at most 1000 mm deep is no press: it looks like um"),
    ],
)
def test_errors_name_file_line_and_column(tmp_path, old, new, message):
    path = write(tmp_path, GOOD.replace(old, new, 1))
    with pytest.raises(ValueError, match=message) as error:
        read_presses(path)
    assert str(error.value).startswith(str(path))


def test_depths_in_metres_are_refused(tmp_path):
    with pytest.raises(ValueError, match=r"it looks like m; multiply by 1000"):
        read_presses(write(tmp_path, "press,depth_mm,force_n\n0,0,0\n0,0.002,0.5\n"))
    with pytest.raises(ValueError, match=r"column depth_mm: all depths are 0$"):
        read_presses(write(tmp_path, "press,depth_mm,force_n\n0,0,0\n0,0,0.5\n"))


def test_a_file_without_data_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"presses\.csv: no line of data"):
        read_presses(write(tmp_path, "press,depth_mm,force_n\n"))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("limit", "late", "line 2: column status: 'late' is none of ok, limit, fail"),
        ("3,,,", "1,,,", "line 3: column press: press 1 is listed twice"),
        ("4,5,3.1", "4,5,up", "line 2: column z_mm: not a finite number: 'up'"),
    ],
)
def test_errors_of_contacts_name_file_line_and_column(tmp_path, old, new, message):
    path = write(tmp_path, contacts=CONTACTS.replace(old, new, 1))
    with pytest.raises(ValueError, match=message) as error:
        read_presses(path)
    assert str(error.value).startswith(str(path.with_name("contacts.csv")))


LINES = st.lists(
    st.lists(st.sampled_from(("0", "1", "2.5", "-3", "nan", "1e999", "", "ok", '"', "\0", "é")), min_size=1, max_size=4)
)


@pytest.mark.long
@given(LINES, LINES)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=100)
def test_a_strange_file_is_read_or_refused_in_one_line(tmp_path, rows, contacts):
    texts = ["\n".join(",".join(cells) for cells in each) for each in (rows, contacts)]
    path = write(tmp_path, "press,depth_mm,force_n,time_s\n" + texts[0], "press,status,x_mm,y_mm,z_mm\n" + texts[1])
    problem = f"{tmp_path}: none"
    try:
        read_presses(path)
    except ValueError as error:
        problem = str(error)
    assert problem.startswith(str(tmp_path))
    assert "\n" not in problem
