"""Calibration: contact parameters with which a mill agrees with what was measured."""
