"""The fenced blocks of a page of the documentation, to be executed in its order."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

FENCE = re.compile(
    r"(?:^<!-- not run: (?P<reason>[^\n]+?) -->\n+)?^```(?P<kind>\w*)\n(?P<text>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
PROMPT = "$ "
# Stands in a page for lines of output that it leaves out.
LEFT_OUT = "..."


@dataclass
class Block:
    """A block of code.

    Attributes:
        kind: the word after the fence: bash, console (prompts and output), python, text, ...
        reason: why it is not run; empty for one that is.
    """

    kind: str
    text: str
    reason: str = ""


@dataclass
class Command:
    """A command of a console block, and the lines of output that the page shows below it."""

    line: str
    shown: list[str] = field(default_factory=list)


def blocks(page: str) -> list[Block]:
    """Return the blocks of a page in their order."""
    found = FENCE.finditer(page)
    return [Block(x["kind"], x["text"], x["reason"] or "") for x in found]


def commands(block: Block) -> list[Command]:
    """Return the commands of a bash or a console block; a bash block is one command."""
    if block.kind != "console":
        return [Command(block.text)]
    found: list[Command] = []
    for line in block.text.splitlines():
        if line.startswith(PROMPT):
            found.append(Command(line.removeprefix(PROMPT)))
        elif line != LEFT_OUT:
            found[-1].shown.append(line)
    return found
