"""Fingers and addresses in configurations, and the base of their sections."""

from typing import Annotated, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

FingerName = Literal["thumb", "index", "middle", "ring", "little"]


def _each_once(fingers: tuple[str, ...]) -> tuple[str, ...]:
    if len(set(fingers)) < len(fingers):
        raise ValueError("a finger is named twice")
    return fingers


Fingers = Annotated[tuple[FingerName, ...], Field(min_length=1, max_length=5), AfterValidator(_each_once)]
Addresses = dict[FingerName, str]
"""Address of each finger's serial device: a tty path or `socket://host:port`."""


class Section(BaseModel):
    """A section of a configuration. Unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True)
