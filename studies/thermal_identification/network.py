"""Empirical information limit: a neural network trained on at least a thousand touches per material.

The network has no model of heat. Its accuracy on the same simulator is a lower bound of the information in a touch. A
calibration has only 25 touches per material.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from remote_site.thermal.touch_start import RecordedTouch
from studies.thermal_identification.situations import Hand

Array = NDArray[np.float64]

HIDDEN = (64, 64)
COMPONENTS = 20
"""Number of principal components per finger at the network's input."""
PENALTY = 1e-2
MOST_EPOCHS = 300
_EARLY_READINGS, _EARLY_BLOCK, _LATE_BLOCK = 60, 4, 5
_FORCE_BLOCKS = 6


def features(hands: Sequence[Hand], fingers: int, t_s: float) -> Array:
    """Return features (hands, f): block means of the readings up to `t_s`, forces, and the plate and its slope."""
    return np.array([np.concatenate([_features(one, t_s) for one in hand.fingers[:fingers]]) for hand in hands])


def _features(touch: RecordedTouch, t_s: float) -> Array:
    count = round(t_s * 100.0)
    edges = np.unique(
        np.concatenate(
            (
                np.arange(0, min(count, _EARLY_READINGS), _EARLY_BLOCK),
                np.arange(_EARLY_READINGS, count, _LATE_BLOCK),
                [count],
            )
        )
    ).astype(np.intp)
    from_s = touch.first + 1
    fallen = touch.trace.sensor_c[from_s : from_s + count] - touch.start_c
    force_n = touch.trace.force_n[from_s : from_s + count]
    blocks, forces = (np.add.reduceat(each, edges[:-1]) / np.diff(edges) for each in (fallen, force_n))
    above_k = touch.start_c - (touch.ambient_c or 0.0)
    return np.concatenate((blocks, forces[:_FORCE_BLOCKS], [force_n.mean(), above_k, touch.slope_k_s]))


@dataclass(frozen=True, slots=True)
class Network:
    """Trained classifier of materials and regression of the object's temperature, for one time after contact."""

    names: tuple[str, ...]
    scaler: Any
    components: Any
    classifier: Any
    regression: Any

    @classmethod
    def train(cls, rows: Array, materials: Sequence[str], above_k: Array, seed: int) -> Self:
        """Train both.

        Args:
            rows: features (n, f) of `features`.
            materials: true materials (n,).
            above_k: true temperatures of the object above ambient (n,), K.
            seed: seed of the initial weights and of the samples held out for early stopping.
        """
        # imported here, so that listing the studies does not wait for it
        neural = import_module("sklearn.neural_network")
        names = tuple(dict.fromkeys(materials))
        scaler = import_module("sklearn.preprocessing").StandardScaler().fit(rows)
        scaled = scaler.transform(rows)
        count = min(COMPONENTS * max(1, round(rows.shape[1] / 100)), *rows.shape)
        components = import_module("sklearn.decomposition").PCA(count, whiten=True, random_state=seed).fit(scaled)
        seen = components.transform(scaled)
        how = {
            "hidden_layer_sizes": HIDDEN,
            "alpha": PENALTY,
            "early_stopping": True,
            "max_iter": MOST_EPOCHS,
            "random_state": seed,
        }
        classifier = neural.MLPClassifier(**how).fit(seen, [names.index(material) for material in materials])
        return cls(names, scaler, components, classifier, neural.MLPRegressor(**how).fit(seen, above_k))

    def judge(self, rows: Array) -> tuple[Array, Array]:
        """Return the probability of each material (n, m) and the temperature above ambient (n,), K."""
        seen = self.components.transform(self.scaler.transform(rows))
        return np.asarray(self.classifier.predict_proba(seen)), np.asarray(self.regression.predict(seen))
