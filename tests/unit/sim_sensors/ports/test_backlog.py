from sim_sensors.ports.backlog import Backlog


def test_a_backlog_drops_whole_messages_oldest_first_and_never_half_of_one() -> None:
    backlog, written, room = Backlog(10), bytearray(), [3]

    def send(data: bytes) -> int:
        if not room[0]:
            raise BlockingIOError
        taken = data[: room[0]]
        written.extend(taken)
        room[0] -= len(taken)
        return len(taken)

    for message in (b"aaaaa", b"bbbbb", b"ccccc"):
        backlog.pass_on(message, send)
    assert (bytes(written), backlog.dropped) == (b"aaa", 1)
    room[0] = 4
    for message in (b"ddd", b"eeeeee"):
        backlog.pass_on(message, send)
    assert (bytes(written), backlog.dropped) == (b"aaaaacc", 2)
    room[0] = 100
    backlog.pass_on(b"f", send)
    assert bytes(written) == b"aaaaaccccceeeeeef", "behind what waited"
    backlog.pass_on(b"g", send)
    assert bytes(written) == b"aaaaaccccceeeeeefg", "past a backlog that is empty"
