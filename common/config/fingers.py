"""Fingers of a configuration, and the addresses of their devices."""

from typing import Annotated

from pydantic import AfterValidator, Field

from common.fingers import FingerName


def _each_once(fingers: tuple[str, ...]) -> tuple[str, ...]:
    if len(set(fingers)) < len(fingers):
        raise ValueError("a finger is named twice")
    return fingers


Fingers = Annotated[tuple[FingerName, ...], Field(min_length=1, max_length=5), AfterValidator(_each_once)]
Addresses = dict[FingerName, str]
"""Address of each finger's serial device: a tty path or `socket://host:port`."""
