"""Contact stiffness and height of the surface from force and indentation.

F = k (z_surface - z): force and height of the fingertip are fitted by least squares with forgetting,
beside a prior that gives a usable value within milliseconds of contact.
"""

PRIOR_N_M = 2000.0
LOWEST_N_M, HIGHEST_N_M = 50.0, 20_000.0
ONSET_N = 0.05
"""The surface is where the force first exceeds this, N: five times its noise."""
FORGET = 0.995
"""Weight kept per sample that moved: 0.4 s at 500 Hz."""
LEAST_MOVE_M = 8e-6
"""A sample nearer than this to the last one used says nothing new about the slope, m."""
UNEVEN_M = 0.3e-3
"""A surface stays this close to the height at which it was met, m."""
PRIOR_WEIGHT_M2 = (2e-5) ** 2
"""Indentation variance at which data and prior weigh the same."""


class Stiffness:
    """Stiffness identification of one finger.

    Attributes:
        stiffness_n_m: N/m, within LOWEST_N_M..HIGHEST_N_M.
        surface_z_m: height of the undeformed surface at the contact, m.
        known: whether this contact has given a value of its own yet.
    """

    __slots__ = (
        "_f",
        "_fz",
        "_onset_z_m",
        "_used_z_m",
        "_weight",
        "_z",
        "_zz",
        "known",
        "stiffness_n_m",
        "surface_z_m",
    )

    def __init__(self) -> None:
        self.stiffness_n_m = PRIOR_N_M
        self.surface_z_m = 0.0
        self.known = False
        self._onset_z_m: float | None = None
        self._used_z_m = 0.0
        self._weight = self._z = self._f = self._zz = self._fz = 0.0

    def step(self, force_n: float, z_m: float) -> None:
        """Take one pair of contact force, N, and height of the fingertip, m; not finite is left out."""
        if not (-100.0 < force_n < 100.0 and -1.0 < z_m < 1.0):
            return
        if force_n < ONSET_N:
            self._onset_z_m = None
            return
        if self._onset_z_m is None:
            self._onset_z_m = self._used_z_m = z_m
            # the onset is itself a pair, and the most telling one
            self._weight, self._z, self._f, self._zz, self._fz = 1.0, 0.0, force_n, 0.0, 0.0
            self.stiffness_n_m = PRIOR_N_M
            self.surface_z_m = z_m + force_n / PRIOR_N_M
            self.known = False
            return
        depth_m = self._onset_z_m - z_m
        if abs(z_m - self._used_z_m) >= LEAST_MOVE_M:
            self._used_z_m = z_m
            self._weight = FORGET * self._weight + 1.0
            self._z = FORGET * self._z + depth_m
            self._f = FORGET * self._f + force_n
            self._zz = FORGET * self._zz + depth_m * depth_m
            self._fz = FORGET * self._fz + depth_m * force_n
            mean_z, mean_f = self._z / self._weight, self._f / self._weight
            spread = self._zz - self._weight * mean_z * mean_z
            slope = self._fz - self._weight * mean_z * mean_f
            k = (slope + PRIOR_N_M * PRIOR_WEIGHT_M2) / (spread + PRIOR_WEIGHT_M2)
            self.stiffness_n_m = min(max(k, LOWEST_N_M), HIGHEST_N_M)
            self.known = self.known or spread > 4.0 * PRIOR_WEIGHT_M2
        # Force and indentation agree with the local model at the present pair, and the surface stays where it was
        # met: sliding from tissue onto a nodule changes the stiffness, not the height.
        surface_m = z_m + force_n / self.stiffness_n_m
        surface_m = min(max(surface_m, self._onset_z_m - UNEVEN_M), self._onset_z_m + UNEVEN_M)
        indentation_m = max(surface_m - z_m, force_n / HIGHEST_N_M)
        self.stiffness_n_m = max(LOWEST_N_M, force_n / indentation_m)
        self.surface_z_m = z_m + indentation_m
