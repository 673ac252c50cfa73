"""Hypothesis strategies that damage valid files."""

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
_ENDS = (
    1e300, 1e200, 1e100, 1e15, 1e9, 1e6, 1e-6, 1e-9, 1e-100, 1e-200, 1e-300, 1e-320, 5e-324,
    1.7976931348623157e308, 2.2250738585072014e-308, 0.0, 1.0,
)  # fmt: skip
_ENCODINGS = (
    "utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-32", "latin-1", "cp1252", "cp037", "utf-7",
)  # fmt: skip
_TYPED = (
    ("\n", "\r\n"), ("\n", "\r"), (".", ","), ("-", "\u2212"), ("-", "\u2013"), ('"', "\u201c"),
    ('"', "'"), ("=", ":"), (" ", "\u00a0"), (" ", "\t"), ("e", "\u0435"), ("#", "//"), ("=", "=="),
    ("\n", "\u2028"), ("1", "\uff11"), ("m", "\u03bc"), ("[", "[["), ("\n", "\n\ufeff"),
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
    """Return bytes of one of the files `originals` with a few faults."""
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
    """Return one of the JSON or TOML documents with a few values changed, dropped or added."""
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


@st.composite
def at_the_ends(draw, originals):
    """Return one of the JSON or TOML documents with a few numbers at the limits of floats.

    Signs stay, so that more of them are accepted.
    """
    document = copy.deepcopy(draw(st.sampled_from(originals)))
    places = [(part, key) for part in _parts(document) for key, value in _items(part)
              if type(value) in (int, float)]  # fmt: skip
    for part, key in draw(st.lists(st.sampled_from(places), min_size=1, max_size=3)):
        number = draw(st.sampled_from(_ENDS) | st.floats(-300.0, 300.0).map(lambda x: 10.0**x))
        part[key] = int(min(number, 1e18)) if isinstance(part[key], int) else number
    return document


def _items(part):
    return part.items() if isinstance(part, dict) else enumerate(part)


def _parts(document):
    yield document
    for _, inner in _items(document):
        if isinstance(inner, dict | list):
            yield from _parts(inner)


@st.composite
def as_saved_elsewhere(draw, originals):
    """Return one of the text files `originals` in encodings and line ends of other programs."""
    text = draw(st.sampled_from(originals)).decode()
    for old, new in draw(st.lists(st.sampled_from(_TYPED), max_size=3)):
        at = draw(st.integers(0, len(text)))
        text = text[:at] + text[at:].replace(old, new, draw(st.sampled_from((1, -1))))
    return text.encode(draw(st.sampled_from(_ENCODINGS)), errors="replace")


def hostile():
    """Return content that harms a reader without checks."""
    return st.sampled_from(
        [
            b"[" * 200_000, b'{"a":' * 100_000, b"9" * 5000, b"1e400", b"NaN", b"-Infinity",
            b'{"schema": 1' + b"0" * 400 + b"}", b'"\x1b[2J"', b"\0" * 4096, b"\xff\xfe", b"",
            b'"' + b"x" * 1_000_000 + b'"', b"[1" + b", 1" * 300_000 + b"]", b"\n" * 300_000,
        ]
    )  # fmt: skip


def as_json(document) -> bytes:
    return json.dumps(document).encode()


def as_toml(document) -> bytes:
    """Return TOML of sections of simple values; other values become text that TOML refuses."""
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
