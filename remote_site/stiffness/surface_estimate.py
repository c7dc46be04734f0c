"""What one finger's contact tells of the surface: height, slope, stiffness, damping, or that they are not yet known.

Until a press has told the stiffness, what is told is too little rather than too much, at every depth: the softest that
the object may be (three standard deviations), from the height where the force first rose above its noise: the finger
touched there, so a resting surface is no lower than that. A local contact with this model presses a finger no harder
than the remote finger is pressed at the same place.
"""

import math
from collections import deque

from common.wire.messages import STIFFNESS_KNOWN_LN_SD, TOUCH_RANGES
from remote_site.stiffness.hunt_crossley_fit import SOFTEST_N_M, HuntCrossleyFit
from remote_site.stiffness.surface_height import SurfaceHeight

WINDOW = 5
"""Samples, 16 ms at 250 Hz, whose mean is fitted, and over which speeds are measured."""
ONSET_N, OFF_N = 0.05, 0.02
"""A contact begins at the first and ends below the second: five and two times the noise of the force."""
LONGEST_GAP_S = 0.1
"""What was known before a longer gap is forgotten."""
STROKE_M_S = 5e-3
"""Slower than this along the surface, a finger rests."""
SAFE_SD = 3.0
DAMPING_SHARE = 0.25
"""Damping is known when its standard deviation is less than this share of it."""
UNKNOWN_LN_SD = TOUCH_RANGES["stiffness_ln_sd"][1]


class SurfaceEstimate:
    """Surface below one finger; step it in every tick.

    Attributes:
        stiffness_n_m: N/m; 0 without contact.
        stiffness_ln_sd: standard deviation of its logarithm; STIFFNESS_KNOWN_LN_SD or more is "not yet known".
        damping_n_s_m: of the object at the present force, N s/m; 0 when not known.
        surface_z_m: height of the undeformed surface below the finger, m; 0 without contact.
        slope_x, slope_y: of the surface along a stroke; 0 when not known.
    """

    __slots__ = (
        "_damping_known",
        "_drift_m2_s",
        "_fit",
        "_forces_n",
        "_height",
        "_heights_m",
        "_onset_z_m",
        "_recent",
        "damping_n_s_m",
        "slope_x",
        "slope_y",
        "stiffness_ln_sd",
        "stiffness_n_m",
        "surface_z_m",
    )

    def __init__(self) -> None:
        self._onset_z_m: float | None
        self._fit: HuntCrossleyFit | None
        self._height: SurfaceHeight | None
        self._recent: deque[tuple[float, float, float, float]] = deque(maxlen=WINDOW)
        """Time, x, y and z of the newest samples of the contact."""
        self._forces_n: deque[float] = deque(maxlen=WINDOW)
        self._heights_m: deque[float] = deque(maxlen=WINDOW)
        self._drift_m2_s = 0.0
        self._damping_known = False
        self._release()

    @property
    def known(self) -> bool:
        """Whether this contact has told its stiffness."""
        return self.stiffness_ln_sd < STIFFNESS_KNOWN_LN_SD

    def step(self, t_s: float, force_n: float, x_m: float, y_m: float, z_m: float) -> None:
        """Take contact force, N, and place of the fingertip, m, at `t_s`; not finite is left out."""
        if self._onset_z_m is None and not force_n >= ONSET_N:
            return
        if not math.isfinite(t_s + force_n + x_m + y_m + z_m):
            return
        recent = self._recent
        if self._onset_z_m is not None and not 0.0 < t_s - recent[-1][0] <= LONGEST_GAP_S:
            self._release()
        if self._onset_z_m is None:
            if force_n < ONSET_N:
                return
            self._onset_z_m = z_m
        elif force_n < OFF_N:
            self._release()
            return
        recent.append((t_s, x_m, y_m, z_m))
        self._forces_n.append(force_n)
        self._heights_m.append(z_m)
        if len(recent) > 1:
            self._feel(t_s, force_n, x_m, y_m, z_m)
        if self._height is None:
            self._tell_too_little(self._onset_z_m, force_n, z_m)

    def _release(self) -> None:
        """Nothing is touched, and so nothing is known."""
        self._recent.clear()
        self._forces_n.clear()
        self._heights_m.clear()
        self._onset_z_m = self._fit = self._height = None
        self.stiffness_n_m = self.surface_z_m = self.damping_n_s_m = self.slope_x = self.slope_y = 0.0
        self.stiffness_ln_sd = UNKNOWN_LN_SD

    def _feel(self, t_s: float, force_n: float, x_m: float, y_m: float, z_m: float) -> None:
        """Take the newest sample of a contact, its second or a later one."""
        recent, fit, height = self._recent, self._fit, self._height
        samples = len(recent)
        from_s, from_x_m, from_y_m, from_z_m = recent[0]
        last_s, last_x_m, last_y_m, _ = recent[-2]
        mean_n, mean_m = sum(self._forces_n) / samples, sum(self._heights_m) / samples
        if fit is None:
            fit = self._fit = HuntCrossleyFit(last_s, self._forces_n[0], from_z_m)
        passed_s = t_s - from_s
        sinks_m_s = (from_z_m - z_m) / passed_s
        dx_m = dy_m = way_m = self.slope_x = self.slope_y = 0.0
        if samples == WINDOW and math.hypot(x_m - from_x_m, y_m - from_y_m) >= STROKE_M_S * passed_s:
            dx_m, dy_m = x_m - last_x_m, y_m - last_y_m
            way_m = math.hypot(dx_m, dy_m)
        if height is not None and fit.stroked_on(t_s):
            fit.see(height.height_m, height.variance_m2, force_n)
        if fit.step(t_s, mean_n, mean_m, sinks_m_s, way_m, samples) or samples == 2:
            self._learn(fit)
        if height is None and not self.known:
            return
        # Means that overlap have no less noise together than single samples.
        measured_m, noise_m2 = fit.measured(mean_n, mean_m, sinks_m_s)
        if height is None or fit.met_other:
            height = self._height = SurfaceHeight(fit.surface_m, noise_m2)
        else:
            height.step(dx_m, dy_m, self._drift_m2_s * (t_s - last_s), measured_m, noise_m2)
        self.surface_z_m = height.height_m
        if way_m:
            self.slope_x, self.slope_y = height.slope_along(dx_m, dy_m)
        self.damping_n_s_m = fit.damping_s_m * force_n if self._damping_known else 0.0

    def _learn(self, fit: HuntCrossleyFit) -> None:
        """Take over what the fit has learned from a sample that counts."""
        self.stiffness_ln_sd = min(fit.ln_sd, UNKNOWN_LN_SD)
        self.stiffness_n_m = 1.0 / fit.compliance_m_n
        self._drift_m2_s = fit.drift_m_s05**2
        self._damping_known = fit.damping_sd_s_m < DAMPING_SHARE * fit.damping_s_m

    def _tell_too_little(self, onset_z_m: float, force_n: float, z_m: float) -> None:
        """Tell the softest and lowest that the object may be."""
        self.stiffness_n_m, highest_m = SOFTEST_N_M, onset_z_m
        if self._fit is not None:
            softest = self._fit.compliance_m_n * (1.0 + SAFE_SD * self._fit.ln_sd)
            self.stiffness_n_m = max(SOFTEST_N_M, 1.0 / softest)
            highest_m += self._fit.moved_m
        self.surface_z_m = min(highest_m, z_m + force_n / self.stiffness_n_m)
