"""Analysis of runs folders: reads case.json, series.csv, dumps and timing.json, nothing else."""
