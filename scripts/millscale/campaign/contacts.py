"""Options of the contacts between balls: in campaign files, case.json and decks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal

Backend = Literal["fast", "stock"]
Damping = Literal["bounded", "plain"]
Precision = Literal["double", "mixed"]

# Words of a campaign file -> of the decks.
SURFACES: Final[dict[Backend, Literal["fast", "default"]]] = {"fast": "fast", "stock": "default"}
DAMPINGS: Final[dict[Damping, str]] = {"bounded": "bounded", "plain": "on"}
PRECISIONS: Final[tuple[Precision, ...]] = ("double", "mixed")


@dataclass(frozen=True)
class ContactOptions:
    """The contact backend and its options.

    Attributes:
        backend: our kernels, "fast", or those of LIGGGHTS, "stock".
        damping: tangential damping, "bounded" (our kernels only) or "plain".
        precision: of our kernels, "double" or "mixed".
        kernel: instruction set of our kernels, 2, 3 or 4 of x86-64; None: the best there is.
        stock_history: end the contact history with the neighbour list, as LIGGGHTS does.
    """

    backend: Backend = "fast"
    damping: Damping = "bounded"
    precision: Precision = "double"
    kernel: int | None = None
    stock_history: bool = False

    @property
    def surface(self) -> Literal["fast", "default"]:
        """Value of the variable `surface` of the decks."""
        return SURFACES[self.backend]

    @property
    def tangential_damping(self) -> str:
        """Value of the variable `tangential_damping` of the decks."""
        return DAMPINGS[self.damping]

    def pair_style_words(self) -> str:
        """Return what follows the models in a line `pair_style gran`; nothing for LIGGGHTS."""
        if self.backend == "stock":
            return ""
        words = ["surface fast tangential_damping", self.tangential_damping]
        words += ["memory stock"] if self.stock_history else []
        words += ["precision mixed"] if self.precision == "mixed" else []
        words += [f"kernel {self.kernel}"] if self.kernel else []
        return " ".join(words)
