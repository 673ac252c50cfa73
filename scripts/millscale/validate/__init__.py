"""Validation in the engine: hard cases, time step, energy budget, torque."""
