"""A patient's report of pain, as the remote site finds it and both sites exchange it."""

from typing import NamedTuple

MOST_REPORTS = 20
"""Number of the newest reports that are kept and exchanged."""


class PainReport(NamedTuple):
    """A report of pain.

    Attributes:
        x_m, y_m: place of the finger that pressed most, m.
        threshold_n: force at which the pain began, N.
        answer: highest answer so far, 0..10.
    """

    x_m: float
    y_m: float
    threshold_n: float
    answer: float
