"""The Python interface: what `import millscale as ms` offers, a file for each kind of task."""
