"""Exact confidence interval of a binomial share (Clopper-Pearson)."""

from scipy.stats import beta


def clopper_pearson(count: int, of: int, level: float = 0.95) -> tuple[float, float]:
    """Confidence interval of a share, 0..1, from `count` answers out of `of` (Clopper & Pearson 1934).

    Raises:
        ValueError: not 0 <= count <= of with of >= 1, or the confidence level is not between 0 and 1.
    """
    if not (0 <= count <= of and of >= 1):
        raise ValueError(f"count must be 0..{of}, of at least one answer, not {count}")
    if not 0.0 < level < 1.0:
        raise ValueError(f"level must be between 0 and 1, not {level}")
    tail = 0.5 * (1.0 - level)
    low = 0.0 if count == 0 else float(beta.ppf(tail, count, of - count + 1))
    high = 1.0 if count == of else float(beta.ppf(1.0 - tail, count + 1, of - count))
    return low, high
