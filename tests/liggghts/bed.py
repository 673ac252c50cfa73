"""A bed of 100 balls that falls into the turning mill: its decks, its state after some steps."""

import numpy as np

from scene import (
    HEAD,
    SLICE,
    analytic_wall,
    loose_bed,
    material,
    mesh_wall,
    mill_deck,
    read_dump,
    run,
    wall_and_drive,
    with_contacts,
)

S = 2.6
RADIUS = 3.9 / S
DT = 5e-5
BALLS = loose_bed(RADIUS, 100, SLICE, seed=5)
FIELDS = ("x y z", "vx vy vz", "omegax omegay omegaz", "fx fy fz", "tqx tqy tqz")
MEMORY_STOCK = "memory stock"
# Half the balls smaller, down to a quarter, and a third of the wall's material.
SIZES_AND_MATERIALS = (
    "".join(
        f"set atom {k + 1} diameter {d!r} density 2678\n"
        for k, d in enumerate(np.linspace(0.01, 0.04, 50).tolist())
    )
    + "set atom 1*33 type 2\n"
)


def bed_deck(
    folder, contacts, options="", *, balls=BALLS, wall="analytic", skin=0.02, edit="", **more
):
    folder.mkdir(exist_ok=True)
    deck = mill_deck(folder, balls, S, "constant-gravity", dt=DT, wall=wall, **more)
    deck = deck.replace("neighbor 0.02 bin", f"neighbor {skin!r} bin")
    return with_contacts(deck, contacts, options) + edit


def run_bed(folder, deck, steps, ranks=1):
    """State after the steps, one (n, 3) array for each of FIELDS, in the order of ids."""
    columns = " ".join(FIELDS)
    form = "%d" + " %.17g" * len(columns.split())
    deck += (
        f"dump end all custom {max(steps, 1)} end.dump id {columns}\n"
        f'dump_modify end format "{form}"\nrun {steps}\n'
    )
    result = run(folder, deck, ranks)
    assert result.code == 0, result.text[-600:]
    dump = read_dump(folder / "end.dump")
    return {names: np.column_stack([dump[name] for name in names.split()]) for names in FIELDS}


def assert_same(got, expected, tolerance):
    """Every field to a share of its largest value."""
    for names in FIELDS:
        largest = np.abs(expected[names]).max()
        np.testing.assert_allclose(
            got[names], expected[names], rtol=0.0, atol=tolerance * largest, err_msg=names
        )


def differ(a, b):
    """Largest difference of a field, as a share of the field's largest value."""
    return max(np.abs(a[n] - b[n]).max() / np.abs(b[n]).max() for n in FIELDS)


def again_deck(contacts, options, deck):
    """The deck that goes on from half.restart."""
    words = deck.split()
    wall = analytic_wall(S)
    if "curvature" in words:
        wall = mesh_wall(float(words[words.index("curvature") + 1]))
    properties = material(0.02, DT)
    lifters = f"lifters 25 lifter_top_radius {3.61 / S!r}"
    drive = wall_and_drive(S, "constant-gravity", wall, "now", lifters)
    again = f"{HEAD}read_restart half.restart\n{properties}{drive}"
    return with_contacts(again, contacts, options)
