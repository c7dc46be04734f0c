"""Estimates compliance and damping of an object from force, height and speed of one pressing finger.

    z = s - c F / (1 + a v)

is the contact of Hunt & Crossley (1975), F = k d (1 + a v) at depth d = s - z, solved for the height z of the
fingertip: s is the height of the undeformed surface, c = 1/k its compliance, a its damping and v the speed downwards.
In this form, noise of the force is noise of the height, and is larger for softer objects. An extended Kalman filter
solves the equation sample by sample. A sample is a mean over 8 ms. It counts when the force has changed since the last
sample that counted. A finger at rest gives no information about c, and the noise of its force would look like a press.

Force and height alone cannot distinguish an object that yields from a surface that moves or slopes. Under a press the
force rises while the finger sinks; such samples teach c. If both rise, the surface has risen. Where this contradicts
the estimate, the surface moves by itself, and `moving_surface` estimates c from then on. If a sample contradicts the
estimate of a stroked surface, the finger has reached another object.

Tissue stiffens with depth, and a line through its forces is harder than the tissue at some depths. Some samples of the
press are therefore kept. A surface up to `highest_m` exceeds none of them.
"""

import math

from remote_site.stiffness.moving_surface import MovingSurface, motion_sd_m
from remote_site.stiffness.pressed_samples import PressedSample, PressedSamples

FORCE_SD_N, PLACE_SD_M, SPEED_SD_M_S = 0.011, 10e-6, 1.8e-3
"""Standard deviations with quantisation: force, N, and height, m, of one sample, and speed over a window, m/s."""
LAW_SHARE, DAMPED_SHARE = 0.01, 0.1
"""Model errors of the law and of its damping, as fractions of the depth and of the damping's part of the depth."""
SOFTEST_N_M, HARDEST_N_M = 50.0, 20_000.0
"""Range of the stiffness, N/m."""
DAMPING_S_M, DAMPING_SD_S_M, MOST_DAMPING_S_M = 1.0, 1.0, 4.0
"""Hunt and Crossley's a before a press: mean, standard deviation and maximum, s/m."""
LEAST_SHARE = 0.5
"""Lower limit of 1 + a v, the fraction of k d that remains of the force when a finger rises fast."""
DRIFT_M_S05, DRIFT_N_S05 = 0.1e-3, 0.1
"""Limits of a resting surface's drift: height, m per root of a second, and the force it causes, N per root of a second.

The smaller drift counts.
"""
STEEPNESS, UNEVEN_M = 0.1, 0.2e-3
"""Standard deviations of a stroked surface: slope, and change of height where another object begins, m."""
PATCH_M = 3e-3
"""Length of stroke within which a fingertip passes from one object to another, m."""
LEAST_CHANGE_N = 0.05
"""Smallest change of force that makes a sample count, N: ten times the noise of the mean force."""
MOVING_S = 0.02
"""Time between samples of a moving surface, s; at 250 Hz, their means have no sample in common."""
REST_S = 0.05
"""Time since the last sample that counted after which a stroke's separately tracked height is used, s."""
CONTRADICTION_SD = 3.5
"""Innovation from which a sample contradicts the estimate, in standard deviations."""
YIELDS_LN_SD = 0.3
"""Standard deviation that is added to ln c when a press contradicts c."""
HARDER_SD = 2.0
"""Excess of the line over a sample of the press from which it is too hard, in standard deviations."""
ROUGHLY_LN_SD = 0.3
"""Standard deviation of ln c below which samples can contradict c and can also teach a."""


class HuntCrossleyFit:
    """Fit of one contact.

    Attributes:
        surface_m: height of the undeformed surface, m.
        compliance_m_n: c, m/N, within 1 / HARDEST_N_M .. 1 / SOFTEST_N_M.
        damping_s_m: a, s/m.
        moved_m: motion of the surface while nothing pressed, m.
        highest_m: largest height, m, of a surface of this compliance that is nowhere harder than the press so far; None
            if the last sample was none of a press.
        met_other: whether the last sample showed that the stroking finger has reached another object.
    """

    def __init__(self, t_s: float, force_n: float, z_m: float) -> None:
        """Begin with the first sample of a contact: time, s, force, N, and height, m."""
        c = self.compliance_m_n = 0.5 / SOFTEST_N_M
        self.surface_m = z_m + c * force_n
        self.damping_s_m = DAMPING_S_M
        self.moved_m = 0.0
        self.met_other = False
        self.highest_m: float | None = None
        # The uncertainty of c is also an uncertainty of s = z + c F.
        shared = c * c * force_n
        height = shared * force_n + PLACE_SD_M**2 + (c * FORCE_SD_N) ** 2
        self._cov = [[height, shared, 0.0], [shared, c * c, 0.0], [0.0, 0.0, DAMPING_SD_S_M**2]]
        self._t_s, self._force_n, self._z_m = t_s, force_n, z_m
        self._began_s, self._press_s, self._most_n = t_s, 0.0, force_n
        self._way_m = self._passing_m = 0.0
        self._moving: MovingSurface | None = None
        self._seen: tuple[float, float, float] | None = None
        self._pressed = PressedSamples(z_m)

    @property
    def ln_sd(self) -> float:
        """Standard deviation of ln c, and so of ln k."""
        return math.hypot(math.sqrt(self._cov[1][1]) / self.compliance_m_n, LAW_SHARE)

    @property
    def damping_sd_s_m(self) -> float:
        """Standard deviation of a, s/m."""
        return math.sqrt(self._cov[2][2])

    @property
    def drift_m_s05(self) -> float:
        """Drift of a surface at rest, m per root of a second."""
        return min(DRIFT_M_S05, DRIFT_N_S05 * self.compliance_m_n)

    def measured(self, force_n: float, z_m: float, speed_m_s: float) -> tuple[float, float]:
        """Return the height of the surface, m, from a sample and the present estimate, and its variance, m2."""
        c, a = self.compliance_m_n, self.damping_s_m
        depth_m = c * force_n / max(LEAST_SHARE, 1.0 + a * speed_m_s)
        return z_m + depth_m, PLACE_SD_M**2 + (c * FORCE_SD_N) ** 2 + (a * SPEED_SD_M_S * depth_m) ** 2

    def stroked_on(self, t_s: float) -> bool:
        """Whether the finger has stroked for REST_S without a sample that counts."""
        return self._way_m > 0.0 and t_s - self._t_s > REST_S

    def see(self, height_m: float, variance_m2: float, force_n: float) -> None:
        """Take a later height of the surface, by the present compliance at this force, N; the last call counts."""
        self._seen, self._way_m = (height_m, variance_m2, force_n), 0.0

    def _take_seen(self, height_m: float, variance_m2: float, force_n: float) -> None:
        """Continue from the height that `see` was given."""
        cov, shared = self._cov, force_n * self._cov[1][1]
        own_m = LAW_SHARE * self.compliance_m_n * force_n
        self._pressed.follow(height_m - self.surface_m)
        self.surface_m, self._seen = height_m, None
        cov[0] = [variance_m2 + own_m * own_m + force_n * shared, shared, force_n * cov[1][2]]
        cov[1][0], cov[2][0] = cov[0][1:]

    def step(self, t_s: float, force_n: float, z_m: float, speed_m_s: float, way_m: float, samples: int) -> bool:
        """Take the mean of the newest samples; return whether it counted, that is, changed the estimate.

        Args:
            t_s: time, s.
            force_n: contact force, N.
            z_m: height of the fingertip, m.
            speed_m_s: speed downwards, m/s.
            way_m: distance along the surface since the last call, m; 0 for a finger that does not stroke.
            samples: number of samples in the mean.
        """
        self._way_m += way_m
        self.met_other = False
        self.highest_m = None
        if self._moving is not None:
            return self._follow(self._moving, t_s, PressedSample(force_n, z_m, speed_m_s, samples))
        change_n = force_n - self._force_n
        if abs(change_n) < LEAST_CHANGE_N:
            return False
        if self._seen is not None:
            self._take_seen(*self._seen)
        cov, way_m = self._cov, self._way_m
        seconds, rise_m = t_s - self._t_s, z_m - self._z_m
        self._t_s, self._force_n, self._z_m, self._way_m = t_s, force_n, z_m, 0.0
        self._passing_m = max(0.0, self._passing_m - way_m) if way_m else 0.0
        cov[0][0] += self.drift_m_s05**2 * seconds + (STEEPNESS * way_m) ** 2

        height_m, noise_m2 = self.measured(force_n, z_m, speed_m_s)
        depth_m, innovation_m = height_m - z_m, height_m - self.surface_m
        noise_m2 = noise_m2 / samples + self._law_m2(depth_m, speed_m_s)
        by_c = -depth_m / self.compliance_m_n
        by_a = depth_m * depth_m * speed_m_s / (self.compliance_m_n * force_n)
        cross = [row[0] + by_c * row[1] + by_a * row[2] for row in cov]
        variance = cross[0] + by_c * cross[1] + by_a * cross[2] + noise_m2

        roughly_known = math.sqrt(cov[1][1]) < ROUGHLY_LN_SD * self.compliance_m_n
        contradicts = roughly_known and innovation_m * innovation_m > CONTRADICTION_SD**2 * variance
        if way_m and (contradicts or self._passing_m):
            if contradicts:
                self._passing_m = PATCH_M
            self._meet(z_m, depth_m, noise_m2)
            return True
        if rise_m * change_n < 0.0:
            learned: tuple[int, ...] = (0, 1, 2) if roughly_known else (0, 1)
            if contradicts:
                doubt = (YIELDS_LN_SD * self.compliance_m_n) ** 2
                cov[1][1] += doubt
                cross[1] += by_c * doubt
                variance += by_c * by_c * doubt
            self._press_s, self._most_n = t_s - self._began_s, max(self._most_n, force_n)
        else:
            learned = (0,)
            if contradicts or not roughly_known:
                moved_m2 = innovation_m * innovation_m
                cov[0][0] += moved_m2
                cross[0] += moved_m2
                variance += moved_m2
                self.moved_m += rise_m
        self._learn(learned, cross, variance, innovation_m)
        if contradicts and learned == (0,):  # the surface may have moved during the press, too
            self._pressed.forget()
            self._begin_to_follow(t_s, force_n, motion_sd_m(self._press_s) / self._most_n)
            return True
        if learned != (0,) and not way_m:
            self._bound(PressedSample(force_n, z_m, speed_m_s, samples))
        return True

    def _begin_to_follow(self, t_s: float, force_n: float, doubt_m_n: float) -> None:
        """Follow a surface that moves by itself; c has a further standard deviation, m/N."""
        self._cov[1][1] += doubt_m_n**2
        self._moving = MovingSurface(t_s, force_n, self.surface_m, self.compliance_m_n, self._cov[1][1])

    def _follow(self, moving: MovingSurface, t_s: float, sample: PressedSample) -> bool:
        """Take the mean of the newest samples on a surface that moves; return whether it counted."""
        force_n, z_m, speed_m_s, samples = sample
        if t_s - self._t_s < MOVING_S:
            return False
        self._t_s, way_m, self._way_m = t_s, self._way_m, 0.0
        change_n, rise_m = force_n - self._force_n, z_m - self._z_m
        changed = abs(change_n) >= LEAST_CHANGE_N
        if changed:
            self._force_n, self._z_m = force_n, z_m
        teaches = changed and rise_m * change_n < 0.0
        height_m, noise_m2 = self.measured(force_n, z_m, speed_m_s)
        depth_m = height_m - z_m
        noise_m2 = noise_m2 / samples + self._law_m2(depth_m, speed_m_s)
        by_c = -depth_m / self.compliance_m_n
        innovation = moving.step(t_s, z_m, by_c, noise_m2, (STEEPNESS * way_m) ** 2, teaches)
        if way_m and abs(innovation) > CONTRADICTION_SD:
            self._meet(z_m, depth_m, noise_m2)
            self._begin_to_follow(t_s, force_n, self.compliance_m_n)
            return True
        self._pressed.follow(moving.surface_m - self.surface_m)
        self.surface_m = moving.surface_m
        self.compliance_m_n = min(max(moving.compliance_m_n, 1.0 / HARDEST_N_M), 1.0 / SOFTEST_N_M)
        self._cov[1][1] = moving.variance_m2_n2 + (moving.compliance_m_n - self.compliance_m_n) ** 2
        if teaches and not way_m:
            self._bound(sample)
        return True

    def _bound(self, sample: PressedSample) -> None:
        """Find `highest_m` after a sample of a press, if the finger has moved."""
        pressed = self._pressed
        if not pressed.take(sample) or not pressed.kept:
            return
        highest_m = math.inf
        for force_n, z_m, speed_m_s, samples in pressed.kept:
            height_m, noise_m2 = self.measured(force_n, z_m, speed_m_s)
            sd_m = math.sqrt(noise_m2 / samples + self._law_m2(height_m - z_m, speed_m_s))
            highest_m = min(highest_m, height_m + HARDER_SD * sd_m)
        self.highest_m = highest_m + pressed.followed_m

    def _law_m2(self, depth_m: float, speed_m_s: float) -> float:
        """Return the variance of a height by errors of the law and of its damping, m2."""
        return ((LAW_SHARE + DAMPED_SHARE * self.damping_s_m * abs(speed_m_s)) * depth_m) ** 2

    def _meet(self, z_m: float, depth_m: float, noise_m2: float) -> None:
        """Begin another object at about the same surface height; its compliance follows from that height."""
        self.met_other = True
        self._pressed.forget()
        by_c = -depth_m / self.compliance_m_n
        softness = (z_m - self.surface_m) / by_c
        self.compliance_m_n = min(max(softness, 1.0 / HARDEST_N_M), 1.0 / SOFTEST_N_M)
        self.surface_m = z_m - by_c * self.compliance_m_n  # with a limited compliance, the height is another one
        height, a = UNEVEN_M**2, self._cov[2][2]
        shared = -height / by_c
        self._cov = [[height, shared, 0.0], [shared, (height + noise_m2) / by_c**2, 0.0], [0.0, 0.0, a]]

    def _learn(self, learned: tuple[int, ...], cross: list[float], variance: float, innovation_m: float) -> None:
        """Update some of s, c and a; the uncertainty of the others is included."""
        gain = [each / variance * innovation_m if number in learned else 0.0 for number, each in enumerate(cross)]
        self.surface_m += gain[0]
        if learned == (0,):
            self._pressed.follow(gain[0])
        wanted = self.compliance_m_n + gain[1]
        self.compliance_m_n = min(max(wanted, 1.0 / HARDEST_N_M), 1.0 / SOFTEST_N_M)
        self.damping_s_m = min(max(self.damping_s_m + gain[2], 0.0), MOST_DAMPING_S_M)
        for i, row in enumerate(self._cov):
            for j in range(3):
                if i in learned or j in learned:
                    row[j] -= cross[i] * cross[j] / variance
        self._cov[1][1] += max(0.0, 1.0 / HARDEST_N_M - wanted) ** 2  # a stiffness above HARDEST_N_M adds uncertainty
