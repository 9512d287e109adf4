"""Steps of different lengths across a common node: growth in a period of a bar with a coarse and a fine part.

The bar has unit modulus, density and area. Masses are lumped. The fine part takes `m` steps in one of the coarse part.
One period is a linear map, and its spectral radius less 1 is the growth in it.
"""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class Bar:
    """`coarse` elements of length 1, then `fine` ones of length 1/ratio."""
    coarse: int
    fine: int
    ratio: int

    def masses(self) -> Matrix:
        """Returns the lumped masses."""
        mass = np.zeros(self.coarse + self.fine + 1)
        for e, length in enumerate(self.lengths()):
            mass[e:e + 2] += 0.5 * length
        return mass

    def lengths(self) -> list[float]:
        """Returns the lengths of the elements."""
        return [1.0] * self.coarse + [1.0 / self.ratio] * self.fine

    def stiffness(self, first: int, last: int) -> Matrix:
        """Returns the stiffness of the elements `first` to `last` - 1."""
        n = self.coarse + self.fine + 1
        k = np.zeros((n, n))
        for e in range(first, last):
            s = 1.0 / self.lengths()[e]
            k[e:e + 2, e:e + 2] += [[s, -s], [-s, s]]
        return k

    def longest_second_step(self) -> float:
        """Returns the step below which forces of coarse elements may act as impulses at every second step:
        dt^2 (1/T^2 + 1/T_c^2) = 1/2, with the stable steps T of the whole bar and T_c of the coarse part by itself."""
        alone = Bar(self.coarse, 0, self.ratio)
        whole, coarse = (b.stable_step(b.stiffness(0, b.coarse + b.fine)) for b in (self, alone))
        return float(np.sqrt(0.5 / (1.0 / whole**2 + 1.0 / coarse**2)))

    def stable_step(self, stiffness: Matrix) -> float:
        """Returns 2 / sqrt(largest eigenvalue of M^-1 K)."""
        root = np.sqrt(self.masses())
        return float(2.0 / np.sqrt(np.linalg.eigvalsh(stiffness / np.outer(root, root))[-1]))


def _kick(impulse: Matrix) -> Matrix:
    n = len(impulse)
    return np.block([[np.eye(n), np.zeros((n, n))], [-impulse, np.eye(n)]])


def _drift(n: int, dt: float) -> Matrix:
    return np.block([[np.eye(n), dt * np.eye(n)], [np.zeros((n, n)), np.eye(n)]])


def of_impulses(bar: Bar, dt: float, m: int) -> Matrix:
    """Returns the period of the impulse method: forces of coarse elements act every `m` steps, with m times the impulse."""
    inverse = 1.0 / bar.masses()[:, None]
    coarse, fine = bar.stiffness(0, bar.coarse), bar.stiffness(bar.coarse, bar.coarse + bar.fine)
    period = np.eye(2 * len(inverse))
    for i in range(m):
        period = _drift(len(inverse), dt) @ _kick(dt * inverse * (fine + (m * coarse if i == 0 else 0.0))) @ period
    return period


def of_nodes(bar: Bar, dt: float, m: int, carry: bool) -> Matrix:
    """Returns the period of a partition by nodes: coarse nodes take one step of m dt, elements that touch a fine node are
    evaluated `m` times. With `carry` a coarse node gets what it was owed of their impulses in the next step."""
    mass = bar.masses()
    n, tau = len(mass), m * dt
    slow = np.diag((np.arange(n) < bar.coarse) / mass)
    fast = np.diag((np.arange(n) >= bar.coarse) / mass)
    touching = bar.stiffness(bar.coarse - 1, bar.coarse + bar.fine)
    whole = bar.stiffness(0, bar.coarse - 1) + touching
    owed = np.diag(1.0 * (np.arange(n) < bar.coarse))
    one, none = np.eye(n), np.zeros((n, n))
    period = np.block([[one, none, none], [-tau * slow @ whole, one, slow if carry else none],
                       [tau * owed @ touching, none, none]])
    for _ in range(m):
        period = np.block([[one, none, none], [-dt * fast @ touching, one, none], [-dt * owed @ touching, none, one]]) @ period
        period = np.block([[one, dt * one, none], [none, one, none], [none, none, one]]) @ period
    return period


def growth(period: Matrix) -> float:
    """Returns the spectral radius less 1."""
    return float(np.abs(np.linalg.eigvals(period)).max()) - 1.0


def growths(method: str, ratio: int, m: int, shares: Matrix) -> list[float]:
    """Returns the growth at these shares of the stable step of the whole bar, those left out that are above the coarse
    part's own. `method` is 'impulses', 'nodes' or 'carry'."""
    out = []
    for coarse, fine in ((5, 13), (8, 40)):
        bar = Bar(coarse, fine, ratio)
        whole = bar.stable_step(bar.stiffness(0, coarse + fine))
        for share in shares:
            dt = float(share) * whole
            if m * dt > share * bar.stable_step(bar.stiffness(0, coarse)) * 1.0001:
                continue
            out.append(growth(of_impulses(bar, dt, m) if method == "impulses" else of_nodes(bar, dt, m, method == "carry")))
    return out
