"""Limits LIGGGHTS 3.8.0 sets on a triangle mesh.

From its surface_mesh_I.h, multi_node_mesh.h and fix_mesh_surface.cpp. The engine compares angles
between 0 and 90 degrees: it takes the absolute value of the cosine of two normals, so a fold of 170
degrees counts as 10.
"""

import math

NODE_PRECISION_M = 1e-8
"""Nodes whose coordinates differ by less are one node."""

SMALLEST_ANGLE_SOFT_DEG = 0.5
"""Triangles with a smaller angle draw a warning that the mesh parallelises badly."""

SMALLEST_ANGLE_HARD_DEG = math.degrees(math.acos(0.9999995))
"""Triangles with a smaller angle (0.057 degrees) stop the run."""

CURVATURE_MAX_DEG = 60.0
"""Largest value of the keyword `curvature`. Triangles whose normals differ by less than `curvature`
are coplanar to the engine: one contact, one shear history. No triangle may have a smaller angle."""
