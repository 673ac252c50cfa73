"""Liners of any shape: read from files or made from few numbers, checked, as `_core.Profile`."""
