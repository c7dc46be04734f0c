"""Joins what both sites have noted of the patient's consent: the stricter answer counts."""

from typing import NamedTuple

from common.wire.noted_consent import NotedConsent


class Consent(NamedTuple):
    """The patient's answers.

    Attributes:
        here: what the patient agrees to have recorded by the console's configuration; None where nobody has asked.
        remote: what the remote site has noted; None while it is unknown.
    """

    here: tuple[str, ...] | None
    remote: NotedConsent | None

    @property
    def there(self) -> tuple[str, ...] | None:
        """What the patient agrees to by the remote site; None where nobody has asked, or while it is unknown."""
        return None if self.remote is None else self.remote.agreed

    @property
    def agreed(self) -> tuple[str, ...] | None:
        """What both answers agree to. A site that has noted none does not restrict; None where neither has."""
        if self.here is None or self.there is None:
            return self.there if self.here is None else self.here
        return tuple(kind for kind in self.here if kind in self.there)

    @property
    def differs(self) -> bool:
        """Whether the known answers differ, or only one site has noted one."""
        return self.remote is not None and self.here != self.there

    def forbids(self, kind: str) -> bool:
        """Return whether an answer is known that does not agree to this kind."""
        return self.agreed is not None and kind not in self.agreed

    def allows(self, kind: str) -> bool:
        """Return whether the patient agrees to this kind, and the answer of the remote site is known."""
        return self.remote is not None and self.agreed is not None and kind in self.agreed
