"""Scenes in TOML: the objects on a bench, and the script of a simulated hand.

A scene describes both the bench of a simulated remote site and a virtual environment.
"""

from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, ValidationError, field_validator, model_validator

from common.files.printable import printable
from common.files.read_files import NotToml, read_toml
from common.files.strict_model import StrictModel
from common.scenes.materials import ALIASES, Material, materials
from common.scenes.script import Step
from common.scenes.surfaces import STIFFNESS_N_M, surface_kind
from common.scenes.tender import TenderSpot
from common.scenes.tissue import Nodule, Tissue
from common.wire.packets import MAX_TEXT

SCENES = Path(__file__).parent
BENCH_M = 0.655
"""Range of the hand in x and y on each side of 0, m."""
Stiffness = Annotated[float | None, Field(ge=STIFFNESS_N_M[0], le=STIFFNESS_N_M[1])]
Offset = Annotated[float, Field(ge=-50.0, le=50.0)]


class SceneObject(StrictModel):
    """A rectangle of one material and one surface on the bench; its top is at z = `height_m`.

    Without `y_m` and `width_m` it covers all y. Without `stiffness_n_m` it has the stiffness of its surface.
    Its temperature is `absolute_c`, or ambient plus a value drawn from `offset_c` in each session. Objects of the same
    `body` are zones of one piece: they share one specimen and one drawn temperature. A `target` differs from its
    surroundings in that quantity, and is to be found. `tissue` makes the object soft tissue in a simulated world, with
    nodules; a virtual environment renders it without them.
    """

    name: str = Field(min_length=1, max_length=40)
    material: str
    surface: str
    body: str | None = None
    x_m: float = Field(ge=-BENCH_M, le=BENCH_M)
    length_m: float = Field(gt=0.005, le=2 * BENCH_M)
    y_m: float | None = Field(default=None, ge=-1.0, le=1.0)
    width_m: float | None = Field(default=None, gt=0.0, le=2.0)
    height_m: float = Field(default=0.0, ge=-0.004, le=0.004)
    stiffness_n_m: Stiffness = None
    thickness_m: float | None = Field(default=None, gt=0.0005, le=1.0)
    offset_c: tuple[Offset, Offset] = (-3.0, 3.0)
    absolute_c: float | None = Field(default=None, ge=-10.0, le=60.0)
    target: Literal["temperature", "roughness", "stiffness"] | None = None
    tissue: Tissue | None = None

    @field_validator("material")
    @classmethod
    def _specimen(cls, name: str) -> str:
        return ALIASES.get(name, name)

    @field_validator("surface")
    @classmethod
    def _known_surface(cls, name: str) -> str:
        surface_kind(name)
        return name

    @model_validator(mode="after")
    def _shape(self) -> Self:
        if (self.y_m is None) != (self.width_m is None):
            raise ValueError("give both y_m and width_m, or neither")
        if not self.offset_c[0] <= self.offset_c[1]:
            raise ValueError("offset_c must be [low, high] with low <= high")
        if self.tissue is not None and self.y_m is None:
            raise ValueError("an object with tissue needs y_m and width_m")
        for nodule in () if self.tissue is None else self.tissue.nodules:
            if not self.covers(nodule.x_m, nodule.y_m):
                raise ValueError(f"nodule {nodule.name!r} does not lie below the object")
        return self

    @property
    def end_x_m(self) -> float:
        """Far edge in x, m."""
        return self.x_m + self.length_m

    @property
    def stiffness(self) -> float:
        """Contact stiffness, N/m."""
        return surface_kind(self.surface).stiffness_n_m if self.stiffness_n_m is None else self.stiffness_n_m

    @property
    def middle_m(self) -> tuple[float, float]:
        """Position of its middle, m."""
        return self.x_at(0.5), sum(self.y_range_m) / 2.0

    @property
    def y_range_m(self) -> tuple[float, float]:
        """Edges in y, m."""
        if self.y_m is None or self.width_m is None:
            return (-2.0, 2.0)
        return (self.y_m, self.y_m + self.width_m)

    def x_at(self, u: float) -> float:
        """Return world x at fraction `u` (0..1) of the object, m."""
        return self.x_m + u * self.length_m

    def covers(self, x_m: float, y_m: float) -> bool:
        """Return whether the object covers a position on the bench."""
        low_y_m, high_y_m = self.y_range_m
        return self.x_m <= x_m < self.end_x_m and low_y_m <= y_m < high_y_m


class Scene(StrictModel):
    """A bench with objects, and the script of the hand; the script repeats after its last step.

    `calibrated` names the materials in the remote site's table. `table` names that table where its name is not the
    scene's. With `pieces` "calibrated", objects of these materials are the same blocks as in the calibration. With
    "new", each session draws pieces of its own. `virtual_stiffness_n_m` applies to all objects in a virtual
    environment, as in Kron & Schmidt 2003; without it each object has its own. `materials` are known in this scene
    only. `tender` are places where a simulated patient feels pain.
    """

    name: str
    ambient_c: float = Field(default=23.0, ge=5.0, le=35.0)
    materials: dict[str, Material] = Field(default_factory=dict)
    calibrated: tuple[str, ...] = ()
    table: str | None = None
    pieces: Literal["new", "calibrated"] = "new"
    virtual_stiffness_n_m: Stiffness = None
    objects: tuple[SceneObject, ...] = Field(min_length=1)
    tender: tuple[TenderSpot, ...] = ()
    script: tuple[Step, ...] = ()

    @field_validator("materials", mode="before")
    @classmethod
    def _own_materials(cls, tables: object) -> object:
        if not isinstance(tables, dict):
            raise ValueError("must be tables [materials.NAME]")
        for name in tables:
            if name in ALIASES or name in materials():
                raise ValueError(f"{name}: is the name of a known material; choose another")
            if len(name) > MAX_TEXT:
                raise ValueError(f"{name}: is longer than {MAX_TEXT} characters")
        # A material of the scene describes this very piece, so its spread is 0 by default.
        return {
            name: Material.read(name, {"spread": 0.0, **given} if isinstance(given, dict) else given, name)
            for name, given in tables.items()
        }

    @field_validator("calibrated")
    @classmethod
    def _specimens(cls, names: tuple[str, ...]) -> tuple[str, ...]:
        return tuple(ALIASES.get(name, name) for name in names)

    @model_validator(mode="after")
    def _known_materials(self) -> Self:
        used = {f"objects.{number}.material": thing.material for number, thing in enumerate(self.objects)}
        used |= {f"calibrated.{number}": name for number, name in enumerate(self.calibrated)}
        known = {*materials(), *self.materials}
        for field, name in used.items():
            if name not in known:
                raise ValueError(f"{field}: unknown material {name!r}; known: {', '.join(sorted([*known, *ALIASES]))}")
        return self

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        names = [thing.name for thing in self.objects]
        if len(set(names)) != len(names):
            raise ValueError("two objects have the same name")
        for i, a in enumerate(self.objects):
            for b in self.objects[i + 1 :]:
                if _overlap(a, b):
                    raise ValueError(f"objects {a.name!r} and {b.name!r} overlap")
        for number, step in enumerate(self.script, 1):
            target = getattr(step, "object", None) or getattr(step, "to_object", None)
            if target is not None and target not in names:
                raise ValueError(f"script step {number} names no object {target!r}; there are {', '.join(names)}")
        return self

    @property
    def nodules(self) -> tuple[Nodule, ...]:
        """True nodules of all its objects."""
        return tuple(nodule for thing in self.objects if thing.tissue for nodule in thing.tissue.nodules)

    def knows_piece(self, material_name: str) -> bool:
        """Return whether objects of this material are blocks of the table's calibration."""
        return self.pieces == "calibrated" and material_name in self.calibrated

    def material(self, name: str) -> Material:
        """Return the constants of a material of the scene."""
        return self.materials.get(name) or materials()[name]

    def object_named(self, name: str) -> SceneObject:
        """Look an object up; raises KeyError where there is none of this name."""
        for thing in self.objects:
            if thing.name == name:
                return thing
        raise KeyError(f"scene {self.name!r} has no object {name!r}")


def _overlap(a: SceneObject, b: SceneObject) -> bool:
    slack = 1e-9
    apart_x = a.end_x_m <= b.x_m + slack or b.end_x_m <= a.x_m + slack
    (a_low, a_high), (b_low, b_high) = a.y_range_m, b.y_range_m
    return not (apart_x or a_high <= b_low + slack or b_high <= a_low + slack)


def scene_names() -> tuple[str, ...]:
    """Return the names of the scenes shipped with the program."""
    return tuple(sorted(path.stem for path in SCENES.glob("*.toml")))


def load_scene(name_or_path: str) -> Scene:
    """Load a scene by its name, or from a path that ends in `.toml`.

    Raises:
        ValueError: the scene is unknown (the message lists the known ones), or the file is unreadable or invalid; the
            message is one line that names file and field.
    """
    path = Path(name_or_path) if name_or_path.endswith(".toml") else SCENES / f"{name_or_path}.toml"
    known = scene_names()
    if path.parent == SCENES and path.stem not in known:
        raise ValueError(f"unknown scene {name_or_path!r}; known: {', '.join(known)} (or a path that ends in .toml)")
    try:
        return Scene.model_validate(read_toml(path)[1])
    except ValidationError as error:
        first = error.errors()[0]
        field = printable(".".join(str(part) for part in first["loc"]), 200)
        message = printable(first["msg"].removeprefix("Value error, "))
        raise ValueError(f"{path}: {field + ': ' if field else ''}{message}") from None
    except NotToml as error:
        raise ValueError(f"{path}: {error}") from None
    except OSError as error:
        raise ValueError(f"{path}: cannot read the scene: {error.strerror}") from None
