"""Timing of the time step against tuned stock LIGGGHTS and other engines."""
