"""Linear algebra of small matrices, in plain Python."""

from __future__ import annotations

import math
from typing import Any

from scenelang.playground import MissingError

from . import (
    _F8,
    _finished,
    _reduced,
    _scalar,
    asarray,
    broadcast_to,
    eye,
    float64,
    ndarray,
    stack,
)

_SWEEPS = 60  # of Jacobi rotations; three-by-three matrices need about six


class LinAlgError(ValueError):
    """Raised for a singular matrix."""


def norm(value: Any, ord: Any = None, axis: Any = None, keepdims: bool = False) -> Any:
    """Return the lengths of vectors along an axis."""
    source = asarray(value)
    kind = source.dtype if source.dtype.kind == "f" else _F8
    if ord in (None, 2):
        return _reduced(source, axis, lambda row: math.sqrt(sum(x * x for x in row)), kind, keepdims=keepdims)
    if ord == 1:
        return _reduced(source, axis, lambda row: sum(map(abs, row)), kind, keepdims=keepdims)
    if ord == math.inf:
        return _reduced(source, axis, lambda row: max(map(abs, row)), kind, keepdims=keepdims)
    raise MissingError(f"`numpy.linalg.norm` of order {ord}")


def _matrices(value: Any) -> tuple[ndarray, tuple[int, ...], list[list[list[float]]]]:
    """Return a stack of matrices as an array, its outer shape, and the matrices as lists of rows."""
    source = asarray(value, float64)
    return source, source.shape[:-2], source.reshape(-1, *source.shape[-2:]).tolist()


def _eliminate(rows: list[list[float]], count: int) -> float:
    """Bring the first ``count`` columns to the identity by Gauss and Jordan; return the determinant."""
    determinant = 1.0
    for i in range(count):
        pivot = max(range(i, count), key=lambda r: abs(rows[r][i]))
        if rows[pivot][i] == 0.0:
            return 0.0
        if pivot != i:
            rows[i], rows[pivot], determinant = rows[pivot], rows[i], -determinant
        determinant *= rows[i][i]
        lead = rows[i][i]
        rows[i] = [value / lead for value in rows[i]]
        for r in range(count):
            if r != i and rows[r][i]:
                factor = rows[r][i]
                rows[r] = [a - factor * b for a, b in zip(rows[r], rows[i], strict=True)]
    return determinant


def det(value: Any) -> Any:
    """Return the determinants of square matrices."""
    _, outer, matrices = _matrices(value)
    flat = [_determinant(rows) for rows in matrices]
    return _finished(flat, outer, _F8) if outer else _scalar(flat[0], _F8)


def _determinant(rows: list[list[float]]) -> float:
    if len(rows) == 2:
        (a, b), (c, d) = rows
        return a * d - b * c
    if len(rows) == 3:
        (a, b, c), (d, e, f), (g, h, i) = rows
        return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    return _eliminate([list(row) for row in rows], len(rows))


def inv(value: Any) -> ndarray:
    """Return the inverses of square matrices; raises LinAlgError for a singular one."""
    source, _, _ = _matrices(value)
    return solve(source, broadcast_to(eye(source.shape[-1]), source.shape))


def solve(matrix: Any, right: Any) -> ndarray:
    """Return the solutions of linear equations; raises LinAlgError for a singular matrix."""
    source, outer, matrices = _matrices(matrix)
    sides = asarray(right, float64)
    is_vector = sides.ndim == 1
    columns = sides.reshape(-1, 1) if is_vector else sides
    columns = broadcast_to(columns, (*outer, *columns.shape[-2:]))
    count, flat = source.shape[-1], []
    for rows, block in zip(matrices, columns.reshape(-1, *columns.shape[-2:]).tolist(), strict=True):
        joined = [[*row, *side] for row, side in zip(rows, block, strict=True)]
        if _eliminate(joined, count) == 0.0:
            raise LinAlgError("Singular matrix")
        flat += [x for row in joined for x in row[count:]]
    result = _finished(flat, columns.shape, _F8)
    return result.reshape(sides.shape) if is_vector else result


def eigh(value: Any) -> tuple[ndarray, ndarray]:
    """Return eigenvalues in ascending order and eigenvectors (columns) of symmetric matrices, by Jacobi's rotations."""
    source, outer, matrices = _matrices(value)
    n = source.shape[-1]
    values, vectors = [], []
    for rows in matrices:
        own, basis = _jacobi(rows)
        order = sorted(range(n), key=own.__getitem__)
        values += [own[i] for i in order]
        vectors += [basis[r][i] for r in range(n) for i in order]
    return _finished(values, (*outer, n), _F8), _finished(vectors, source.shape, _F8)


def eigvalsh(value: Any) -> ndarray:
    """Return the eigenvalues of symmetric matrices in ascending order."""
    return eigh(value)[0]


def _jacobi(rows: list[list[float]]) -> tuple[list[float], list[list[float]]]:
    """Return the eigenvalues and eigenvectors of a symmetric matrix."""
    n = len(rows)
    a = [list(row) for row in rows]
    v = [[float(i == j) for j in range(n)] for i in range(n)]
    for _ in range(_SWEEPS):
        if sum(a[i][j] ** 2 for i in range(n) for j in range(i)) <= 1e-40 * sum(a[i][i] ** 2 for i in range(n)):
            break
        for p in range(n):
            for q in range(p + 1, n):
                if a[p][q] == 0.0:
                    continue
                theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q])
                t = math.copysign(1.0, theta) / (abs(theta) + math.hypot(theta, 1.0))
                c = 1.0 / math.hypot(t, 1.0)
                s = t * c
                for k in range(n):
                    a[k][p], a[k][q] = c * a[k][p] - s * a[k][q], s * a[k][p] + c * a[k][q]
                for k in range(n):
                    a[p][k], a[q][k] = c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]
                for k in range(n):
                    v[k][p], v[k][q] = c * v[k][p] - s * v[k][q], s * v[k][p] + c * v[k][q]
    return [a[i][i] for i in range(n)], v


def svd(value: Any, full_matrices: bool = True, compute_uv: bool = True) -> Any:
    """Return singular values in descending order, with both bases unless ``compute_uv`` is false.

    One-sided Jacobi rotations keep small singular values exact, which the eigenvalues of the square would not.
    """
    source, outer, matrices = _matrices(value)
    if source.shape[-2] < source.shape[-1]:
        result = svd(source.swapaxes(-1, -2), full_matrices, compute_uv)
        return result if not compute_uv else (result[2].swapaxes(-1, -2), result[1], result[0].swapaxes(-1, -2))
    parts = [_one_sided(rows) for rows in matrices]
    n = source.shape[-1]
    values = _finished([x for _, s, _ in parts for x in s], (*outer, n), _F8)
    if not compute_uv:
        return values
    left = stack([asarray(_completed(u, full=full_matrices)) for u, _, _ in parts])
    right = stack([asarray(v) for _, _, v in parts])
    return left.reshape(*outer, *left.shape[1:]), values, right.reshape(*outer, *right.shape[1:])


def _one_sided(rows: list[list[float]]) -> tuple[list[list[float]], list[float], list[list[float]]]:
    """Return left vectors (as columns of rows), singular values, and right vectors as rows."""
    m, n = len(rows), len(rows[0])
    columns = [[rows[i][j] for i in range(m)] for j in range(n)]
    basis = [[float(i == j) for i in range(n)] for j in range(n)]
    for _ in range(_SWEEPS):
        rotated = False
        for p in range(n):
            for q in range(p + 1, n):
                alpha = sum(x * x for x in columns[p])
                beta = sum(x * x for x in columns[q])
                gamma = sum(x * y for x, y in zip(columns[p], columns[q], strict=True))
                if abs(gamma) <= 1e-16 * math.sqrt(alpha * beta) or gamma == 0.0:
                    continue
                rotated = True
                zeta = (beta - alpha) / (2.0 * gamma)
                t = math.copysign(1.0, zeta) / (abs(zeta) + math.hypot(zeta, 1.0))
                c = 1.0 / math.hypot(t, 1.0)
                for each in (columns, basis):
                    x, y = each[p], each[q]
                    each[p] = [c * a - c * t * b for a, b in zip(x, y, strict=True)]
                    each[q] = [c * t * a + c * b for a, b in zip(x, y, strict=True)]
        if not rotated:
            break
    lengths = [math.sqrt(sum(x * x for x in column)) for column in columns]
    order = sorted(range(n), key=lambda j: -lengths[j])
    left = [[columns[j][i] / lengths[j] if lengths[j] else math.nan for j in order] for i in range(m)]
    return left, [lengths[j] for j in order], [basis[j] for j in order]


def _completed(rows: list[list[float]], *, full: bool) -> list[list[float]]:
    """Return left vectors with those of zero singular values, and with ``full`` the rest of the space, filled in."""
    m, n = len(rows), len(rows[0])
    width = m if full else n
    vectors: list[list[float]] = [[row[j] for row in rows] for j in range(n)]
    vectors = [vector for vector in vectors if not math.isnan(vector[0])]
    for axis in range(m):
        if len(vectors) == width:
            break
        trial = [float(i == axis) for i in range(m)]
        for vector in (*vectors, *vectors):
            share = sum(a * b for a, b in zip(trial, vector, strict=True))
            trial = [a - share * b for a, b in zip(trial, vector, strict=True)]
        length = math.sqrt(sum(x * x for x in trial))
        if length > 1e-6:
            vectors.append([x / length for x in trial])
    return [[vector[i] for vector in vectors] for i in range(m)]


def matrix_rank(value: Any) -> int:
    """Return the number of singular values above numpy's threshold."""
    values = svd(value, compute_uv=False).tolist()
    return sum(x > max(values) * max(asarray(value).shape) * 2.0**-52 for x in values)


def lstsq(matrix: Any, right: Any, rcond: Any = None) -> Any:
    """Return the solution of least squares by the normal equations' singular values."""
    u, s, v = svd(matrix, full_matrices=False)
    scaled = (u.T @ asarray(right)) / s
    return v.T @ scaled, None, None, s


def qr(matrix: Any) -> tuple[ndarray, ndarray]:
    """Return an orthogonal basis of columns and the triangle, by Gram and Schmidt twice."""
    source = asarray(matrix, float64)
    columns: list[list[float]] = []
    for column in source.T.tolist():
        for vector in (*columns, *columns):
            share = sum(a * b for a, b in zip(column, vector, strict=True))
            column = [a - share * b for a, b in zip(column, vector, strict=True)]
        length = math.sqrt(sum(x * x for x in column))
        columns.append([x / length if length else 0.0 for x in column])
    q = asarray(columns).T
    return q, q.T @ source
