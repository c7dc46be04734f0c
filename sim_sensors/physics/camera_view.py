"""The picture of a camera above the bench: objects, fingertips, the patient's face, and a stamp.

The picture is drawn from the simulated world only. Places on the bench are in proportion, seen from straight above.
"""

import numpy as np
from numpy.typing import NDArray

from common.fingers import FINGER_Y_M, FINGERS
from common.scenes.scene import Scene
from sim_sensors.physics.camera_stamp import draw_stamp

Array = NDArray[np.float64]
Plane = NDArray[np.uint8]

_MARGIN_M = 0.03
"""Bench that is seen beyond the outer objects, m."""
_NARROWEST_M = 0.3
"""Least width of the view, m."""
_FINGER_M = 0.014
"""Width and length of a fingertip, m."""
_TOUCHES_N = 0.05
"""Force from which a finger touches, N."""
_HURTS_N = 5.0
"""Force at which the face shows the most pain, N."""
_BENCH = (70, 128, 128)
_SKIN = (170, 112, 150)
_PRESSED = (215, 108, 170)
_DARK = 60
_EDGE_M = 0.003
"""Width of a fingertip's dark edge, m."""


class CameraView:
    """Draws pictures in YUV 4:2:0, one byte a sample."""

    def __init__(self, scene: Scene, fingers: tuple[str, ...], width: int, height: int) -> None:
        """Choose the view of the scene's bench for the fingers that take part; width and height are even, pixels."""
        self._fingers = [FINGERS.index(finger) for finger in fingers]
        first_m = min(thing.x_m for thing in scene.objects) - _MARGIN_M
        last_m = max(thing.x_m + thing.length_m for thing in scene.objects) + _MARGIN_M
        self._per_m = width / max(last_m - first_m, _NARROWEST_M)
        self._centre_m = 0.5 * (first_m + last_m)
        self._size = width, height
        self._still = self._planes()
        self._paint(self._still, (slice(None), slice(None)), _BENCH)
        for number, thing in enumerate(scene.objects):
            near_m, far_m = thing.y_range_m
            area = self._area(*thing.middle_m, thing.length_m, far_m - near_m)
            self._paint(self._still, area, (110 + 24 * (number % 4), 118 + 5 * (number % 3), 132 + 4 * (number % 5)))
        for plane in self._still[1:]:
            plane[-height // 40 :] = _BENCH[1]  # the stamp is grey

    def _planes(self) -> list[Plane]:
        width, height = self._size
        return [np.empty((height // part, width // part), dtype=np.uint8) for part in (1, 2, 2)]

    def place(self, x_m: float, y_m: float) -> tuple[float, float]:
        """Return the pixel of a place on the bench, from the top left corner."""
        width, height = self._size
        return 0.5 * width + (x_m - self._centre_m) * self._per_m, 0.5 * height - y_m * self._per_m

    def _area(self, x_m: float, y_m: float, long_m: float, across_m: float) -> tuple[slice, slice]:
        """Return rows and columns of a rectangle around a place, within the picture and even."""
        column, row = self.place(x_m, y_m)
        width, height = self._size
        spans = []
        for middle, side, most in ((row, across_m, height), (column, long_m, width)):
            half = 0.5 * side * self._per_m
            first, last = (2 * round(min(max(edge, 0.0), most) / 2.0) for edge in (middle - half, middle + half))
            spans.append(slice(first, last))
        return spans[0], spans[1]

    @staticmethod
    def _paint(planes: list[Plane], area: tuple[slice, slice], colour: tuple[int, int, int]) -> None:
        planes[0][area] = colour[0]
        half = tuple(
            slice(None if span.start is None else span.start // 2, None if span.stop is None else span.stop // 2)
            for span in area
        )
        for plane, value in zip(planes[1:], colour[1:], strict=True):
            plane[half] = value

    def draw(self, time_s: float, x_m: float, y_m: float, force_n: Array) -> bytes:
        """Return the picture with its time's stamp, three planes in turn, for forces (5,) on an object, N."""
        planes = [plane.copy() for plane in self._still]
        touches = force_n > _TOUCHES_N
        for finger in self._fingers:
            place = x_m, y_m + FINGER_Y_M[finger]
            planes[0][self._area(*place, _FINGER_M + 2.0 * _EDGE_M, _FINGER_M + 2.0 * _EDGE_M)] = _DARK
            self._paint(planes, self._area(*place, _FINGER_M, _FINGER_M), _PRESSED if touches[finger] else _SKIN)
        self._draw_face(planes, min(float(force_n.max()) / _HURTS_N, 1.0))
        draw_stamp(planes[0], time_s, touches)
        return b"".join(plane.tobytes() for plane in planes)

    def _draw_face(self, planes: list[Plane], pain: float) -> None:
        """Draw a face in the top right corner: with pain, 0..1, its eyes narrow and its mouth opens."""
        width, height = self._size
        side = height // 8 * 2
        top, left = 4, width - side - 4
        self._paint(planes, (slice(top, top + side), slice(left, left + side)), _SKIN)
        face = planes[0][top : top + side, left : left + side]
        eye = max(round(side * 0.12 * (1.0 - 0.8 * pain)), 1)
        middle, part = round(side * 0.36), side // 5
        for column in (part, side - 2 * part):
            face[middle - eye : middle + eye, column : column + part] = _DARK
        mouth = max(round(side * 0.16 * pain), 2)
        face[round(side * 0.72) - mouth : round(side * 0.72) + mouth, side // 3 : side - side // 3] = _DARK
