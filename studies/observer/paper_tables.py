"""Answers of the participants of Kron & Schmidt 2003 (Tables 1 and 2) as counts, beside predicted shares."""

from collections.abc import Mapping
from typing import Any

from scipy.stats import binomtest

MATCHING_OF = 20
MATCHED: Mapping[str, int] = {
    "foam": 12,
    "sandpaper": 18,
    "plain_pvc": 14,
    "closely_grooved_pvc": 18,
    "arbitrarily_grooved_pvc": 17,
    "widely_grooved_pvc": 17,
}
"""Table 1: number of participants, of twenty, who matched each surface."""

COMPARING_OF = 12
COMPARED: Mapping[str, Mapping[str, tuple[int, int, int]]] = {
    "real": {"a-w": (12, 0, 0), "a-p": (11, 1, 0), "c-w": (11, 0, 1), "p-w": (5, 7, 0)},
    "virtual": {"a-w": (12, 0, 0), "a-p": (10, 2, 0), "c-w": (11, 0, 1), "p-w": (8, 4, 0)},
}
"""Table 2: number of participants, of twelve, who felt the first object colder, equal, less cold. The label of the
first row is lost in print. It is taken as a-w, the only pair on which all twelve are likely to agree."""


def beside(share: float, count: int | None, of: int) -> dict[str, Any]:
    """A predicted share, 0..1, beside a count of the paper, in percent; None where the paper has no count."""
    if count is None:
        nothing = dict.fromkeys(("paper_percent", "paper_count", "interval_low_percent", "interval_high_percent"))
        return {"predicted_percent": 100.0 * share, **nothing, "inside": None}
    low, high = binomtest(count, of).proportion_ci()
    return {
        "predicted_percent": 100.0 * share,
        "paper_percent": 100.0 * count / of,
        "paper_count": count,
        "interval_low_percent": 100.0 * low,
        "interval_high_percent": 100.0 * high,
        "inside": low <= share <= high,
    }
