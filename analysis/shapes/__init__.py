"""Shape of a charge: solid fraction, contour, curtains, mass flow, throw angle."""
