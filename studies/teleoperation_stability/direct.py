"""Direct position-force control: the finger's position crosses the link, and the remote force returns unchanged."""

from studies.teleoperation_stability.cases import Floats


class DirectForce:
    """Architecture without a model and without passivity control."""

    packet_rows = 1

    def __init__(self, start_m: Floats) -> None:
        self._start_m = start_m

    def operator(self, depth_m: Floats, packet: Floats) -> tuple[Floats, Floats]:
        """Show the newest remote force; send the position."""
        return packet[0], (depth_m - self._start_m)[None]

    def remote(
        self, depth_m: Floats, force_n: Floats, servo_n: Floats, packet: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """Go to the newest position; send the force."""
        del depth_m, servo_n
        return self._start_m + packet[0], 0.0 * force_n, force_n[None]
