"""Rules about files that all Python sources keep."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = [
    path
    for folder in ("scripts", "analysis", "meshes")
    for path in sorted((ROOT / folder).rglob("*.py"))
    # Decks of other engines, which run without this package.
    if "decks" not in path.parts
]


def calls(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute | ast.Name):
            of_name = isinstance(node.func, ast.Name)
            name = node.func.id if of_name else node.func.attr
            owner = "" if of_name else ast.unparse(node.func.value)
            yield node, owner, name


def in_the_locales_encoding(node, owner, name):
    """Return whether a call reads or writes text in an encoding that depends on the machine."""
    given = {x.arg for x in node.keywords}
    if given & {"encoding", None}:
        return False
    if name in ("read_text", "write_text"):
        return bool(owner)
    if name == "open" and owner not in ("os", "Picture", "webbrowser"):  # they open no text
        words = [x.value for x in node.args if isinstance(x, ast.Constant)]
        return not any("b" in str(word) for word in words)
    # Only `subprocess` gives `text` this meaning.
    runs = owner == "subprocess" or name in ("Popen", "check_output")
    return runs and bool(given & {"text", "universal_newlines"})


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_no_source_uses_the_encoding_of_the_locale(path):
    found = [ast.unparse(x[0]) for x in calls(path) if in_the_locales_encoding(*x)]
    assert found == []


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("path.read_text()", True),
        ("path.read_text(encoding='utf-8')", False),
        ("(a / b).write_text(x)", True),
        ("write_text(path, x)", False),
        ("path.open()", True),
        ("path.open('w')", True),
        ("path.open('wb')", False),
        ("open(x)", True),
        ("os.open(x, 1)", False),
        ("subprocess.run(x, text=True)", True),
    ],
)
def test_the_rule_finds_each_call_that_depends_on_the_locale(tmp_path, text, found):
    (tmp_path / "a.py").write_text(text)
    assert [in_the_locales_encoding(*x) for x in calls(tmp_path / "a.py")][:1] == [found]
