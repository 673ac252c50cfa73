"""Loads of the balls on the liner: the load of a lifter over a revolution, and the wear."""
