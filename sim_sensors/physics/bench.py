"""Build the bench of one session: a scene's objects with their randomly drawn properties, ready for the physics."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from common.fingers import FINGERS
from common.scenes.materials import Material
from common.scenes.scene import Scene, SceneObject
from sim_sensors.physics.object_column import ObjectColumn, object_column
from sim_sensors.physics.surface import GROOVE_DEPTH_M, make_profile, relief_of
from sim_sensors.physics.texture_touch import RELIEF_PER_M, compliance_share
from sim_sensors.physics.thermal_touch import STAGE_S, full_conductance_w_m2k
from sim_sensors.tissue.tissue_bed import TissueBed


@dataclass(frozen=True, slots=True)
class BenchObject:
    """One object in the terms of the physics; `track` is the start of each finger's profile in `Bench.heights_m`."""

    name: str
    material: str
    low_x_m: float
    high_x_m: float
    low_y_m: float
    high_y_m: float
    surface_z_m: float
    stiffness_n_m: float
    object_c: float
    column: ObjectColumn
    conductance_w_m2k: float
    area_share: float
    relief_per_m: float
    track: tuple[int, ...]
    grooves_x_m: tuple[float, ...]
    bed: TissueBed | None


@dataclass(frozen=True, slots=True)
class Specimen:
    """One piece of a material; conductivity and heat capacity are scaled alike, which keeps the diffusivity."""

    conductivity_w_mk: float
    heat_j_m3k: float

    @classmethod
    def draw(cls, kind: Material, rng: np.random.Generator, *, block: bool = False) -> "Specimen":
        """Draw ln(effusivity) around the material's value with its spread.

        `block` selects the known block of this material, which has the nominal constants in every session.
        """
        drawn = rng.standard_normal()
        scale = 1.0 if block else math.exp(kind.spread * drawn)
        return cls(kind.conductivity_w_mk * scale, kind.density_kg_m3 * kind.specific_heat_j_kgk * scale)


class Bench:
    """All objects of a session, and the profiles of height and slope below the five fingers."""

    def __init__(self, scene: Scene, rng: np.random.Generator, groove_depth_m: float = GROOVE_DEPTH_M) -> None:
        bodies: dict[str, tuple[Specimen, float]] = {}
        objects = []
        heights: list[NDArray[np.float32]] = []
        slopes: list[NDArray[np.float32]] = []
        start = 0
        for thing in scene.objects:
            body = thing.body or thing.name
            piece = Specimen.draw(scene.material(thing.material), rng, block=scene.knows_piece(thing.material))
            specimen, offset = bodies.setdefault(body, (piece, rng.uniform(*thing.offset_c)))
            profile = make_profile(relief_of(thing.surface), thing.length_m, rng, groove_depth_m)
            samples = profile.height_m.shape[1]
            tracks = tuple(start + finger * samples for finger in range(len(FINGERS)))
            start += profile.height_m.size
            heights.append(profile.height_m.ravel())
            slopes.append(profile.slope.ravel())
            object_c = scene.ambient_c + offset if thing.absolute_c is None else thing.absolute_c
            # A spawned generator leaves the numbers of all other draws as they are.
            bed = None if thing.tissue is None else TissueBed(thing, thing.tissue, rng.spawn(1)[0])
            objects.append(_bench_object(thing, specimen, object_c, tracks, profile.grooves_m, bed))
        self.objects = tuple(objects)
        self.heights_m = np.concatenate(heights)
        self.slopes = np.concatenate(slopes)

    def find(self, x_m: float, y_m: float, guess: int = -1) -> int:
        """Return the index of the object at a position, -1 for none; `guess` is tried first."""
        if guess >= 0:
            thing = self.objects[guess]
            if thing.low_x_m <= x_m < thing.high_x_m and thing.low_y_m <= y_m < thing.high_y_m:
                return guess
        for index, thing in enumerate(self.objects):
            if thing.low_x_m <= x_m < thing.high_x_m and thing.low_y_m <= y_m < thing.high_y_m:
                return index
        return -1


def _bench_object(
    thing: SceneObject,
    specimen: Specimen,
    object_c: float,
    tracks: tuple[int, ...],
    grooves_m: tuple[float, ...],
    bed: TissueBed | None,
) -> BenchObject:
    relief = relief_of(thing.surface)
    return BenchObject(
        name=thing.name,
        material=thing.material,
        low_x_m=thing.x_m,
        high_x_m=thing.end_x_m,
        low_y_m=thing.y_range_m[0],
        high_y_m=thing.y_range_m[1],
        surface_z_m=thing.height_m,
        stiffness_n_m=thing.stiffness,
        object_c=object_c,
        column=object_column(specimen.conductivity_w_mk, specimen.heat_j_m3k, thing.thickness_m, STAGE_S),
        conductance_w_m2k=full_conductance_w_m2k(specimen.conductivity_w_mk, relief.rms_m),
        area_share=relief.contact_fraction,
        relief_per_m=RELIEF_PER_M * compliance_share(thing.stiffness),
        track=tracks,
        grooves_x_m=tuple(thing.x_m + groove for groove in grooves_m),
        bed=bed,
    )
