"""Which of the open pages acts: the first that may, until it goes or another takes over."""

from dataclasses import dataclass

from operator_site.console.web.clients import Client


@dataclass(slots=True)
class Control:
    """Which page acts: one at a time."""

    holder: Client | None = None

    @property
    def name(self) -> str:
        """Of the page in control."""
        return "nobody" if self.holder is None else self.holder.name

    def offer(self, client: Client) -> None:
        """A page that may act has come, or may take over from one that is gone."""
        if self.holder is None and client.acts:
            self.holder = client

    def left(self, client: Client, others: list[Client]) -> None:
        """A page has gone; the longest present of the others that may act is in control."""
        if self.holder is client:
            self.holder = next((other for other in others if other.acts), None)
