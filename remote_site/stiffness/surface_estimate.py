"""Estimates height, slope, stiffness and damping of the surface below one finger in contact.

Until a press identifies the stiffness, the outputs are lower bounds at every depth. The stiffness is the softest
possible one (three standard deviations). The height is that at which the force first rose above its noise. The finger
touched there, so a resting surface is not lower. A local contact with this model presses the operator's finger no
harder than the remote finger is pressed at the same place.
"""

import math
from collections import deque

from common.wire.messages import STIFFNESS_KNOWN_LN_SD, TOUCH_RANGES
from remote_site.stiffness.hunt_crossley_fit import SOFTEST_N_M, HuntCrossleyFit
from remote_site.stiffness.surface_height import SurfaceHeight

WINDOW = 5
"""Number of samples in the fitted mean and in each measurement of speed; 16 ms at 250 Hz."""
ONSET_N, OFF_N = 0.05, 0.02
"""Forces above the sensor's offset at which a contact begins and below which it ends, N: five and two times the noise.
"""
LONGEST_GAP_S = 0.1
"""Maximum gap between samples of one contact, s; a longer gap resets the estimate."""
STROKE_M_S = 5e-3
"""Minimum speed of a stroke along the surface, m/s; a slower finger rests."""
SAFE_SD = 3.0
"""Standard deviations between the estimated compliance and the upper bound that is used before it is known."""
DAMPING_SHARE = 0.25
"""Largest standard deviation of a known damping, as a fraction of the damping."""
UNKNOWN_LN_SD = TOUCH_RANGES["stiffness_ln_sd"][1]
"""Standard deviation of ln stiffness that stands for an unknown stiffness."""


class SurfaceEstimate:
    """Surface below one finger; step it in every tick.

    Attributes:
        stiffness_n_m: stiffness of the object, N/m; 0 without contact.
        stiffness_ln_sd: standard deviation of its logarithm; STIFFNESS_KNOWN_LN_SD or more means "not yet known".
        damping_n_s_m: damping of the object at the present force, N s/m; 0 if unknown.
        surface_z_m: height of the undeformed surface below the finger, m; 0 without contact.
        slope_x, slope_y: slope of the surface along a stroke; 0 if unknown.
    """

    def __init__(self) -> None:
        self._onset_z_m: float | None
        self._fit: HuntCrossleyFit | None
        self._height: SurfaceHeight | None
        self._recent: deque[tuple[float, float, float, float]] = deque(maxlen=WINDOW)
        """Time, x, y and z of the newest samples of the contact."""
        self._forces_n: deque[float] = deque(maxlen=WINDOW)
        self._heights_m: deque[float] = deque(maxlen=WINDOW)
        self._drift_m2_s = 0.0
        self._lower_m = 0.0
        """Distance by which the surface is shown lower, so that it is nowhere harder than the press, m."""
        self._pressed_m = self._known_n_m = math.inf
        """Largest height that the press allows, m, and stiffness that was last known in this contact, N/m."""
        self._damping_known = False
        self._offset_n = 0.0
        """Offset of the force sensor at the onset of the contact, N."""
        self._release()

    @property
    def known(self) -> bool:
        """Whether the stiffness of this contact is identified."""
        return self.stiffness_ln_sd < STIFFNESS_KNOWN_LN_SD

    def step(self, t_s: float, force_n: float, x_m: float, y_m: float, z_m: float, offset_n: float = 0.0) -> None:
        """Take one sample; a sample that is not finite is ignored.

        Args:
            t_s: time, s.
            force_n: measured contact force, N.
            x_m, y_m, z_m: place of the fingertip, m.
            offset_n: present offset of the force sensor, N. A contact keeps that of its onset.
        """
        if self._onset_z_m is None and not force_n - offset_n >= ONSET_N:
            return
        if not math.isfinite(t_s + force_n + x_m + y_m + z_m):
            return
        recent = self._recent
        if self._onset_z_m is not None and not 0.0 < t_s - recent[-1][0] <= LONGEST_GAP_S:
            self._release()
        if self._onset_z_m is None:
            if force_n - offset_n < ONSET_N:
                return
            self._onset_z_m, self._offset_n = z_m, offset_n
        elif force_n - max(offset_n, self._offset_n) < OFF_N:
            self._release()
            return
        force_n -= self._offset_n
        recent.append((t_s, x_m, y_m, z_m))
        self._forces_n.append(force_n)
        self._heights_m.append(z_m)
        if len(recent) > 1:
            self._take(t_s, force_n, x_m, y_m, z_m)
        if self._height is None:
            self._take_lower_bounds(self._onset_z_m, force_n, z_m)

    def _release(self) -> None:
        """Forget the contact."""
        self._recent.clear()
        self._forces_n.clear()
        self._heights_m.clear()
        self._onset_z_m = self._fit = self._height = None
        self.stiffness_n_m = self.surface_z_m = self.damping_n_s_m = self.slope_x = self.slope_y = 0.0
        self.stiffness_ln_sd = UNKNOWN_LN_SD
        self._lower_m, self._known_n_m, self._pressed_m = 0.0, math.inf, math.inf

    def _take(self, t_s: float, force_n: float, x_m: float, y_m: float, z_m: float) -> None:
        """Take the newest sample of a contact, the second or a later one."""
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
        if fit.highest_m is not None:
            self._pressed_m = fit.highest_m
        if height is None and not self.known:
            return
        # Together, overlapping means have as much noise as single samples.
        measured_m, noise_m2 = fit.measured(mean_n, mean_m, sinks_m_s)
        if height is None or fit.met_other:
            height = self._height = SurfaceHeight(fit.surface_m, noise_m2)
        else:
            height.step(dx_m, dy_m, self._drift_m2_s * (t_s - last_s), measured_m, noise_m2)
        if fit.met_other:
            self._lower_m = 0.0
        elif fit.highest_m is not None:
            self._lower_m = max(0.0, height.height_m - fit.highest_m)
        self.surface_z_m = height.height_m - self._lower_m
        if way_m:
            self.slope_x, self.slope_y = height.slope_along(dx_m, dy_m)
        self.damping_n_s_m = fit.damping_s_m * force_n if self._damping_known else 0.0

    def _learn(self, fit: HuntCrossleyFit) -> None:
        """Copy the result of the fit after a sample that counted."""
        self.stiffness_ln_sd = min(fit.ln_sd, UNKNOWN_LN_SD)
        stiffness_n_m = 1.0 / fit.compliance_m_n
        if self.known:
            self._known_n_m = stiffness_n_m
        elif fit.met_other:
            self._known_n_m = math.inf
        self.stiffness_n_m = min(stiffness_n_m, self._known_n_m)
        self._drift_m2_s = fit.drift_m_s05**2
        self._damping_known = fit.damping_sd_s_m < DAMPING_SHARE * fit.damping_s_m

    def _take_lower_bounds(self, onset_z_m: float, force_n: float, z_m: float) -> None:
        """Set stiffness and surface height to their lower bounds."""
        self.stiffness_n_m, highest_m = SOFTEST_N_M, onset_z_m
        if self._fit is not None:
            softest = self._fit.compliance_m_n * (1.0 + SAFE_SD * self._fit.ln_sd)
            self.stiffness_n_m = max(SOFTEST_N_M, 1.0 / softest)
            highest_m = min(highest_m + self._fit.moved_m, self._pressed_m)
        self.surface_z_m = min(highest_m, z_m + force_n / self.stiffness_n_m)
