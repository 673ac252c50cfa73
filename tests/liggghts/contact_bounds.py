"""How far the engine's time step may move an impact from the law: bounds, derived here."""

from __future__ import annotations

import numpy as np

from millscale import _core


def restitution_bound(restitution, share_of_duration, first_step):
    """Bound of |realised - requested| restitution at a time step, (n,).

    Forces use velocities half a step old: a linear spring with such a dashpot behaves as one with
    less mass, its damping ratio z grows by the factor 1 + c dt / 2, c = -ln(e) / t_c being its rate
    of decay, so e falls by e ln(e)^2 dt / (2 t_c (1 - z^2)). And contact begins up to a step late,
    x = v dt / (largest overlap) deep: the dashpot (force ~ x^(1/4) v) then misses up to x^(5/4) of
    its work on the way in, half of the -2 ln(e) it takes off ln(energy), and the spring x^(5/2) of
    the energy.

    Args:
        share_of_duration: dt over the duration of the elastic impact.
        first_step: v dt over the largest overlap of the elastic impact.
    """
    restitution = np.atleast_1d(np.asarray(restitution, float))
    damping = np.array([_core.damping_ratio(e) for e in restitution])
    loss = -np.log(restitution)
    lag = restitution * loss**2 * share_of_duration / (2.0 * (1.0 - damping**2))
    late = first_step**1.25
    return lag + 0.5 * restitution * loss * late + 0.5 * restitution * late**2


def slip_bound(impact, dt):
    """Bound of the error of a ball's speed along the surface after an impact, (n,) [m/s]; that of
    its spin times radius is 5/2 of it.

    Friction is at most mu F, with F up to 5/4 m v^2 / (largest overlap), and each of its four
    events (touch, stick, slip, part) is met within half a step: 5/2 mu v^2 dt / overlap. Its sum
    over the impact is mu (1 + e) v with the restitution's own error. While the ball sticks, the
    tangential spring swings with a phase error of (w dt)^2 / 24 over at most one period and a decay
    that is late by half a step, as the normal one; its mass is 2/7 of the ball's.
    """
    _, overlap, duration = impact.hertz()
    towards, share = impact.closing, dt / duration
    *_, young, shear = impact.effective
    whole = towards / impact.towards  # two mirrored balls see half of it each
    first = towards * dt / overlap
    sticking = np.sqrt(3.5 * 4.0 * shear / young)  # frequencies, tangential over normal
    decay = -np.log(impact.restitution) * sticking
    bound = (
        impact.friction
        * towards
        * (2.5 * first + restitution_bound(impact.restitution, share, first))
    )
    slip = np.abs(impact.along - impact.radius * impact.spin) * whole
    late = 0.5 * decay**2 * np.exp(-decay) * share
    phase = 2.0 * np.pi * (sticking * np.pi * share) ** 2 / 24.0
    return (bound + slip * (late + phase)) / whole
