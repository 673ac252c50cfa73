"""Timing of the time step: ours against tuned stock LIGGGHTS, on mills in motion."""
