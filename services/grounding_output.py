"""What the grounding service publishes, and its answers to queries for the latest of it."""

import json
import logging
from typing import Any

from gazemap.wire.streams import Stream
from grounding.plan import GroundedInstruction, GroundedPlan, Status
from grounding.symbols.document import to_json
from grounding.symbols.model import SymbolModel
from grounding.symbols.teach import Question
from services.bus.base import Bus
from services.health import Health
from services.latest import LatestMessages
from services.wire import grounding as wire

_log = logging.getLogger(__name__)


class GroundingOutput:
    """Publishes plans, the instructions that settle, questions and symbols."""

    def __init__(self, bus: Bus, health: Health) -> None:
        self._bus, self._health = bus, health
        self._latest = LatestMessages(bus, Stream.PLAN, Stream.SYMBOLS)
        self._sent: dict[int, dict[str, Any]] = {}
        self._asked: set[tuple[str, str]] = set()
        self.revision = 0

    def restart(self) -> None:
        """Begin anew with another session."""
        self._sent, self.revision = {}, 0
        self._asked = set()

    def say_plan(self, plan: GroundedPlan) -> None:
        """Publish a plan with a new revision, and its instructions that changed."""
        if plan.revision == self.revision:
            return
        self.revision = plan.revision
        message = wire.PlanMessage(
            t_ns=self._health.t_ns, revision=plan.revision, plan=plan.to_json()
        )
        self._latest.publish(Stream.PLAN, wire.encode_plan(message))
        for each in plan.instructions:
            self._say_instruction(each)

    def _say_instruction(self, each: GroundedInstruction) -> None:
        """Publish an instruction that settles, or is corrected after it had."""
        document, index = each.to_json(), each.spoken.index
        is_open = each.status is Status.UNGROUNDED and index not in self._sent
        if is_open or self._sent.get(index) == document:
            return
        self._sent[index] = document
        message = wire.InstructionMessage(
            t_ns=self._health.t_ns, revision=self.revision, index=index, instruction=document
        )
        self._bus.publish(Stream.INSTRUCTION, wire.encode_instruction(message))
        if each.question is not None:
            self._ask(each, each.question)

    def _ask(self, each: GroundedInstruction, text: str) -> None:
        question = wire.Question(
            t_ns=self._health.t_ns,
            instruction_index=each.spoken.index,
            text=text,
            words=each.spoken.instruction.target,
            object_id=each.target.object_id if each.target else None,
        )
        self._publish(question)

    def ask_about(self, object_id: str, asked: Question) -> None:
        """Ask once what a thing is that no word of a group explains."""
        if (object_id, asked.group) in self._asked:
            return
        self._asked.add((object_id, asked.group))
        self._publish(
            wire.Question(
                t_ns=self._health.t_ns,
                instruction_index=wire.NO_INSTRUCTION,
                text=asked.text,
                words=asked.words,
                object_id=object_id,
            )
        )

    def _publish(self, question: wire.Question) -> None:
        about = "" if question.object_id is None else f" ({question.object_id})"
        _log.warning("question: %s%s", question.text, about)
        self._bus.publish(Stream.QUESTION, wire.encode_question(question))

    def say_symbols(self, model: SymbolModel) -> None:
        """Publish what every word means so far."""
        message = wire.SymbolsMessage(t_ns=self._health.t_ns, symbols=json.loads(to_json(model)))
        self._latest.publish(Stream.SYMBOLS, wire.encode_symbols(message))
