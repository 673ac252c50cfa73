"""An ore file of an ore that is made up, within the ranges of published materials."""

CATCH = """
[catch]
hold_up_t = 3.0
particles = 3
energy_share = 0.8
energy = "{energy}"
"""
JK = """
[jk]
A = 60
b = 0.8
"""
TAVARES = """
[tavares]
residual_energy = 150
size_mm = 3
size_exponent = 1.2
scatter = 0.5
truncation = 4
damage_exponent = 5
largest_t10 = 60
t10_rate = 0.03
"""
AUSTIN = """
[austin]
rate = 0.5
exponent = 0.8
size_mm = 12
fall = 3
"""


def ore_text(parts=JK + TAVARES, energy="dissipated", sizes="[1, 2, 4, 6, 8, 16]"):
    """Return the text of an ore file."""
    head = f'[ore]\nname = "made-up ore"\ndensity_g_cm3 = 2.7\nsizes_mm = {sizes}\n'
    return head + CATCH.format(energy=energy) + parts


def write_ore(path, *args, **changes):
    """Write an ore file; return its path."""
    path.write_text(ore_text(*args, **changes))
    return path
