"""Morrell C: potential and kinetic energy given to a continuum between toe and shoulder."""

from __future__ import annotations

import math
from dataclasses import dataclass

from millscale.power_models.limits import diameter, filling, speed
from millscale.power_models.mill import Mill

LIMITS = (diameter(0.85, 9.6), filling(0.1, 0.48), speed(0.48, 0.89))
ACCEPTED = "J of 0.1 to 0.48 and 48 to 89 % of the critical speed"
# Gross over net power beyond the no-load power: heat of friction, attrition, error of the model.
LOSSES = 1.26


@dataclass(frozen=True)
class ChargeShape:
    """The part of the cross-section that the active charge fills.

    Attributes:
        toe, shoulder: theta_T, theta_S, anticlockwise from the horizontal on the rising side of a
            mill that turns anticlockwise [rad]. From the vertical, positive on the rising side,
            they are pi/2 - theta.
        inner_radius: r_i, of its inner surface [m].
        slip: z, r_i times which is the radius where the velocity vanishes.
        active: beta, share of the charge between toe and shoulder; the rest is in flight.
    """

    toe: float
    shoulder: float
    inner_radius: float
    slip: float
    active: float


def charge_shape(mill: Mill) -> ChargeShape:
    """Return the shape of the charge.

        phi_c   = max(phi, 0.35 (3.364 - J))
        theta_T = 2.5307 (1.2796 - J) (1 - exp(-19.42 (phi_c - phi))) + pi/2
        theta_S = pi/2 - (theta_T - pi/2) (0.3386 + 0.1041 phi + (1.54 - 2.5673 phi) J)
        z       = (1 - J)^0.4532
        r_mean  = R/2 (1 + sqrt(1 - 2 pi J / (2 pi + theta_S - theta_T)))
        t_c     = (2 pi + theta_S - theta_T) / (pi N);  N in revolutions per second
        t_f     = sqrt(2 r_mean (sin theta_S - sin theta_T) / g)
        beta    = t_c / (t_c + t_f)
        r_i     = R sqrt(1 - 2 pi beta J / (2 pi + theta_S - theta_T))

    phi_c is the speed at which the charge centrifuges. t_c and t_f are the times of a ball in the
    charge and in free fall. Symbols, validity and source: `morrell_net_power`.

    Raises:
        ValueError: toe and shoulder leave no room for the charge, far outside of the limits.
    """
    J, phi, R = mill.filling, mill.fraction_of_critical, mill.radius
    centrifuging = max(phi, 0.35 * (3.364 - J))
    past = 2.5307 * (1.2796 - J) * (1.0 - math.exp(-19.42 * (centrifuging - phi)))
    toe = past + 0.5 * math.pi
    shoulder = 0.5 * math.pi - past * (0.3386 + 0.1041 * phi + (1.54 - 2.5673 * phi) * J)
    filled = 2.0 * math.pi + shoulder - toe
    drop = math.sin(shoulder) - math.sin(toe)
    if drop < 0.0 or filled < 2.0 * math.pi * J:
        raise ValueError(
            f"Morrell's charge has no room between toe and shoulder at J = {J:.3g}, "
            f"{100.0 * phi:.3g} % of the critical speed; accepted: {ACCEPTED}"
        )
    mean_radius = 0.5 * R * (1.0 + math.sqrt(1.0 - 2.0 * math.pi * J / filled))
    in_charge = 2.0 * filled / mill.omega
    in_flight = math.sqrt(2.0 * mean_radius * drop / mill.gravity)
    active = in_charge / (in_charge + in_flight)
    inner = R * math.sqrt(1.0 - 2.0 * math.pi * active * J / filled)
    return ChargeShape(toe, shoulder, inner, (1.0 - J) ** 0.4532, active)


def morrell_net_power(mill: Mill) -> float:
    """Return the net power of the charge [W].

        P = pi g L N R rho / (3 (R - z r_i)) (2 R^3 - 3 z R^2 r_i + r_i^3 (3 z - 2))
              (sin theta_S - sin theta_T)
          + L rho (pi N R / (R - z r_i))^3 ((R - z r_i)^4 - r_i^4 (z - 1)^4)

    The first line is the work against gravity, the second the kinetic energy at the shoulder.
    Both follow from a velocity 2 pi N R (r - z r_i) / (R - z r_i) at radius r between theta_T and
    theta_S, with r_i, z and the angles of `charge_shape`.
    rho is the bulk density, N the speed in revolutions per second.
    The pool of slurry of a mill that overflows and the cones of its ends are left out.
    Torque over M g R does not depend on D, and similar mills draw D^3.5.

    Valid for the range of the mills it was fitted to, from memory: D of 0.85 to 9.6 m, J of 0.1 to
    0.48, 48 to 89 % of the critical speed; the gross power then had an error of 10 % (95 %).

    Source: S. Morrell, Power draw of wet tumbling mills and its relationship to charge dynamics,
    Trans. Instn Min. Metall. C 105 (1996) C43 and C54. The original was not seen. The constants
    are those of three public programs, and they give the example of Erdem and others (2004) to
    0.1 % (docs/theory/power-models.md).
    """
    shape = charge_shape(mill)
    R, r, z = mill.radius, shape.inner_radius, shape.slip
    turns = mill.omega / (2.0 * math.pi)
    depth = R - z * r
    lifted = 2.0 * R**3 - 3.0 * z * R**2 * r + r**3 * (3.0 * z - 2.0)
    drop = math.sin(shape.shoulder) - math.sin(shape.toe)
    gravity = math.pi * mill.gravity * turns * R / (3.0 * depth) * lifted * drop
    kinetic = (math.pi * turns * R / depth) ** 3 * (depth**4 - r**4 * (z - 1.0) ** 4)
    return mill.length * mill.bulk_density * (gravity + kinetic)


def no_load_power(mill: Mill) -> float:
    """Return the power of the empty mill at the motor [W].

        P = 1.68 D^2.05 (phi L)^0.82      [kW; D, L in m]

    With cones of length L_d at its ends L is replaced by L + 0.667 L_d.
    Source: `morrell_net_power`.
    """
    return 1e3 * 1.68 * mill.diameter**2.05 * (mill.fraction_of_critical * mill.length) ** 0.82


def morrell_gross_power(mill: Mill) -> float:
    """Return the power at the motor [W]: the no-load power and 1.26 times the net power.

    Similar mills draw D^3.5 but for the no-load power, which follows D^2.87.
    Source: `morrell_net_power`.
    """
    return no_load_power(mill) + LOSSES * morrell_net_power(mill)
