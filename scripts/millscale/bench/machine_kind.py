"""The kind of a machine: the widest vectors that our kernels can use on it."""

from __future__ import annotations

from pathlib import Path

# Beyond x86-64-v3, in the words of the system.
_OF_V4 = {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"}
_OF_V3 = {"avx2", "fma", "bmi2"}
_CPU = Path("/proc/cpuinfo")


def machine_kind() -> str:
    """Return AVX-512, AVX2, or scalar."""
    for line in _CPU.read_text(encoding="utf-8", errors="replace").splitlines():
        name, _, words = line.partition(":")
        if name.strip() == "flags":
            return kind_of(set(words.split()))
    return kind_of(set())


def kind_of(flags: set[str]) -> str:
    """Return the kind of a processor with these flags."""
    if not flags >= _OF_V3:
        return "scalar"
    return "AVX-512" if flags >= _OF_V4 else "AVX2"
