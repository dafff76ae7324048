"""Mapping in a process of its own: the solver never takes the tracking thread's time."""

import multiprocessing
import os
import queue
import signal
import threading
from multiprocessing.connection import wait
from multiprocessing.context import SpawnContext, SpawnProcess

import cv2

from gazemap.errors import SolverError
from gazemap.geometry.camera import Camera
from gazemap.slam.live.config import LiveConfig
from gazemap.slam.live.mapper import Mapper
from gazemap.slam.live.messages import Note, Reply
from gazemap.slam.live.warm_up import warm_up_mapping
from gazemap.types.session import TagLayout

_START_TIMEOUT_S = 120.0
_REPLY_TIMEOUT_S = 60.0
_STOP_TIMEOUT_S = 5.0


class ProcessLink:
    """Mapping in a child process, which ends when this one closes the link or dies."""

    def __init__(self, camera: Camera, *, layout: TagLayout | None, config: LiveConfig) -> None:
        """Start the process and wait until it is ready.

        Raises:
            SolverError: if it does not start.
        """
        context: SpawnContext = multiprocessing.get_context("spawn")
        self._notes: multiprocessing.Queue[Note | None] = context.Queue()
        self._replies: multiprocessing.Queue[Reply | None] = context.Queue()
        self._process: SpawnProcess = context.Process(
            target=_serve,
            args=(self._notes, self._replies, camera, layout, config),
            name="gazemap-mapping",
            daemon=True,
        )
        self._process.start()
        self._take(_START_TIMEOUT_S)

    def send(self, note: Note) -> None:
        """Hand over a note; it is pickled in a thread of the queue's own."""
        self._notes.put(note)

    def poll(self) -> Reply | None:
        """Return the next reply if it is there."""
        try:
            return self._replies.get_nowait()
        except queue.Empty:
            if not self._process.is_alive():
                raise SolverError("mapping: its process has died") from None
            return None

    def wait(self) -> Reply:
        """Return the next reply."""
        reply = self._take(_REPLY_TIMEOUT_S)
        if reply is None:
            raise SolverError("mapping: an empty reply")
        return reply

    def close(self) -> None:
        """Stop the process."""
        if self._process.is_alive():
            self._notes.put(None)
            self._process.join(_STOP_TIMEOUT_S)
        if self._process.is_alive():
            self._process.kill()
            self._process.join(_STOP_TIMEOUT_S)
        for channel in (self._notes, self._replies):
            channel.cancel_join_thread()
            channel.close()

    def _take(self, timeout_s: float) -> Reply | None:
        waited_s = 0.0
        while waited_s < timeout_s:
            try:
                return self._replies.get(timeout=1.0)
            except queue.Empty:
                waited_s += 1.0
                if not self._process.is_alive():
                    raise SolverError("mapping: its process has died") from None
        raise SolverError(f"mapping: no reply within {timeout_s:.0f} s")


def _serve(
    notes: "multiprocessing.Queue[Note | None]",
    replies: "multiprocessing.Queue[Reply | None]",
    camera: Camera,
    layout: TagLayout | None,
    config: LiveConfig,
) -> None:
    """Work notes in until None comes; the first reply, None, says that it is ready."""
    # Signals go to whole groups of processes: who tracks decides when mapping ends.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    cv2.setNumThreads(1)
    mapper = Mapper(camera, layout=layout, config=config)
    warm_up_mapping()
    replies.put(None)
    while (note := notes.get()) is not None:
        replies.put(mapper.handle(note))
    # Nobody takes the last replies any more: the end must not wait until they are taken.
    replies.cancel_join_thread()


def _end_with_parent() -> None:
    """End with a parent that was killed: this process holds both ends of its own queues open."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(1)
