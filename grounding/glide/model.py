"""The session as the model sees it, and the parameters that are learnt from it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from grounding.glide.actions import Act, Kind, elementary_actions
from grounding.glide.config import GlideConfig
from grounding.glide.sight import Sights, sights_of
from grounding.types import (
    BoolArray,
    FixationObservation,
    FloatArray,
    IntArray,
    ObjectInstance,
    SpokenInstruction,
)

_MARGIN_M = 0.1


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Demonstration:
    """The observed side of one session.

    Attributes:
        spoken: the instructions in the order said.
        fixations: the looks, in any order.
        objects: the instances that vision found; may be empty.
        heading_rad: the wearer's heading about z; 0 looks along +y.
        table_height: of the table's top in world, or None: taken from objects or looks.
        meant: for positions of instructions, the object that a human said was meant.
        not_meant: for positions of instructions, the objects that a human said were not.
    """

    spoken: Sequence[SpokenInstruction]
    fixations: Sequence[FixationObservation]
    objects: Sequence[ObjectInstance] = ()
    heading_rad: float = 0.0
    table_height: float | None = None
    meant: Mapping[int, str] = field(default_factory=dict)
    not_meant: Mapping[int, frozenset[str]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rests:
    """All resting places of all instances: the environment state E as far as vision saw it.

    Attributes:
        thing: (R,) index of the instance.
        position: (R, 3) centre of its volume.
        cov: (R, 3, 3) of the centre.
        extent: (R,) mean horizontal size of the instance.
        height: (R,) vertical size of the instance.
        since_s: (R,) when it came to rest.
        left_s: (R,) when it was carried away; inf if it never was.
        next_rest: (R,) row of where it rests after that, or -1.
    """

    thing: IntArray
    position: FloatArray
    cov: FloatArray
    extent: FloatArray
    height: FloatArray
    since_s: FloatArray
    left_s: FloatArray
    next_rest: IntArray

    @property
    def count(self) -> int:
        """The number of resting places."""
        return len(self.thing)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Session:
    """What is observed, as arrays.

    Attributes:
        acts: the chain of elementary actions.
        sights: the looks in time order.
        rests: the resting places.
        things_count: number of instances.
        said_s: (I,) start of speech of each instruction, NaN where none is known or the sentence
            was begun by an earlier instruction.
        motion_seen: whether vision saw any instance move.
        table_z: height of the table.
        low: (2,) lower corner of the workspace, x and y.
        high: (2,) its upper corner.
        names: for each act, the row of its name; for each act, the rows of its landmarks' names.
        heading_rad: the wearer's heading about z.
        allowed: (A, O) whether a human left it open that the act is about the instance.
    """

    acts: tuple[Act, ...]
    sights: Sights
    rests: Rests
    things_count: int
    said_s: FloatArray
    motion_seen: bool
    table_z: float
    low: FloatArray
    high: FloatArray
    names: "Names"
    heading_rad: float
    allowed: BoolArray

    @property
    def area(self) -> float:
        """The workspace's area in m^2."""
        return float(np.prod(self.high - self.low))

    @property
    def unsaid_share(self) -> float:
        """The share of the movements that vision saw of which nothing was said."""
        within = (self.rests.left_s > 0) & (self.rests.left_s < self.span_s)
        moved = int((within & (self.rests.next_rest >= 0)).sum())
        said = sum(1 for act in self.acts if act.kind is Kind.PUT)
        return max(moved - said, 0) / max(moved, 1)

    def gap_looks(self, config: GlideConfig) -> FloatArray:
        """Return (4,) background looks to expect: before, between, in hand, after.

        The looks of movements that nobody spoke of are background too.
        """
        gaps = sum(1 for act in self.acts if not act.in_hand) + 1
        unsaid = self.unsaid_share * self.sights.count / gaps
        gap, in_hand = config.gap_fixations, config.gap_in_hand_fixations
        return np.array([2 * gap + unsaid, gap + unsaid, in_hand, 2 * gap + unsaid])

    @property
    def span_s(self) -> float:
        """The time from the first look to the end of the last."""
        return max(float(self.sights.end_s[-1]), 1.0) if self.sights.count else 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Names:
    """The phrases that name things; one row a phrase.

    Attributes:
        phrases: the words of each.
        of_act: for each act, the row of its thing's phrase.
        landmarks_of_act: for each act, the rows of its landmarks' phrases.
    """

    phrases: tuple[tuple[str, ...], ...]
    of_act: tuple[int, ...]
    landmarks_of_act: tuple[tuple[int, ...], ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Parameters:
    """What is learnt from the session, eq. 18 to 23.

    Attributes:
        theta: (A, O) how likely the phrase of each act's thing means each instance, by what the
            phrase meant elsewhere.
        landmark_theta: (A, O) the same for the phrases of its landmarks, their mean; 0 without any.
        narration_shift_s: start of speech minus start of action.
        narration_sigma_s: its spread.
        action_s: (3,) median duration for each kind of action.
        gap_fixations: expected background looks: before, between, in hand, after.
        gaze_offset_rad: (2,) offset that is still in the gaze, to the right and up.
        noise_scale: factor on the measurement's standard deviations.
        motion_shift_s: (3,) end of the action minus the event that vision saw, for each kind.
        popular_share: share of idle looks that rest on things.
    """

    theta: FloatArray
    landmark_theta: FloatArray
    narration_shift_s: float
    narration_sigma_s: float
    action_s: FloatArray
    gap_fixations: FloatArray
    gaze_offset_rad: FloatArray
    noise_scale: float
    motion_shift_s: FloatArray
    popular_share: float


def session_of(demonstration: Demonstration, config: GlideConfig) -> Session:
    """Bring a session's observations into arrays; fixations must be in time order."""
    spoken, fixations = demonstration.spoken, demonstration.fixations
    acts = tuple(elementary_actions(spoken))
    sights = sights_of(fixations, unit_m=config.scene_unit_m)
    zero_ns = fixations[0].start_ns if fixations else 0
    rests = _rests_of(demonstration.objects, zero_ns=zero_ns)
    low, high = _workspace(sights, rests, unit_m=config.scene_unit_m)
    height = demonstration.table_height
    return Session(
        acts=acts,
        sights=sights,
        rests=rests,
        things_count=len(demonstration.objects),
        said_s=_said_s(spoken, zero_ns=zero_ns),
        motion_seen=bool(np.isfinite(rests.left_s).any()),
        table_z=_table_height(sights, demonstration.objects) if height is None else height,
        low=low,
        high=high,
        names=_names_of(acts),
        heading_rad=demonstration.heading_rad,
        allowed=_allowed(acts, demonstration),
    )


def initial_parameters(session: Session, config: GlideConfig) -> Parameters:
    """Return what is assumed before learning: flat meanings, durations that fill the session."""
    share = 0.7 * session.span_s / max(len(session.acts), 1)
    action_s = float(np.sqrt(config.action_s * np.clip(share, 0.5, 8.0)))
    things = max(session.things_count, 1)
    return Parameters(
        theta=np.full((len(session.acts), things), 1.0 / things),
        landmark_theta=np.full((len(session.acts), things), 1.0 / things),
        narration_shift_s=0.0,
        narration_sigma_s=config.narration_sigma_s,
        action_s=np.full(3, action_s),
        gap_fixations=session.gap_looks(config),
        gaze_offset_rad=np.zeros(2),
        noise_scale=1.0,
        motion_shift_s=np.zeros(3),
        popular_share=config.popular_share,
    )


def present(session: Session, times_s: FloatArray, *, slack_s: float) -> BoolArray:
    """Return (T, R): whether each resting place is taken at each time, give or take the slack."""
    rests = session.rests
    t = times_s[:, None]
    return np.asarray((t >= rests.since_s - slack_s) & (t < rests.left_s + slack_s))


def _rests_of(objects: Sequence[ObjectInstance], *, zero_ns: int) -> Rests:
    thing, next_rest, left, since = [], [], [], []
    for k, each in enumerate(objects):
        for r, place in enumerate(each.track):
            is_last = r + 1 == len(each.track)
            thing.append(k)
            next_rest.append(-1 if is_last or place.left_ns is None else len(thing))
            since.append(-np.inf if r == 0 else (place.t_ns - zero_ns) / 1e9)
            left.append(np.inf if place.left_ns is None else (place.left_ns - zero_ns) / 1e9)
    places = [place for each in objects for place in each.track]
    sizes = [each.size_m for each in objects for _ in each.track]
    return Rests(
        thing=np.array(thing, dtype=np.int64),
        position=np.array([p.position_world for p in places], dtype=np.float64).reshape(-1, 3),
        cov=np.array([p.cov_world for p in places], dtype=np.float64).reshape(-1, 3, 3),
        extent=np.array([np.mean(s[:2]) for s in sizes], dtype=np.float64),
        height=np.array([s[2] for s in sizes], dtype=np.float64),
        since_s=np.array(since, dtype=np.float64),
        left_s=np.array(left, dtype=np.float64),
        next_rest=np.array(next_rest, dtype=np.int64),
    )


def _said_s(spoken: Sequence[SpokenInstruction], *, zero_ns: int) -> FloatArray:
    said = np.full(len(spoken), np.nan)
    before: int | None = None
    for i, each in enumerate(spoken):
        if each.said_start_ns is not None and each.said_start_ns != before:
            said[i] = (each.said_start_ns - zero_ns) / 1e9
        before = each.said_start_ns
    return said


def _workspace(sights: Sights, rests: Rests, *, unit_m: float) -> tuple[FloatArray, FloatArray]:
    points = np.concatenate([sights.point[sights.seen, :2], rests.position[:, :2]])
    if not len(points):
        return np.zeros(2), np.ones(2)
    low, high = np.quantile(points, [0.02, 0.98], axis=0)
    if rests.count:
        low = np.minimum(low, rests.position[:, :2].min(axis=0))
        high = np.maximum(high, rests.position[:, :2].max(axis=0))
    return low - _MARGIN_M * unit_m, high + _MARGIN_M * unit_m


def _table_height(sights: Sights, objects: Sequence[ObjectInstance]) -> float:
    if objects:
        bottoms = [o.track[0].position_world[2] - o.size_m[2] / 2 for o in objects]
        return float(np.median(bottoms))
    if sights.seen.any():
        return float(np.quantile(sights.point[sights.seen, 2], 0.2))
    return 0.0


def _names_of(acts: Sequence[Act]) -> Names:
    rows: dict[tuple[str, ...], int] = {}
    for act in acts:
        for phrase in (act.name, *act.landmarks):
            rows.setdefault(phrase, len(rows))
    return Names(
        phrases=tuple(rows),
        of_act=tuple(rows[act.name] for act in acts),
        landmarks_of_act=tuple(tuple(rows[w] for w in act.landmarks) for act in acts),
    )


def _allowed(acts: Sequence[Act], demonstration: Demonstration) -> BoolArray:
    """Say which instances a human's corrections leave, for whole runs on one thing."""
    ids = [each.object_id for each in demonstration.objects]
    allowed = np.ones((len(acts), len(ids)), dtype=np.bool_)
    first = 0
    for a, act in enumerate(acts):
        first = first if act.in_hand else a
        meant = demonstration.meant.get(act.instruction)
        ruled_out = demonstration.not_meant.get(act.instruction, frozenset())
        open_ones = [(meant in (None, i)) and i not in ruled_out for i in ids]
        allowed[first] &= np.array(open_ones, dtype=np.bool_)
    return allowed
