"""Direct position-force control: the finger's position crosses the link, and the remote force returns unchanged."""

from studies.teleoperation_stability.cases import Floats, Measured


class DirectForce:
    """Architecture without a model and without passivity control."""

    packet_rows = 1

    def __init__(self, start_m: Floats) -> None:
        self._start_m = start_m

    def operator(self, depth_m: Floats, packet: Floats) -> tuple[Floats, Floats]:
        """Show the newest remote force; send the position."""
        return packet[0], (depth_m - self._start_m)[None]

    def remote(self, at: Measured, packet: Floats) -> tuple[Floats, Floats, Floats]:
        """Go to the newest position; send the force."""
        return self._start_m + packet[0], 0.0 * at.force_n, at.force_n[None]
