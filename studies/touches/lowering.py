"""Motion of a finger that comes down to a real, virtual or remote object."""

UP_M = 0.006
LOWER_S = 0.35


def height_m(time_s: float, depth_m: float, lower_s: float = LOWER_S) -> float:
    """Height of a finger over the surface, m: from time 0 on it descends with minimum jerk to `depth_m` below it."""
    u = min(max(time_s / lower_s, 0.0), 1.0)
    return UP_M - u**3 * (10.0 - 15.0 * u + 6.0 * u * u) * (UP_M + depth_m)
