"""A scaled mill by the similarity law, without a campaign."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from millscale import _core
from millscale.campaign.keys import POLICIES, SCHEMES
from millscale.campaign.units import resolve, speed_forms
from millscale.errors import CampaignError, nearest
from millscale.prediction.text import aligned, html_table

_WHERE = Path("millscale.scale")


@dataclass(frozen=True, repr=False)
class ScaledMill:
    """A scaled mill and its physical mill.

    Attributes:
        law: the scaled mill as `_core` returns it, with the factors of length, mass and time.
        physical: radius and ball radius [m], gravity [m/s^2], omega [rad/s].
    """

    S: float
    scheme: str
    policy: str
    law: _core.ScaledMill
    physical: _core.OperatingPoint

    @property
    def radius_m(self) -> float:
        """R at the liner [m]."""
        return self.law.mill.radius

    @property
    def gravity_m_s2(self) -> float:
        """Gravity [m/s^2]."""
        return self.law.mill.gravity

    @property
    def omega_rad_s(self) -> float:
        """Speed [rad/s]."""
        return self.law.mill.omega

    @property
    def froude(self) -> float:
        """omega^2 R / g."""
        return self.law.froude

    @property
    def percent_of_critical(self) -> float:
        """Speed in % of sqrt(g / (R - a))."""
        return 100.0 * self.omega_rad_s / _core.critical_speed(self.law.mill)

    def factor(self, length: int = 0, mass: int = 0, time: int = 0) -> float:
        """Return scaled over physical value of a quantity, from the exponents of its dimension.

        That of one ball's energy is factor(length=2, mass=1, time=-2).
        """
        return _core.factor(self.law.base, length, mass, time)

    def _rows(self) -> list[tuple[str, str, str, str]]:
        ours, theirs = self.law.mill, self.physical
        critical = _core.critical_speed(theirs)
        return [
            ("radius", f"{theirs.radius:.4g}", f"{ours.radius:.4g}", "m"),
            ("ball radius", f"{theirs.ball_radius:.4g}", f"{ours.ball_radius:.4g}", "m"),
            ("gravity", f"{theirs.gravity:.4g}", f"{ours.gravity:.4g}", "m/s2"),
            ("speed", f"{theirs.omega:.4g}", f"{ours.omega:.4g}", "rad/s"),
            (
                "of the critical speed",
                f"{100.0 * theirs.omega / critical:.4g}",
                f"{self.percent_of_critical:.4g}",
                "%",
            ),
        ]

    def _title(self) -> str:
        return f"S = {self.S:.4g}, {self.scheme}, {self.policy}: Froude number {self.froude:.4g}"

    def __repr__(self) -> str:
        return "\n".join([self._title(), *aligned([("", "physical", "scaled", ""), *self._rows()])])

    def _repr_html_(self) -> str:
        return html_table(self._title(), ("", "physical", "scaled", "unit"), self._rows(), [])


def scale(
    S: float,
    *,
    radius_m: float,
    ball_radius_m: float,
    gravity_m_s2: float = 9.81,
    scheme: str = "constant-gravity",
    policy: str = "paper",
    time_factor: float = 0.0,
    friction_exponent: float = 1.0,
    allow_centrifuging: bool = False,
    speed_rad_s: float | None = None,
    speed_rpm: float | None = None,
    period_s: float | None = None,
    percent_of_critical: float | None = None,
    froude: float | None = None,
) -> ScaledMill:
    """Return a scaled mill by the similarity law (docs/theory/similarity-law.md).

    Args:
        S: radius of the physical mill over that of the scaled mill, 1 or more.
        radius_m, ball_radius_m, gravity_m_s2: of the physical mill.
        scheme: constant-gravity, constant-speed, or froude with `time_factor`.
        policy: paper, corrected, offset-liner or friction-matched.
        time_factor: scaled over physical time, of scheme froude.
        friction_exponent: k of S^-k, of policy friction-matched.
        allow_centrifuging: accept a Froude number of 1 or more.
        speed_rad_s, speed_rpm, period_s, percent_of_critical, froude: speed of the physical mill,
            one of them.

    >>> import millscale as ms
    >>> mill = ms.scale(2.25, radius_m=4.5, ball_radius_m=0.02, speed_rad_s=1.0)
    >>> mill.radius_m, mill.omega_rad_s, mill.factor(length=2, mass=1, time=-2)
    (2.0, 1.5, 0.4444444444444444)

    Raises:
        CampaignError: no speed, several that differ, or numbers that the law refuses.
    """
    forms = speed_forms(radius_m, ball_radius_m, gravity_m_s2)
    given = dict(zip(forms, (speed_rad_s, speed_rpm, period_s, percent_of_critical, froude),
                     strict=True))  # fmt: skip
    omega = resolve(given, forms, "rad/s", (_WHERE, "speed"))
    if omega is None:
        raise CampaignError(_WHERE, "", "the speed is missing", "one of " + ", ".join(forms))
    for key, word, known in (("scheme", scheme, SCHEMES), ("policy", policy, POLICIES)):
        if word not in known:
            near = nearest(word, known)
            cause = f"got {word!r:.60}" + (f", nearest is {near}" if near else "")
            raise CampaignError(_WHERE, key, cause, ", ".join(known))
    physical = _core.OperatingPoint(radius_m, ball_radius_m, gravity_m_s2, omega)
    try:
        law = _core.scale(
            physical,
            S,
            scheme,
            policy,
            time_factor,
            allow_centrifuging,
            friction_exponent=friction_exponent,
        )
    except ValueError as cause:
        raise CampaignError(_WHERE, f"S = {S:g}", str(cause)) from None
    return ScaledMill(S, scheme, policy, law, physical)
