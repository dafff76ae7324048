"""Positions where vision has no instance: a grid on the table, summed over."""

from dataclasses import dataclass, replace

import numpy as np
from numba import njit

from grounding.glide.actions import Kind
from grounding.glide.config import GlideConfig
from grounding.glide.emissions import aim_cov
from grounding.glide.landmarks import beside, tells_place
from grounding.glide.model import Parameters, Session
from grounding.glide.sight import log_density, where_met
from grounding.types import FloatArray, IntArray

_NODES_MOST = 20_000
_HEIGHT_SIGMA_M = 0.008
_HEIGHT_STEP_M = 0.005  # grids closer than this are one
_STACKED_M = 0.04  # height of a thing that was not seen, to stand another on
_LEAST_HALF_M = 0.015  # of a thing's width
_RATIO_CAP = 5e3
_SEEN = 1e-3  # a look whose density ratio at a node is below this says nothing for the node


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Grid:
    """Nodes of a level grid and what each look says for them; sparse, one run of nodes a look.

    Attributes:
        nodes: (G, 3) positions.
        first: (T + 1,) where each look's run begins.
        node: (S,) node of each entry.
        ratio: (S,) density of the look for that node over that of the background.
        prior: (G,) of the nodes; the sum is 1.
    """

    nodes: FloatArray
    prior: FloatArray
    first: IntArray
    node: IntArray
    ratio: FloatArray

    @property
    def runs(self) -> tuple[IntArray, IntArray, FloatArray]:
        """The sparse part, as the compiled functions take it."""
        return self.first, self.node, self.ratio


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GridRow:
    """A sort of segment whose position was not seen.

    Attributes:
        grid: the positions it may have.
        base: (T,) what else a look may be, over the background.
        weight: of the position's part of the mixture.
    """

    grid: Grid
    base: FloatArray
    weight: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Unseen:
    """Which actions, under which hypotheses, have an unseen position.

    Attributes:
        row: (A, H) index into `rows`, or -1.
        rows: the sorts of segments.
    """

    row: IntArray
    rows: tuple[GridRow, ...]

    def segments(self, *, longest: int) -> FloatArray:
        """Return (rows, T, D + 1): log likelihood of segments, positions summed out, eq. 5."""
        count = len(self.rows[0].base)
        table = np.zeros((len(self.rows), count, longest + 1))
        for out, each in zip(table, self.rows, strict=True):
            _fill(out, each.grid.runs, each.base, each.weight, each.grid.prior)
        return table

    def read(self, a: int, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the position's posterior on the grid of action a, and the looks at it.

        Args:
            a: the action.
            weights: (T, D + 1) posterior of its segments with an unseen position.
        """
        each = self.rows[int(self.row[a].max())]
        return read_grid(weights, each.grid.runs, each.base, each.weight, each.grid.prior)

    def nodes(self, a: int) -> FloatArray:
        """Return the nodes (G, 3) of action a's grid."""
        return self.rows[int(self.row[a].max())].grid.nodes


def unseen_positions(
    session: Session,
    parameters: Parameters,
    config: GlideConfig,
    *,
    parts: tuple[FloatArray, FloatArray, FloatArray],
) -> Unseen:
    """Lay grids at the heights that unseen positions have, and say who uses which.

    Args:
        session: what was observed.
        parameters: what was learnt.
        config: the constants.
        parts: weights (A, 3, 3), landmarks (A, H, T), density of anywhere over background (T,).

    Returns:
        The grids; actions that cannot be told apart share a row.
    """
    weights, landmark, calm = parts
    step = _HEIGHT_STEP_M * config.scene_unit_m
    row = np.full((len(session.acts), session.rests.count + 1), -1, dtype=np.int64)
    grids: dict[int, Grid] = {}
    rows: dict[tuple[int, float, bytes, bytes], GridRow] = {}
    for a, act in enumerate(session.acts):
        put = act.kind is Kind.PUT
        level = round(_height(session, parameters, config, a) / step)
        if level not in grids:
            grids[level] = _grid(session, parameters, config, height=level * step, calm=calm)
        grid = (
            _about_landmark(session, parameters, config, a, grid=grids[level], calm=calm)
            if put
            else _with_room(session, config, grids[level])
        )
        mean = weights[a].mean(axis=0)
        base = 1.0 - mean.sum() + (mean[2] * landmark[a, -1] if put else 0.0 * calm)
        weight = float(mean[0] + mean[1])
        key = (level, weight, base.tobytes(), grid.prior.tobytes())
        rows.setdefault(key, GridRow(grid=grid, base=base, weight=weight))
        row[a, -1] = list(rows).index(key)
        if put:
            row[a, :-1][session.rests.next_rest < 0] = row[a, -1]
    return Unseen(row=row, rows=tuple(rows.values()))


def _height(session: Session, parameters: Parameters, config: GlideConfig, a: int) -> float:
    """Return how high the middle of an unseen thing stands, by what is known of its likes."""
    act, rests, unit = session.acts[a], session.rests, config.scene_unit_m
    half = config.rest_height_m * unit
    top = _STACKED_M * unit
    if rests.count:
        once = 1.0 / np.bincount(rests.thing)[rests.thing]
        half = float(parameters.theta[a][rests.thing] * once @ rests.height) / 2
        if act.landmarks:
            named = parameters.landmark_theta[a][rests.thing] * once
            top = float(named @ (rests.position[:, 2] + rests.height / 2)) - session.table_z
    on_top = act.relation == "on-top-of" and bool(act.landmarks)
    return session.table_z + half + (top if on_top and act.landmarks != (("table",),) else 0.0)


def _grid(
    session: Session,
    parameters: Parameters,
    config: GlideConfig,
    *,
    height: float,
    calm: FloatArray,
) -> Grid:
    unit, low, high = config.scene_unit_m, session.low, session.high
    extent = float(np.prod(high - low))
    spacing = max(config.grid_spacing_m * unit, float(np.sqrt(extent / _NODES_MOST)))
    x, y = (np.arange(low[k], high[k] + spacing, spacing) for k in range(2))
    level = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    met, cov = where_met(session.sights, height, offset_rad=parameters.gaze_offset_rad)
    spread = (config.aim_sigma_m**2 + _HEIGHT_SIGMA_M**2) * unit**2 + spacing**2 / 12
    cov = parameters.noise_scale**2 * cov + spread * np.eye(2)
    first, node, density = _near_nodes((x, y), met[:, :2], cov)
    look = np.repeat(np.arange(session.sights.count), np.diff(first))
    ratio = np.minimum(density * session.area, _RATIO_CAP) * calm[look]
    nodes = np.column_stack([level, np.full(len(level), height)])
    prior = np.full(len(nodes), 1.0 / len(nodes))
    return Grid(nodes=nodes, first=first, node=node, ratio=ratio, prior=prior)


def _with_room(session: Session, config: GlideConfig, grid: Grid) -> Grid:
    """Return the grid without the nodes at which something that was always there leaves no room.

    Else a gaze that falls between two things would find a third one there.
    """
    rests = session.rests
    stays = np.isinf(rests.left_s) & np.isinf(rests.since_s)
    off = grid.nodes[:, None] - rests.position[stays]  # (G, S, 3)
    reach = rests.extent[stays] / 2 + _LEAST_HALF_M * config.scene_unit_m
    is_near = np.linalg.norm(off[..., :2], axis=2) < reach
    is_level = np.abs(off[..., 2]) < rests.height[stays] / 2
    free = ~(is_near & is_level).any(axis=1)
    if not free.any():
        return grid
    prior = grid.prior * free
    return replace(grid, prior=prior / prior.sum())


def _about_landmark(
    session: Session,
    parameters: Parameters,
    config: GlideConfig,
    a: int,
    *,
    grid: Grid,
    calm: FloatArray,
) -> Grid:
    """Return the grid of an action with what its landmark says of the place as prior, eq. 5b.

    On top of something means on top of one of the things there are, mostly.
    """
    act, rests = session.acts[a], session.rests
    if not tells_place(act) or not rests.count:
        return grid
    own = parameters.theta[a][rests.thing]
    size = own / max(float(own.sum()), 1e-12) @ np.column_stack([rests.extent, rests.height])
    named = parameters.landmark_theta[a][rests.thing]
    named = named / max(float(named.sum()), 1e-12)
    if act.relation != "on-top-of":
        near = beside(session, config, act, extent=float(size[0]), points=grid.nodes) @ named
        missed = config.relation_missed / len(near)
        prior = missed + (1 - config.relation_missed) * near / max(float(near.sum()), 1e-12)
        return replace(grid, prior=prior)
    top = rests.position[:, 2] + 0.5 * rests.height + 0.5 * float(size[1])
    tops = np.column_stack([rests.position[:, :2], top])
    log = log_density(
        session.sights,
        tops,
        aim_cov(session, config),
        offset_rad=parameters.gaze_offset_rad,
        scale=parameters.noise_scale,
    )
    ratio = np.minimum(np.exp(np.minimum(log, 30.0)) * session.area, _RATIO_CAP) * calm[:, None]
    return _with_nodes(grid, tops, ratio, prior=named, missed=config.relation_missed)


def _with_nodes(
    grid: Grid, nodes: FloatArray, ratio: FloatArray, *, prior: FloatArray, missed: float
) -> Grid:
    """Return a grid with more nodes (N, 3), each seen by every look, and most of the prior there.

    Args:
        grid: the level grid.
        nodes: (N, 3) the places.
        ratio: (T, N) what each look says for them.
        prior: (N,) of the places among each other.
        missed: share of the prior that the level grid keeps.
    """
    count, places = ratio.shape
    looks = np.arange(count)
    look = np.concatenate([np.repeat(looks, np.diff(grid.first)), np.repeat(looks, places)])
    order = np.argsort(look, kind="stable")
    node = np.concatenate([grid.node, np.tile(np.arange(places) + len(grid.nodes), count)])
    return Grid(
        nodes=np.concatenate([grid.nodes, nodes]),
        first=grid.first + places * np.arange(count + 1),
        node=node[order],
        ratio=np.concatenate([grid.ratio, ratio.ravel()])[order],
        prior=np.concatenate([missed * grid.prior, (1 - missed) * prior]),
    )


@njit(cache=True)
def _near_nodes(
    axes: tuple[FloatArray, FloatArray], met: FloatArray, cov: FloatArray
) -> tuple[IntArray, IntArray, FloatArray]:
    """Return the nodes within reach of each look, as runs, with the normal densities there."""
    x, y = axes
    reach = np.sqrt(-2 * np.log(_SEEN))
    first = np.zeros(len(met) + 1, dtype=np.int64)
    node, density = [0], [0.0]  # a first entry of each, for their types
    for t in range(len(met)):
        a, b, d = cov[t, 0, 0], cov[t, 0, 1], cov[t, 1, 1]
        det = a * d - b * b
        if np.isfinite(met[t, 0]):
            for i in range(
                np.searchsorted(x, met[t, 0] - reach * np.sqrt(a)),
                np.searchsorted(x, met[t, 0] + reach * np.sqrt(a)),
            ):
                for j in range(
                    np.searchsorted(y, met[t, 1] - reach * np.sqrt(d)),
                    np.searchsorted(y, met[t, 1] + reach * np.sqrt(d)),
                ):
                    u, v = x[i] - met[t, 0], y[j] - met[t, 1]
                    squared = (d * u * u - 2 * b * u * v + a * v * v) / det
                    if squared < reach * reach:
                        node.append(i * len(y) + j)
                        density.append(np.exp(-0.5 * squared) / (2 * np.pi * np.sqrt(det)))
        first[t + 1] = len(node) - 1
    return first, np.array(node)[1:], np.array(density)[1:]


@njit(cache=True)
def _fill(
    table: FloatArray,
    runs: tuple[IntArray, IntArray, FloatArray],
    base: FloatArray,
    weight: float,
    prior: FloatArray,
) -> None:
    first, node, ratio = runs
    count, longest = table.shape[0], table.shape[1] - 1
    product = prior.copy()
    for s in range(count):
        total, log_base = 1.0, 0.0
        e = min(count, s + longest)
        for t in range(s, e):
            log_base += np.log(base[t])
            for k in range(first[t], first[t + 1]):
                before = product[node[k]]
                product[node[k]] = before * (1.0 + weight * ratio[k] / base[t])
                total += product[node[k]] - before
            table[s, t + 1 - s] = log_base + np.log(total)
        for t in range(s, e):
            for k in range(first[t], first[t + 1]):
                product[node[k]] = prior[node[k]]


@njit(cache=True)
def read_grid(
    weights: FloatArray,
    runs: tuple[IntArray, IntArray, FloatArray],
    base: FloatArray,
    weight: float,
    prior: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return what segments with posterior weights (T, D + 1) say of the position.

    Returns:
        belief: (nodes,) posterior of the position, its sum that of the weights.
        on_place: (T,) posterior that the look was at the position.
    """
    first, node, ratio = runs
    count, longest = weights.shape[0], weights.shape[1] - 1
    belief, on_place = np.zeros(len(prior)), np.zeros(count)
    for s in range(count):
        for d in range(1, longest + 1):
            w = weights[s, d]
            if w < 1e-9:
                continue
            product = prior.copy()
            for t in range(s, s + d):
                for k in range(first[t], first[t + 1]):
                    product[node[k]] *= 1.0 + weight * ratio[k] / base[t]
            product *= w / product.sum()
            belief += product
            for t in range(s, s + d):
                for k in range(first[t], first[t + 1]):
                    pull = weight * ratio[k] / base[t]
                    on_place[t] += product[node[k]] * pull / (1.0 + pull)
    return belief, on_place
