"""The patient's consent that the remote site has noted reaches the console, over the link of a whole session."""

from pathlib import Path

import msgpack
import pytest

from operator_site.console.model import Console
from teletaction.session.demo_files import DemoOptions, prepare
from teletaction.testbed.testbed import Extras, SessionConfigs, Testbed

NOTED = """
[consent]
touch = true
pain = true
picture = false
"""


@pytest.mark.parametrize(("noted", "agreed"), [("", None), (NOTED, ("touch", "pain"))])
def test_the_console_knows_the_remote_sites_answer(tmp_path: Path, noted: str, agreed: tuple[str, ...] | None) -> None:
    files = prepare(DemoOptions(fingers=1, seconds=None), tmp_path)
    with files["remote"].open("a", encoding="utf-8") as file:
        file.write(noted)
    session, console = Testbed(SessionConfigs.read(files), 0, Extras()), Console(noted=("touch", "picture"))
    console.take("operator/figures", 0, msgpack.packb(session.operator.figures()))
    assert not console.consent.allows("touch"), "the remote site has not answered yet"
    session.run_coarsely(2.0)
    console.take("operator/figures", 1, msgpack.packb(session.operator.figures()))
    assert console.consent.there == agreed
    assert console.consent.allows("touch")
    assert console.consent.allows("picture") == (agreed is None)
    session.close()
