"""Calibration: contact parameters with which a mill agrees with measurements or another mill."""
