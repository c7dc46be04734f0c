"""Reads and writes a site's note of the patient's consent, for the answer to hello and for status files."""

from collections.abc import Mapping
from typing import NamedTuple, Self

KINDS = ("touch", "pain", "picture", "voice")
"""What may be recorded."""
FIELD = "consented"
"""Field of the answer to hello: a list of KINDS; missing where nobody has asked the patient."""


class NotedConsent(NamedTuple):
    """Answer of the patient at one site.

    Attributes:
        agreed: KINDS that the patient agrees to have recorded; None where nobody has asked.
    """

    agreed: tuple[str, ...] | None

    @classmethod
    def of(cls, details: Mapping[str, object]) -> Self:
        """Read the field of a map; unknown kinds are left out, and anything but a list is no answer."""
        value = details.get(FIELD)
        return cls(tuple(kind for kind in KINDS if kind in value) if isinstance(value, list) else None)

    def details(self) -> dict[str, list[str]]:
        """Return the map from which `of` reads the same answer."""
        return {} if self.agreed is None else {FIELD: list(self.agreed)}
