"""Decides which page is in control: the first one that may act, until it leaves or another takes over."""

from dataclasses import dataclass

from operator_site.console.web.clients import Client


@dataclass(slots=True)
class Control:
    """Holds the one page in control, or None."""

    holder: Client | None = None

    @property
    def name(self) -> str:
        """Name of the page in control."""
        return "nobody" if self.holder is None else self.holder.name

    def offer(self, client: Client) -> None:
        """Give control to a page that may act, if no page has it."""
        if self.holder is None and client.acts:
            self.holder = client

    def left(self, client: Client, others: list[Client]) -> None:
        """Note that a page has left; the longest present of the others that may act takes over."""
        if self.holder is client:
            self.holder = next((other for other in others if other.acts), None)
