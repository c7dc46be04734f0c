"""Five-fingered haptic teleoperation: the command line, sessions, recordings, and the Python interface.

`import teletaction as tt` gives the names of `__all__`. They are loaded on first use.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from teletaction.api.recording import Recording, Stream
    from teletaction.api.simulation import simulate

__all__ = ["Recording", "Stream", "simulate"]
_MODULES = {"Recording": "recording", "Stream": "recording", "simulate": "simulation"}


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module 'teletaction' has no attribute {name!r}")
    return getattr(import_module(f"teletaction.api.{_MODULES[name]}"), name)
