"""Height and slope of a surface below a finger that rests or strokes: a Kalman filter on noisy heights.

    s(next) = s + g_x dx + g_y dy + drift,    measured = s + noise

How much is smoothed follows from the noise: 0.01 N are 0.2 mm of a surface of 50 N/m, and 5 um of one of 2000 N/m.
"""

import math

SLOPE_SD = 0.1
"""Slopes before a stroke has told them."""
BEND_M05 = 0.6
"""A slope changes by so much per root of a metre: 0.02 within a millimetre."""
KNOWN_SLOPE_SD = 0.05


class SurfaceHeight:
    """Surface below one finger.

    Attributes:
        height_m: of the surface below the finger, m.
        slope_x, slope_y: its slope.
    """

    __slots__ = ("_cov", "height_m", "slope_x", "slope_y")

    def __init__(self, height_m: float, variance_m2: float) -> None:
        """Begin at a height known to this variance, m2, with no slope known."""
        self.height_m = height_m
        self.slope_x = self.slope_y = 0.0
        self._cov = [[variance_m2, 0.0, 0.0], [0.0, SLOPE_SD**2, 0.0], [0.0, 0.0, SLOPE_SD**2]]

    @property
    def variance_m2(self) -> float:
        """Of the height, m2."""
        return self._cov[0][0]

    def step(self, dx_m: float, dy_m: float, drift_m2: float, measured_m: float, noise_m2: float) -> None:
        """Go on by `dx_m`, `dy_m` and a drift of this variance; take a measured height, m, with its noise, m2."""
        cov = self._cov
        if dx_m or dy_m:
            self.height_m += self.slope_x * dx_m + self.slope_y * dy_m
            cov[0] = [s + dx_m * x + dy_m * y for s, x, y in zip(*cov, strict=True)]
            for row in cov:
                row[0] += dx_m * row[1] + dy_m * row[2]
            bend = BEND_M05**2 * math.hypot(dx_m, dy_m)
            cov[1][1] += bend
            cov[2][2] += bend
        cov[0][0] += drift_m2
        cross = [row[0] for row in cov]
        variance = cross[0] + noise_m2
        surprise = (measured_m - self.height_m) / variance
        self.height_m += cross[0] * surprise
        self.slope_x += cross[1] * surprise
        self.slope_y += cross[2] * surprise
        self._cov = [
            [p - a * b / variance for p, b in zip(row, cross, strict=True)] for row, a in zip(cov, cross, strict=True)
        ]

    def slope_along(self, dx_m: float, dy_m: float) -> tuple[float, float]:
        """Slope along a way, as its parts in x and y; (0, 0) where it is not known to KNOWN_SLOPE_SD."""
        way2 = dx_m * dx_m + dy_m * dy_m
        if way2 == 0.0:
            return 0.0, 0.0
        cov = self._cov
        variance = (dx_m * dx_m * cov[1][1] + 2.0 * dx_m * dy_m * cov[1][2] + dy_m * dy_m * cov[2][2]) / way2
        if variance > KNOWN_SLOPE_SD**2:
            return 0.0, 0.0
        along = (self.slope_x * dx_m + self.slope_y * dy_m) / way2
        return along * dx_m, along * dy_m
