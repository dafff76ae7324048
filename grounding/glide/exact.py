"""Exact inference: forward-backward and Viterbi over all partitions, eq. 13 to 17."""

from dataclasses import dataclass

import numpy as np

from grounding.glide.bounds import pruned
from grounding.glide.kernels import Marks, backward, forward, no_marks, posterior
from grounding.glide.model import Session
from grounding.glide.tables import Model
from grounding.glide.viterbi import viterbi
from grounding.types import FloatArray, IntArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Beliefs:
    """The posterior of everything that is not observed.

    Attributes:
        log_evidence: log likelihood of the looks over that of pure background.
        things: (A, H) of what each action's thing is; the last column is "elsewhere".
        skipped: (A,) that the action was not done.
        begins: (A, T + 1) of the first look of the action.
        ends: (A, T + 1) of its end.
        member: (A, T) that the look belongs to the action and to its target, location or landmark.
        inside: (A,) expected looks in the action's segment, whatever they are at.
        on_place: (T, R) that the look is at the resting place as target or location of an action.
        on_landmark: (A, R) expected looks at each place as the action's landmark.
        unseen_position: for each action (G,) on its grid; the sum is that of being unseen.
        best_first: (A,) first look of the best partition.
        best_past: (A,) one past its last look; the same where the action was skipped.
    """

    log_evidence: float
    things: FloatArray
    skipped: FloatArray
    begins: FloatArray
    ends: FloatArray
    member: FloatArray
    inside: FloatArray
    on_place: FloatArray
    on_landmark: FloatArray
    unseen_position: tuple[FloatArray, ...]
    best_first: IntArray
    best_past: IntArray


def infer(session: Session, model: Model) -> Beliefs:
    """Return the exact posterior under the model.

    Args:
        session: at least one act and one look.
        model: its factors.

    Returns:
        The beliefs, and the single best partition.
    """
    tables, marks = pruned(model.tables), no_marks(model.tables)
    log_evidence = posterior(tables, forward(tables), backward(tables), marks)
    first, past, _ = viterbi(tables)
    return read_looks(
        session,
        model,
        Occupancy(log_evidence=log_evidence, marks=marks, best_first=first, best_past=past),
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Occupancy:
    """The posterior of the partition alone, however it was come by."""

    log_evidence: float
    marks: Marks
    best_first: IntArray
    best_past: IntArray


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Looks:
    """What each look was at, summed up over the actions; see `Beliefs`."""

    member: FloatArray
    on_place: FloatArray
    on_landmark: FloatArray


def read_looks(session: Session, model: Model, occupancy: Occupancy) -> Beliefs:
    """Say for each look what it was at: the parts of eq. 2 under the partition, eq. 17."""
    acts, count, places = len(session.acts), session.sights.count, session.rests.count
    marks = occupancy.marks
    looks = _Looks(
        member=np.zeros((acts, count)),
        on_place=np.zeros((count, places)),
        on_landmark=np.zeros((acts, places)),
    )
    position = [np.zeros(len(model.unseen.nodes(a))) for a in range(acts)]
    for a in range(acts):
        _read_places(session, model, marks.inside[a, ..., :count], a=a, looks=looks)
        if marks.grids[a].any():
            position[a], on_grid = model.unseen.read(a, marks.grids[a])
            looks.member[a] += on_grid
    return Beliefs(
        log_evidence=occupancy.log_evidence,
        things=marks.things,
        skipped=marks.skipped,
        begins=marks.begins,
        ends=marks.ends,
        member=np.minimum(looks.member, 1.0),
        inside=marks.inside[..., :count].sum(axis=(1, 2, 3)),
        on_place=looks.on_place,
        on_landmark=looks.on_landmark,
        unseen_position=tuple(position),
        best_first=occupancy.best_first,
        best_past=occupancy.best_past,
    )


def _read_places(
    session: Session, model: Model, inside: FloatArray, *, a: int, looks: _Looks
) -> None:
    """Share the looks of one action, (H, 3, T), among target, location and landmark."""
    goal, ratio = session.rests.next_rest, model.ratio
    for h in np.flatnonzero(inside[:-1].max(axis=(1, 2), initial=0.0) > 1e-6):
        if model.tables.grid_row[a, h] >= 0:
            continue
        at_goal = ratio[:, goal[h]] if goal[h] >= 0 else np.zeros(len(ratio))
        for third in range(3):
            w = model.weights[a, third]
            target, location = w[0] * ratio[:, h], w[1] * at_goal
            landmark = w[2] * model.landmark[a, h]
            here = inside[h, third] / (target + location + landmark + 1.0 - w.sum())
            looks.member[a] += here * (target + location + landmark)
            looks.on_place[:, h] += here * target
            if goal[h] >= 0:
                looks.on_place[:, goal[h]] += here * location
            at_landmark = model.landmark_share[a, h] * ratio * model.present
            looks.on_landmark[a] += w[2] * (here @ at_landmark)
