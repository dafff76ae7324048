"""The mapping service: takes a rig's streams, says where things are and what was looked at."""

import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np

from gazemap.calibration import load_rig
from gazemap.errors import GazemapError, InputError
from gazemap.geometry.camera import Camera
from gazemap.live import LiveMapping, LiveMappingConfig, LiveRig, News, warm_up
from gazemap.session.gaze_camera import GazeCamera, gaze_camera_in
from gazemap.types.tracking import Scale
from gazemap.wire import images, rig
from gazemap.wire.streams import Stream
from services.bus.base import Bus, Inbox, Message
from services.bus.zenoh import ZenohConfig
from services.gate import ImageGate
from services.health import IS_METRIC, Health
from services.introduction import INTRODUCTION, Introduction
from services.mapping_output import MappingOutput
from services.replayer import RECORDING_END

NAME: Final = "mapping"
_WAIT_S: Final = 0.2
# A rig says how it is built when it begins; what is not said by then it does not have.
_INTRODUCTION_S: Final = 1.0
_EARLY_COUNT: Final = 2000
_GAZE_LIMIT_NS: Final = 60_000_000_000
_NEEDS_MAPPING: Final = frozenset(
    {
        Stream.HEAD_IMAGE,
        Stream.OVERHEAD_IMAGE,
        Stream.GAZE,
        Stream.DEVICE_FIXATION,
        Stream.EVENT,
    }
)


@dataclass(frozen=True, slots=True, kw_only=True)
class MappingServiceConfig:
    """How the service is started.

    Attributes:
        bus: how to reach the router.
        calibration: a folder of calib/: its tags and read-out time, where the rig sends none.
        live: the settings of each stage.
        seed: of everything that is random.
    """

    bus: ZenohConfig = field(default_factory=ZenohConfig)
    calibration: Path | None = None
    live: LiveMappingConfig = field(default_factory=LiveMappingConfig)
    seed: int = 0


class MappingService:
    """Feeds a live mapping from the bus and publishes what it says."""

    def __init__(self, bus: Bus, config: MappingServiceConfig) -> None:
        """Subscribe to the rig.

        Raises:
            GazemapError: if the calibration cannot be used.
        """
        self._bus, self._config = bus, config
        self._health = Health(bus, service=NAME, stream=Stream.MAPPING_STATUS)
        self._output = MappingOutput(bus, self._health)
        self._mapping: LiveMapping | None = None
        known = None if config.calibration is None else load_rig(config.calibration)
        self._rig = Introduction(known)
        self._takers: dict[Stream, Callable[[bytes], None]] = {
            Stream.SESSION: self._take_session,
            **{stream: partial(self._take_introduction, stream) for stream in INTRODUCTION},
            Stream.HEAD_IMAGE: self._take_head_image,
            Stream.OVERHEAD_IMAGE: self._take_overhead_image,
            Stream.GAZE: self._take_gaze,
            Stream.DEVICE_FIXATION: self._take_device_fixation,
            Stream.EVENT: self._take_event,
            Stream.IMU: self._take_imu,
        }
        self._gates = {
            stream: ImageGate(stream) for stream in (Stream.HEAD_IMAGE, Stream.OVERHEAD_IMAGE)
        }
        self._has_device_fixations = False
        self._gaze_camera: GazeCamera | None = None
        self._early: deque[Message] = deque(maxlen=_EARLY_COUNT)
        self._introduced_s: float | None = None
        self._has_session = False
        warm_up()
        self.inbox = Inbox()
        for stream in self._takers:
            bus.subscribe(stream, self.inbox)
        bus.announce(NAME)

    def run(self, stop: threading.Event) -> None:
        """Serve until asked to stop."""
        try:
            while not stop.is_set():
                message = self.inbox.get(timeout_s=_WAIT_S)
                if message is not None:
                    self.take(message)
                self._begin_if_introduced()
                self._health.beat(self._figures)
        finally:
            self._forget()

    def take(self, message: Message) -> None:
        """Take one message; one that cannot be used is named in the status and dropped."""
        if self._mapping is None and message.stream in _NEEDS_MAPPING:
            self._early.append(message)
            return
        try:
            self._takers[message.stream](message.payload)
        except InputError as error:
            self._health.complain(str(error))
        except Exception as error:  # noqa: BLE001  a service's boundary
            # Nothing tells what state the map is in: the next images begin another.
            self._health.fail(error, what=message.stream)
            self._forget()

    def _forget(self) -> None:
        if self._mapping is not None:
            self._mapping.close()
        self._mapping = None
        for gate in self._gates.values():
            gate.reset()

    def _take_session(self, payload: bytes) -> None:
        info = rig.decode_session(payload)
        self._forget()
        self._rig.begin_session()
        self._has_session = True
        self._has_device_fixations = info.has_device_fixations
        self._health.restart(info.name)
        self._gaze_camera = None
        self._gaze_camera = gaze_camera_in(info.info)

    def _take_introduction(self, stream: Stream, payload: bytes) -> None:
        if self._rig.hear(stream, payload):
            # A map that was begun with another camera or other tags is of no use.
            self._forget()

    def _take_head_image(self, payload: bytes) -> None:
        frame = images.decode_image(payload, stream=Stream.HEAD_IMAGE)
        if self._mapping is None or self._rig.head is None:
            return
        if not self._gates[Stream.HEAD_IMAGE].check(frame, self._rig.head):
            # Poses of one map are in one time: the next image begins another.
            self._forget()
            return
        self._health.reached(frame.t_ns)
        self._publish(self._mapping.head_frame(frame))

    def _begin_if_introduced(self) -> None:
        """Start to map once the rig is known; what came before is then taken in its order.

        The streams of a rig do not arrive in the order in which they were sent.
        """
        if self._mapping is not None or not self._early:
            return
        now_s = time.monotonic()
        if self._introduced_s is None:
            self._introduced_s = now_s
        is_complete = self._rig.layout is not None and self._rig.overhead is not None
        if not (is_complete and self._has_session) and now_s - self._introduced_s < _INTRODUCTION_S:
            return
        if self._rig.head is None:
            self._health.complain("head/calibration: none yet; publish it, or name a calibration")
            return
        try:
            self._begin(self._rig.head)
        except GazemapError as error:
            self._health.complain(str(error))
        except Exception as error:  # noqa: BLE001  a service's boundary
            self._health.fail(error, what="the beginning of a map")

    def _begin(self, head: Camera) -> None:
        early, self._introduced_s = tuple(self._early), None
        self._early.clear()
        known = LiveRig(
            head_camera=head,
            overhead_camera=self._rig.overhead,
            layout=self._rig.layout,
            gaze_camera=self._gaze_camera,
        )
        rng = np.random.default_rng(self._config.seed)
        self._mapping = LiveMapping(known, self._config.live, rng=rng)
        for message in early:
            self.take(message)

    def _take_overhead_image(self, payload: bytes) -> None:
        if self._mapping is not None and self._rig.overhead is not None:
            frame = images.decode_image(payload, stream=Stream.OVERHEAD_IMAGE)
            if self._gates[Stream.OVERHEAD_IMAGE].check(frame, self._rig.overhead):
                self._publish(self._mapping.overhead_frame(frame))

    def _take_gaze(self, payload: bytes) -> None:
        if self._mapping is not None and not self._has_device_fixations:
            sample = rig.decode_gaze(payload)
            if abs(sample.t_ns - self._health.t_ns) > _GAZE_LIMIT_NS and self._health.t_ns:
                todo = "put cameras and eye tracker on one clock"
                raise InputError("far from the images' time", where=Stream.GAZE, todo=todo)
            self._mapping.gaze(sample)

    def _take_device_fixation(self, payload: bytes) -> None:
        fixation = rig.decode_device_fixation(payload)
        self._has_device_fixations = True
        if self._mapping is not None:
            self._mapping.device_fixation(fixation)

    def _take_imu(self, payload: bytes) -> None:
        if self._mapping is not None:
            self._mapping.inertial(rig.decode_imu(payload))

    def _take_event(self, payload: bytes) -> None:
        if rig.decode_event(payload).name == RECORDING_END and self._mapping is not None:
            self._publish(self._mapping.finish())
            self._health.finish(self._figures)

    def _publish(self, news: News) -> None:
        if self._mapping is not None:
            self._output.say(news, self._mapping)

    def _figures(self) -> dict[str, float]:
        if self._mapping is None:
            return {}
        self._output.say_points(self._mapping)
        offset = self._mapping.looks.offset
        dropped = {f"{stream}_dropped": float(n) for stream, n in self.inbox.dropped.items()}
        return {
            **dropped,
            "map_id": float(self._mapping.tracker.map_id),
            IS_METRIC: float(self._mapping.tracker.scale is Scale.METRIC),
            "gaze_offset_azimuth_deg": float(np.degrees(offset.azimuth_rad)),
            "gaze_offset_elevation_deg": float(np.degrees(offset.elevation_rad)),
        }
