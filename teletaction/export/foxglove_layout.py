"""Panels of Foxglove that show a session: forces, temperatures, motors, modes, materials, maps and events."""

import json
from typing import Any

from common.fingers import FINGERS

_PLOTS = {
    "force": ("Force at the operator's fingers, N", "rendered", "force_n"),
    "contact": ("Contact force at the remote fingers, N", "touch", "contact_force_n"),
    "object": ("Temperature of the object, C", "touch", "object_c"),
    "plate": ("Plates at the operator's fingers, C", "rendered", "plate_c"),
    "motor": ("Motors, rpm", "rendered", "motor_rpm"),
}
"""Title, stream of the operator site and field of each plot."""
_ORDER = ("contact", "force", "object", "plate", "motor")
"""Plots from top to bottom, of the same height."""
_PLOT = {
    "showLegend": True,
    "legendDisplay": "floating",
    "showXAxisLabels": True,
    "showYAxisLabels": True,
    "showPlotValuesInLegend": False,
    "isSynced": True,
    "xAxisVal": "timestamp",
    "sidebarDimension": 240,
}
Panel = dict[str, Any]


def _paths(stream: str, field: str, label: str = "{finger}", **more: bool) -> list[Panel]:
    """Return the path of a field of each finger."""
    return [
        {
            "value": f"/operator/{stream}.{finger}.{field}",
            "label": label.format(finger=finger),
            **more,
            "timestampMethod": "receiveTime",
        }
        for finger in FINGERS
    ]


def _image(quantity: str) -> Panel:
    return {"imageMode": {"imageTopic": f"/map/{quantity}"}}


def _split(first: object, second: object, direction: str, percent: int) -> Panel:
    """Return two panels, one beside or above the other; the first has a share of the room."""
    return {"first": first, "second": second, "direction": direction, "splitPercentage": percent}


def _column(plots: tuple[str, ...]) -> object:
    first, *rest = plots
    return f"Plot!{first}" if not rest else _split(f"Plot!{first}", _column(tuple(rest)), "column", 100 // len(plots))


def _layout() -> Panel:
    plots = {
        f"Plot!{name}": {"title": title, "paths": _paths(stream, field, enabled=True), **_PLOT}
        for name, (title, stream, field) in _PLOTS.items()
    }
    named = [path for field in ("mode", "material") for path in _paths("touch", field, f"{{finger}} {field}")]
    maps = _split("Image!temperature", "Image!stiffness", "row", 50)
    events = _split("StateTransitions!mode", _split(maps, "RosOut!log", "column", 65), "column", 35)
    return {
        "configById": plots
        | {
            "StateTransitions!mode": {"paths": named, "isSynced": True},
            "Image!temperature": _image("temperature"),
            "Image!stiffness": _image("stiffness"),
            "RosOut!log": {"searchTerms": [], "minLogLevel": 1, "topicToRender": "/log"},
        },
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": _split(_column(_ORDER), events, "row", 55),
    }


LAYOUT = json.dumps(_layout(), indent=1).encode() + b"\n"
"""The file that Foxglove imports."""
