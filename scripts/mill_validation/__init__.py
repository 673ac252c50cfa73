"""Hard cases for numerical stability, in the engine, and the map of where they turn unstable."""
