"""Reads haptic texture models: ARMA models of a tool's acceleration at points of speed and force.

A file describes one material (Culbertson, Lopez Delgado & Kuchenbecker 2014). Each of its points has line spectral
frequencies of both polynomials, the variance of the excitation, and the gain of the moving average. Triangles join the
points.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from studies.running import Unavailable

Array = NDArray[np.float64]
RATE_HZ = 1000.0
"""Sampling rate of the models, Hz."""
FLAT = 1e-6
"""Smallest doubled area of a triangle, mm/s N; a flatter one has no inside."""
_LONGEST = 4000
"""Length of an impulse response, samples."""


@dataclass(frozen=True)
class Arma:
    """Filters of several instants, one a row.

    Attributes:
        denominator: coefficients of the autoregressive part, (n, orders + 1); the first is 1.
        numerator: coefficients of the moving average with its gain, (n, orders + 1).
        deviation: standard deviation of the excitation, (n,), m/s^2.
    """

    denominator: Array
    numerator: Array
    deviation: Array

    def rms(self) -> Array:
        """Return the rms of the output of each filter at rest, (n,), m/s^2."""
        impulse = np.zeros(_LONGEST)
        impulse[0] = 1.0
        rows = zip(self.numerator, self.denominator, self.deviation, strict=True)
        return np.array([s * np.linalg.norm(lfilter(b, a, impulse)) for b, a, s in rows])


@dataclass(frozen=True)
class TextureModel:
    """Model of one material.

    Attributes:
        material: its name.
        points: speed, mm/s, and force, N, of each point, (points, 2).
        triangles: indices of the points of each triangle, (triangles, 3).
        ar_lsf: line spectral frequencies of the autoregressive part, (points, order), rad.
        ma_lsf: those of the moving average, (points, order), rad.
        variance: variance of the excitation, (points,), (m/s^2)^2.
        gain: gain of the moving average, (points,).
    """

    material: str
    points: Array
    triangles: NDArray[np.intp]
    ar_lsf: Array
    ma_lsf: Array
    variance: Array
    gain: Array

    @property
    def most(self) -> tuple[float, float]:
        """Largest speed, mm/s, and force, N."""
        speed, force = self.points.max(axis=0)
        return float(speed), float(force)

    def at(self, speed_mm_s: Array, force_n: Array) -> Arma:
        """Interpolate frequencies, variance and gain in the triangle of each speed, mm/s, and force, N."""
        triangles, inverse = self._inside
        asked = np.column_stack([np.clip(speed_mm_s, 0.0, self.most[0]), np.clip(force_n, 0.0, self.most[1])])
        shares = np.einsum("tij,nj->nti", inverse, np.column_stack([asked, np.ones(len(asked))]))
        nearest = shares.min(axis=2).argmax(axis=1)
        share = np.clip(shares[np.arange(len(asked)), nearest], 0.0, 1.0)
        share /= share.sum(axis=1, keepdims=True)
        corners = triangles[nearest]

        def mixed(values: Array) -> Array:
            return np.asarray(np.einsum("nk,nk...->n...", share, values[corners]))

        return Arma(
            polynomials(mixed(self.ar_lsf)),
            mixed(self.gain)[:, None] * polynomials(mixed(self.ma_lsf)),
            np.sqrt(mixed(self.variance)),
        )

    @cached_property
    def _inside(self) -> tuple[NDArray[np.intp], Array]:
        """Triangles that have an inside, and the matrices that give the shares of their corners."""
        corners = self.points[self.triangles].transpose(0, 2, 1)
        matrices = np.concatenate([corners, np.ones((len(corners), 1, 3))], axis=1)
        whole = np.abs(np.linalg.det(matrices)) > FLAT
        return self.triangles[whole], np.linalg.inv(matrices[whole])


def polynomials(lsf: Array) -> Array:
    """Return the coefficients of polynomials from their line spectral frequencies, (n, order), rad.

    A polynomial is the mean of a symmetric and an antisymmetric one, whose roots alternate on the unit circle.
    """
    ordered = np.sort(lsf, axis=1)
    ends = ([1.0], [1.0, 0.0, -1.0]) if lsf.shape[1] % 2 else ([1.0, 1.0], [1.0, -1.0])
    halves = []
    for first, end in enumerate(ends):
        product = np.tile(np.array(end), (len(lsf), 1))
        for column in np.cos(ordered[:, first::2]).T:
            longer = np.zeros((len(product), product.shape[1] + 2))
            longer[:, :-2] += product
            longer[:, 1:-1] -= 2.0 * column[:, None] * product
            longer[:, 2:] += product
            product = longer
        halves.append(product)
    return np.asarray(0.5 * (halves[0] + halves[1])[:, : lsf.shape[1] + 1])


def read_models(folder: Path) -> list[TextureModel]:
    """Read all models of a folder, in the order of their file names.

    Raises:
        Unavailable: there are none.
        ValueError: a file is no model; the message names it.
    """
    paths = sorted(folder.glob("*.xml"))
    if not paths:
        raise Unavailable(f"there are no texture models (*.xml) in {folder}")
    return [read_model(path) for path in paths]


def read_model(path: Path) -> TextureModel:
    """Read one model; raises ValueError, which names the file, where it is no model."""
    try:
        root = ElementTree.parse(path).getroot()
        each = root.findall("model")
        model = TextureModel(
            material=_text(root, "material"),
            points=np.column_stack([_values(root, "speedList"), _values(root, "forceList")]),
            triangles=np.array([_numbers(one) for one in root.findall("tri")]).astype(np.intp) - 1,
            ar_lsf=np.array([_values(one, "ARlsf") for one in each]),
            ma_lsf=np.array([_values(one, "MAlsf") for one in each]),
            variance=np.array([_number(_text(one, "var")) for one in each]),
            gain=np.array([_number(_text(one, "gain")) for one in each]),
        )
    except (OSError, ElementTree.ParseError, ValueError) as error:
        raise ValueError(f"{path}: no haptic texture model: {error}") from None
    count = len(model.points)
    if not count == len(each):
        raise ValueError(f"{path}: no haptic texture model: {len(each)} models and {count} points")
    if model.triangles.shape[1:] != (3,) or not 0 <= model.triangles.min() <= model.triangles.max() < count:
        raise ValueError(f"{path}: no haptic texture model: no triangle, or one with a corner that is no point")
    if model.variance.min() < 0.0:
        raise ValueError(f"{path}: no haptic texture model: a negative variance")
    return model


def _text(parent: ElementTree.Element, name: str) -> str:
    text = parent.findtext(name)
    if not text:
        raise ValueError(f"<{name}> is missing")
    return text


def _values(parent: ElementTree.Element, name: str) -> list[float]:
    found = parent.find(name)
    if found is None:
        raise ValueError(f"<{name}> is missing")
    return _numbers(found)


def _numbers(parent: ElementTree.Element) -> list[float]:
    return [_number(each.text or "") for each in parent.findall("value")]


def _number(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"not a finite number: {text!r}")
    return value
