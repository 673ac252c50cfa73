"""Power models of tumbling mills: what published formulas give for a mill, and where they end.

    >>> from millscale.power_models import Mill, models_for
    >>> mill = Mill(diameter=4.0, length=5.0, filling=0.35, fraction_of_critical=0.72,
    ...             bulk_density=4650.0)
    >>> [f"{row.name}: {row.power_kw:.0f} kW" for row in models_for(mill)][:2]
    ['Hogg-Fuerstenau: 1027 kW', 'Bond: 1137 kW']

Formulas, sources and limits: docs/theory/power-models.md.
"""

from millscale.power_models.austin import austin_power
from millscale.power_models.bond import bond_power
from millscale.power_models.hogg_fuerstenau import hogg_fuerstenau_power
from millscale.power_models.limits import Limit
from millscale.power_models.mill import Mill
from millscale.power_models.models import MODELS, ModelPower, PowerModel, mill_of, models_for
from millscale.power_models.morrell import (
    ChargeShape,
    charge_shape,
    morrell_gross_power,
    morrell_net_power,
    no_load_power,
)

__all__ = [
    "MODELS",
    "ChargeShape",
    "Limit",
    "Mill",
    "ModelPower",
    "PowerModel",
    "austin_power",
    "bond_power",
    "charge_shape",
    "hogg_fuerstenau_power",
    "mill_of",
    "models_for",
    "morrell_gross_power",
    "morrell_net_power",
    "no_load_power",
]
