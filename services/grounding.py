"""The grounding service: takes words, looks and objects, says what each instruction means."""

import json
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final

from gazemap.errors import InputError
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Overhead, Pose, World
from gazemap.types.status import ServiceStatus
from gazemap.wire import images, mapping, rig
from gazemap.wire.streams import Stream
from grounding.discourse import Utterance
from grounding.language.parser import Parser, parser_for
from grounding.live import LiveGrounding
from grounding.pipeline import GroundingConfig, SessionGrounding
from grounding.plan import Status
from grounding.symbols.document import to_json
from services.answers import answer_parse
from services.bus.base import Bus, Inbox, Message
from services.bus.zenoh import ZenohConfig
from services.health import FINISHED, Health
from services.latest import LatestMessages
from services.translate import instance, observation
from services.views import BufferedView, StandingCamera
from services.wire import grounding as wire

NAME: Final = "grounding"
_WAIT_S: Final = 0.2


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundingServiceConfig:
    """How the service is started.

    Attributes:
        bus: how to reach the router.
        grounding: the settings of each stage.
        period_s: how often the plan is looked at again while things come in.
        image_count: how many overhead images are kept to cut patches from.
    """

    bus: ZenohConfig = field(default_factory=ZenohConfig)
    grounding: GroundingConfig = field(default_factory=GroundingConfig)
    period_s: float = 1.0
    image_count: int = 3000


class GroundingService:
    """Feeds a live grounding from the bus and publishes what it says."""

    def __init__(self, bus: Bus, config: GroundingServiceConfig) -> None:
        """Subscribe to the rig and to mapping, and answer questions."""
        self._bus, self._config = bus, config
        self._health = Health(bus, service=NAME, stream=Stream.GROUNDING_STATUS)
        self._parser: Parser = parser_for(config.grounding.language)
        self._live = self._begin("live", heading_rad=0.0)
        self._camera: Camera | None = None
        self._T_world_overhead: Pose[World, Overhead] | None = None
        self._images = BufferedView(limit=config.image_count)
        self._is_stale = False
        self._last_s = 0.0
        self._sent: dict[int, dict[str, Any]] = {}
        self._revision = 0
        self._takers: dict[Stream, Callable[[bytes], None]] = {
            Stream.SESSION: self._take_session,
            Stream.NARRATION: self._take_narration,
            Stream.FIXATION: self._take_fixation,
            Stream.OBJECT: self._take_object,
            Stream.OVERHEAD_CALIBRATION: self._take_calibration,
            Stream.OVERHEAD_POSE: self._take_overhead_pose,
            Stream.OVERHEAD_IMAGE: self._take_image,
            Stream.MAPPING_STATUS: self._take_mapping_status,
        }
        self.inbox = Inbox()
        for stream in self._takers:
            bus.subscribe(stream, self.inbox)
        self._latest = LatestMessages(bus, Stream.PLAN, Stream.SYMBOLS)
        bus.answer(Stream.PARSE, lambda asked: answer_parse(asked, self._parser))
        bus.announce(NAME)

    def _begin(self, name: str, *, heading_rad: float) -> LiveGrounding:
        return LiveGrounding(
            parser=self._parser,
            config=self._config.grounding,
            name=name,
            heading_rad=heading_rad,
        )

    def run(self, stop: threading.Event) -> None:
        """Serve until asked to stop."""
        while not stop.is_set():
            message = self.inbox.get(timeout_s=_WAIT_S)
            if message is not None:
                self.take(message)
            if self._is_stale and time.monotonic() - self._last_s >= self._config.period_s:
                self.update(is_finished=False)
            self._health.beat(lambda: {"revision": float(self._revision)})

    def take(self, message: Message) -> None:
        """Take one message; one that cannot be used is named in the status and dropped."""
        try:
            self._takers[message.stream](message.payload)
        except InputError as error:
            self._health.complain(str(error))

    def _take_session(self, payload: bytes) -> None:
        info = rig.decode_session(payload)
        self._live = self._begin(info.name, heading_rad=info.wearer_heading_rad)
        self._images.clear()
        self._sent, self._revision = {}, 0
        self._health.restart(info.name)

    def _take_narration(self, payload: bytes) -> None:
        cue = rig.decode_cue(payload)
        self._live.heard(Utterance(text=cue.text, start_ns=cue.start_ns, end_ns=cue.end_ns))
        self._is_stale = True

    def _take_fixation(self, payload: bytes) -> None:
        fixation = mapping.decode_fixation(payload)
        self._live.looked(observation(fixation))
        self._health.reached(fixation.fixation.end_ns)
        self._is_stale = True

    def _take_object(self, payload: bytes) -> None:
        self._live.saw(instance(mapping.decode_object(payload)))
        self._is_stale = True

    def _take_calibration(self, payload: bytes) -> None:
        self._camera = images.decode_calibration(payload, stream=Stream.OVERHEAD_CALIBRATION)
        self._place_camera()

    def _take_overhead_pose(self, payload: bytes) -> None:
        self._T_world_overhead = mapping.decode_transform(payload, stream=Stream.OVERHEAD_POSE)
        self._place_camera()

    def _place_camera(self) -> None:
        if self._camera is not None and self._T_world_overhead is not None:
            self._images.camera = StandingCamera(
                camera=self._camera, T_world_cam=self._T_world_overhead
            )

    def _take_image(self, payload: bytes) -> None:
        self._images.add(payload)

    def _take_mapping_status(self, payload: bytes) -> None:
        status: ServiceStatus = mapping.decode_status(payload)
        if status.figures.get(FINISHED):
            self.update(is_finished=True)
            self._health.finish(lambda: {"revision": float(self._revision)})

    def update(self, *, is_finished: bool) -> None:
        """Ground all there is; publish what has changed."""
        # Patches cost more than all the rest: live they are cut when a session is at its end.
        view = self._images if is_finished and self._images.camera is not None else None
        grounded = self._live.ground(view, open_end=not is_finished)
        self._last_s, self._is_stale = time.monotonic(), False
        if grounded.plan.revision != self._revision:
            self._publish_plan(grounded)
        if is_finished:
            self._publish_symbols(grounded)

    def _publish_plan(self, grounded: SessionGrounding) -> None:
        plan = grounded.plan
        self._revision, t_ns = plan.revision, self._health.t_ns
        document = plan.to_json()
        message = wire.PlanMessage(t_ns=t_ns, revision=plan.revision, plan=document)
        self._latest.publish(Stream.PLAN, wire.encode_plan(message))
        for each in plan.instructions:
            settled, index = each.to_json(), each.spoken.index
            is_new = each.status is not Status.UNGROUNDED or index in self._sent
            if is_new and self._sent.get(index) != settled:
                self._sent[index] = settled
                self._bus.publish(
                    Stream.INSTRUCTION,
                    wire.encode_instruction(
                        wire.InstructionMessage(
                            t_ns=t_ns, revision=plan.revision, index=index, instruction=settled
                        )
                    ),
                )
                self._ask(settled)

    def _ask(self, instruction: dict[str, Any]) -> None:
        if instruction["question"] is None:
            return
        question = wire.Question(
            t_ns=self._health.t_ns,
            instruction_index=instruction["index"],
            text=instruction["question"],
            words=tuple(instruction["target"]),
            object_id=instruction["object"],
        )
        self._bus.publish(Stream.QUESTION, wire.encode_question(question))

    def _publish_symbols(self, grounded: SessionGrounding) -> None:
        document = json.loads(to_json(grounded.symbols))
        message = wire.SymbolsMessage(t_ns=self._health.t_ns, symbols=document)
        self._latest.publish(Stream.SYMBOLS, wire.encode_symbols(message))
