"""Distributions for confidence intervals and tests of variance, with the standard library only."""
from __future__ import annotations

import math


def beta_share(x: float, a: float, b: float) -> float:
    """Returns the regularised incomplete beta function, by its continued fraction (Lentz)."""
    if not 0.0 < x < 1.0:
        return 0.0 if x <= 0.0 else 1.0
    if x > (a + 1.0) / (a + b + 2.0):
        return 1.0 - beta_share(1.0 - x, b, a)
    front = math.exp(math.lgamma(a + b) - math.lgamma(a) - math.lgamma(b) + a * math.log(x) + b * math.log1p(-x)) / a
    tiny = 1e-300
    d = 1.0 - (a + b) * x / (a + 1.0)
    c, d = 1.0, 1.0 / (d if abs(d) > tiny else tiny)
    value = d
    for k in range(1, 400):
        for term in (k * (b - k) * x / ((a + 2 * k - 1) * (a + 2 * k)),
                     -(a + k) * (a + b + k) * x / ((a + 2 * k) * (a + 2 * k + 1))):
            d = 1.0 + term * d
            c = 1.0 + term / c
            d, c = 1.0 / (d if abs(d) > tiny else tiny), c if abs(c) > tiny else tiny
            value *= c * d
        if abs(c * d - 1.0) < 1e-14:
            break
    return front * value


def student(share: float, degrees: int) -> float:
    """Returns the bound t of a Student variable that stays within -t and t with probability `share`."""
    low, high = 0.0, 1e4
    for _ in range(200):
        t = 0.5 * (low + high)
        inside = 1.0 - beta_share(degrees / (degrees + t * t), 0.5 * degrees, 0.5)
        low, high = (t, high) if inside < share else (low, t)
    return 0.5 * (low + high)
