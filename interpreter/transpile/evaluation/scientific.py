"""What evaluated programs may use of scipy, shapely, networkx and trimesh, which compute it (``python-libraries``).

A function gets plain data, of limited size, and what it gives is plain data or an object of a class of the table. A
program reads the attributes that the table names for that class, and no others. Nothing is listed that reads files or
clocks, draws numbers without a seed, or may take long for data within the limits.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType
from typing import Any

import numpy as np

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.loading import require
from scenelang.interpreter.transpile.evaluation import MAX_ITEMS, UnsupportedPython, words
from scenelang.interpreter.transpile.evaluation.objects import Native
from scenelang.interpreter.transpile.evaluation.residue import has_residual

EXTRA = "'scenelang[python-libraries]'"
_MOST_NUMBERS = 20_000  # in the arguments of a call
_MOST_COUNT = 1_000  # of what a number asks for
_MOST_AXES = 4  # of points, in whose dimensions the work grows exponentially

FUNCTIONS: Mapping[str, str] = MappingProxyType({
    "scipy.spatial": "ConvexHull Delaunay KDTree Voronoi cKDTree",
    "scipy.spatial.distance": "cdist chebyshev cityblock cosine euclidean pdist sqeuclidean squareform",
    "scipy.interpolate": "Akima1DInterpolator BSpline CubicHermiteSpline CubicSpline PchipInterpolator "
    "RBFInterpolator RegularGridInterpolator UnivariateSpline griddata interp1d make_interp_spline splev splprep "
    "splrep",
    "scipy.ndimage": "binary_closing binary_dilation binary_erosion binary_fill_holes binary_opening "
    "distance_transform_edt gaussian_filter label maximum_filter median_filter minimum_filter uniform_filter",
    "shapely": "LineString LinearRing MultiLineString MultiPoint MultiPolygon Point Polygon box unary_union",
    "shapely.geometry": "LineString LinearRing MultiLineString MultiPoint MultiPolygon Point Polygon box",
    "shapely.ops": "linemerge nearest_points polygonize triangulate unary_union",
    "shapely.affinity": "rotate scale skew translate",
    "networkx": "DiGraph Graph MultiGraph all_neighbors ancestors astar_path balanced_tree barabasi_albert_graph "
    "bfs_edges bfs_tree binomial_tree circulant_graph circular_layout complete_bipartite_graph complete_graph "
    "connected_components cycle_graph degree descendants dfs_edges dfs_postorder_nodes dfs_preorder_nodes dfs_tree "
    "dijkstra_path dijkstra_path_length erdos_renyi_graph gnp_random_graph greedy_color "
    "grid_2d_graph grid_graph has_path hexagonal_lattice_graph is_connected is_directed_acyclic_graph is_tree "
    "ladder_graph minimum_spanning_edges minimum_spanning_tree neighbors number_connected_components path_graph "
    "random_geometric_graph random_labeled_tree shell_layout shortest_path shortest_path_length "
    "single_source_shortest_path single_source_shortest_path_length spring_layout star_graph "
    "strongly_connected_components topological_generations topological_sort triangular_lattice_graph "
    "watts_strogatz_graph weakly_connected_components wheel_graph",
    "trimesh": "creation",
    "trimesh.creation": "annulus box capsule cone cylinder icosahedron icosphere torus uv_sphere",
})  # fmt: skip

_GEOMETRY = (
    "area boundary bounds buffer centroid contains convex_hull coords covers crosses difference disjoint distance "
    "envelope equals exterior geom_type geoms has_z interiors intersection intersects interpolate is_closed is_empty "
    "is_ring is_simple is_valid length line_interpolate_point minimum_rotated_rectangle overlaps parallel_offset "
    "offset_curve project representative_point simplify symmetric_difference touches union within x xy y z"
)
_SPLINE = "__call__ antiderivative c derivative integrate k roots solve t x"
_VIEW = "data get items keys values"
_GRAPH = (
    "add_edge add_edges_from add_node add_nodes_from add_weighted_edges_from adj adjacency clear copy degree edges "
    "get_edge_data graph has_edge has_node in_degree in_edges is_directed neighbors nodes number_of_edges "
    "number_of_nodes order out_degree out_edges predecessors remove_edge remove_edges_from remove_node "
    "remove_nodes_from reverse size subgraph edge_subgraph successors to_directed to_undirected"
)


@dataclass(frozen=True, slots=True)
class LibraryClass:
    """Class of a library: the attributes that programs may read, and those in which its changing state is."""

    attributes: frozenset[str]
    state: tuple[str, ...] = ()


def _classes(library: str, attributes: str, *names: str, state: str = "") -> dict[str, LibraryClass]:
    return {f"{library}.{name}": LibraryClass(frozenset(words(attributes)), words(state)) for name in names}


CLASSES: Mapping[str, LibraryClass] = MappingProxyType({
    **_classes("scipy", "area equations max_bound min_bound neighbors npoints points simplices vertices volume "
               "find_simplex convex_hull coplanar good", "ConvexHull", "Delaunay"),
    **_classes("scipy", "max_bound min_bound npoints point_region points regions ridge_dict ridge_points "
               "ridge_vertices vertices", "Voronoi"),
    **_classes("scipy", "data m n query query_ball_point query_pairs", "KDTree", "cKDTree"),
    **_classes("scipy", _SPLINE, "BSpline", "PPoly", "UnivariateSpline"),
    **_classes("scipy", "__call__ x y grid values", "interp1d", "RegularGridInterpolator", "RBFInterpolator"),
    **_classes("shapely", _GEOMETRY, "BaseGeometry"),
    **_classes("shapely", "", "GeometrySequence", "CoordinateSequence", "InteriorRingSequence"),
    **_classes("networkx", _GRAPH, "Graph", state="_node _adj graph"),
    **_classes("networkx", _VIEW, "NodeDataView", "OutEdgeDataView", "AtlasView", "FilterAdjacency", "FilterAtlas"),
    **_classes("networkx", f"{_VIEW} __call__", "DiDegreeView", "NodeView", "OutEdgeView"),
    **_classes("trimesh", "area bounds center_mass centroid edges edges_unique edges_unique_length extents "
               "face_normals faces facets triangles triangles_center vertex_normals vertices volume", "Trimesh"),
})  # fmt: skip


@lru_cache(maxsize=1_000)
def _class_of(kind: type) -> LibraryClass | None:
    names = (f"{each.__module__.partition('.')[0]}.{each.__name__}" for each in kind.__mro__)
    return next((CLASSES[name] for name in names if name in CLASSES), None)


def library_class(value: Any) -> LibraryClass | None:
    """Return the row of the class of a value, None if it is of no library."""
    kind: Any = type(value)
    return _class_of(kind)


# --- sizes ------------------------------------------------------------------------------------------------------------


def _geometric(ratio: int, height: int) -> int:
    return int(min(max(abs(ratio), 1), 10**6) ** min(max(height, 0), 40))


_COUNTS: Mapping[str, Callable[..., int]] = MappingProxyType({  # of what a call makes, by its arguments
    "trimesh.creation.icosphere": lambda subdivisions=3, **_: 20 * _geometric(4, subdivisions),
    "trimesh.creation.uv_sphere": lambda radius=1, count=(32, 32), **_: int(np.prod(count)),
    "networkx.balanced_tree": lambda r, h, **_: _geometric(r, h + 1),
    "networkx.binomial_tree": lambda n, **_: _geometric(2, n),
    "networkx.complete_graph": lambda n, **_: n * n if isinstance(n, int) else len(n) ** 2,
    "networkx.complete_bipartite_graph": lambda a, b, **_: a * b,
    "networkx.grid_2d_graph": lambda m, n, **_: _number(m) * _number(n),
    "networkx.hexagonal_lattice_graph": lambda m, n, **_: 4 * m * n,
    "networkx.triangular_lattice_graph": lambda m, n, **_: m * n,
    "networkx.grid_graph": lambda dim, **_: int(np.prod([_number(each) for each in dim])),
    "networkx.erdos_renyi_graph": lambda n, p, **_: n * n,
    "networkx.gnp_random_graph": lambda n, p, **_: n * n,
    "networkx.random_geometric_graph": lambda n, radius, **_: _number(n) ** 2,
    "networkx.spring_layout": lambda graph, *_, iterations=50, **__: len(graph) ** 2 * iterations // 50,
    "scipy.spatial.distance.cdist": lambda a, b, *_, **__: len(a) * len(b),
    "scipy.spatial.distance.pdist": lambda a, *_, **__: len(a) ** 2,
    "scipy.interpolate.RBFInterpolator": lambda points, *_, **__: len(points) ** 2,
    "query_pairs": lambda tree, *_, **__: int(tree.n) ** 2,
    "query": lambda tree, x, k=1, *_, **__: np.size(x) * _number(k),
    "query_ball_point": lambda tree, x, *_, **__: max(np.size(x) // 2, 1) * int(tree.n),
})  # fmt: skip


def _number(value: Any) -> int:
    return value if isinstance(value, int) else len(value)


def _check(path: str, arguments: tuple[Any, ...], named: Mapping[str, Any]) -> None:
    """Raise an error for arguments that are no plain data, or make something large."""
    given = (*arguments, *named.values())
    if any(map(has_residual, given)):
        raise UnsupportedPython(f"`{path}` of values that are known only in the finished scene is not supported")
    total = sum(map(_size, given))
    counts = [each for each in given if type(each) is int]
    count = _COUNTS.get(path, lambda *_, **__: 0)(*arguments, **named)
    if total > _MOST_NUMBERS or count > MAX_ITEMS or any(abs(each) > _MOST_COUNT for each in counts):
        raise UnsupportedPython(f"this call of `{path}` is too large")
    if any(isinstance(each, np.ndarray) and each.dtype == object for each in given):
        raise UnsupportedPython(f"`{path}` of an array of objects is not supported")
    points: Any = arguments[0] if arguments else None
    if path.startswith("scipy.spatial.") and np.ndim(points) == 2 and np.shape(points)[1] > _MOST_AXES:
        raise UnsupportedPython(f"`{path}` of points with more than {_MOST_AXES} coordinates is not supported")


def _size(value: Any) -> int:
    if isinstance(value, np.ndarray):
        return int(value.size)
    if isinstance(value, (list, tuple)):
        return sum(map(_size, value)) if value and isinstance(value[0], (list, tuple, np.ndarray)) else len(value)
    if hasattr(type(value), "coords") or hasattr(type(value), "geoms"):  # of a polygon it raises an exception
        return int(require("shapely", EXTRA).get_num_coordinates(value))
    return len(value) if isinstance(value, (str, dict, set)) or (library_class(value) is not None and (
        hasattr(value, "__len__")
    )) else 1  # fmt: skip


_PLAIN = (type(None), int, float, complex, str, bytes, list, tuple, dict, set, frozenset, np.ndarray, np.generic)


def _shown(path: str, value: Any) -> Any:
    """Return what a library gives if programs may see it."""
    if isinstance(value, np.ndarray):
        return np.array(value) if type(value) is not np.ndarray or not value.flags.writeable else value
    if isinstance(value, (*_PLAIN, Iterator)) or library_class(value) is not None or _is_of_program(value):
        return value
    raise UnsupportedPython(f"what `{path}` gives is not supported")


def _is_of_program(value: Any) -> bool:
    return type(value).__module__.startswith("scenelang.")


def _checked(path: str, function: Callable[..., Any]) -> Callable[..., Any]:
    def call(*arguments: Any, **named: Any) -> Any:
        _check(path, arguments, named)
        if _is_random(function) and named.get("seed") is None:
            raise UnsupportedPython(f"`{path}` without a seed gives another result in every run", "write `seed=1`")
        return _shown(path, function(*arguments, **named))

    return call


@lru_cache(maxsize=1_000)
def _is_random(function: Callable[..., Any]) -> bool:
    try:
        return "seed" in inspect.signature(function).parameters
    except (TypeError, ValueError):
        return False


# --- modules and attributes -------------------------------------------------------------------------------------------


def library_names(path: str) -> dict[str, Any]:
    """Return the names of a module of the table.

    Raises
    ------
    UnsupportedPython
        Without the extra.
    """
    try:
        module = require(path, EXTRA)
    except SceneError as error:
        message = f"the module `{path}` needs `python-libraries`"
        raise UnsupportedPython(message, error.hint, "backend") from error
    names: dict[str, Any] = {}
    for name in words(FUNCTIONS[path]):
        value = getattr(module, name, None)
        if callable(value):
            kind = value if isinstance(value, type) else None
            names[name] = Native(f"{path}.{name}", _checked(f"{path}.{name}", value), kind)
    return names


def library_attribute(value: Any, row: LibraryClass, name: str, missing: Any) -> Any:
    """Return an attribute of an object of a library, ``missing`` for one that is not in the table."""
    if name not in row.attributes or name.startswith("_"):
        return missing
    attribute = getattr(value, name)
    if not callable(attribute) or library_class(attribute) is not None:
        return _shown(name, attribute)

    def call(*arguments: Any, **named: Any) -> Any:
        _check(name, (value, *arguments), named) if name in _COUNTS else _check(name, arguments, named)
        return _shown(name, attribute(*arguments, **named))

    return Native(name, call)


def call_of_library(value: Any, *arguments: Any, **named: Any) -> Any:
    """Call an object of a library, such as a spline."""
    path = type(value).__name__
    _check(path, arguments, named)
    return _shown(path, value(*arguments, **named))
