"""The idle share of a machine."""

from common.runtime.machine import ProcessorTime


def test_shares_of_the_processors_cover_the_time_between_two_readings() -> None:
    assert ProcessorTime(150, 10, 300).shares(ProcessorTime(100, 0, 200)) == {"idle": 0.5, "stolen": 0.1}
    now = ProcessorTime.now()
    assert 0 <= now.idle <= now.total
