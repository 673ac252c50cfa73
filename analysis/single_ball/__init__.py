"""Analysis of a single ball: events, flight, energies, comparison with the law."""
