"""Compares the clocks of both ends of a stream beside the session, and dates what the far end sends on this one's."""

from common.link.clock_offset import ClockOffset


class StreamClock:
    """Offset of the far end's clock. Pure: times are arguments, ns.

    Attributes:
        own: offset that was measured on the stream itself.
        site: offset of the remote site's clock and its uncertainty, ns; None while it is unknown, or where the far end
            is not at the remote site.
    """

    def __init__(self) -> None:
        self.own = ClockOffset()
        self.site: tuple[int, int] | None = None

    def compare(self, sent_ns: int, heard_ns: int, answered_ns: int, now_ns: int, newest_ns: int) -> None:
        """Take the four times of a round trip; `sent_ns` is 0 where the far end has heard nothing yet.

        Args:
            sent_ns: when this end sent its packet.
            heard_ns, answered_ns: when the far end heard it, and sent its answer, on the far clock.
            now_ns: when the answer was read.
            newest_ns: when this end sent its newest packet.

        Raises:
            ValueError: the times run backwards, or the packet was never sent.
        """
        if sent_ns > newest_ns:
            raise ValueError("it answers a packet that was not sent")
        if sent_ns:
            self.own.add(sent_ns, heard_ns, answered_ns, now_ns)

    @property
    def dating(self) -> tuple[int, int] | None:
        """Offset that dates what the far end sends, and its uncertainty, ns; None while it is unknown.

        A process on the site's host has the site's clock. What it sends is then dated as touch is, so that an error of
        the offset, which may be half a round trip, is the same for both. Another clock contradicts that offset.
        """
        own = self.own
        if own.uncertainty_ns is None:
            return None
        if self.site is not None:
            offset_ns, uncertainty_ns = self.site
            if abs(offset_ns - own.offset_ns) <= uncertainty_ns + own.uncertainty_ns:
                return self.site
        return own.offset_ns, own.uncertainty_ns
