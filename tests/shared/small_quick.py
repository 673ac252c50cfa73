"""The quick campaign with larger balls: seconds instead of minutes, and what the notebooks show."""

from __future__ import annotations

import tomllib
from typing import Any

from paper_campaign import CAMPAIGNS


def content() -> dict[str, dict[str, Any]]:
    """Return the content of its campaign file: a single ball at three S with every policy, and the
    energy budget of thin slices of a charge at two S."""
    campaign = tomllib.loads((CAMPAIGNS / "quick.toml").read_text(encoding="utf-8"))
    campaign["campaign"] = {"name": "small-quick"}
    campaign["ball"]["radius_m"] = 0.035
    del campaign["wall"]
    campaign["scaling"] = {"schemes": ["constant-gravity"]}
    campaign["multi_ball"] = {
        "S": [2.6, 3.6],
        "filling": 0.25,
        "slice_diameters": 3.0,
        "settle_s": 0.8,
        "rotation_angle_rad": 8.0,
        "step_s": 2.9e-4,
        "dump_angle_rad": 0.5,
        "ledger": True,
    }
    return campaign
