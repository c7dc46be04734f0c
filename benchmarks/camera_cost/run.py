"""Cost of encoding the camera's picture: bit rate, and processor time in reference steps, by size and rate.

`python -m benchmarks.camera_cost.run` prints a table. The pictures are those of the simulated camera over a moving
hand. The time of reference steps and pictures is measured in turns, in one thread.
"""

import math
from functools import partial
from typing import NamedTuple

import av
import numpy as np

from benchmarks.runtime_cost.measure import timed
from common.fingers import FINGERS
from common.runtime.reference_step import reference_step
from common.scenes.scene import load_scene
from remote_site.camera.video_encoder import VideoEncoder
from sim_sensors.physics.camera_view import CameraView

FORMS = ((640, 360, 15, 400_000), (640, 360, 15, 40_000), (1280, 720, 25, 1_500_000))
"""Width and height (pixels), pictures a second, and bit rate at most (bit/s)."""
SECONDS = 10.0


class Cost(NamedTuple):
    """Cost of a form of pictures.

    Attributes:
        kbit_s: bit rate, kbit/s.
        steps: reference steps a picture, median.
        core: share of a processor.
    """

    kbit_s: float
    steps: float
    core: float


def cost(width: int, height: int, rate_hz: int, bit_s: int) -> Cost:
    """Encode the simulated camera's pictures for SECONDS."""
    view = CameraView(load_scene("materials"), FINGERS, width, height)
    encoder = VideoEncoder(width, height, rate_hz, bit_s)
    pictures_ns, steps_ns, size = [], [], 0

    def encode(time_s: float, frame: av.VideoFrame) -> None:
        nonlocal size
        encoded = encoder.encode(frame, round(time_s * 1e9), key=False)
        size += 0 if encoded is None else len(encoded.data)

    for number in range(round(SECONDS * rate_hz)):
        time_s = 1.0 + number / rate_hz
        planes = view.draw(time_s, 0.2 * math.sin(time_s), 0.0, np.full(5, float(int(time_s) % 2)))
        frame = av.VideoFrame.from_ndarray(
            np.frombuffer(planes, np.uint8).reshape(height * 3 // 2, width), format="yuv420p"
        )
        pictures_ns.append(timed(partial(encode, time_s, frame)))
        steps_ns.append(timed(reference_step))
    steps = float(np.median(pictures_ns) / np.median(steps_ns))
    return Cost(8e-3 * size / SECONDS, steps, 1e-9 * float(np.mean(pictures_ns)) * rate_hz)


if __name__ == "__main__":
    print("| size | pictures/s | at most, kbit/s | kbit/s | reference steps a picture | processors |\n|" + "---|" * 6)
    for form in FORMS:
        found = cost(*form)
        print(
            f"| {form[0]} x {form[1]} | {form[2]} | {form[3] * 1e-3:.0f} | {found.kbit_s:.0f} | {found.steps:.1f} | "
            f"{found.core:.3f} |"
        )
