#!/usr/bin/env python3
"""Forces of one or two balls pressed side by side into a block that is bonded to its base: linear elasticity.

An independent reference for tests/contact/two_balls.cpp; needs numpy and scipy. Hexahedra with 27 nodes on a graded mesh;
symmetry planes at x = 0 and y = 0. The compliance C of the surface near a ball is computed once, for symmetric and
antisymmetric loads about x = 0. A ball without friction is an obstacle to the nodes: with the normals n of the ball at the
deformed positions, the gaps g = n (X + C n f - c) - R and the forces f satisfy g >= 0, f >= 0, g f = 0. This is a convex
problem (nonnegative least squares), solved again until the normals stay.

pressed_balls.py check    Hertz's force, and the plate of docs/validation-sfem.md with trilinear elements
pressed_balls.py          the table of docs/validation-lattice.md
"""
import dataclasses
import itertools
import sys

import numpy as np
import scipy.integrate
import scipy.linalg
import scipy.optimize
import scipy.sparse
import scipy.sparse.linalg
import scipy.special


def elasticity(young, poisson):
    """Matrix of Hooke's law for the strains xx, yy, zz, xy, yz, zx [Pa]."""
    shear = young / (2 * (1 + poisson))
    law = np.zeros((6, 6))
    law[:3, :3] = young * poisson / ((1 + poisson) * (1 - 2 * poisson))
    law[range(3), range(3)] += 2 * shear
    law[range(3, 6), range(3, 6)] = shear
    return law


def shape_functions(order, s):
    """Lagrange polynomials and their slopes at s of [-1, 1], with nodes at equal distances."""
    if order == 1:
        return np.array([(1 - s) / 2, (1 + s) / 2]), np.array([-0.5, 0.5])
    return (np.array([s * (s - 1) / 2, 1 - s * s, s * (s + 1) / 2]), np.array([s - 0.5, -2 * s, s + 0.5]))


def element_stiffness(size, law, order):
    """Stiffness matrix of a brick of this size, its nodes ordered with x fastest."""
    points, weights = np.polynomial.legendre.leggauss(order + 1)
    count = (order + 1) ** 3
    matrix = np.zeros((3 * count, 3 * count))
    for q in itertools.product(range(order + 1), repeat=3):
        line = [shape_functions(order, points[n]) for n in q]
        slopes = np.empty((count, 3))
        for axis in range(3):
            factors = [line[a][1] * 2 / size[a] if a == axis else line[a][0] for a in range(3)]
            slopes[:, axis] = np.einsum("k,j,i->kji", factors[2], factors[1], factors[0]).ravel()
        strain = np.zeros((6, 3 * count))
        for row, (a, b) in enumerate([(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)]):
            strain[row, b::3] += slopes[:, a]
            if a != b:
                strain[row, a::3] += slopes[:, b]
        matrix += strain.T @ law @ strain * np.prod(size) / 8 * weights[q[0]] * weights[q[1]] * weights[q[2]]
    return matrix


class Mesh:
    """Bricks between planes along x, y and z."""

    def __init__(self, planes, order=2):
        self.order = order
        self.planes = [np.asarray(p) for p in planes]
        lines = [np.unique(np.concatenate([p[:-1] + k / order * np.diff(p) for k in range(order)] + [p[-1:]]))
                 for p in self.planes]
        self.size = [len(line) for line in lines]
        z, y, x = np.meshgrid(lines[2], lines[1], lines[0], indexing="ij")
        self.x = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)

    def stiffness(self, young, poisson):
        law, order = elasticity(young, poisson), self.order
        nx, ny, _ = self.size
        local = np.array([(k * ny + j) * nx + i for k, j, i in itertools.product(range(order + 1), repeat=3)])
        rows, columns, values, known = [], [], [], {}
        steps = [np.diff(p) for p in self.planes]
        for k, j, i in itertools.product(*[range(len(s)) for s in reversed(steps)]):
            size = (steps[0][i], steps[1][j], steps[2][k])
            key = tuple(np.round(size, 12))
            if key not in known:
                known[key] = element_stiffness(size, law, order)
            nodes = local + ((k * order) * ny + j * order) * nx + i * order
            unknowns = (3 * nodes[:, None] + np.arange(3)).ravel()
            rows.append(np.repeat(unknowns, len(unknowns)))
            columns.append(np.tile(unknowns, len(unknowns)))
            values.append(known[key].ravel())
        n = 3 * len(self.x)
        return scipy.sparse.csc_matrix((np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
                                       (n, n))


class Factor:
    """Solver of a stiffness matrix without the fixed unknowns."""

    def __init__(self, matrix, fixed):
        self.free = np.setdiff1d(np.arange(matrix.shape[0]), fixed)
        self.n = matrix.shape[0]
        self.lu = scipy.sparse.linalg.splu(matrix[self.free][:, self.free].tocsc(), permc_spec="MMD_AT_PLUS_A",
                                           diag_pivot_thresh=0, options={"SymmetricMode": True})

    def compliance(self, unknowns):
        """Displacements of these unknowns by unit forces on each; 0 where they are fixed."""
        matrix = np.zeros((len(unknowns), len(unknowns)))
        position = -np.ones(self.n, int)
        position[self.free] = np.arange(len(self.free))
        at = position[unknowns]
        loaded = np.flatnonzero(at >= 0)
        for columns in np.array_split(loaded, max(1, len(loaded) // 48)):
            force = np.zeros((len(self.free), len(columns)))
            force[at[columns], np.arange(len(columns))] = 1
            matrix[np.ix_(loaded, columns)] = self.lu.solve(force)[at[loaded]]
        return matrix


def graded(middle, fine, reach, low, high, growth=1.5):
    """Planes from low to high: bricks of size `fine` up to `reach` from the middle, growing ones beyond."""
    def side(end):
        count = max(1, round(min(reach, end) / fine))
        inner = np.linspace(0, min(count * fine, end), count + 1)
        rest = end - inner[-1]
        if rest < 1e-9:
            return inner
        n = 1
        while fine * growth * (growth ** n - 1) / (growth - 1) < rest:
            n += 1
        steps = growth ** np.arange(1, n + 1)
        return np.concatenate([inner, inner[-1] + rest * np.cumsum(steps) / steps.sum()])
    left = middle - side(middle - low)[::-1] if middle > low else np.array([low])
    return np.concatenate([left[:-1], middle + side(high - middle)])


@dataclasses.dataclass
class Block:
    """Half block x, y >= 0 of a block of 2 half[0] x 2 half[1] x thickness, with a ball above (apart / 2, 0)."""
    young: float = 1e4  # Pa
    poisson: float = 0.45
    half: tuple = (0.048, 0.032)  # m
    thickness: float = 0.025  # m
    apart: float = 0.03  # of the centers [m]; 0: one ball in the middle
    fine: float = 8e-4  # size of the bricks below the ball [m]
    reach: float = 0.0044  # of these bricks [m]
    order: int = 2


class Press:
    """Compliance of the surface near the balls, and forces at any depths."""

    def __init__(self, block):
        self.block = block
        across = [graded(block.apart / 2, block.fine, block.reach, 0, block.half[0]),
                  graded(0, block.fine, block.reach, 0, block.half[1])]
        down = block.thickness - graded(0, block.fine, 2 * block.fine, 0, block.thickness)[::-1]
        mesh = Mesh(across + [down], block.order)
        middle = np.array([block.apart / 2, 0, block.thickness])
        self.nodes = np.flatnonzero((np.abs(mesh.x[:, 2] - block.thickness) < 1e-9) &
                                    (np.hypot(mesh.x[:, 0] - middle[0], mesh.x[:, 1]) < block.reach))
        self.x = mesh.x[self.nodes] - middle
        matrix = mesh.stiffness(block.young, block.poisson)
        unknowns = (3 * self.nodes[:, None] + np.arange(3)).ravel()
        base = np.flatnonzero(mesh.x[:, 2] < 1e-9)
        fixed = [(3 * base[:, None] + np.arange(3)).ravel(), 3 * np.flatnonzero(mesh.x[:, 1] < 1e-9) + 1]
        plane = np.flatnonzero(mesh.x[:, 0] < 1e-9)
        even = Factor(matrix, np.concatenate(fixed + [3 * plane])).compliance(unknowns)
        if block.apart == 0:
            self.own, self.other = even, np.zeros_like(even)
            self.parts = 4  # quarters of a contact
            return
        odd = Factor(matrix, np.concatenate(fixed + [3 * plane + 1, 3 * plane + 2])).compliance(unknowns)
        self.own, self.other = (even + odd) / 2, (even - odd) / 2
        self.parts = 2

    def forces(self, radius, depths, follows=True):
        """Force on each ball [N]. Depths of the tips [m]; None: no such ball. The second ball is in mirrored coordinates.
        follows: contact at the deformed positions, else at those at rest (small strain)."""
        n = len(self.nodes)
        balls = [b for b, depth in enumerate(depths) if depth is not None]
        blocks = [[self.own if a == b else self.other for b in balls] for a in balls]
        compliance = np.block(blocks)
        rest = np.concatenate([self.x - np.array([0, 0, radius - depths[b]]) for b in balls])
        moved = np.zeros_like(rest)
        force = np.zeros(len(rest))
        for _ in range(60):
            at = rest + (moved if follows else moved * 0)
            normal = at / np.linalg.norm(at, axis=1)[:, None]
            if not follows:
                normal = np.tile([0.0, 0.0, -1.0], (len(rest), 1))
            along = np.zeros((3 * len(rest), len(rest)))
            for axis in range(3):
                along[3 * np.arange(len(rest)) + axis, np.arange(len(rest))] = normal[:, axis]
            matrix = along.T @ compliance @ along
            gap = np.einsum("ij,ij->i", normal, rest) - radius
            if not follows:  # height of the ball's paraboloid above the surface
                gap = (rest[:, 0] ** 2 + rest[:, 1] ** 2) / (2 * radius) - radius - rest[:, 2]
            lower = np.linalg.cholesky(matrix + 1e-13 * np.trace(matrix) * np.eye(len(matrix)))
            new, _ = scipy.optimize.nnls(lower.T, -scipy.linalg.solve_triangular(lower, gap, lower=True),
                                         maxiter=50 * len(matrix))
            moved = (compliance @ (along @ new)).reshape(-1, 3)
            change = np.abs(new - force).sum() / new.sum()
            force = new
            if change < 1e-9 or not follows:
                break
        # the force on a ball is opposite to that on the nodes; parts of a contact beyond the symmetry planes
        vertical = -normal[:, 2] * force
        return [self.parts * vertical[k * n:(k + 1) * n].sum() for k in range(len(balls))]


def hertz(young, poisson, radius, depth):
    return 4 / 3 * young / (1 - poisson ** 2) * np.sqrt(radius) * depth ** 1.5


def neighbor_displacement(young, poisson, thickness, away):
    """Displacement of the surface per force at a distance: of a half space (Boussinesq), and of a wide layer on a rigid base."""
    def factor(t):  # Fourier transform of the layer's displacement, relative to that of the half space
        e, a = np.exp(-2 * t), 3 - 4 * poisson
        return (a * (1 - e * e) / 2 - 2 * t * e) / (a * (1 + e * e) / 2 + (2 * t * t + 5 - 12 * poisson + 8 * poisson ** 2) * e)
    k = np.linspace(0, 40 / thickness, 20001)
    integral = scipy.integrate.simpson((factor(k * thickness) - 1) * scipy.special.j0(k * away), x=k)
    return (1 - poisson ** 2) / (np.pi * young) * np.array([1 / away, 1 / away + integral])


def check():
    """Compares with Hertz's force on a block that is wide and thick, and with the plate of docs/validation-sfem.md."""
    for cells, expected in (((4, 4, 1), -1.04722), ((8, 8, 2), -0.584958), ((12, 12, 3), -0.456165)):
        mesh = Mesh([np.linspace(0, side, n + 1) for side, n in zip((0.1, 0.1, 0.01), cells)], 1)
        middle = np.argmin(np.linalg.norm(mesh.x - [0.05, 0.05, 0.01], axis=1))
        edge = np.flatnonzero((mesh.x[:, :2] < 1e-9).any(1) | (mesh.x[:, :2] > 0.1 - 1e-9).any(1))
        factor = Factor(mesh.stiffness(1e5, 0.4), (3 * edge[:, None] + np.arange(3)).ravel())
        matrix = factor.compliance(3 * middle + np.arange(3))
        force = np.linalg.solve(matrix, [0, 0, -0.003])[2]
        print(f"plate {cells}: {force:.6f} N, known {expected} N")
    for fine in (1e-3, 5e-4):
        press = Press(Block(half=(0.2, 0.2), thickness=0.2, apart=0, fine=fine, reach=0.004, poisson=0.3))
        for depth in (1e-5, 2e-5, 4e-5, 6e-5):
            expected = hertz(1e4, 0.3, 0.2, depth)
            force = [press.forces(0.2, [depth], follows)[0] for follows in (False, True)]
            print(f"Hertz, bricks of {1e3 * fine} mm, contact radius {1e3 * np.sqrt(0.2 * depth):.2f} mm: "
                  f"{force[0] / expected - 1:+.4f}, {force[1] / expected - 1:+.4f}")


def table():
    """Forces of two balls of 8 mm, together and alone, on two meshes, and superposition estimates for two equal depths."""
    for apart, fine in itertools.product((0.017, 0.03), (1.6e-3, 1.2e-3)):
        block = Block(apart=apart, fine=fine, reach=0.0048)
        press = Press(block)
        for depths in ((1.2e-3, None), (0.6e-3, None), (1.2e-3, 1.2e-3), (0.6e-3, 1.2e-3)):
            print(f"{1e3 * apart:.0f} mm apart, bricks of {1e3 * fine:.1f} mm, depths {depths}:",
                  ", ".join(f"{f:.5f} N" for f in press.forces(8e-3, depths)))
        force = press.forces(8e-3, (1.2e-3, None))[0]
        moved = neighbor_displacement(block.young, block.poisson, block.thickness, apart) * force
        print("superposition, 1.2 mm: together over alone", *np.round((1 - moved / 1.2e-3) ** 1.5, 4),
              "(half space, layer)")


if __name__ == "__main__":
    check() if sys.argv[1:] == ["check"] else table()
