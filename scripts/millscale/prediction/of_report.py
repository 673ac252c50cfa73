"""Numbers of the physical mill for the report of a campaign, extrapolated from its scaled mills."""

from __future__ import annotations

from millscale.analysis.finished_campaign import Campaign
from millscale.errors import PredictionError
from millscale.prediction.predict import predict_numbers
from millscale.report.overview import LEVEL, Predicted


def predicted_numbers(campaign: Campaign) -> list[Predicted]:
    """Return what the scaled mills of a campaign predict; empty where they cannot: of one S alone,
    of several schemes or policies, or not steady."""
    if len({charge.S for charge in campaign.charges}) < 2:
        return []
    try:
        numbers = predict_numbers(campaign.charges, campaign.comparison.measured.numbers, LEVEL)
    except PredictionError:
        return []
    return [
        Predicted(row.observable.name, row.value, row.half_width)
        for row in numbers
        if row.value is not None and row.half_width is not None
    ]
