"""The commands of the how-to pages, as they stand there."""

import re

from tests.places import ROOT

NOT_RUN = "# not run in the tests"


def blocks(page: str) -> dict[str, list[str]]:
    """Blocks of commands of a page by their heading, but for those that say that they are not run."""
    found: dict[str, list[str]] = {}
    text = (ROOT / page).read_text("utf-8")
    for part in re.split(r"^##? ", text, flags=re.MULTILINE)[1:]:
        heading, _, body = part.partition("\n")
        made = [
            re.sub("^    ", "", block, flags=re.MULTILINE)
            for block in re.findall(r"(?:^    .*\n)+", body, re.MULTILINE)
        ]
        found[heading] = [block for block in made if not block.startswith(NOT_RUN)]
    return {heading: made for heading, made in found.items() if made}


def named_in_passing(page: str) -> list[str]:
    """Commands of docker-compose that a page names within a sentence."""
    return re.findall(r"`(docker-compose [^`]+)`", (ROOT / page).read_text("utf-8"))
