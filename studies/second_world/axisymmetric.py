"""Builds the network of a sensor on a piece of material: rings of finite volumes around the middle of the contact."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from studies.second_world.heat_network import Network
from studies.second_world.ranges import AIR_W_M2K, Piece, Sensor

Array = NDArray[np.float64]
RINGS_INSIDE, RINGS_OUTSIDE, LAYERS = 6, 6, 16
"""Numbers of rings within the contact and around it, and of layers of the piece."""
FIRST_LAYER_M = 25e-6
"""Thickness of the layer at the surface, m; the layers below grow."""


@dataclass(frozen=True, slots=True)
class SensorOnPiece:
    """A sensor's and a piece's network.

    Attributes:
        network: nodes and links without the contact.
        plate: numbers of the plate's rings, from the middle outwards.
        surface: numbers of the piece's rings below them.
        ring_m2: area of each of these rings, m2.
        middle_m: mean radius of each of these rings, m.
        half_cell_w_m2k: conductance from the surface to the middle of its first layer, W/(m2 K).
        sensor_nodes: number of nodes of the sensor; they come first.
        back: number of the Peltier's back.
    """

    network: Network
    plate: tuple[int, ...]
    surface: tuple[int, ...]
    ring_m2: Array
    middle_m: Array
    half_cell_w_m2k: float
    sensor_nodes: int
    back: int


def grown(first: float, total: float, count: int) -> Array:
    """Return `count` steps that begin with `first`, grow evenly and add up to `total`."""
    low, high = 1.0 + 1e-9, 10.0
    for _ in range(80):
        ratio = 0.5 * (low + high)
        low, high = (ratio, high) if first * (ratio**count - 1.0) / (ratio - 1.0) < total else (low, ratio)
    steps = first * low ** np.arange(count, dtype=np.float64)
    return np.asarray(steps * (total / float(steps.sum())))


def alone(sensor: Sensor, leak: float) -> tuple[Network, tuple[int, ...], int]:
    """Return the network of a sensor in the air, the numbers of its plate's rings, and that of its back.

    `leak` is this unit's leaks as a multiple of the kind's.
    """
    network = Network()
    edges = np.linspace(0.0, sensor.radius_m, RINGS_INSIDE + 1)
    area_m2, middle_m = math.pi * np.diff(edges**2), 0.5 * (edges[1:] + edges[:-1])
    share = area_m2 / area_m2.sum()
    plate = tuple(network.node(sensor.plate_j_m3k * sensor.plate_m * float(a)) for a in area_m2)
    for k in range(len(plate) - 1):
        wall_m2 = 2.0 * math.pi * edges[k + 1] * sensor.plate_m
        network.link(plate[k], plate[k + 1], sensor.plate_w_mk * wall_m2 / (middle_m[k + 1] - middle_m[k]))
    back = network.node(sensor.back_j_k, sensor.back_w_k)
    pellets = network.node(sensor.pellet_j_k)
    through_w_k = leak * sensor.pellet_w_k * (1.0 + sensor.seebeck_share)
    for number, each in enumerate(plate):
        network.link(each, pellets, 2.0 * through_w_k * share[number])
    network.link(pellets, back, 2.0 * through_w_k)
    case = network.node(sensor.case_j_k, sensor.outer_w_k)
    network.link(plate[-1], case, leak * sensor.case_w_k)
    cable = network.node(sensor.cable_j_k, sensor.outer_w_k)
    network.link(plate[0], cable, leak * sensor.cable_w_k)
    return network, plate, back


def build(sensor: Sensor, leak: float, piece: Piece) -> SensorOnPiece:
    """Build the network of a sensor above a piece; arguments as for `alone`."""
    network, plate, back = alone(sensor, leak)
    sensor_nodes = len(network.capacity_j_k)
    edges: Array = np.concatenate(
        (
            np.linspace(0.0, sensor.radius_m, RINGS_INSIDE + 1),
            sensor.radius_m
            + np.cumsum(grown(sensor.radius_m / RINGS_INSIDE, piece.radius_m - sensor.radius_m, RINGS_OUTSIDE)),
        )
    )
    area_m2 = math.pi * np.diff(edges**2)
    middle_m = 0.5 * (edges[1:] + edges[:-1])
    surface = _piece(network, piece, area_m2, middle_m, edges)
    return SensorOnPiece(
        network,
        plate,
        surface[:RINGS_INSIDE],
        area_m2[:RINGS_INSIDE],
        middle_m[:RINGS_INSIDE],
        2.0 * piece.conductivity_w_mk / FIRST_LAYER_M,
        sensor_nodes,
        back,
    )


def _piece(network: Network, piece: Piece, area_m2: Array, middle_m: Array, edges: Array) -> tuple[int, ...]:
    layers_m = grown(FIRST_LAYER_M, piece.thickness_m, LAYERS)
    k_w_mk = piece.conductivity_w_mk
    number = np.empty((len(area_m2), LAYERS), dtype=int)
    for ring, a in enumerate(area_m2):
        for layer, thick_m in enumerate(layers_m):
            loss_w_k = 0.0
            if layer == LAYERS - 1:
                loss_w_k += AIR_W_M2K * a
            if layer == 0 and ring >= RINGS_INSIDE:
                loss_w_k += AIR_W_M2K * a
            if ring == len(area_m2) - 1:
                loss_w_k += AIR_W_M2K * 2.0 * math.pi * edges[-1] * thick_m
            number[ring, layer] = network.node(piece.heat_j_m3k * a * thick_m, loss_w_k)
    for ring, a in enumerate(area_m2):
        for layer in range(LAYERS - 1):
            apart_m = 0.5 * (layers_m[layer] + layers_m[layer + 1])
            network.link(int(number[ring, layer]), int(number[ring, layer + 1]), k_w_mk * a / apart_m)
    for ring in range(len(area_m2) - 1):
        apart_m = middle_m[ring + 1] - middle_m[ring]
        for layer, thick_m in enumerate(layers_m):
            wall_m2 = 2.0 * math.pi * edges[ring + 1] * thick_m
            network.link(int(number[ring, layer]), int(number[ring + 1, layer]), k_w_mk * wall_m2 / apart_m)
    return tuple(number[:, 0].tolist())
