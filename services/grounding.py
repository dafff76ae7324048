"""The grounding service: takes words, looks and objects, says what each instruction means."""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Final

from gazemap.errors import InputError
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Overhead, Pose, World
from gazemap.types.status import ServiceStatus
from gazemap.types.tracking import Scale
from gazemap.wire import images, mapping, rig
from gazemap.wire.streams import Stream
from grounding.discourse import Utterance
from grounding.language.parser import Parser, parser_for
from grounding.live import LiveGrounding
from grounding.patches.view import View
from grounding.pipeline import GroundingConfig, SessionGrounding
from grounding.symbols.learn import fit_symbols
from grounding.symbols.teach import WhichGroup, teach
from services.answers import answer_classify, answer_parse, ground_now
from services.bus.base import Bus, Inbox, Message
from services.bus.zenoh import ZenohConfig
from services.grounding_output import GroundingOutput
from services.health import FINISHED, IS_METRIC, SENT, Health
from services.lessons import TargetLesson, VerbLesson, WordLesson, lesson_of
from services.present import is_covered, look_at, present_scene, strange_things
from services.translate import instance, observation
from services.views import BufferedView, StandingCamera
from services.wire.queries import (
    decode_ground_request,
    decode_teach_request,
    encode_ground_answer,
    encode_teach_answer,
)

NAME: Final = "grounding"
_WAIT_S: Final = 0.2
_STRAGGLERS_S: Final = 3.0


@dataclass(frozen=True, slots=True, kw_only=True)
class End:
    """What mapping said at the end of a session: how much it sent, and when it said so."""

    sent_count: int
    told_s: float


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
        self._output = GroundingOutput(bus, self._health)
        self._taught_verbs: dict[str, str] = {}
        self._parser: Parser = parser_for(config.grounding.language)
        self._live = self._begin("live", heading_rad=0.0)
        self._camera: Camera | None = None
        self._T_world_overhead: Pose[World, Overhead] | None = None
        self._images = BufferedView(limit=config.image_count)
        # Queries come on threads of their own.
        self._lock = threading.RLock()
        self._grounded: SessionGrounding | None = None
        self._model = fit_symbols((), config.grounding.symbols)
        self._is_stale, self._is_over = False, False
        self._end: End | None = None
        self._got_count = 0
        self._last_s = 0.0
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
        for stream, handler in (
            (Stream.PARSE, lambda asked: answer_parse(asked, self._parser)),
            (Stream.CLASSIFY, lambda asked: answer_classify(asked, self._model)),
            (Stream.GROUND, self._answer_ground),
            (Stream.TEACH, self._answer_teach),
        ):
            bus.answer(stream, handler)
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
            self._finish_or_say_why()
            if self._is_stale and time.monotonic() - self._last_s >= self._config.period_s:
                self._update_or_say_why()
            self._health.beat(self._figures)

    def _finish_or_say_why(self) -> None:
        try:
            self._finish_if_all_is_there()
        except Exception as error:  # noqa: BLE001  a service's boundary
            self._health.fail(error, what=Stream.PLAN)

    def _update_or_say_why(self) -> None:
        self._last_s = time.monotonic()
        try:
            self.update(is_finished=False)
        except Exception as error:  # noqa: BLE001  a service's boundary
            self._health.fail(error, what=Stream.PLAN)

    def _figures(self) -> dict[str, float]:
        return {"revision": float(self._output.revision)}

    def take(self, message: Message) -> None:
        """Take one message; one that cannot be used is named in the status and dropped."""
        try:
            with self._lock:
                self._takers[message.stream](message.payload)
        except InputError as error:
            self._health.complain(str(error))
        except Exception as error:  # noqa: BLE001  a service's boundary
            self._health.fail(error, what=message.stream)

    def _take_session(self, payload: bytes) -> None:
        info = rig.decode_session(payload)
        self._live = self._begin(info.name, heading_rad=info.wearer_heading_rad)
        self._images.clear()
        self._is_over, self._end, self._got_count = False, None, 0
        self._output.restart()
        self._health.restart(info.name)

    def _take_narration(self, payload: bytes) -> None:
        cue = rig.decode_cue(payload)
        self._live.heard(Utterance(text=cue.text, start_ns=cue.start_ns, end_ns=cue.end_ns))
        self._is_stale = True

    def _take_fixation(self, payload: bytes) -> None:
        fixation = mapping.decode_fixation(payload)
        self._live.looked(observation(fixation))
        self._got_count += 1
        self._health.reached(fixation.fixation.end_ns)
        self._is_stale = True

    def _take_object(self, payload: bytes) -> None:
        self._live.saw(instance(mapping.decode_object(payload)))
        self._got_count += 1
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
        status: ServiceStatus = mapping.decode_status(payload, stream=Stream.MAPPING_STATUS)
        if IS_METRIC in status.figures:
            self._live.scale = (
                Scale.METRIC if status.figures[IS_METRIC] else Scale.ARBITRARY
            ).value
        if status.figures.get(FINISHED):
            self._end = End(sent_count=int(status.figures.get(SENT, 0)), told_s=time.monotonic())
            self._finish_if_all_is_there()

    def _finish_if_all_is_there(self) -> None:
        """End the session once all that mapping sent has arrived: streams overtake one another."""
        if self._end is None:
            return
        is_late = time.monotonic() - self._end.told_s > _STRAGGLERS_S
        if self._got_count >= self._end.sent_count or is_late:
            self._end = None
            self.update(is_finished=True)
            self._health.finish(self._figures)

    def update(self, *, is_finished: bool) -> None:
        """Ground all there is; publish what has changed."""
        # Patches cost more than all the rest: live they are cut when a session is at its end.
        self._is_over = self._is_over or is_finished
        view = self._view() if self._is_over else None
        with self._lock:
            grounded = self._live.ground(view, open_end=not self._is_over)
        self._grounded = grounded
        self._last_s, self._is_stale = time.monotonic(), False
        self._output.say_plan(grounded.plan)
        if is_finished:
            self._model = grounded.symbols
            self._say_symbols()

    def _say_symbols(self) -> None:
        """Publish what words mean, and ask about the things on the table that none explains."""
        self._output.say_symbols(self._model)
        for object_id, question in strange_things(
            self._live.objects, self._model, view=self._view()
        ):
            self._output.ask_about(object_id, question)

    def _view(self) -> View | None:
        return self._images if self._images.camera is not None else None

    def _answer_ground(self, asked: bytes) -> bytes:
        """Answer `ground`: sentences in the present scene; none: what was heard, once more."""
        sentences = decode_ground_request(asked).sentences
        with self._lock:
            if not sentences:
                self.update(is_finished=False)
                plan = self._grounded.plan.to_json() if self._grounded else {}
                return encode_ground_answer(plan)
            scene = present_scene(
                self._grounded,
                self._live.objects,
                self._model,
                view=self._view(),
                heading_rad=self._live.heading_rad,
            )
            document = ground_now(
                sentences,
                self._parser,
                scene,
                session=self._live.name,
                scale=self._live.scale,
            )
        return encode_ground_answer(document)

    def _answer_teach(self, asked: bytes) -> bytes:
        """Answer `teach`: take a lesson over and say what came of it."""
        lesson = lesson_of(decode_teach_request(asked))
        with self._lock:
            match lesson:
                case VerbLesson():
                    self._learn_verb(lesson)
                case TargetLesson():
                    self._check(lesson)
                    self._live.corrected(
                        lesson.instruction, object_id=lesson.object_id, is_meant=lesson.is_meant
                    )
                    self.update(is_finished=False)
                case WordLesson():
                    self._learn_words(lesson)
        return encode_teach_answer({"learnt": True, "revision": self._output.revision})

    def _check(self, lesson: TargetLesson) -> None:
        count = 0 if self._grounded is None else len(self._grounded.plan.instructions)
        ids = sorted(each.object_id for each in self._live.objects)
        if not 0 <= lesson.instruction < count:
            todo = f"name one of the {count} that were heard"
            what = f"there is no instruction {lesson.instruction}"
            raise InputError(what, where=Stream.TEACH, todo=todo)
        if lesson.object_id not in ids:
            todo = f"name one of: {', '.join(ids)}"
            raise InputError(f"no object {lesson.object_id!r}", where=Stream.TEACH, todo=todo)

    def _learn_verb(self, lesson: VerbLesson) -> None:
        language = self._config.grounding.language
        self._taught_verbs[lesson.verb] = lesson.like
        verbs = {**language.verbs, **self._taught_verbs}
        self._parser = self._live.parser = parser_for(replace(language, verbs=verbs))
        self._is_stale = True

    def _learn_words(self, lesson: WordLesson) -> None:
        thing = next((o for o in self._live.objects if o.object_id == lesson.object_id), None)
        features = None
        if thing is not None and not is_covered(thing, self._live.objects):
            features = look_at(thing, self._view())
        if features is None:
            todo = "name an object that the overhead camera sees now"
            raise InputError(f"{lesson.object_id!r} is not seen", where=Stream.TEACH, todo=todo)
        for word in lesson.words:
            taught = teach(self._model, word, [features], group=lesson.group)
            if isinstance(taught, WhichGroup):
                todo = f"add group: one of {', '.join(taught.groups)}"
                raise InputError(f"what does {word!r} describe?", where=Stream.TEACH, todo=todo)
            self._model = taught.model
        self._say_symbols()
