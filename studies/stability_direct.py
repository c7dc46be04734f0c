"""Direct position-force: the finger's place crosses the network, and the remote force comes back as it is."""

from studies.stability_cases import Floats


class DirectForce:
    """No model and no guard: what a first attempt does."""

    packet_rows = 1

    def __init__(self, start_m: Floats) -> None:
        self._start_m = start_m

    def operator(self, depth_m: Floats, packet: Floats) -> tuple[Floats, Floats]:
        """Show the newest remote force; send the place."""
        return packet[0], (depth_m - self._start_m)[None]

    def remote(
        self, depth_m: Floats, force_n: Floats, servo_n: Floats, packet: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """Go to the newest place; send the force."""
        del depth_m, servo_n
        return self._start_m + packet[0], 0.0 * force_n, force_n[None]
