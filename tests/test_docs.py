"""The documentation: links, commands, lengths of lines and sentences, terms."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
import typer
from test_layers import CORE, PYTHON

from millscale.cli.main import app
from millscale.workflow.failures import KINDS

ROOT = Path(__file__).parents[1]
COLUMNS = 100
WORDS = 25  # of a sentence, and of a cell of a table
SOURCES = ("*.md", "*.py", "*.h", "*.cpp", "*.in", "*.toml", "*.sh", "*.j2", "scripts/*")

# Words that end with a full stop inside a sentence: names of journals, initials, "Fig. 8".
ABBREVIATIONS = re.compile(
    r"\b(?:e\.g|i\.e|etc|Figs?|Eqs?|Mech|Part|Comput|Comp|Eng|Chem|Appl|Metall|Trans|Technol"
    r"|Phys|Lett|J|B)\.$"
)
END_OF_SENTENCE = re.compile(r"[.!?][\"')*_\]]{0,3}\s+(?=[±\"'`*_\[(]|[A-Z0-9])")
ITEM = re.compile(r"(\s*)([-*]|\d+\.)\s+(.*)")
# Not the signature of a restart file, whose first words are "millscale restart step".
COMMAND = re.compile(
    r"\s*(?:\$ +)?(?:\.venv/bin/)?millscale\s+(?!restart step)([a-z][\w-]*)(?:\s+([a-z][\w-]*))?"
)
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
# Of the sentences and metaphors that style rewrites, what is left of them anywhere in the sources.
WITHDRAWN = (
    "if they are a pair of i and touch, its memory on i",
    "what the fastest ball around it travels",
    "their owners' to tell",
    "true of a ball that is nowhere",
    "Asks the memory for what a contact needs",
    "that lies all over it",
    "is the door of a runs folder",
    "Who keeps no account pays nothing",
    "A list reaches as far as its balls will go",
    "Simulation of ball mills that are too large to simulate",
    "of whatever part of it",
    "the Froude number stays, so the charge moves alike",
    "says how wrong each",
    "puts a term in all the same",
    "tells that it came to its end",
    "the queue's word",
    "whose process is gone without a word",
    "so what chance adds is taken off",
    "What does not exceed the latter says nothing",
    "that does not exceed it says nothing",
    "Elsewhere means the same case",
    "What goes for balls that do not meet is not said",
    "what the account leaves",
)
# Terms that the documentation has replaced, in prose: code keeps `fix mill/ledger` and `memory`.
TERMS = (
    (r"\bmemor(y|ies) of (a |the |all )?contacts?\b", "contact history"),
    (r"\btangential memor(y|ies)\b", "contact history, tangential displacement"),
    (r"\bcarriers?\b", "last lifter"),
    (r"\b(keep|keeps|kept) (an |no )?account\b|\baccount of the energy\b", "energy budget"),
    (r"\bwho evaluates\b|\bcontact paths?\b", "contact backend"),
    (r"\boutr[ua]n\b", "exceeded"),
    (r"\b(is|are) told\b|\btells\b", "is reported, states"),
    (r"\banew\b", "again"),
)


def markdown_files() -> list[Path]:
    listed = _tracked("*.md")
    return [ROOT / name for name in listed]


def _tracked(*patterns: str) -> list[str]:
    """Return the tracked and new files of the repository that match."""
    line = ["git", "-C", str(ROOT), "ls-files", "-co", "--exclude-standard", *patterns]
    done = subprocess.run(line, capture_output=True, text=True)
    if done.returncode:
        pytest.skip("not in a repository")
    return [name for name in done.stdout.splitlines() if (ROOT / name).is_file()]


FILES = markdown_files()
NAMES = [str(path.relative_to(ROOT)) for path in FILES]
each_file = pytest.mark.parametrize("path", FILES, ids=NAMES)


def lines_of(text: str) -> Iterator[tuple[int, str, str]]:
    """Yield number, kind and text of each line; kinds: code, blank, title, table, prose."""
    fenced, after_blank, code = False, True, False
    for number, line in enumerate(text.splitlines(), 1):
        if line.lstrip().startswith("```"):
            fenced = not fenced
            kind = "code"
        elif fenced:
            kind = "code"
        elif not line.strip():
            kind = "blank"
        elif line.startswith("    ") and (after_blank or code) and not ITEM.match(line):
            kind = "code"
        elif line.startswith("#"):
            kind = "title"
        elif line.lstrip().startswith("|"):
            kind = "table"
        else:
            kind = "prose"
        code = kind == "code" and not fenced and line.startswith("    ")
        after_blank = kind == "blank"
        yield number, kind, line


def paragraphs(text: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the first line's number and the lines of each paragraph and each item of a list."""
    begin, lines = 0, []
    for number, kind, line in lines_of(text):
        item = ITEM.match(line) if kind == "prose" else None
        if (kind != "prose" or item) and lines:
            yield begin, lines
            lines = []
        if kind == "prose":
            begin = begin if lines else number
            lines.append(item[3] if item else line.strip())
    if lines:
        yield begin, lines


def sentences(text: str) -> list[str]:
    """Return the sentences of a paragraph."""
    found, start = [], 0
    for end in END_OF_SENTENCE.finditer(text):
        head = text[start : end.end()].rstrip()
        in_code = text[: end.start()].count("`") % 2
        if in_code or ABBREVIATIONS.search(head.rstrip("\"')*_]")):
            continue
        found.append(head)
        start = end.end()
    return [*found, text[start:]]


def words(sentence: str) -> int:
    """Return the number of words; code and the target of a link count as one word and none."""
    plain = re.sub(r"\]\([^)]*\)", "]", re.sub(r"`[^`]*`", "code", sentence))
    return sum(bool(re.search(r"\w", word)) for word in plain.split())


def cells(row: str) -> list[str]:
    return [cell.strip() for cell in re.split(r"(?<!\\)\|", row.strip())[1:-1]]


@each_file
def test_a_line_has_at_most_100_columns(path):
    """A row of a table may be longer if the table has three columns or more."""
    long = []
    for number, kind, line in lines_of(path.read_text(encoding="utf-8")):
        shown = re.sub(r"\]\([^)]*\)", "]", line) if kind == "table" else line
        if len(shown) > COLUMNS and not (kind == "table" and len(cells(line)) > 2):
            long.append(f"{number}: {len(shown)} columns")
    assert not long


@each_file
def test_a_line_holds_no_more_than_one_sentence(path):
    for number, lines in paragraphs(path.read_text(encoding="utf-8")):
        for line in lines:
            assert len(sentences(line)) == 1, f"line {number} and following: {line}"


@each_file
def test_a_sentence_and_a_cell_have_at_most_25_words(path):
    text = path.read_text(encoding="utf-8")
    long = [
        (number, sentence)
        for number, lines in paragraphs(text)
        for sentence in sentences(" ".join(lines))
        if words(sentence) > WORDS
    ]
    long += [
        (number, cell)
        for number, kind, line in lines_of(text)
        if kind == "table"
        for cell in cells(line)
        if words(cell) > WORDS
    ]
    assert not long


def anchors(path: Path) -> set[str]:
    """Return the anchors that GitHub gives to the titles of a page."""
    found: set[str] = set()
    for _, kind, line in lines_of(path.read_text(encoding="utf-8")):
        if kind == "title":
            title = re.sub(r"\]\([^)]*\)", "]", line.lstrip("#").strip())
            found.add(re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-"))
    return found


@each_file
def test_relative_links_lead_to_files_and_titles(path):
    text = path.read_text(encoding="utf-8")
    prose = "\n".join(line for _, kind, line in lines_of(text) if kind != "code")
    broken = []
    for target in LINK.findall(re.sub(r"`[^`]*`", "", prose)) + re.findall(r'src="([^"]+)"', prose):
        if re.match(r"[a-z]+:", target):
            continue
        name, _, anchor = target.partition("#")
        file = (path.parent / name).resolve() if name else path
        if not file.exists() or (anchor and anchor not in anchors(file)):
            broken.append(target)
    assert not broken


def test_every_page_of_docs_is_linked_from_the_index_of_its_folder():
    for folder in sorted({path.parent for path in FILES if ROOT / "docs" in path.parents}):
        index = (folder / "README.md").read_text(encoding="utf-8")
        pages = {path.name for path in folder.glob("*.md")} - {"README.md"}
        assert pages <= {target.partition("#")[0] for target in LINK.findall(index)}, folder


def test_paths_of_docs_in_sources_exist():
    wrong = []
    for name in _tracked(*SOURCES):
        for found in re.findall(r"\bdocs/[\w./-]+\.md\b", (ROOT / name).read_text("utf-8")):
            if not (ROOT / found).is_file():
                wrong.append((name, found))
    assert not wrong


def unknown_word(line: str) -> str:
    """Return the first command or option of a line with `millscale` that does not exist."""
    command = typer.main.get_command(app)
    named = COMMAND.match(line)
    for name in [name for name in named.groups() if name]:
        inner = getattr(command, "commands", {})
        # `bench` is a command and a group.
        if inner and name not in inner and command.name != "bench":
            return name
        command = inner.get(name, command)
    options = {name for option in command.params for name in (*option.opts, *option.secondary_opts)}
    given = re.findall(r"(?<=\s)--?[A-Za-z][\w-]*", line)
    return next((name for name in given if name not in {*options, "--help"}), "")


def test_every_command_and_option_in_the_documentation_exists():
    unknown = []
    for path in FILES:
        if path.name == "CHANGELOG.md":
            continue
        text = path.read_text(encoding="utf-8")
        code = "\n".join(line for _, kind, line in lines_of(text) if kind == "code")
        prose = "\n".join(line for _, kind, line in lines_of(text) if kind != "code")
        shown = code.replace("\\\n", " ").splitlines() + re.findall(r"`([^`]+)`", prose)
        for line in filter(COMMAND.match, (line.partition("  #")[0] for line in shown)):
            if word := unknown_word(line):
                unknown.append((path.name, line, word))
    assert not unknown


def test_the_reference_lists_every_command():
    listed = (ROOT / "docs/reference/commands.md").read_text(encoding="utf-8")
    group = typer.main.get_command(app)
    for name, command in group.commands.items():
        for inner in ("", *(f" {inner}" for inner in getattr(command, "commands", ()))):
            assert f"`millscale {name}{inner}" in listed


def test_the_guide_lists_every_kind_of_failure():
    text = (ROOT / "docs/guide/failures.md").read_text(encoding="utf-8")
    table = text.partition("| kind |")[2].partition("\n\n")[0].splitlines()[2:]
    assert {cells(row)[0] for row in table} == set(KINDS)


def test_the_architecture_names_the_layers_in_their_order():
    text = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    core, _, python = text.partition("**C++.**")[2].partition("**Python.**")
    assert tuple(re.findall(r"`(\w+)`[,.]", core.partition("`.\n")[0] + "`.")) == CORE
    table = [line for line in python.partition("\n## ")[0].splitlines() if line.startswith("| `")]
    rows = [tuple(re.findall(r"`(\w+)`", cells(line)[0])) for line in table]
    assert rows == [row for row in PYTHON if row != ("__main__",)]


def test_withdrawn_sentences_are_nowhere():
    found = []
    for name in _tracked(*SOURCES):
        if name == "tests/test_docs.py":
            continue
        text = (ROOT / name).read_text(encoding="utf-8")
        plain = re.sub(r"\s*\n\s*(///?|#|\*)?\s*", " ", text)
        found += [(name, part) for part in WITHDRAWN if part.lower() in plain.lower()]
    assert not found


@each_file
def test_terms_are_those_of_the_field(path):
    text = path.read_text(encoding="utf-8")
    prose = " ".join(" ".join(lines) for _, lines in paragraphs(text))
    prose = re.sub(r"`[^`]*`", "code", prose)
    found = [(term, instead) for term, instead in TERMS if re.search(term, prose)]
    assert not found
