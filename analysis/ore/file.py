"""Ore file: an ore, and what an impact does to it, as a person states them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from millscale.breakage import AustinSelection, Nip, TavaresOre
from millscale.campaign.keys import REQUIRED, Key
from millscale.campaign.reader import parse_text, read_section, read_text, unknown_word
from millscale.errors import CampaignError, Mistakes

ENERGIES = ("available", "dissipated")
MOST_SIZES = 50
# Rates of fewer sizes do not give the four constants of Austin's function.
FEWEST_FITTED = 5

ORE_KEYS = {
    "name": Key("text", "one line for the report", REQUIRED),
    "density_kg_m3": Key("number", "of the particles", REQUIRED, above=0.0),
    "sizes_m": Key("number", "of the particles, each as if the mill held it alone", REQUIRED,
                   above=0.0, many=True),
}  # fmt: skip
CATCH_KEYS = {
    "hold_up_kg": Key("number", "mass of the ore in the physical mill", REQUIRED, above=0.0),
    "particles": Key("number", "particles that an impact catches", REQUIRED, above=0.0),
    "energy_share": Key(
        "number", "share of the energy of an impact that they take", REQUIRED, above=0.0, most=1.0
    ),
    "energy": Key(
        "text", "of an impact: of its approach, or dissipated until its end", REQUIRED,
        choices=ENERGIES,
    ),
}  # fmt: skip
JK_KEYS = {
    "A": Key("number", "t10 of unlimited energy [%]", REQUIRED, above=0.0, most=100.0),
    "b": Key("number", "[t/kWh]", REQUIRED, above=0.0),
}
TAVARES_KEYS = {
    "residual_energy": Key(
        "number", "median specific fracture energy of large particles [J/kg]", REQUIRED, above=0.0
    ),
    "size_m": Key("number", "below which particles are stronger", REQUIRED, above=0.0),
    "size_exponent": Key("number", "phi", REQUIRED, above=0.0),
    "scatter": Key("number", "of the logarithm of the fracture energies", REQUIRED, above=0.0),
    "truncation": Key("number", "largest fracture energy over the median", REQUIRED, above=1.0),
    "damage_exponent": Key("number", "gamma", REQUIRED, above=0.0),
    "largest_t10": Key("number", "A [%]", REQUIRED, above=0.0, most=100.0),
    "t10_rate": Key("number", "b', over e / e_50", REQUIRED, above=0.0),
    "stiffness_ratio": Key("number", "particle over what hits it; 0: on steel", 0.0, least=0.0),
}
AUSTIN_KEYS = {
    "rate": Key("number", "a of a batch test [1/min]", REQUIRED, above=0.0),
    "exponent": Key("number", "alpha", REQUIRED, above=0.0),
    "size_m": Key("number", "mu", REQUIRED, above=0.0),
    "fall": Key("number", "Lambda", REQUIRED, above=0.0),
}
SECTIONS: Mapping[str, Mapping[str, Key]] = {
    "ore": ORE_KEYS,
    "catch": CATCH_KEYS,
    "jk": JK_KEYS,
    "tavares": TAVARES_KEYS,
    "austin": AUSTIN_KEYS,
}
_MODELS = ("jk", "tavares")


@dataclass(frozen=True)
class DropWeight:
    """A and b of the JK drop-weight test.

    Attributes:
        A: [%].
        b: [t/kWh].
    """

    A: float
    b: float


@dataclass(frozen=True)
class OreFile:
    """A checked ore file, SI units.

    Attributes:
        sizes: rising [m].
        hold_up: mass of the ore in the physical mill [kg].
        energy: of ENERGIES.
        drop_weight, tavares, austin: None if not given.
        text: of the file.
    """

    name: str
    density: float
    sizes: tuple[float, ...]
    hold_up: float
    nip: Nip
    energy: str
    drop_weight: DropWeight | None
    tavares: TavaresOre | None
    austin: AustinSelection | None
    text: str

    @property
    def about(self) -> str:
        """Return the ore and what is assumed of an impact, in words."""
        return (
            f"Ore: {self.name}, {1e-3 * self.hold_up:.4g} t in the mill. Assumed: an impact "
            f"catches {self.nip.particles:g} particles, and they take "
            f"{100.0 * self.nip.energy_share:g} % of its {self.energy} energy."
        )

    def document(self) -> dict[str, Any]:
        """Return the ore as a JSON object."""
        return {
            "name": self.name,
            "density_kg_m3": self.density,
            "hold_up_kg": self.hold_up,
            "particles": self.nip.particles,
            "energy_share": self.nip.energy_share,
            "energy": self.energy,
            "jk": None if self.drop_weight is None else asdict(self.drop_weight),
            "tavares": None if self.tavares is None else asdict(self.tavares),
            "austin": None if self.austin is None else asdict(self.austin),
        }


def load_ore(path: Path) -> OreFile:
    """Return the ore of a TOML file.

    Raises:
        CampaignError: the file or a number is not accepted; holds all mistakes.
    """
    text = read_text(path)
    tree = parse_text(path, text)
    for word in tree:
        if word not in SECTIONS:
            raise unknown_word(path, word, "", dict.fromkeys(SECTIONS))
    mistakes, read = Mistakes(), dict[str, dict[str, Any]]()
    for name, known in SECTIONS.items():
        with mistakes.collected():
            content = tree.get(name, {})
            if not isinstance(content, Mapping):
                raise CampaignError(path, name, "got no section", f"a section, written [{name}]")
            if name in tree or name in ("ore", "catch"):
                read[name] = read_section(path, name, content, known)
    mistakes.raise_all()
    if not any(name in read for name in _MODELS):
        cause = "no strength of the ore"
        raise CampaignError(path, "", cause, "[jk] (A, b) or [tavares], or both")
    ore, catch = read["ore"], read["catch"]
    return OreFile(
        name=ore["name"],
        density=ore["density_kg_m3"],
        sizes=_sizes(path, ore["sizes_m"]),
        hold_up=catch["hold_up_kg"],
        nip=Nip(catch["particles"], catch["energy_share"]),
        energy=catch["energy"],
        drop_weight=DropWeight(**read["jk"]) if "jk" in read else None,
        tavares=_tavares(ore["density_kg_m3"], read.get("tavares")),
        austin=_austin(read.get("austin")),
        text=text,
    )


def _sizes(path: Path, sizes: tuple[float, ...]) -> tuple[float, ...]:
    if len(sizes) > MOST_SIZES:
        raise CampaignError(path, "ore.sizes_m", f"got {len(sizes)} sizes", f"up to {MOST_SIZES}")
    return tuple(sorted(sizes))


def _tavares(density: float, values: dict[str, Any] | None) -> TavaresOre | None:
    if values is None:
        return None
    numbers = {key: value for key, value in values.items() if key != "size_m"}
    return TavaresOre(density=density, size=values["size_m"], **numbers)


def _austin(values: dict[str, Any] | None) -> AustinSelection | None:
    if values is None:
        return None
    return AustinSelection(values["rate"], values["exponent"], values["size_m"], values["fall"])
