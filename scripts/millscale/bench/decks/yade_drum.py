# The smooth drum in Yade, run by it: yade -n -x -j RANKS yade_drum.py. The same balls, contact law and time step; a drum of facets
# and two flat ends, a radius outside of the centres, since Yade's facets cannot turn through a periodic seam.
import json
import math
import time

values = json.load(open("values.json"))
balls = FrictMat(
    young=values["youngs_modulus"],
    poisson=values["poisson_ratio"],
    density=values["density"],
    frictionAngle=math.atan(values["friction"]),
)
O.materials.append(balls)
widest = 0.0
for x, y, z, radius, *motion in json.load(open("balls.json")):
    widest = max(widest, radius)
    body = sphere((x, y, z), radius, material=balls)
    number = O.bodies.append(body)
    O.bodies[number].state.vel = motion[:3]
    O.bodies[number].state.angVel = motion[3:]
length, count = values["length"], 300
ends = [O.bodies.append(wall((0, y, 0), axis=1, material=balls)) for y in (-widest, length + widest)]
turn = [2.0 * math.pi * k / count for k in range(count + 1)]
rim = [(values["mill_radius"] * math.cos(a), values["mill_radius"] * math.sin(a)) for a in turn]
margin, drum = 2.0 * widest, []
for (ax, az), (bx, bz) in zip(rim, rim[1:]):
    low, high = -margin, length + margin
    for corners in (
        ((ax, low, az), (bx, low, bz), (bx, high, bz)),
        ((ax, low, az), (bx, high, bz), (ax, high, az)),
    ):
        drum.append(O.bodies.append(facet(corners, material=balls)))
# Damping from en = 0.1 makes balls on joints of facets unstable at this step; the damping ratio of the same restitution does not.
damping = dict(betan=values["damping_ratio"])
O.engines = [
    ForceResetter(),
    InsertionSortCollider(
        [Bo1_Sphere_Aabb(), Bo1_Facet_Aabb(), Bo1_Wall_Aabb()], verletDist=values["skin"] / 2
    ),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom(), Ig2_Facet_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()],
        [Ip2_FrictMat_FrictMat_MindlinPhys(**damping)],
        [Law2_ScGeom_MindlinPhys_Mindlin()],
    ),
    RotationEngine(
        ids=drum,
        rotateAroundZero=True,
        zeroPoint=(0, 0, 0),
        rotationAxis=(0, 1, 0),
        angularVelocity=values["omega"],
    ),
    NewtonIntegrator(damping=0, gravity=(0, 0, -values["gravity"])),
]
O.dt = values["time_step"]
O.run(values["warm_steps"], True)
begin = time.perf_counter()
O.run(values["steps"], True)
seconds = time.perf_counter() - begin
speeds = [b.state.vel.norm() for b in O.bodies if isinstance(b.shape, Sphere)]
print(
    "TIMED",
    json.dumps({"seconds": seconds, "balls": len(speeds), "fastest": max(speeds)}),
    flush=True,
)
