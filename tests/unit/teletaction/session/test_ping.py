"""The bare ping counts a late answer once, and not for a later packet."""

import os
import signal

import zmq

from teletaction.session.ping import BarePing


def test_a_late_answer_is_not_that_of_a_later_packet() -> None:
    with BarePing() as ping:
        ping.once()
        pid = ping._process.pid
        assert pid is not None
        ping._socket.setsockopt(zmq.RCVTIMEO, 50)
        os.kill(pid, signal.SIGSTOP)
        try:
            ping.once()
        finally:
            os.kill(pid, signal.SIGCONT)
        ping._socket.setsockopt(zmq.RCVTIMEO, 5000)
        ping.once()
        assert ping.round_trips_s[1] == 2.0
        assert ping._socket.poll(200) == 0, "every answer was taken for its own packet"
