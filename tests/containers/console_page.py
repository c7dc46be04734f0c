"""The page of a console in a container, which needs a token."""

import ssl
from urllib.error import HTTPError
from urllib.request import Request, urlopen

import pytest
from websockets.exceptions import ConnectionClosed, InvalidMessage

from tests.system.page import opened


def assert_closed_to_strangers(address: str, trust: ssl.SSLContext) -> None:
    """Without a token, or with a wrong one, there is no page and no session to see.

    The connection is ended, mostly behind an answer; once in containers there was none before its end.
    """
    with pytest.raises(HTTPError, match="401"):
        urlopen(address + "/page/main.js", context=trust)
    for headers in ({}, {"Cookie": "teletaction=" + "0" * 64}):
        with (
            pytest.raises((ConnectionClosed, InvalidMessage)),
            opened(address, ssl=trust, **headers) as stranger,
        ):
            stranger.until(lambda page=stranger: page.state, "nothing")


def assert_used_by_its_tokens(address: str, trust: ssl.SSLContext, tokens: dict[str, str]) -> None:
    """One token acts: an examination with a finding, and its report; the other sees all of it and may do nothing."""
    with (
        opened(address, ssl=trust, Cookie=f"teletaction={tokens['act']}") as page,
        opened(address, ssl=trust, Cookie=f"teletaction={tokens['observe']}") as observer,
    ):
        page.until(lambda: page.state and page.state["session"]["state"] == "engaged", "an engaged session")
        page.until(lambda: page.picture is not None and len(page.picture.bins) > 0, "a picture")
        assert page.state["meaning"].startswith("Calibrated ")
        assert page.ask("begin", pseudonym="P-0417")["ok"]
        assert page.ask("finding", finger="index", kind="warm")["details"]["saved"]
        observer.until(lambda: observer.state and observer.state["findings"], "the finding")
        assert not observer.ask("estop")["ok"]
        # A machine that builds and starts all of this may let a request wait too long: a person asks again.
        page.until(lambda: page.ask("end")["ok"], "the end")
        page.until(lambda: (page.state["session"]["saved"] or {}).get("report"), "the report", 120.0)
        assert page.ask("sound", answer="refused")["ok"]
        page.until(lambda: page.ask("engage")["ok"], "engaging again")
        report = Request(address + page.state["session"]["saved"]["report"])
    report.add_header("Cookie", f"teletaction={tokens['observe']}")
    assert "P-0417" in urlopen(report, context=trust).read().decode()


def read_tokens(lines: str) -> dict[str, str]:
    """Tokens by what they are for, from lines `act: ADDRESS?token=TOKEN`."""
    return {role: address.split("token=")[1] for role, address in (line.split(": ") for line in lines.splitlines())}
