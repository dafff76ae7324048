"""Grounding as it happens: words, looks and objects come in, in any order and corrected."""

import dataclasses
from dataclasses import dataclass, field

from grounding.discourse import Utterance, understand
from grounding.glide.follow import Follower
from grounding.glide.model import Demonstration
from grounding.language.parser import Parser
from grounding.patches.view import View
from grounding.pipeline import GroundingConfig, SessionGrounding, ground_session
from grounding.plan import GroundedPlan
from grounding.types import FixationObservation, ObjectInstance


@dataclass(slots=True, kw_only=True, eq=False)
class LiveGrounding:
    """What a running session has said, looked at and shown so far.

    Attributes:
        parser: turns what is said into instructions.
        config: of all stages.
        name: of the session.
        scale: "metric" or "arbitrary".
        heading_rad: the wearer's heading about z.
    """

    parser: Parser
    config: GroundingConfig
    name: str
    scale: str = "arbitrary"
    heading_rad: float = 0.0
    _said: list[Utterance] = field(default_factory=list)
    _fixations: dict[int, FixationObservation] = field(default_factory=dict)
    _objects: dict[str, ObjectInstance] = field(default_factory=dict)
    _meant: dict[int, str] = field(default_factory=dict)
    _not_meant: dict[int, frozenset[str]] = field(default_factory=dict)
    _plan: GroundedPlan | None = None
    _follower: Follower = field(default_factory=Follower)

    @property
    def objects(self) -> tuple[ObjectInstance, ...]:
        """All objects seen so far."""
        return tuple(self._objects.values())

    def heard(self, utterance: Utterance) -> None:
        """Take in what was said; the same cue again changes nothing."""
        if utterance not in self._said:
            self._said.append(utterance)
            self._said.sort(key=lambda each: each.start_ns or 0)

    def looked(self, fixation: FixationObservation) -> None:
        """Take in a fixation, or its correction."""
        self._fixations[fixation.fixation_id] = fixation

    def saw(self, thing: ObjectInstance) -> None:
        """Take in an object, or what is known better of it now."""
        self._objects[thing.object_id] = thing

    def corrected(self, instruction: int, *, object_id: str, is_meant: bool) -> None:
        """Take in what a human said of an instruction's target: this one, or not this one.

        Plan, patches and symbols follow when the session is grounded next.
        """
        if is_meant:
            self._meant[instruction] = object_id
        else:
            before = self._not_meant.get(instruction, frozenset())
            self._not_meant[instruction] = before | {object_id}

    def ground(self, view: View | None, *, open_end: bool) -> SessionGrounding:
        """Ground all that was said so far; the revision grows where the plan has changed.

        Args:
            view: the camera that patches are cut from; None leaves patches out.
            open_end: the session goes on, so the last instructions may not have been done yet.
        """
        discourse = understand(self._said, self.parser)
        grounded = ground_session(
            Demonstration(
                spoken=discourse.spoken,
                fixations=list(self._fixations.values()),
                objects=list(self._objects.values()),
                heading_rad=self.heading_rad,
                meant=self._meant,
                not_meant=self._not_meant,
            ),
            self.config,
            name=self.name,
            scale=self.scale,
            unparsed=discourse.unparsed,
            view=view,
            follower=self._follower if open_end else None,
            before=self._plan,
        )
        self._plan = _revised(grounded.plan, self._plan)
        return dataclasses.replace(grounded, plan=self._plan)


def _revised(plan: GroundedPlan, before: GroundedPlan | None) -> GroundedPlan:
    if before is None:
        return plan
    same = dataclasses.replace(plan, revision=before.revision)
    if same.to_json() == before.to_json():
        return before
    return dataclasses.replace(plan, revision=before.revision + 1)
