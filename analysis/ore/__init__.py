"""Breakage of an ore by the impacts of finished charges, by published models: post-processing."""
