"""Steps the temperatures of a linear network of heat capacities, some of whose conductances change with each step.

Backward differentiation of second order (BDF2): implicit, so that any step is stable, and a sudden contact does not
ring. The fixed part of the network is inverted once. The few changing contacts enter by the Woodbury identity.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(slots=True)
class Network:
    """Nodes and links of a network that is being built; all temperatures are above ambient, K.

    Attributes:
        capacity_j_k: heat capacity of each node, J/K.
        links: node, node and conductance, W/K.
        ambient_w_k: conductance of each node to the surroundings, W/K.
    """

    capacity_j_k: list[float] = field(default_factory=list)
    links: list[tuple[int, int, float]] = field(default_factory=list)
    ambient_w_k: list[float] = field(default_factory=list)

    def node(self, capacity_j_k: float, ambient_w_k: float = 0.0) -> int:
        """Add a node and return its number."""
        self.capacity_j_k.append(capacity_j_k)
        self.ambient_w_k.append(ambient_w_k)
        return len(self.capacity_j_k) - 1

    def link(self, first: int, second: int, w_k: float) -> None:
        """Join two nodes by a conductance, W/K."""
        self.links.append((first, second, w_k))

    def matrix(self) -> Array:
        """Return the conductance matrix, (n, n), W/K."""
        matrix = np.diag(np.array(self.ambient_w_k))
        for i, j, w_k in self.links:
            matrix[i, i] += w_k
            matrix[j, j] += w_k
            matrix[i, j] -= w_k
            matrix[j, i] -= w_k
        return matrix


class Stepper:
    """Temperatures of a network over time, K above ambient, (n,)."""

    def __init__(self, network: Network, contacts: Sequence[tuple[int, int]], step_s: float) -> None:
        """Prepare steps of one length, s; each states the conductance of the contacts, which are pairs of nodes."""
        self._rate = np.array(network.capacity_j_k) / step_s
        between = np.zeros((len(self._rate), len(contacts)))
        for number, (i, j) in enumerate(contacts):
            between[i, number], between[j, number] = 1.0, -1.0
        conductance = network.matrix()
        self._between = between
        self._ways = [self._prepared(conductance, share) for share in (1.0, 1.5)]
        self.above_k = np.zeros(len(self._rate))
        self._before_k: Array | None = None

    def _prepared(self, conductance: Array, share: float) -> tuple[Array, Array, Array]:
        inverse: Array = np.linalg.inv(conductance + np.diag(share * self._rate)).astype(np.float64)
        spread = inverse @ self._between
        return inverse, spread, self._between.T @ spread

    def settle(self, above_k: Array) -> None:
        """Begin at these temperatures; the first step after it is of first order."""
        self.above_k, self._before_k = above_k.copy(), None

    def step(self, contact_w_k: Array, heat_w: Array) -> Array:
        """Return the new temperatures, K above ambient, with conductances, W/K, and the heat into each node, W."""
        now_k = self.above_k
        if self._before_k is None:
            inverse, spread, coupling = self._ways[0]
            known = self._rate * now_k + heat_w
        else:
            inverse, spread, coupling = self._ways[1]
            known = self._rate * (2.0 * now_k - 0.5 * self._before_k) + heat_w
        free_k = inverse @ known
        if contact_w_k.any():
            flow_w = np.linalg.solve(
                np.eye(len(contact_w_k)) + contact_w_k[:, None] * coupling, contact_w_k * (self._between.T @ free_k)
            )
            free_k = free_k - spread @ flow_w
        self._before_k, self.above_k = now_k, free_k
        return free_k
