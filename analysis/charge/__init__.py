"""Analysis of a charge: steady window, means, errors of scaled mills, energy budget."""
