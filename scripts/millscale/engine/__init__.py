"""Runs of the engine: mpirun, log, attempts, restart files, provenance."""
