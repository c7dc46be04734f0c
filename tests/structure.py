"""Measure the layout of the product: `python -m tests.structure > docs/structure.md`.

A box is a module at the top of a room, or a folder with all that is in it. An arrow is an import from one box to
another, counted once. Floors are the boxes on the longest way of arrows.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from statistics import median

import grimp

from tests.places import ROOT

ROOMS = ("common", "remote_site", "operator_site", "sim_sensors", "teletaction", "studies", "benchmarks", "robustness")
MOST_FILES = 25
"""Modules in one folder, at most."""
MOST_FLOORS = 8
OPAQUE = frozenset(
    [
        "told",
        "slow_telling",
        "desk",
        "desk_line",
        "desk_requests",
        "acceptance",
        "precedence",
        "held_rate",
        "descent",
        "motion_estimate",
        "drive_obeys",
        "encoder_jumps",
        "frame_damage",
        "lately",
        "reading_sums",
        "touch_guesses",
        "pressed_contact",
        "thermal_touches",
        "impulses",
        "press_fit",
        "sensed",
        "passive_update",
        "held_force",
        "felt_speed",
        "still_finger",
        "plate_loop",
        "plate_display",
        "attendance",
        "due",
        "words",
        "acts",
        "keeping",
        "kept_before",
        "picture",
        "shown_state",
        "session_book",
        "playing",
        "reading_ahead",
        "whereabouts",
        "doorkeeper",
        "ladder",
        "perceptible",
        "earlier_file",
        "cut_recording",
        "port_energy",
        "skin_dose",
        "left_work",
        "held_encoder",
        "surface_class",
        "stored_table",
        "fresh_ground",
        "told_hand",
        "faulty_parts",
    ]
)
"""Module names that do not say what the module holds."""
OTHERS = (
    ("python-can", 20, 222, 1293),
    ("ophyd-async", 26, 81, 1009),
    ("hapticore", 10, 126, 1078),
    ("opendbc", 27, 82, 1890),
)
"""Projects of this field: files in the fullest folder, lines of the median and the longest file; counted in 2026."""


@dataclass(frozen=True, slots=True)
class Room:
    """One room: modules of each folder, lines of each module, and arrows from each box to others."""

    folders: Mapping[str, int]
    lines: tuple[int, ...]
    arrows: Mapping[str, frozenset[str]]

    @property
    def floors(self) -> int:
        """Boxes on the longest way of arrows; raises ValueError where arrows go round."""
        return max((len(way) for way in map(self._longest, self.arrows)), default=0)

    def _longest(self, box: str, above: tuple[str, ...] = ()) -> tuple[str, ...]:
        if box in above:
            raise ValueError(f"imports go round: {' -> '.join((*above[above.index(box) :], box))}")
        below = [self._longest(other, (*above, box)) for other in self.arrows[box]]
        return (box, *max(below, key=len, default=()))


def measure() -> dict[str, Room]:
    """Every room of the product."""
    graph = grimp.build_graph(*ROOMS, cache_dir=None)
    return {room: _room(room, graph) for room in ROOMS}


def _room(room: str, graph: grimp.ImportGraph) -> Room:
    folders: dict[str, int] = {}
    lines: list[int] = []
    for path in sorted((ROOT / room).rglob("*.py")):
        lines.append(len(path.read_text("utf-8").splitlines()))
        if path.name != "__init__.py":
            folder = str(path.parent.relative_to(ROOT))
            folders[folder] = folders.get(folder, 0) + 1
    modules = [module for module in graph.modules if module.startswith(f"{room}.")]
    arrows: dict[str, set[str]] = {_box(module): set() for module in modules}
    for module in modules:
        for other in graph.find_modules_directly_imported_by(module):
            if other.startswith(f"{room}.") and _box(other) != _box(module):
                arrows[_box(module)].add(_box(other))
    return Room(folders, tuple(lines), {box: frozenset(others) for box, others in arrows.items()})


def _box(module: str) -> str:
    return module.split(".")[1]


def opaque_names() -> list[str]:
    """Modules whose names do not say what they hold."""
    paths = (path for room in ROOMS for path in (ROOT / room).rglob("*.py"))
    return sorted(str(path.relative_to(ROOT)) for path in paths if path.stem in OPAQUE)


def page() -> str:
    """The page of the layout, in Markdown."""
    rooms = measure()
    rows = []
    for name, room in rooms.items():
        fullest = max(room.folders, key=room.folders.__getitem__)
        arrows = sum(map(len, room.arrows.values()))
        rows.append(
            f"| `{name}` | {len(room.lines)} | `{fullest}`, {room.folders[fullest]} | {median(room.lines):.0f} | "
            f"{max(room.lines)} | {len(room.arrows)} | {arrows} | {room.floors} |"
        )
    lines = [count for room in rooms.values() for count in room.lines]
    most = max(count for room in rooms.values() for count in room.folders.values())
    others = [("teletaction", most, round(median(lines)), max(lines)), *OTHERS]
    return _PAGE.format(
        rows="\n".join(rows),
        others="\n".join("| " + " | ".join(map(str, row)) + " |" for row in others),
        most_files=MOST_FILES,
        most_floors=MOST_FLOORS,
    )


_PAGE = """# Layout in numbers

`python -m tests.structure` writes this page. A test holds its limits: at most {most_files} modules in a folder, at most
{most_floors} floors in a room, and no imports that go round.

A *box* is a module at the top of a room, or a folder with all that is in it. An *arrow* is an import from one box to
another, counted once. *Floors* are the boxes on the longest way of arrows.

| room | files | fullest folder | median lines | most lines | boxes | arrows | floors |
|---|---|---|---|---|---|---|---|
{rows}

Other projects of this field, counted in 2026:

| project | files in the fullest folder | median lines | most lines |
|---|---|---|---|
{others}
"""

if __name__ == "__main__":
    print(page(), end="")
