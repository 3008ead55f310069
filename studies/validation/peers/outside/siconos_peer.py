"""A path of increments by Siconos, run by a Python that has Siconos.

This Python need not have frictopt. The program reads one question as JSON and writes the answer as
JSON, see `programs`. Each increment is one call of a driver of Siconos, with the matrices and loads
of frictopt. The call starts from the slip after the previous increment.
"""

import json
import sys
import time
from typing import Any

import numpy as np
import siconos.numerics as siconos

Array = np.ndarray[Any, Any]


def complementarity(asked: dict[str, Any], S: Array, loads: Array) -> list[float]:
    """Work of friction of each increment, by linear complementarity problems in the plane.

    The unknowns are the gaps and the slips in both senses. This stiffness form needs no compliance.
    """
    n, f = len(S) // 2, asked["friction"]
    A, B, C = S[:n, :n], S[n:, :n], S[n:, n:]
    M = np.block(
        [[C, B, -B], [f * C + B.T, A + f * B, -A - f * B], [f * C - B.T, f * B - A, A - f * B]]
    )
    unit = asked["force"] / np.abs(S).max()
    M = M * (unit / asked["force"])
    options = siconos.SolverOptions(getattr(siconos, asked["solver"]))
    options.iparam[siconos.SICONOS_IPARAM_MAX_ITER] = asked["iterations"]
    if asked["tolerance"]:
        options.dparam[siconos.SICONOS_DPARAM_TOL] = asked["tolerance"]
    v, before, works = np.zeros(n), loads[0][n:], []
    for load in loads[1:]:
        r = load + S[:, :n] @ v
        q, p = r[:n], r[n:]
        right = np.concatenate([p, f * p + q, f * p - q]) / asked["force"]
        z, w = np.zeros(3 * n), np.zeros(3 * n)
        info = siconos.linearComplementarity_driver(siconos.LCP(M, right), z, w, options)
        if info:
            raise SystemExit(f"{asked['solver']} ends with {info}")
        slip = (z[n : 2 * n] - z[2 * n :]) * unit
        pressure = p + B @ slip + C @ z[:n] * unit
        works.append(float(f * np.abs(slip) @ (before + pressure) / 2))
        v, before = v + slip, pressure
    return works


def cones(asked: dict[str, Any], S: Array, loads: Array) -> list[float]:
    """Work of friction of each increment, by friction-contact problems in space."""
    n, f = len(S) // 3, asked["friction"]
    order = np.arange(3 * n).reshape(3, n)[[2, 0, 1]].T.ravel()  # normal, then two tangents
    W = np.linalg.inv(S)[np.ix_(order, order)]
    bound = np.full(n, f)
    options = siconos.SolverOptions(getattr(siconos, asked["solver"]))
    options.iparam[siconos.SICONOS_IPARAM_MAX_ITER] = asked["iterations"]
    if asked["tolerance"]:
        options.dparam[siconos.SICONOS_DPARAM_TOL] = asked["tolerance"]
    v, works = np.zeros((n, 2)), []
    reaction, velocity = np.zeros(3 * n), np.zeros(3 * n)
    for load in loads[1:]:
        free = -W @ load[order]
        free.reshape(n, 3)[:, 1:] -= v
        problem = siconos.FrictionContactProblem(3, n, W, free, bound)
        info = siconos.fc3d_driver(problem, reaction, velocity, options)
        if info:
            raise SystemExit(f"{asked['solver']} ends with {info}")
        slip = velocity.reshape(n, 3)[:, 1:]
        works.append(float(f * reaction[::3] @ np.linalg.norm(slip, axis=1)))
        v = v + slip
    return works


if __name__ == "__main__":
    asked = json.load(sys.stdin)
    S, loads = np.array(asked["S"]), np.array(asked["loads"])
    follow = cones if asked["space"] else complementarity
    started = time.process_time()
    works = follow(asked, S, loads)
    print(json.dumps({"works": works, "seconds": time.process_time() - started}))
