"""From beliefs in arrays to what each instruction and each look is about."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grounding.glide.actions import Kind
from grounding.glide.config import GlideConfig
from grounding.glide.exact import Beliefs
from grounding.glide.model import Session
from grounding.glide.tables import Model
from grounding.types import FixationObservation, FloatArray, ObjectInstance, SpokenInstruction

_MODE_RADIUS_M = 0.05
_UNSEEN_SIGMA_M = (0.005, 0.005, 0.01)  # of a position on the grid, beside its spread


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Spot:
    """A position with its spread.

    Attributes:
        position_world: (3,) metres.
        cov_world: (3, 3) m^2.
        probability: share of the belief that this spot holds.
    """

    position_world: FloatArray
    cov_world: FloatArray
    probability: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Candidate:
    """What an instruction's target may be.

    Attributes:
        object_id: the instance, or None for a thing that vision did not see.
        spot: where it stood when the instruction began.
        quat_xyzw: (4,) its orientation, or None.
        size_m: (3,) its extents, or None.
        probability: the posterior.
    """

    object_id: str | None
    spot: Spot
    quat_xyzw: FloatArray | None
    size_m: FloatArray | None

    @property
    def probability(self) -> float:
        """The posterior of this candidate."""
        return self.spot.probability


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class InstructionBelief:
    """What is believed of one instruction.

    Attributes:
        index: of the spoken instruction.
        start_ns: of its first action, or None where it seems not to have been done.
        end_ns: of its last action, or None with start_ns.
        done: probability that it was done at all.
        looks: expected number of looks at its target, location or landmark.
        candidates: for its target, most likely first.
        moves: whether its action brings the target to another place.
        location: where the thing was put; None where that is not known or it stays.
        landmark: the one thing that its location most likely refers to, or None.
        over: probability that it was done and is over; below 1 only while a session goes on.
        fixation_ids: the looks that belong to it.
    """

    index: int
    start_ns: int | None
    end_ns: int | None
    done: float
    looks: float
    candidates: tuple[Candidate, ...]
    moves: bool
    location: Spot | None
    landmark: Candidate | None
    over: float
    fixation_ids: tuple[int, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class LookBelief:
    """Which instruction a fixation belongs to.

    Attributes:
        fixation_id: of the fixation.
        instruction: index of the spoken instruction, or None for none.
        probability: of what `instruction` says.
    """

    fixation_id: int
    instruction: int | None
    probability: float


def read_labels(
    session: Session,
    beliefs: Beliefs,
    spoken: Sequence[SpokenInstruction],
    fixations: Sequence[FixationObservation],
) -> tuple[LookBelief, ...]:
    """Label each look by the instruction it most likely serves, or by none, eq. 17."""
    member = np.zeros((len(spoken), len(fixations)))
    for a, act in enumerate(session.acts):
        member[act.instruction] += beliefs.member[a]
    labels = []
    for t, fixation in enumerate(fixations):
        idle = 1.0 - float(member[:, t].sum())
        i = int(member[:, t].argmax()) if len(spoken) else -1
        mine = i >= 0 and member[:, t].sum() > 0.5
        labels.append(
            LookBelief(
                fixation_id=fixation.fixation_id,
                instruction=spoken[i].index if mine else None,
                probability=float(np.clip(member[i, t] if mine else idle, 0.0, 1.0)),
            )
        )
    return tuple(labels)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Reader:
    """Everything that is needed to read one instruction."""

    session: Session
    model: Model
    beliefs: Beliefs
    objects: Sequence[ObjectInstance]
    fixations: Sequence[FixationObservation]
    config: GlideConfig

    def instruction(
        self, spoken: SpokenInstruction, position: int, labels: Sequence[LookBelief]
    ) -> InstructionBelief:
        """Return what is believed of the instruction at a position of the sequence."""
        acts = [a for a, act in enumerate(self.session.acts) if act.instruction == position]
        first, last = acts[0], acts[-1]
        start_ns, end_ns = self._bounds(first, last)
        return InstructionBelief(
            index=spoken.index,
            start_ns=start_ns,
            end_ns=end_ns,
            done=float(np.clip(1.0 - self.beliefs.skipped[acts].max(), 0.0, 1.0)),
            looks=float(self.beliefs.member[acts].sum()),
            candidates=self._candidates(first),
            moves=self.session.acts[last].kind is Kind.PUT,
            location=self._location(last),
            landmark=self._landmark(last),
            over=float(self.beliefs.ends[last, :-1].sum()),
            fixation_ids=tuple(x.fixation_id for x in labels if x.instruction == spoken.index),
        )

    def _bounds(self, first: int, last: int) -> tuple[int | None, int | None]:
        s, e = int(self.beliefs.best_first[first]), int(self.beliefs.best_past[last])
        if e <= s:
            return None, None
        return self.fixations[s].start_ns, self.fixations[e - 1].end_ns

    def _candidates(self, a: int) -> tuple[Candidate, ...]:
        rests, things = self.session.rests, self.beliefs.things[a]
        places = [(k, place) for k, each in enumerate(self.objects) for place in each.track]
        total = max(float(things.sum()), 1e-12)
        found = [
            Candidate(
                object_id=self.objects[k].object_id,
                spot=Spot(
                    position_world=place.position_world,
                    cov_world=place.cov_world,
                    probability=float(things[r] / total),
                ),
                quat_xyzw=place.quat_xyzw,
                size_m=self.objects[k].size_m,
            )
            for r, (k, place) in enumerate(places)
            if r < rests.count and things[r] / total > 1e-3
        ]
        unseen = float(things[-1] / total)
        source = self._taking(a)
        spot = self._unseen(source) if source is not None and unseen > 1e-3 else None
        if spot is not None:
            at = Spot(
                position_world=spot.position_world,
                cov_world=spot.cov_world,
                probability=unseen * spot.probability,
            )
            found.append(Candidate(object_id=None, spot=at, quat_xyzw=None, size_m=None))
        return tuple(sorted(found, key=lambda c: -c.probability))

    def _taking(self, a: int) -> int | None:
        """Return the action in which the thing of action a was looked for."""
        while a > 0 and self.session.acts[a].in_hand:
            a -= 1
        return a if self.session.acts[a].kind is not Kind.PUT else None

    def _location(self, a: int) -> Spot | None:
        if self.session.acts[a].kind is not Kind.PUT:
            return None
        rests, things = self.session.rests, self.beliefs.things[a]
        total = max(float(things.sum()), 1e-12)
        mass = np.zeros(rests.count)
        for h, goal in enumerate(rests.next_rest):
            if goal >= 0:
                mass[goal] += things[h] / total
        unseen = self._unseen(a)
        best = int(mass.argmax()) if rests.count else -1
        left = 1.0 - float(mass.sum())
        if best >= 0 and mass[best] >= left:
            return Spot(
                position_world=rests.position[best],
                cov_world=rests.cov[best],
                probability=float(mass[best]),
            )
        if unseen is None:
            return None
        return Spot(
            position_world=unseen.position_world,
            cov_world=unseen.cov_world,
            probability=left * unseen.probability,
        )

    def _landmark(self, a: int) -> Candidate | None:
        """Return the likeliest landmark, as it stood when the action ended, eq. 4."""
        rests, things = self.session.rests, self.beliefs.things[a]
        past = int(self.beliefs.best_past[a])
        if not rests.count or len(self.session.acts[a].landmarks) != 1 or past == 0:
            return None
        share = self.model.landmark_share[a, int(things.argmax())] * self.model.present[past - 1]
        best = int(share.argmax())
        if share[best] <= 0:
            return None
        thing = self.objects[int(rests.thing[best])]
        first = int(np.flatnonzero(rests.thing == rests.thing[best])[0])
        place = thing.track[best - first]
        return Candidate(
            object_id=thing.object_id,
            spot=Spot(
                position_world=place.position_world,
                cov_world=place.cov_world,
                probability=float(share[best] / share.sum()),
            ),
            quat_xyzw=place.quat_xyzw,
            size_m=thing.size_m,
        )

    def _unseen(self, a: int) -> Spot | None:
        """Summarise the grid's belief about its mode; the share outside it counts as doubt."""
        belief = self.beliefs.unseen_position[a]
        total = float(belief.sum())
        if total < 1e-9:
            return None
        unit = self.config.scene_unit_m
        nodes = self.model.unseen.nodes(a)
        near = np.linalg.norm(nodes - nodes[belief.argmax()], axis=1) < _MODE_RADIUS_M * unit
        w = belief[near] / belief[near].sum()
        mean = w @ nodes[near]
        off = nodes[near] - mean
        cov = np.einsum("g,ga,gb->ab", w, off, off)
        cov += np.diag(np.square(_UNSEEN_SIGMA_M)) * unit**2
        return Spot(
            position_world=mean, cov_world=cov, probability=float(belief[near].sum() / total)
        )
