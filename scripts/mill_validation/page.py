"""docs/hard-cases.md from docs/results/hard-cases.json."""

from __future__ import annotations


def page(document):
    return ""
