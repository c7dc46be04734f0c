"""Kalman filter for height and slope of a surface below a finger that rests or strokes.

    s(next) = s + g_x dx + g_y dy + drift,    measured = s + noise

The noise sets the smoothing: 0.01 N equals 0.2 mm on a surface of 50 N/m, and 5 um on one of 2000 N/m.
"""

import math

SLOPE_SD = 0.1
"""Standard deviation of a slope before a stroke."""
BEND_M05 = 0.6
"""Standard deviation of a slope's change per root of a metre; 0.02 within a millimetre."""
KNOWN_SLOPE_SD = 0.05
"""Largest standard deviation of a slope that counts as known."""


class SurfaceHeight:
    """Surface below one finger.

    Attributes:
        height_m: height of the surface below the finger, m.
        variance_m2: variance of the height, m2.
        slope_x, slope_y: slope of the surface.
    """

    def __init__(self, height_m: float, variance_m2: float) -> None:
        """Begin at a height, m, with this variance, m2, and an unknown slope."""
        self.height_m, self.variance_m2 = height_m, variance_m2
        self.slope_x = self.slope_y = 0.0
        # Covariance of height (s) and slopes (x, y); `_sx` belongs to height and slope along x.
        self._sx = self._sy = self._xy = 0.0
        self._xx = self._yy = SLOPE_SD**2

    def step(self, dx_m: float, dy_m: float, drift_m2: float, measured_m: float, noise_m2: float) -> None:
        """Move by `dx_m`, `dy_m` with a drift of variance `drift_m2`, and take a height, m, with its variance, m2."""
        ss, sx, sy = self.variance_m2, self._sx, self._sy
        if dx_m or dy_m:
            self.height_m += self.slope_x * dx_m + self.slope_y * dy_m
            ss += dx_m * sx + dy_m * sy
            sx += dx_m * self._xx + dy_m * self._xy
            sy += dx_m * self._xy + dy_m * self._yy
            ss += dx_m * sx + dy_m * sy
            bend = BEND_M05**2 * math.hypot(dx_m, dy_m)
            self._xx += bend
            self._yy += bend
        ss += drift_m2
        variance = ss + noise_m2
        surprise = (measured_m - self.height_m) / variance
        self.height_m += ss * surprise
        self.slope_x += sx * surprise
        self.slope_y += sy * surprise
        self.variance_m2 = ss - ss * ss / variance
        self._sx, self._sy = sx - ss * sx / variance, sy - ss * sy / variance
        self._xx -= sx * sx / variance
        self._xy -= sx * sy / variance
        self._yy -= sy * sy / variance

    def slope_along(self, dx_m: float, dy_m: float) -> tuple[float, float]:
        """Return the x and y parts of the slope along a motion; (0, 0) if it is less well known than KNOWN_SLOPE_SD."""
        way2 = dx_m * dx_m + dy_m * dy_m
        if way2 == 0.0:
            return 0.0, 0.0
        variance = (dx_m * dx_m * self._xx + 2.0 * dx_m * dy_m * self._xy + dy_m * dy_m * self._yy) / way2
        if variance > KNOWN_SLOPE_SD**2:
            return 0.0, 0.0
        along = (self.slope_x * dx_m + self.slope_y * dy_m) / way2
        return along * dx_m, along * dy_m
