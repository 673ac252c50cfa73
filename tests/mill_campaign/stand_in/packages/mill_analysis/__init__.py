"""Stands in for mill_analysis: a result as soon as there is a series."""

import json


class RunFolderError(ValueError):
    pass


def analyse_case(folder):
    rows = (folder / "series.csv").read_text().splitlines()
    return {"rows": len(rows) - 1}


def build_report(runs):
    (runs / "report").mkdir(exist_ok=True)
    (runs / "report" / "index.html").write_text("<html></html>")
    (runs / "report" / "results.json").write_text(json.dumps({"schema": 1}))
