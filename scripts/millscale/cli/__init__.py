"""The command line `millscale`."""
