"""Designs of studies: the values of the varied keys for every member, and sensitivity indices of what was measured."""
import itertools
import math

import numpy as np

KINDS = ("grid", "lhs", "saltelli")


def varied_value(spec, share):
    """Value of a varied key at this fraction of its range, in [0, 1)."""
    if "values" in spec:
        return spec["values"][int(share * len(spec["values"]))]
    low, high = spec["uniform"] if "uniform" in spec else spec["log_uniform"]
    if isinstance(low, list):  # a vector, from one to the other
        return [_between(*ends, share, "uniform" in spec) for ends in zip(low, high)]
    return _between(low, high, share, "uniform" in spec)


def _between(low, high, share, linear):
    return low + (high - low) * share if linear else low * (high / low) ** share


def latin_hypercube(count, dimensions, seed):
    """(count, dimensions) in [0, 1): every column has one number in each of `count` equal intervals."""
    random = np.random.default_rng(seed)
    cells = np.stack([random.permutation(count) for _ in range(dimensions)], axis=1)
    return (cells + random.random((count, dimensions))) / count


def saltelli(count, dimensions, seed):
    """Matrices A, B, and A with each column replaced by that of B [Saltelli 2010]: (dimensions + 2) · count rows."""
    both = latin_hypercube(count, 2 * dimensions, seed)
    a, b = both[:, :dimensions], both[:, dimensions:]
    blocks = [a, b]
    for column in range(dimensions):
        mixed = a.copy()
        mixed[:, column] = b[:, column]
        blocks.append(mixed)
    return np.concatenate(blocks)


def rows_of_design(design, vary):
    kind = design["kind"]
    if kind == "grid":
        return [dict(zip(vary, values)) for values in itertools.product(*(spec["values"] for spec in vary.values()))]
    make = saltelli if kind == "saltelli" else latin_hypercube
    shares = make(design["count"], len(vary), design.get("seed", 0))
    return [{key: varied_value(spec, share) for (key, spec), share in zip(vary.items(), row)} for row in shares.tolist()]


def sobol_indices(values, dimensions, seed=0, times=500):
    """First and total Sobol indices of a Saltelli design [Jansen 1999], each with the half width of its 95 % interval.

    values: (dimensions + 2) · count, in the order of the design; failed members are nan and excluded with their base row.
    Returns first, total: (dimensions, 2).
    """
    blocks = np.asarray(values, dtype=float).reshape(dimensions + 2, -1)
    blocks = blocks[:, np.isfinite(blocks).all(axis=0)]

    def of(rows):
        a, b, mixed = blocks[0, rows], blocks[1, rows], blocks[2:, rows]
        spread = np.var(np.concatenate([a, b]), axis=0) or math.nan
        return 1 - np.mean((b - mixed) ** 2, axis=1) / (2 * spread), np.mean((a - mixed) ** 2, axis=1) / (2 * spread)

    count = blocks.shape[1]
    if count < 2:
        return np.full((2, dimensions, 2), math.nan)
    random = np.random.default_rng(seed)
    again = np.array([of(random.integers(count, size=count)) for _ in range(times)])
    return np.stack([np.array(of(np.arange(count))), 1.96 * again.std(axis=0)], axis=-1)
