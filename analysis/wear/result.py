"""The part `liner_loads` of result.json."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from millscale.analysis.result_file import LifterForce, LinerLoadsResult
from millscale.analysis.wear.lifter_load import LifterLoad, lifter_loads
from millscale.analysis.wear.loads import FACES, LinerLoads, read_liner_loads
from millscale.runs.case_file import Case


def read_liner_loads_result(folder: Path, case: Case) -> LinerLoadsResult:
    """Return the loads on the liner of a case folder, summed over the window of the files.

    Raises:
        RunFolderError: a file is missing or not whole.
    """
    loads = read_liner_loads(folder, case)
    slip = loads.of_bins("slip_work_J")
    on_liner = float(slip.sum())
    return LinerLoadsResult(
        from_rad=loads.from_rad,
        to_rad=loads.to_rad,
        duration_s=loads.duration,
        torque_Nm=loads.total("torque_impulse_Nms") / loads.duration,
        slip_power_W=loads.total("slip_work_J") / loads.duration,
        normal_dissipation_W=loads.total("normal_dissipation_J") / loads.duration,
        impacts_per_s=loads.total("impacts") / loads.duration,
        impact_power_W=loads.total("impact_energy_J") / loads.duration,
        slip_share={face: _share(slip, loads, face, on_liner) for face in FACES},
        lifters=tuple(map(_force, lifter_loads(loads, case))),
    )


def _share(slip: np.ndarray, loads: LinerLoads, face: str, whole: float) -> float | None:
    """Return the share of a face in the slip work on the liner; None without slip."""
    return float(slip[loads.bins.faces == face].sum()) / whole if whole else None


def _force(load: LifterLoad) -> LifterForce:
    size = load.size
    largest = int(np.argmax(size))
    return LifterForce(
        lifter=load.lifter,
        mean_N_m=float(size.mean()),
        largest_N_m=float(size[largest]),
        largest_at_rad=float(load.angle[largest]),
        toe_rad=load.toe,
        shoulder_rad=load.shoulder,
    )
