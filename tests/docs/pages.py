"""The project's pages as their readers see them: headings, links, and blocks with what is said about them.

An invisible comment stands before what it is about, a block or a heading (then everything under it):

    <!-- what it prints -->                       no commands
    <!-- runs until it is ended -->               started beside what follows, ended with the page
    <!-- run by: tests/containers/test_x.py -->   another test runs these commands
    <!-- not run here: needs a CAN interface -->  nobody can here, and why
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache

from markdown_it import MarkdownIt
from markdown_it.token import Token

from tests.places import ROOT

PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
NAMES = [str(page.relative_to(ROOT)) for page in PAGES]
PRINTED, LASTING, RUN_BY, NOT_RUN = "what it prints", "runs until it is ended", "run by", "not run here"
_COMMENT = re.compile(r"<!--\s*(.*?)\s*-->", re.DOTALL)
_MARKDOWN = MarkdownIt("commonmark").enable("table")


@dataclass(frozen=True, slots=True)
class Block:
    """One block of code.

    Attributes:
        page: its page's name.
        line: where it begins.
        info: what stands behind its fence, in words; none of an indented block.
        text: what is in it.
        said: the comments that are about it, each `(kind, the rest)`.
    """

    page: str
    line: int
    info: tuple[str, ...]
    text: str
    said: dict[str, str]

    @property
    def commands(self) -> bool:
        """Whether these are commands for a shell: an indented block, or a fence of `sh`."""
        return PRINTED not in self.said and (not self.info or self.info[0] == "sh")

    @property
    def where(self) -> str:
        """Page and line."""
        return f"{self.page}:{self.line}"


@cache
def tokens(name: str) -> list[Token]:
    """A page, parsed once; nobody changes what is returned."""
    return _MARKDOWN.parse((ROOT / name).read_text("utf-8"))


def blocks(name: str) -> list[Block]:
    """All blocks of a page, in their order."""
    found: list[Block] = []
    under: list[tuple[int, dict[str, str]]] = []
    said: dict[str, str] = {}
    for token in tokens(name):
        if token.type == "html_block":
            for comment in _COMMENT.findall(token.content):
                kind, _, rest = comment.partition(":")
                said[kind.strip()] = rest.strip()
            continue
        if token.type == "heading_open":
            level = int(token.tag[1])
            under = [(above, about) for above, about in under if above < level]
            under.append((level, said))
        if token.type in {"fence", "code_block"}:
            about = {kind: rest for _, above in under for kind, rest in above.items()} | said
            line = token.map[0] + 1 if token.map else 0
            found.append(Block(name, line, tuple(token.info.split()), token.content, about))
        if not token.type.endswith("_open") or token.type == "heading_open":
            said = {}
    return found


def links(name: str) -> Iterator[tuple[str, int]]:
    """Where a page's links and pictures lead, and the line."""
    for token in tokens(name):
        for child in token.children or ():
            target = child.attrGet("href" if child.type == "link_open" else "src")
            if child.type in {"link_open", "image"} and target is not None:
                yield str(target), token.map[0] + 1 if token.map else 0


@cache
def anchors(name: str) -> set[str]:
    """The anchors of a page's headings, as the repository's view and the site make them."""
    page = tokens(name)
    titles = [page[at + 1].children or [] for at, token in enumerate(page) if token.type == "heading_open"]
    texts = ("".join(child.content for child in title if child.type in {"text", "code_inline"}) for title in titles)
    return {re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", "-") for text in texts}


def code_spans(name: str) -> Iterator[tuple[str, str, int]]:
    """Code within a page's text, what follows each, and the line."""
    for token in tokens(name):
        children = token.children or []
        for at, child in enumerate(children):
            if child.type == "code_inline":
                after = children[at + 1].content if at + 1 < len(children) else ""
                yield child.content, after, token.map[0] + 1 if token.map else 0
