"""parameters.in: the numbers of a case as variables of the engine's decks."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from msgspec import to_builtins

from millscale.engine.material_block import HARD_ABOVE, SOFT_BELOW, yes_or_no
from millscale.runs.atom_types import COEFFICIENTS, AtomTypes, atom_types
from millscale.runs.case_file import Case, Mill, Wall
from millscale.runs.layout import PROFILE_FILE
from millscale.runs.liner import liner_of
from millscale.runs.speed import turned_angle
from millscale.runs.writing import write_text

FILE = "parameters.in"
LINER_FILE = "liner.stl"


def parameters(case: Case) -> dict[str, float | int | str]:
    """Return the variables of the decks by name. SI units; angles in rad unless named _deg."""
    physical, mill, ball, time, output = (
        case.physical, case.mill, case.ball, case.time, case.output
    )  # fmt: skip
    types = atom_types(case)
    x, y, z = ball.start_m or (0.0, 0.0, 0.0)
    return {
        # No deck uses it: the engine's log, which repeats this file, names the case of a run.
        "case_digest": f"sha256-{case.digest!s:.32}",
        "mill_radius_physical": physical.radius_m,
        "gravity_physical": physical.gravity_m_s2,
        "omega_physical": physical.omega_rad_s,
        "S": case.S,
        "scheme": case.scheme,
        "policy": case.policy,
        "time_factor": case.time_factor,
        "centrifuging": "allow" if case.allow_centrifuging else "refuse",
        "ball_radius": ball.radius_m,
        "ball_density": ball.density_kg_m3,
        "ball_x": x,
        "ball_y": y,
        "ball_z": z,
        **_materials(types),
        "wall_damping": "on",
        **to_builtins(case.deck),
        "mill_radius": mill.radius_m,
        "wall": case.wall.kind,
        "lifters": mill.lifters,
        "liner_shape": _liner_shape(mill),
        "axial": "p" if mill.ends == "periodic" else "f",
        "wall_words": _wall(case, types),
        "length": mill.simulated_length_m,
        "half_box": case.domain.half_box_m,
        "skin": case.domain.skin_m,
        **_mesh(case.wall),
        "time_step": time.step_s,
        "start_time": time.start_s,
        "rest_steps": time.rest_steps,
        "settle_steps": time.settle_steps,
        "rotation_steps": time.rotation_steps,
        "rotation_angle": turned_angle(time, mill.omega_rad_s),
        "speed_changes": len(time.speed_changes),
        "speed": _speed(case),
        "sample_steps": output.sample_steps,
        "dump_steps": output.dump_steps,
        "restart_steps": output.restart_steps,
        "thermo_steps": output.thermo_steps,
    }


def write_parameters(case: Case, folder: Path) -> None:
    """Write parameters.in of a case to a folder, and the file of its liner if it needs one."""
    write_text(Path(folder) / FILE, parameters_text(case))
    if case.mill.profile:
        write_text(Path(folder) / PROFILE_FILE, liner_of(case.mill).text)


def parameters_text(case: Case) -> str:
    """Return parameters.in of a case.

    Variables are of style string: the engine prints other styles with 15 digits, too few to restore
    a number exactly.
    """
    values = parameters(case)
    lines = [f"# {case.id}: values of the decks, SI units"]
    lines += [
        f"variable {name} string {value if isinstance(value, str) else repr(value)}"
        for name, value in values.items()
    ]
    return "\n".join(lines) + "\n"


def _liner_shape(mill: Mill) -> str:
    """Return the words of the deck that state the liner."""
    if mill.profile:
        return f'"profile {PROFILE_FILE}"'
    words = f"lifters {mill.lifters!r} phase {mill.phase_rad!r}"
    if mill.lifters:
        words += (
            f" lifter_top_radius {mill.lifter_top_radius_m!r}"
            f" lifter_top_width {mill.lifter_top_width_m!r}"
            f" groove_width {mill.groove_width_m!r}"
        )
    return f'"{words}"'


def _speed(case: Case) -> str:
    """Return the words of the deck that state changes of the speed, and the angle between dumps."""
    words = [f"mark {case.output.dump_angle_rad!r}"]
    words += [f"speed_change {x!r} {over!r} {to!r}" for x, over, to in case.time.speed_changes]
    return f'"{" ".join(words)}"'


def _wall(case: Case, types: AtomTypes) -> str:
    """Return the words of the deck that state material and ends of an analytic wall."""
    mill, words = case.mill, f"type {types.liner_type}"
    if mill.ends != "periodic":
        motion = {"turning": "mill", "resting": "rest"}[mill.ends]
        words += f" ends 0.0 {mill.simulated_length_m!r} end_motion {motion}"
        words += f" end_type {types.end_type}"
    return f'"{words}"'


def _mesh(wall: Wall) -> dict[str, float | str | None]:
    """Return the variables of a mesh wall; none for an analytic wall."""
    if wall.kind != "mesh":
        return {}
    return {"curvature_deg": wall.curvature_deg, "liner_file": LINER_FILE}


def _materials(types: AtomTypes) -> dict[str, float | int | str]:
    """Return the variables of the material block: lists of numbers as text."""
    moduli = [material.youngs_modulus_pa for material in types.all]
    return {
        "types": len(types.all),
        "liner_type": types.liner_type,
        "youngs_moduli": _list(moduli),
        "poisson_ratios": _list([material.poisson_ratio for material in types.all]),
        "soft_particles": yes_or_no(min(moduli) < SOFT_BELOW),
        "hard_particles": yes_or_no(max(moduli) > HARD_ABOVE),
        **{f"{name}s": _list(types.matrix(name)) for name in COEFFICIENTS},
    }


def _list(numbers: Sequence[float]) -> str:
    return '"' + " ".join(repr(float(x)) for x in numbers) + '"'
