"""Initial packing of the charge and the state of the settled bed."""
