"""Cost of the camera's picture by size and rate: bit rate, and processor time of encoding and of still pictures.

`python -m benchmarks.camera_cost.run` prints two tables. The pictures are those of the simulated camera over a moving
hand. The time of reference steps and pictures is measured in turns, in one thread.
"""

import math
import time
from functools import partial

import av
import numpy as np

from benchmarks.runtime_cost.measure import timed
from common.fingers import FINGERS
from common.runtime.reference_step import reference_step
from common.scenes.scene import load_scene
from operator_site.console.camera.camera_picture import Picture
from operator_site.console.camera.still_picture import PictureDecoder, jpeg_of
from operator_site.console.camera.stills import STILL_S
from remote_site.camera.video_encoder import VideoEncoder
from sim_sensors.physics.camera_view import CameraView

FORMS = ((640, 360, 15, 400_000), (640, 360, 15, 40_000), (1280, 720, 25, 1_500_000))
"""Width and height (pixels), pictures a second, and bit rate at most (bit/s)."""
SECONDS = 10.0


def cost(width: int, height: int, rate_hz: int, bit_s: int) -> tuple[str, list[Picture]]:
    """Encode the simulated camera's pictures for SECONDS; return the cells of their cost, and the encoded pictures.

    The cells are bit rate, kbit/s, reference steps a picture (median), and share of a processor.
    """
    view = CameraView(load_scene("materials"), FINGERS, width, height)
    encoder = VideoEncoder(width, height, rate_hz, bit_s)
    pictures_ns, steps_ns = [], []
    coded: list[Picture] = []

    def encode(time_s: float, frame: av.VideoFrame) -> None:
        encoded = encoder.encode(frame, round(time_s * 1e9), key=False)
        if encoded is not None:
            coded.append(Picture(len(coded) + 1, time_s, 0.0, encoded.is_key, width, height, encoded.data))

    for number in range(round(SECONDS * rate_hz)):
        time_s = 1.0 + number / rate_hz
        planes = view.draw(time_s, 0.2 * math.sin(time_s), 0.0, np.full(5, float(int(time_s) % 2)))
        frame = av.VideoFrame.from_ndarray(
            np.frombuffer(planes, np.uint8).reshape(height * 3 // 2, width), format="yuv420p"
        )
        pictures_ns.append(timed(partial(encode, time_s, frame)))
        steps_ns.append(timed(reference_step))
    steps = float(np.median(pictures_ns) / np.median(steps_ns))
    size = sum(len(picture.content) for picture in coded)
    core = 1e-9 * float(np.mean(pictures_ns)) * rate_hz
    return f"{8e-3 * size / SECONDS:.0f} | {steps:.1f} | {core:.3f}", coded


def still_cost(coded: list[Picture]) -> str:
    """Decode SECONDS of pictures, and write a still picture of one in STILL_S, as the console's process does.

    Return the cells of the cost: mean of decoding a picture and median of writing a still one, ms, median size of a
    still picture, kB, and share of a processor.
    """
    decoder, batch = PictureDecoder(), max(1, round(len(coded) * STILL_S / SECONDS))
    decode_ns, still_ns, sizes = [], [], []
    for first in range(0, len(coded), batch):
        began_ns = time.process_time_ns()
        frame = decoder.decode(coded[first : first + batch])
        decode_ns.append(time.process_time_ns() - began_ns)
        began_ns = time.process_time_ns()
        sizes.append(len(jpeg_of(frame)))
        still_ns.append(time.process_time_ns() - began_ns)
    core = 1e-9 * (sum(decode_ns) + sum(still_ns)) / SECONDS
    decode_ms = 1e-6 * sum(decode_ns) / len(coded)
    still_ms, kbyte = 1e-6 * np.median(still_ns), 1e-3 * np.median(sizes)
    return f"{decode_ms:.2f} | {still_ms:.1f} | {kbyte:.1f} | {core:.3f}"


if __name__ == "__main__":
    print("| size | pictures/s | at most, kbit/s | kbit/s | reference steps a picture | processors |\n|" + "---|" * 6)
    stills = []
    for form in FORMS:
        found, coded = cost(*form)
        what = f"| {form[0]} x {form[1]} | {form[2]} | {form[3] * 1e-3:.0f} |"
        print(f"{what} {found} |")
        stills.append((what, still_cost(coded)))
    print("\n| size | pictures/s | at most, kbit/s | decode one, ms | write a still one, ms | kB | processors |")
    print("|" + "---|" * 7)
    for what, still in stills:
        print(f"{what} {still} |")
