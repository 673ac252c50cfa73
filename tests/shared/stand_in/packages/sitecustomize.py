"""Replaces the analysis and the report by stand-ins: a result as soon as there is a series.

Python imports this module at its start when PYTHONPATH names this folder.
"""

import json
import sys
from types import ModuleType


def analyse_case(folder):
    rows = (folder / "series.csv").read_text().splitlines()
    return {"rows": len(rows) - 1}


def build_report(runs, predict):
    (runs / "report").mkdir(exist_ok=True)
    (runs / "report" / "index.html").write_text("<html></html>")
    (runs / "report" / "results.json").write_text(json.dumps({"schema": 1}))


for _name, _function in (
    ("millscale.analysis.case", analyse_case),
    ("millscale.report.build", build_report),
):
    _module = ModuleType(_name)
    setattr(_module, _function.__name__, _function)
    sys.modules[_name] = _module
