"""The contact backends that every contact test goes through. A new one is a line here."""

from __future__ import annotations

from pathlib import Path

from millscale.campaign.contacts import ContactOptions

CONTACT_PATHS = {
    "stock": ContactOptions("stock", "plain"),
    **{f"fast-v{k}": ContactOptions(damping="plain", kernel=k) for k in (2, 3, 4)},
    **{f"mixed-v{k}": ContactOptions(damping="plain", precision="mixed", kernel=k) for k in (3, 4)},
}
# Instructions that a kernel needs, as /proc/cpuinfo names them.
_NEEDS = {"fast-v3": "avx2", "fast-v4": "avx512vl", "mixed-v3": "avx2", "mixed-v4": "avx512vl"}


def available_paths() -> list[str]:
    """Return the names of the backends that this machine can run."""
    flags = Path("/proc/cpuinfo").read_text() if Path("/proc/cpuinfo").exists() else ""
    return [name for name in CONTACT_PATHS if _NEEDS.get(name, "") in flags]
