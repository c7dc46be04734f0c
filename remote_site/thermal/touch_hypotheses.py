"""Makes the hypotheses about a touch: material, conductance of the contact and lag of the read-out.

Each touch has a random effusivity of the piece, conductance of the contact and lag of the sensor, with normal
logarithms. The estimator is exact only near a hypothesis, so that a row of narrow normals replaces a wide one.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from remote_site.thermal.material_table import MaterialTable
from remote_site.thermal.touch_model import Contacts

Array = NDArray[np.float64]

SPACING = {"effusivity": 0.40, "conductance": 0.30, "lag": 0.30}
"""Distance between neighbouring hypotheses in each logarithm."""
INNER = 0.6
"""Standard deviation around each hypothesis over their distance; a row of such normals is as smooth as one normal."""
REACH_SD = 2.2
"""Range of the hypotheses, in standard deviations."""
FOREIGN_LN_STEP = 0.35
"""Distance in ln effusivity between the substances that represent all uncalibrated materials."""
FOREIGN_FROM, FOREIGN_TO = 25.0, 45_000.0
"""Range of effusivities of uncalibrated materials, from foam to copper, J/(m2 K s^0.5)."""
FOREIGN_CONDUCTANCE_SD = 0.40
"""Standard deviation of an uncalibrated material's ln conductance around that of materials of similar effusivity."""
SOFTER = 0.6
"""Slope of ln conductance over ln effusivity below the calibrated effusivities.

Insulators conduct little even where they touch (Ho & Jones 2008).
"""
FOREIGN = 0.02
"""Default prior probability of an object of no calibrated material."""


@dataclass(frozen=True, slots=True)
class Substances:
    """Possible substances of an object: calibrated materials, then all others in steps of effusivity; (m,) each.

    Attributes:
        ln_effusivity: mean of ln effusivity, effusivity in 1/sqrt(s).
        effusivity_variance: variance of ln effusivity from piece to piece.
        probability: prior probability; sums to 1.
        calibrated: number of calibrated materials, which come first.
    """

    ln_effusivity: Array
    effusivity_variance: Array
    probability: Array
    calibrated: int


@dataclass(frozen=True, slots=True)
class TouchHypotheses:
    """All hypotheses of one touch.

    Attributes:
        contacts: p contacts.
        contact_of: (n,) index of the contact.
        ln_lag: (n,) ln(lag in s).
        substance: (n,) index of the substance.
        ln_weight: (n,) ln prior probability within its substance.
        covariance: (n, 3, 3) covariance of ln effusivity, ln conductance and ln lag around the hypothesis.
        precision: (n, 3, 3) inverse of `covariance`.
        ln_determinant: (n,) ln determinant of `precision`.
    """

    contacts: Contacts
    contact_of: NDArray[np.intp]
    ln_lag: Array
    substance: NDArray[np.intp]
    ln_weight: Array
    covariance: Array
    precision: Array = field(init=False)
    ln_determinant: Array = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "precision", np.linalg.inv(self.covariance))
        object.__setattr__(self, "ln_determinant", np.linalg.slogdet(self.precision)[1])


def spread(sd: float, spacing: float) -> tuple[Array, Array, float]:
    """Return a normal around 0 as a row of narrower ones: means, weights and common standard deviation."""
    if sd <= 0.75 * spacing:
        return np.zeros(1), np.ones(1), sd
    inner = INNER * spacing
    outer = float(np.sqrt(sd * sd - inner * inner))
    beside = max(int(np.ceil(REACH_SD * outer / spacing - 0.5)), 1)
    means = spacing * np.arange(-beside, beside + 1)
    weights = np.exp(-0.5 * (means / outer) ** 2)
    return np.asarray(means), np.asarray(weights / weights.sum()), inner


def substances(table: MaterialTable, foreign_share: float = FOREIGN) -> Substances:
    """Return the calibrated materials, each as frequent as in calibration, and steps of effusivity for all others.

    `foreign_share` is the prior probability of all others together.
    """
    touches = np.array([entry.touches for entry in table.materials], dtype=np.float64)
    foreign = _foreign_ln_effusivity(table)
    known, others = len(table.materials), len(foreign)
    return Substances(
        np.concatenate(([entry.ln_effusivity for entry in table.materials], foreign)),
        np.concatenate(
            ([entry.covariance[0][0] for entry in table.materials], np.full(others, (INNER * FOREIGN_LN_STEP) ** 2))
        ),
        np.concatenate(((1.0 - foreign_share) * touches / touches.sum(), np.full(others, foreign_share / others))),
        known,
    )


def guesses(table: MaterialTable) -> TouchHypotheses:
    """Return all hypotheses of a touch, from the calibrated populations."""
    ln_contacts: list[tuple[float, float, float]] = []
    rows: list[tuple[int, float, int, float, Array]] = []
    lags, lag_weights, lag_sd = spread(table.ln_lag_sd, SPACING["lag"])

    def add(
        substance: int, ln_effusivity: float, ln_conductance: float, slab_s: float, weight: float, inner: Array
    ) -> None:
        covariance = np.zeros((3, 3))
        covariance[:2, :2], covariance[2, 2] = inner, lag_sd * lag_sd
        ln_contacts.append((ln_effusivity, ln_conductance, slab_s))
        for lag, lag_weight in zip(lags, lag_weights, strict=True):
            rows.append(
                (len(ln_contacts) - 1, table.ln_lag + lag, substance, float(np.log(weight * lag_weight)), covariance)
            )

    for number, entry in enumerate(table.materials):
        (ee, ec), (_, cc) = entry.covariance
        follows = ec / cc  # regression of ln effusivity on ln conductance
        pieces, piece_weights, piece_sd = spread(float(np.sqrt(ee - follows * ec)), SPACING["effusivity"])
        contacts, contact_weights, contact_sd = spread(float(np.sqrt(cc)), SPACING["conductance"])
        own = contact_sd * contact_sd
        within = np.array([[piece_sd**2 + follows**2 * own, follows * own], [follows * own, own]])
        slab_s = np.inf if entry.slab_s is None else entry.slab_s
        for contact, contact_weight in zip(contacts, contact_weights, strict=True):
            for piece, piece_weight in zip(pieces, piece_weights, strict=True):
                ln_effusivity = entry.ln_effusivity + follows * contact + piece
                weight = contact_weight * piece_weight
                add(number, ln_effusivity, entry.ln_conductance + contact, slab_s, weight, within)

    foreign = _foreign_ln_effusivity(table)
    order = np.argsort([entry.ln_effusivity for entry in table.materials])
    known = np.array([(entry.ln_effusivity, entry.ln_conductance) for entry in table.materials])[order]
    within = np.diag([(INNER * FOREIGN_LN_STEP) ** 2, FOREIGN_CONDUCTANCE_SD**2])
    for number, ln_effusivity in enumerate(foreign):
        usual = float(np.interp(ln_effusivity, known[:, 0], known[:, 1]))
        usual -= SOFTER * max(known[0, 0] - ln_effusivity, 0.0)
        add(len(table.materials) + number, ln_effusivity, usual, np.inf, 1.0, within)

    ln = np.array(ln_contacts)
    return TouchHypotheses(
        Contacts(ln[:, 0], ln[:, 1], ln[:, 2]),
        np.array([row[0] for row in rows], dtype=np.intp),
        np.array([row[1] for row in rows]),
        np.array([row[2] for row in rows], dtype=np.intp),
        np.array([row[3] for row in rows]),
        np.stack([row[4] for row in rows]),
    )


def _foreign_ln_effusivity(table: MaterialTable) -> Array:
    """Return steps of ln effusivity from foam to copper, in the table's units."""
    low, high = np.log(FOREIGN_FROM / table.plate_j_m2k), np.log(FOREIGN_TO / table.plate_j_m2k)
    return np.linspace(low, high, round((high - low) / FOREIGN_LN_STEP) + 1)
