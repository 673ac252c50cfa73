"""A campaign of two single balls and one small charge, for tests of running, not of physics."""

SINGLE_BALLS = ("sb-cg-paper-S1.000", "sb-cg-paper-S2.000")
CHARGE = "mb-cg-paper-S2.000"

TEXT = """
[campaign]
name = "small"

[mill]
radius_m = 1.0
length_m = 0.3
speed_rad_s = 2.0

[liner]
lifters = 8
lifter_top_radius_m = 0.92
lifter_top_width_m = 0.06
groove_width_m = 0.6

[ball]
radius_m = 0.02
density_kg_m3 = 2678.0

[material]
youngs_modulus_pa = 5.98e7
poisson_ratio = 0.3
restitution_pp = 0.1
restitution_pw = 0.2
static_friction_pp = 0.545
static_friction_pw = 0.5
rolling_friction_pp = 0.01
rolling_friction_pw = 0.01

[scaling]
schemes = ["constant-gravity"]
policies = ["paper"]

[single_ball]
S = [1.0, 2.0]
rotation_angle_rad = 1.0
step_s = 1e-4

[multi_ball]
S = [2.0]
count = [50]
settle_s = 0.1
rotation_angle_rad = 1.0
step_s = 1e-4
"""
