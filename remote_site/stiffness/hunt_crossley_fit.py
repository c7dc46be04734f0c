"""What a press tells: compliance and damping of an object, from one finger's force, height and speed.

    z = s - c F / (1 + a v)

is the contact of Hunt & Crossley (1975), F = k d (1 + a v) at depth d = s - z, solved for the height z of the
fingertip: s is the height of the undeformed surface, c = 1/k its compliance, a its damping and v the speed downwards.
Noise of the force is then noise of the height, the wider the softer the object. An extended Kalman filter solves it,
sample by sample. A sample is a mean over 8 ms, and counts when the force has changed since the last one that did: a
finger at rest tells nothing of c, and the noise of its force would be taken for pressing.

Force and height alone cannot tell an object that gives way from a surface that moves or slopes. Under a press the
force rises while the finger sinks: that teaches c. Where both rise, the surface has risen. Where that contradicts what
is known of a surface that is stroked, the finger has come upon something else.
"""

import math

FORCE_SD_N, PLACE_SD_M, SPEED_SD_M_S = 0.011, 10e-6, 1.8e-3
"""Noise and steps of one sample's force and height, and of the speed over a window."""
LAW_SHARE, DAMPED_SHARE = 0.01, 0.1
"""No object keeps closer to the law than to these shares of its depth, and of what damping makes of it."""
SOFTEST_N_M, HARDEST_N_M = 50.0, 20_000.0
DAMPING_S_M, DAMPING_SD_S_M, MOST_DAMPING_S_M = 1.0, 1.0, 4.0
"""Hunt and Crossley's a before a press has told it."""
LEAST_SHARE = 0.5
"""Of k d that is left of the force of a finger that rises fast."""
DRIFT_M_S05, DRIFT_N_S05 = 0.1e-3, 0.1
"""A surface that stands still drifts by the first, m per root of a second, or by what makes the second of force."""
STEEPNESS, UNEVEN_M = 0.1, 0.2e-3
"""A stroked surface slopes so much, and stays so near its height where it becomes something else."""
PATCH_M = 3e-3
"""A fingertip passes from one object to another within this way."""
LEAST_CHANGE_N = 0.05
"""Ten times the noise of the mean force."""
REST_S = 0.05
CONTRADICTION_SD = 3.5
MISTAKEN_SHARE = 0.25
"""Of the way that a surface moves under a press, taken for depth."""
YIELDS_LN_SD = 0.3
"""Doubt about c where a press contradicts it."""
ROUGHLY_LN_SD = 0.3
"""Only when c is known as well as this, samples can contradict it, and teach a as well."""


class HuntCrossleyFit:
    """Fit of one contact.

    Attributes:
        surface_m: height of the undeformed surface, m.
        compliance_m_n: c, m/N, within 1 / HARDEST_N_M .. 1 / SOFTEST_N_M.
        damping_s_m: a, s/m.
        moved_m: how far the surface has moved while nothing pressed, m.
        met_other: whether the last sample said that the finger strokes something else than before.
    """

    __slots__ = (
        "_began_s",
        "_cov",
        "_doubt_m_n",
        "_force_n",
        "_most_n",
        "_passing_m",
        "_press_s",
        "_seen",
        "_t_s",
        "_way_m",
        "_z_m",
        "compliance_m_n",
        "damping_s_m",
        "met_other",
        "moved_m",
        "surface_m",
    )

    def __init__(self, t_s: float, force_n: float, z_m: float) -> None:
        """Begin with the first sample of a contact: time, s, force, N, and height, m."""
        c = self.compliance_m_n = 0.5 / SOFTEST_N_M
        self.surface_m = z_m + c * force_n
        self.damping_s_m = DAMPING_S_M
        self.moved_m = 0.0
        self.met_other = False
        # What is not known of c is not known of s = z + c F either.
        shared = c * c * force_n
        height = shared * force_n + PLACE_SD_M**2 + (c * FORCE_SD_N) ** 2
        self._cov = [[height, shared, 0.0], [shared, c * c, 0.0], [0.0, 0.0, DAMPING_SD_S_M**2]]
        self._t_s, self._force_n, self._z_m = t_s, force_n, z_m
        self._began_s, self._press_s, self._most_n = t_s, 0.0, force_n
        self._way_m = self._passing_m = self._doubt_m_n = 0.0
        self._seen: tuple[float, float, float] | None = None

    @property
    def ln_sd(self) -> float:
        """Standard deviation of ln c, and so of ln k."""
        return math.hypot(math.hypot(math.sqrt(self._cov[1][1]), self._doubt_m_n) / self.compliance_m_n, LAW_SHARE)

    @property
    def damping_sd_s_m(self) -> float:
        """Standard deviation of a, s/m."""
        return math.sqrt(self._cov[2][2])

    @property
    def drift_m_s05(self) -> float:
        """How far a surface that stands still may drift, m per root of a second."""
        return min(DRIFT_M_S05, DRIFT_N_S05 * self.compliance_m_n)

    def measured(self, force_n: float, z_m: float, speed_m_s: float) -> tuple[float, float]:
        """Height of the surface by a sample and what is known of the object, m; and its variance, m2."""
        c, a = self.compliance_m_n, self.damping_s_m
        depth_m = c * force_n / max(LEAST_SHARE, 1.0 + a * speed_m_s)
        return z_m + depth_m, PLACE_SD_M**2 + (c * FORCE_SD_N) ** 2 + (a * SPEED_SD_M_S * depth_m) ** 2

    def stroked_on(self, t_s: float) -> bool:
        """Whether the finger has stroked for REST_S without a sample that counts."""
        return self._way_m > 0.0 and t_s - self._t_s > REST_S

    def see(self, height_m: float, variance_m2: float, force_n: float) -> None:
        """Take where the surface was seen since, by the compliance known and at a force in N; the last one holds."""
        self._seen, self._way_m = (height_m, variance_m2, force_n), 0.0

    def _take_seen(self, height_m: float, variance_m2: float, force_n: float) -> None:
        """Go on from where the surface was seen."""
        cov, shared = self._cov, force_n * self._cov[1][1]
        own_m = LAW_SHARE * self.compliance_m_n * force_n
        self.surface_m, self._seen = height_m, None
        cov[0] = [variance_m2 + own_m * own_m + force_n * shared, shared, force_n * cov[1][2]]
        cov[1][0], cov[2][0] = cov[0][1:]

    def step(self, t_s: float, force_n: float, z_m: float, speed_m_s: float, way_m: float, samples: int) -> bool:
        """Take the mean of the newest samples; return whether it counted: else nothing has been learned.

        Args:
            t_s: time, s.
            force_n: contact force, N.
            z_m: height of the fingertip, m.
            speed_m_s: speed downwards, m/s.
            way_m: way along the surface since the last call, m; 0 for a finger that does not stroke.
            samples: of how many it is the mean.
        """
        self._way_m += way_m
        self.met_other = False
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
        noise_m2 = noise_m2 / samples + ((LAW_SHARE + DAMPED_SHARE * self.damping_s_m * abs(speed_m_s)) * depth_m) ** 2
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
            if contradicts:  # so fast it may have moved under the press, too
                moved_m = MISTAKEN_SHARE * abs(innovation_m) / seconds * self._press_s
                self._doubt_m_n = max(self._doubt_m_n, moved_m / self._most_n)
        self._learn(learned, cross, variance, innovation_m)
        return True

    def _meet(self, z_m: float, depth_m: float, noise_m2: float) -> None:
        """The surface stays about where it was, and what lies below is as soft as that says."""
        self.met_other = True
        by_c = -depth_m / self.compliance_m_n
        softness = (z_m - self.surface_m) / by_c
        self.compliance_m_n = min(max(softness, 1.0 / HARDEST_N_M), 1.0 / SOFTEST_N_M)
        self.surface_m = z_m - by_c * self.compliance_m_n  # where no softness says it, the surface is another one
        height, a = UNEVEN_M**2, self._cov[2][2]
        shared = -height / by_c
        self._cov = [[height, shared, 0.0], [shared, (height + noise_m2) / by_c**2, 0.0], [0.0, 0.0, a]]

    def _learn(self, learned: tuple[int, ...], cross: list[float], variance: float, innovation_m: float) -> None:
        """Learn some of s, c and a; what is not known of the others is minded all the same."""
        gain = [each / variance * innovation_m if number in learned else 0.0 for number, each in enumerate(cross)]
        self.surface_m += gain[0]
        wanted = self.compliance_m_n + gain[1]
        self.compliance_m_n = min(max(wanted, 1.0 / HARDEST_N_M), 1.0 / SOFTEST_N_M)
        self.damping_s_m = min(max(self.damping_s_m + gain[2], 0.0), MOST_DAMPING_S_M)
        for i, row in enumerate(self._cov):
            for j in range(3):
                if i in learned or j in learned:
                    row[j] -= cross[i] * cross[j] / variance
        self._cov[1][1] += max(0.0, 1.0 / HARDEST_N_M - wanted) ** 2  # what is harder than can be is not believed
