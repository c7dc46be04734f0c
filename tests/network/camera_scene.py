"""A simulated network camera above a moving hand, until its input ends.

camera_scene.py PORT WIDTH HEIGHT RATE_HZ
"""

import math
import select
import sys
from contextlib import closing

import numpy as np

from common.config.simulation_models import SimCameraConfig
from common.fingers import FINGERS
from common.scenes.scene import load_scene
from sim_sensors.physics.camera_view import CameraView
from sim_sensors.ports.camera_server import CameraServer
from sim_sensors.ports.select_loop import SelectLoop


def main(port: int, width: int, height: int, rate_hz: int) -> None:
    """Serve until the input ends."""
    view = CameraView(load_scene("materials"), FINGERS, width, height)

    def draw(now_s: float) -> bytes:
        """Draw the hand on its way, which touches in every other second."""
        force_n = np.full(5, 2.0 if int(now_s) % 2 else 0.0)
        return view.draw(now_s, 0.2 * math.sin(now_s), 0.05 * math.sin(3.0 * now_s), force_n)

    sockets = SelectLoop()
    config = SimCameraConfig(port=f"tcp:127.0.0.1:{port}", width=width, height=height, rate_hz=rate_hz)
    with closing(CameraServer(config, sockets, draw, sockets.now())) as server:
        print("bound", flush=True)
        while not select.select([sys.stdin], [], [], 0.0)[0]:
            sockets.serve(0.002)
            server.pump(sockets.now())


if __name__ == "__main__":
    main(*(int(word) for word in sys.argv[1:]))
