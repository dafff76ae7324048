"""The things on the table, the plan of what is done with them, and where they are at any time."""

from dataclasses import dataclass, field, replace
from enum import StrEnum
from itertools import product

import numpy as np

from gazemap.errors import ConfigError
from gazemap.geometry.arrays import FloatArray
from gazemap.sim.config import SimConfig, TabletopConfig
from gazemap.sim.speech import pick_sentence, put_sentence
from gazemap.sim.vocabulary import SHAPES, Relation

TABLE_SIZE_M = (1.24, 0.84)
TABLE_THICKNESS_M = 0.02
_FREE_HALF_M = (0.44, 0.25)  # centres keep off the tags, which lie along the border
_START_GAP_M = 0.045
_PLACE_GAP_M = 0.03
_LEAD_S, _TAIL_S = 1.5, 1.7
_PAIR_S = 5.6  # what a pick, a place and the pause before the next usually take
_LIFT_BEFORE_S, _RELEASE_BEFORE_S = 0.25, 0.45
_CARRY_HEIGHT_M = 0.16
_TRIES = 2000


class Action(StrEnum):
    """What the person does."""

    PICK = "pick"
    PUT = "put"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Block:
    """A box-shaped thing: full size (3,), yaw about z, its centre (3,) at the start in world."""

    colour: str
    shape: str
    size_m: FloatArray
    yaw_rad: float
    start_world: FloatArray

    @property
    def words(self) -> tuple[str, str]:
        """What it is called: colour and shape."""
        return self.colour, self.shape

    def T_world_body(self, centre_world: FloatArray) -> FloatArray:
        """Return the homogeneous matrix (4, 4) of its body with its centre (3,) at a place."""
        c, s = np.cos(self.yaw_rad), np.sin(self.yaw_rad)
        matrix = np.eye(4)
        matrix[:2, :2] = [[c, -s], [s, c]]
        matrix[:3, 3] = centre_world
        return matrix


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Step:
    """One action: picks and puts alternate.

    Attributes:
        action: what is done.
        block: index of the thing it is done with.
        sentence: what is said.
        position_world: where the thing's centre is (pick) or is left (put), (3,) metres.
        start_s: from the first frame on.
        end_s: likewise.
        relation: where it is put; None for a pick.
        reference: index of the thing it is put next to; None for a pick.
    """

    action: Action
    block: int
    sentence: str
    position_world: FloatArray
    start_s: float = 0.0
    end_s: float = 0.0
    relation: Relation | None = None
    reference: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Carry:
    """A thing on its way from one place to another."""

    block: int
    lift_s: float
    release_s: float
    from_world: FloatArray
    to_world: FloatArray

    def centre_world(self, t_s: float) -> FloatArray:
        """Return the centre (3,) at a time between lift and release: quintic, on an arc."""
        a = float(np.clip((t_s - self.lift_s) / (self.release_s - self.lift_s), 0.0, 1.0))
        s = a**3 * (10.0 - 15.0 * a + 6.0 * a * a)
        way: FloatArray = self.from_world * (1.0 - s) + self.to_world * s
        arc: FloatArray = np.array([0.0, 0.0, _CARRY_HEIGHT_M * np.sin(np.pi * s)])
        return np.asarray(way + arc)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Demonstration:
    """The things and everything that is done with them."""

    blocks: tuple[Block, ...]
    steps: tuple[Step, ...]
    carries: tuple[Carry, ...]

    def centres_world(self, t_s: float) -> FloatArray:
        """Return the centres (N, 3) of all things at a time."""
        centres = np.array([block.start_world for block in self.blocks])
        for carry in self.carries:
            if t_s >= carry.lift_s:
                centres[carry.block] = carry.centre_world(t_s)
        return centres


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Table:
    """The things as they stand between two carries, and which were carried already."""

    blocks: tuple[Block, ...]
    centres: FloatArray
    carried: set[int] = field(default_factory=set)

    def allows(self, picked: int, reference: int, relation: Relation) -> bool:
        """Whether a thing can be put beside or on a reference that stands on the table."""
        stacked = relation is Relation.ON_TOP_OF
        if picked == reference or self.is_covered(picked) or not self.is_on_table(reference):
            return False
        if stacked and self.is_covered(reference):
            return False
        goal = self.goal_world(picked, reference, relation)
        return self.is_free(goal, picked=picked, below=reference if stacked else None)

    def is_covered(self, i: int) -> bool:
        """Whether something stands on thing i."""
        beside = np.hypot(*(self.centres[:, :2] - self.centres[i, :2]).T)
        return bool(((beside < 0.005) & (self.centres[:, 2] > self.centres[i, 2] + 1e-6)).any())

    def is_on_table(self, i: int) -> bool:
        """Whether thing i stands on the table itself."""
        return bool(self.centres[i, 2] < self.blocks[i].size_m[2] / 2 + 1e-6)

    def goal_world(self, picked: int, reference: int, relation: Relation) -> FloatArray:
        """Return where the centre (3,) of a thing comes to rest beside or on a reference."""
        half, base = self.blocks[picked].size_m / 2, self.blocks[reference].size_m / 2
        x, y, z = self.centres[reference]
        if relation is Relation.ON_TOP_OF:
            return np.array([x, y, z + base[2] + half[2]])
        step = np.array(relation.direction) * (half.max() + base.max() + _PLACE_GAP_M)
        return np.array([x + step[0], y + step[1], half[2]])

    def is_free(self, goal: FloatArray, *, picked: int, below: int | None) -> bool:
        """Whether a thing fits at a goal (3,) on the table, or on the thing below."""
        if (np.abs(goal[:2]) > _FREE_HALF_M).any():
            return False
        mine = _radius_m(self.blocks[picked].size_m)
        return all(
            np.hypot(*(goal - centre)[:2]) > mine + _radius_m(block.size_m)
            for i, (block, centre) in enumerate(zip(self.blocks, self.centres, strict=True))
            if i not in (picked, below)
        )


def demonstrate(config: SimConfig, rng: np.random.Generator) -> Demonstration:
    """Draw a table and what the person does on it."""
    blocks = _lay_out(config.tabletop, rng)
    table = _Table(blocks=blocks, centres=np.array([block.start_world for block in blocks]))
    steps: list[Step] = []
    t_s = _LEAD_S
    for pick_s, put_s, pause_s in _durations_s(config.seconds, rng):
        pick, put = _pick_and_put(table, config.tabletop, rng)
        middle_s, end_s = t_s + float(pick_s), t_s + float(pick_s + put_s)
        steps.append(replace(pick, start_s=t_s, end_s=middle_s))
        steps.append(replace(put, start_s=middle_s, end_s=end_s))
        table.centres[put.block] = put.position_world
        table.carried.add(put.block)
        t_s = end_s + float(pause_s)
    pairs = zip(steps[0::2], steps[1::2], strict=True)
    carries = tuple(_carry(pick, put) for pick, put in pairs)
    return Demonstration(blocks=blocks, steps=tuple(steps), carries=carries)


def _pick_and_put(
    table: _Table, config: TabletopConfig, rng: np.random.Generator
) -> tuple[Step, Step]:
    """Draw what is picked and where it is put; the times are still to come."""
    picked, reference, relation = _choose(table, config, rng)
    words, other = table.blocks[picked].words, table.blocks[reference].words
    pick = Step(
        action=Action.PICK,
        block=picked,
        sentence=pick_sentence(words, rng),
        position_world=table.centres[picked].copy(),
    )
    put = Step(
        action=Action.PUT,
        block=picked,
        sentence=put_sentence(words, relation, reference=other, rng=rng),
        position_world=table.goal_world(picked, reference, relation),
        relation=relation,
        reference=reference,
    )
    return pick, put


def _carry(pick: Step, put: Step) -> Carry:
    return Carry(
        block=pick.block,
        lift_s=pick.end_s - _LIFT_BEFORE_S,
        release_s=put.end_s - _RELEASE_BEFORE_S,
        from_world=pick.position_world,
        to_world=put.position_world,
    )


def _durations_s(seconds: float, rng: np.random.Generator) -> FloatArray:
    """Draw pick, put and pause (N, 3) of as many pairs as fit, stretched a little to fill."""
    room_s = seconds - _LEAD_S - _TAIL_S
    count = max(1, round(room_s / _PAIR_S))
    drawn = np.column_stack(
        [
            rng.uniform(1.9, 2.7, count),
            rng.uniform(2.25, 2.95, count),
            rng.uniform(0.5, 1.25, count),
        ]
    )
    drawn[-1, 2] = 0.0
    scaled: FloatArray = drawn * min(1.15, room_s / float(drawn.sum()))
    return scaled


def _lay_out(config: TabletopConfig, rng: np.random.Generator) -> tuple[Block, ...]:
    pairs = [(c, s) for c in dict.fromkeys(config.colours) for s in dict.fromkeys(config.shapes)]
    order = rng.permutation(len(pairs))[: config.object_count]
    blocks: list[Block] = []
    for colour, shape in (pairs[int(i)] for i in order):
        size_m = np.array(SHAPES[shape].size_m) * rng.uniform(0.94, 1.06)
        radius_m = _radius_m(size_m)
        for _ in range(_TRIES):
            xy = rng.uniform(-1.0, 1.0, 2) * _FREE_HALF_M
            apart = (
                np.hypot(*(xy - b.start_world[:2])) > radius_m + _radius_m(b.size_m) + _START_GAP_M
                for b in blocks
            )
            if all(apart):
                break
        else:
            raise ConfigError(f"sim: {config.object_count} things do not fit on the table")
        yaw_rad = float(rng.uniform(-np.pi, np.pi))
        start = np.array([*xy, size_m[2] / 2])
        blocks.append(
            Block(colour=colour, shape=shape, size_m=size_m, yaw_rad=yaw_rad, start_world=start)
        )
    return tuple(blocks)


def _radius_m(size_m: FloatArray) -> float:
    return float(np.hypot(size_m[0], size_m[1])) / 2


def _choose(
    table: _Table, config: TabletopConfig, rng: np.random.Generator
) -> tuple[int, int, Relation]:
    """Draw a thing, a reference and a relation whose place is free and on the table."""
    count = range(len(table.blocks))
    possible = [
        (picked, reference, relation)
        for picked, reference, relation in product(count, count, config.relations)
        if table.allows(picked, reference, relation)
    ]
    fresh = [each for each in possible if each[0] not in table.carried]
    choices = fresh or possible  # a person seldom moves a thing twice
    if not choices:
        raise ConfigError("sim: nothing on the table can be put anywhere; ask for fewer things")
    return choices[int(rng.integers(len(choices)))]
