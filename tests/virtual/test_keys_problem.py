"""The status file of a remote site names the damage of its list of trusted keys."""

from tests.virtual.session import VirtualSession


def test_the_status_file_names_a_damaged_list_until_it_is_repaired(session: VirtualSession) -> None:
    link = session.remote._link
    assert session.remote.figures()["keys"] == ""
    link.keys_problem = "/keys/trusted:2: not UTF-8; remove this line"  # type: ignore[misc]
    assert session.remote.figures()["keys"] == "/keys/trusted:2: not UTF-8; remove this line"
