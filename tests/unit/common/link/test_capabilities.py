import pytest

from common.link.capabilities import capabilities, disagreement

OURS = capabilities(("index", "middle"), 500.0, calibration="abc")


@pytest.mark.parametrize(
    ("theirs", "words"),
    [
        ({}, "laid out differently"),
        (OURS | {"layout": "0"}, "laid out differently"),
        (OURS | {"fingers": ["index"]}, "has fingers"),
        (OURS | {"fingers": None}, "has fingers"),
        (OURS | {"rate_hz": 20.0}, "far side"),
        (OURS | {"rate_hz": "fast"}, "far side"),
        (OURS | {"rate_hz": float("nan")}, "far side"),
    ],
)
def test_different_capabilities_are_reported(theirs: dict[str, object], words: str) -> None:
    assert disagreement(OURS, capabilities(("index", "middle"), 100.0)) == ""
    assert words in disagreement(OURS, theirs)
