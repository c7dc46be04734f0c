"""What a machine has left for a session."""

from common.runtime.machine import ProcessorTime


def test_shares_of_the_processors_are_what_passed_between_two_looks() -> None:
    assert ProcessorTime(150, 10, 300).shares(ProcessorTime(100, 0, 200)) == {"idle": 0.5, "stolen": 0.1}
    now = ProcessorTime.now()
    assert 0 <= now.idle <= now.total
