"""Damaged files, from good ones: hypothesis strategies."""

import copy
import json
import re

from hypothesis import strategies as st

WORDS = (
    "", "x", "nan", "inf", "-inf", "1e999", "-1", "0", "1e308", "1e-320", "0x10", "1_0", "9" * 400,
    "../../escaped", "/tmp/escaped", "..", "a/b", "a\nshell touch escaped\n", "${x}", "$(step)",
    "\x00", "\u2028", "[red]", "%s%n", "{0.__class__}", "__import__('os').system('touch escaped')",
    "x" * 5000, "sb-cg-paper-S1.000/../../../escaped",
)  # fmt: skip
_NUMBERS = (
    0, -1, 1, 2, 3, 10**6, 10**9, 2**31, 2**63, 10**30, 10**400, 0.0, -0.0, 1e-320, 1e-9, 0.5,
    1e15, 1e300, -1e300, float("nan"), float("inf"),
)  # fmt: skip
_NUMBER = re.compile(rb"-?\d+\.?\d*(?:[eE][-+]?\d+)?")

wild = st.recursive(
    st.sampled_from(WORDS) | st.sampled_from(_NUMBERS) | st.booleans() | st.none()
    | st.floats() | st.integers() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=4)
    | st.dictionaries(st.sampled_from(("a", "S", "radius_m", "..")), inner, max_size=3),
    max_leaves=6,
)  # fmt: skip


@st.composite
def damaged(draw, originals):
    """Bytes of one of the files `originals` with a few faults."""
    data = bytearray(draw(st.sampled_from(originals)))
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, len(data)))
        kind = draw(st.sampled_from(("flip", "put", "drop", "cut", "again", "number", "number")))
        if kind == "flip" and at < len(data):
            data[at] ^= draw(st.integers(1, 255))
        elif kind == "put":
            data[at:at] = draw(
                st.binary(max_size=12) | st.sampled_from([b"\n", b"\xff", b"\0" * 90])
            )
        elif kind == "drop":
            del data[at : at + draw(st.integers(1, 200))]
        elif kind == "cut":
            del data[at:]
        elif kind == "again":
            length = draw(st.integers(1, 2000))
            data[at:at] = data[at : at + length]
        elif kind == "number":
            _change_number(data, at, draw(st.sampled_from(WORDS)).encode())
    return bytes(data)


def _change_number(data, at, word):
    found = _NUMBER.search(data, at)
    if found:
        data[found.start() : found.end()] = word


@st.composite
def documents(draw, originals):
    """Content of one of the JSON or TOML documents with a few values changed, dropped or added."""
    document = copy.deepcopy(draw(st.sampled_from(originals)))
    for _ in range(draw(st.integers(1, 4))):
        _change(draw, document)
    return document


def _change(draw, document):
    place = document
    while True:
        keys = list(place) if isinstance(place, dict) else list(range(len(place)))
        if not keys:
            return
        key = draw(st.sampled_from(keys))
        deeper = isinstance(place[key], dict | list) and draw(st.integers(0, 5)) > 0
        if not deeper:
            break
        place = place[key]
    kind = draw(st.sampled_from(("change", "change", "change", "drop", "add")))
    if kind == "change":
        place[key] = draw(wild)
    elif kind == "drop":
        del place[key]
    elif isinstance(place, dict):
        place[draw(st.sampled_from(WORDS))] = draw(wild)


def as_json(document) -> bytes:
    return json.dumps(document).encode()


def as_toml(document) -> bytes:
    """TOML of sections of simple values; what TOML has not becomes text that it refuses."""
    lines = []
    for name, section in document.items():
        if not isinstance(section, dict):
            lines.insert(0, f"{_key(name)} = {_value(section)}")
            continue
        lines.append(f"[{_key(name)}]")
        lines += [f"{_key(key)} = {_value(value)}" for key, value in section.items()]
    return "\n".join(lines).encode(errors="surrogatepass")


def _key(name):
    return name if re.fullmatch(r"\w+", name, re.A) else json.dumps(name)


def _value(value):
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value)
