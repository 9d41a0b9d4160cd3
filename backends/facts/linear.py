"""Linear programs of statics, by HiGHS."""

from __future__ import annotations

import numpy as np

from scenelang.backends.surfaces.distance import IntArray
from scenelang.backends.surfaces.solids import FloatArray

# Iterations of the simplex method per variable: a limit in steps, so that a loaded machine changes no verdict. Arches
# and walls of 200 bodies take two to three.
_ITERATIONS_PER_VARIABLE = 20


def least_slack(
    matrix: tuple[IntArray, IntArray, FloatArray], rows: int, columns: int, right: FloatArray
) -> FloatArray | None:
    """Return the slack (rows,) of least sum with which forces balance loads; None if the solver gives up.

    Parameters
    ----------
    matrix
        Rows, columns and values of the nonzero entries of A.
    rows, columns
        Numbers of the equations and of the forces.
    right : (rows,)
        Loads b.

    Notes
    -----
    Minimizes the sum of |s| under A x + s = b, x >= 0 (Whiting, Ochsendorf and Durand, "Procedural modeling of
    structurally-sound masonry buildings", 2009, measure infeasibility so, by the tension that would be needed).
    """
    import highspy

    index, at, values = matrix
    every = np.arange(rows)
    index = np.concatenate([index, every, every])
    at = np.concatenate([at, columns + every, columns + rows + every])
    values = np.concatenate([values, np.ones(rows), -np.ones(rows)])
    order = np.lexsort((index, at))
    total = columns + 2 * rows
    program = highspy.HighsLp()
    program.num_col_, program.num_row_ = total, rows
    program.col_cost_ = np.concatenate([np.zeros(columns), np.ones(2 * rows)])
    program.col_lower_, program.col_upper_ = np.zeros(total), np.full(total, np.inf)
    program.row_lower_ = program.row_upper_ = right
    program.a_matrix_.format_ = highspy.MatrixFormat.kColwise
    program.a_matrix_.start_ = np.searchsorted(at[order], np.arange(total + 1)).astype(np.int32)
    program.a_matrix_.index_, program.a_matrix_.value_ = index[order].astype(np.int32), values[order]
    solver = highspy.Highs.__bases__[0]()  # without the callbacks of `Highs`, which make it print a banner
    for name, value in (
        ("output_flag", False), ("threads", 1), ("simplex_iteration_limit", _ITERATIONS_PER_VARIABLE * total)
    ):  # fmt: skip
        solver.setOptionValue(name, value)
    solver.passModel(program)
    solver.run()
    if solver.getModelStatus() != highspy.HighsModelStatus.kOptimal:
        return None
    solution = np.array(solver.getSolution().col_value)
    return np.asarray(solution[columns : columns + rows] - solution[columns + rows :], np.float64)
