"""Who evaluates the contacts between balls: the table every contact test goes through.

A path is a name and the words behind the stock `pair_style gran` line. A new one is a line here.
"""

from __future__ import annotations

from pathlib import Path

CONTACT_PATHS = {
    "stock": "",
    "fast-v2": "surface fast kernel 2",
    "fast-v3": "surface fast kernel 3",
    "fast-v4": "surface fast kernel 4",
    "mixed-v3": "surface fast kernel 3 precision mixed",
    "mixed-v4": "surface fast kernel 4 precision mixed",
}
# What a kernel's instructions need of the processor, in the words of the system.
_NEEDS = {"fast-v3": "avx2", "fast-v4": "avx512vl", "mixed-v3": "avx2", "mixed-v4": "avx512vl"}


def available_paths() -> list[str]:
    """Names of the paths this machine can run."""
    flags = Path("/proc/cpuinfo").read_text() if Path("/proc/cpuinfo").exists() else ""
    return [name for name in CONTACT_PATHS if _NEEDS.get(name, "") in flags]
