"""Defines the answer to a request of a page, and what carries a request out."""

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any

from operator_site.console.web.clients import Client


@dataclass(frozen=True, slots=True)
class Answer:
    """Answer to a request of a page."""

    ok: bool
    text: str
    details: dict[str, Any] | None = None


Act = Callable[[Client, dict[str, Any], float], Awaitable[Answer]]
"""Carries out one verb for a page, with its details, at a time, s."""
