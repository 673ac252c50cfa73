"""Kinds of observables by what makes their error, and the prior of the exponent of each.

Both mechanisms follow the inertial number I of the flowing layer, which grows as S (derived here;
docs/theory/prediction.md):

- Friction: mu(I) = mu_s + (mu_2 - mu_s) / (1 + I_0 / I) (Jop, Forterre, Pouliquen, Nature 441
  (2006) 727, doi 10.1038/nature04801). The local exponent of its change with S is
  (I_0 - I) / (I_0 + I): 1 at a small I, 0 at I = I_0, -1/2 at I = 3 I_0, about .9, where dense flow
  ends.
- Dilation: the solid fraction falls linearly with I in dense flow (da Cruz et al., Phys. Rev. E 72
  (2005) 021309, doi 10.1103/PhysRevE.72.021309): p = 1. It falls more slowly where the layer is
  nearly collisional, hence values down to 1/2. The thickness of the layer in balls changes as
  well, in either direction, hence values somewhat above 1.
"""

from __future__ import annotations

from enum import Enum

from millscale.prediction.extrapolation import WIDE, Prior


class Kind(Enum):
    """What makes the error of an observable of a scaled mill."""

    FRICTION = "friction"
    DILATION = "dilation"
    SHAPE = "shape"
    UNKNOWN = "unknown"

    @property
    def prior(self) -> Prior:
        return _PRIORS[self]


_PRIORS = {
    Kind.FRICTION: Prior(-0.5, 1.0),
    Kind.DILATION: Prior(0.5, 1.25),
    # Both act: from friction at I = I_0, the logarithm, to linear.
    Kind.SHAPE: WIDE,
    # Either of the two.
    Kind.UNKNOWN: Prior(-0.5, 1.25),
}
