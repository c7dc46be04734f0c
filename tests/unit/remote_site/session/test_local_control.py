"""Requests of a person at the remote site to the wrong process are refused with the right command."""

from typing import cast

import pytest

from common.link.session_state import Refused
from remote_site.session.local_control import answer_desk
from remote_site.session.session_server import SessionServer


@pytest.mark.parametrize("verb", ["mute_voice", "unmute_voice"])
def test_the_microphone_is_muted_at_the_voices_process(verb: str) -> None:
    with pytest.raises(Refused, match=f"teletaction session {verb.replace('_', '-')}$"):
        answer_desk(cast(SessionServer, None), 0, "", verb)
