"""Analysis of run folders: reads case.json, series.csv, dumps and timing.json, nothing else."""

import importlib

_HOME = {
    "RunFolderError": "run_folder",
    "analyse_case": "case",
    "build_report": "report",
}
__all__ = ["RunFolderError", "analyse_case", "build_report"]


def __getattr__(name: str):
    # On first use: the analysis of a case need not wait for the report's plotting library.
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOME[name]}"), name)
