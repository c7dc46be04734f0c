"""The console's end of the camera under test: receives and decodes pictures, until its input ends.

    picture_end.py ADDRESS BASE_PORT KEYS REMOTE_PUBLIC_KEY

Prints a line at the first picture, and at the end all that the test judges.
"""

import json
import select
import socket
import sys
import time
from contextlib import closing, suppress
from pathlib import Path

import av

from common.link.keys import load_keys
from common.wire.camera_messages import MAX_PICTURE
from operator_site.console.camera.camera import Camera
from operator_site.console.camera.camera_picture import Picture
from operator_site.console.stream_socket import StreamSocket
from sim_sensors.physics.camera_stamp import read_stamp
from tests.network.operator_end import AGES

_STEP_S = 0.008
"""Interval between two steps, as the console's, s."""


def take_touch(camera: Camera, ages: socket.socket) -> float:
    """Give the camera the site's clock; return the largest age of touch since the last call, s, 0 without one."""
    largest_ns = 0
    with suppress(BlockingIOError):
        while True:
            age_ns, *site_clock = json.loads(ages.recv(256))
            largest_ns = max(largest_ns, age_ns)
            camera.clock.site = site_clock[0], site_clock[1]
    return largest_ns * 1e-9


def judged(picture: Picture, camera: Camera, decoder: av.VideoCodecContext) -> tuple[float, ...]:
    """What is known of a picture that has just arrived.

    When it arrived, its time of capture as known and as stamped, and the error of touch's clock, s; its bytes, and its
    width in pixels.
    """
    arrived_s = time.monotonic()
    frame = decoder.decode(av.Packet(picture.content))[0]
    stamp = read_stamp(frame.to_ndarray()[: picture.height], arrived_s)
    stamped_s = float("nan") if stamp is None else stamp[0]
    offset_ns = 0 if camera.clock.site is None else camera.clock.site[0]
    touch_error_s = -offset_ns * 1e-9  # both hosts of the test have one clock
    return arrived_s, picture.captured_s, stamped_s, touch_error_s, float(len(picture.content)), float(picture.width)


def main(address: str, base_port: int, keys: Path, remote_public_key: str) -> None:
    """Receive until the input ends."""
    found = []
    decoder = av.VideoCodecContext.create("vp8", "r")
    line = StreamSocket("camera", address, base_port, load_keys(keys), remote_public_key, MAX_PICTURE)
    with closing(Camera(line)) as camera, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ages:
        ages.setblocking(False)
        ages.bind(("127.0.0.1", AGES))
        while not select.select([sys.stdin], [], [], _STEP_S)[0]:
            for picture in camera.step(1, take_touch(camera, ages), wants_key=False):
                found.append(judged(picture, camera, decoder))
                if len(found) == 1:
                    print("first picture", flush=True)
    print(json.dumps(found), flush=True)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), Path(sys.argv[3]), sys.argv[4])
