"""The physical mill from its scaled mills: extrapolation to S = 1 with an interval."""
