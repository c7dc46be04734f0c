"""Models surfaces of slow strokes by a Gaussian of the unevenness at each wavelength; all share one covariance."""

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field
from scipy.stats import chi2

from common.files.strict_model import StrictModel
from remote_site.tables.table_file import NotNegative, Positive, TableFile
from remote_site.texture.motion_spectrum import UNKNOWN
from remote_site.texture.recorded.surface_spectrum import Along, spectrum, unevenness
from remote_site.traces.trace_files import StrokeTrace

Array = NDArray[np.float64]

STRANGE = 1e-3
"""Smallest probability of a distance as large as a stroke's; below it, the stroke is of no calibrated surface."""
LEAST_BANDS = 3
"""Minimum number of bands for a comparison."""


@dataclass(frozen=True, slots=True)
class Recognised:
    """Recognised surface of a stroke.

    Attributes:
        surface: label given in calibration, or `unknown` if none fits.
        probability: probability of the likeliest label among the calibrated ones, 0..1.
    """

    surface: str
    probability: float


class SpectrumModel(StrictModel):
    """Unevenness of all surfaces along one measure of the path.

    Attributes:
        along: measure of the path.
        edges: edges of the bands, 1 over the unit of the path.
        noise: standard deviation of each signal's own white noise, in its unit.
        means: ln power of each surface (rows) in each band.
        between_strokes: covariance of ln power between strokes of one surface over the same place.
        between_places: covariance between quarters of one stroke.
        misfit: mean squared distance of strokes left out in calibration, over that expected from the covariances; at
            least 1.
    """

    along: Along
    edges: list[Positive] = Field(min_length=LEAST_BANDS + 1)
    noise: list[NotNegative]
    means: list[list[float]] = Field(min_length=1)
    between_strokes: list[list[float]]
    between_places: list[list[float]]
    misfit: Annotated[float, Field(ge=1.0)] = 1.0

    def distances(self, pieces: Array) -> tuple[Array, int] | None:
        """Return a stroke's squared distance to each surface, and the number of bands; None with too few bands.

        `pieces` are ln power, pieces x bands; bands that are nan are left out.
        """
        seen = np.isfinite(pieces).all(axis=0)
        if np.count_nonzero(seen) < LEAST_BANDS:
            return None
        off = pieces.mean(axis=0)[seen] - np.array(self.means)[:, seen]
        covariance = np.array(self.between_strokes) + np.array(self.between_places) / len(pieces)
        solved = np.linalg.solve(covariance[np.ix_(seen, seen)], off.T)
        return np.einsum("sb,bs->s", off, solved), int(np.count_nonzero(seen))


class SpectrumTable(TableFile):
    """Surfaces calibrated with slow strokes.

    Attributes:
        surfaces: labels.
        signals: number of signals in calibration; a stroke must have the same number.
        models: one along metres if all speeds were known, and one that needs no speed.
    """

    kind: Literal["surface_spectra"] = "surface_spectra"
    schema_version: Literal[1] = 1
    surfaces: list[Annotated[str, Field(min_length=1)]] = Field(min_length=1)
    signals: int = Field(ge=1)
    models: list[SpectrumModel] = Field(min_length=1)

    def recognise(self, trace: StrokeTrace, speed_m_s: float | None = None) -> Recognised | None:
        """Return the surface of a slow stroke; None if its speed, length or rate do not suffice.

        Raises:
            ValueError: the stroke has more or fewer signals than the calibration.
        """
        if trace.signals.shape[1] != self.signals:
            raise ValueError(
                f"{trace.name}: {trace.signals.shape[1]} signals, the table was calibrated with {self.signals}; "
                "name the same --signal as in calibration"
            )
        for model in self.models:
            stroke = unevenness(trace, model.along, speed_m_s)
            found = (
                None
                if stroke is None
                else model.distances(spectrum(stroke, np.array(model.edges), np.array(model.noise)))
            )
            if found is not None:
                return judged(self.surfaces, found, model.misfit)
        return None


def judged(surfaces: list[str], found: tuple[Array, int], misfit: float) -> Recognised:
    """Return the likeliest surface; all have the same prior probability."""
    distances, bands = found[0] / misfit, found[1]
    likelihood = np.exp(-0.5 * (distances - distances.min()))
    nearest = int(np.argmin(distances))
    fits = float(chi2.sf(distances[nearest], bands)) > STRANGE
    return Recognised(surfaces[nearest] if fits else UNKNOWN, float(likelihood[nearest] / likelihood.sum()))
