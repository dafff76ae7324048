"""The bus over Zenoh: a client session of a router.

Small streams are published with a cache and subscribed with recovery, so that a router that was
killed and came back, or a subscriber that came late, loses nothing. Images are plain puts that may
be dropped. Blocking is never used: one stalled subscriber would stop everyone.
"""

import json
import logging
import queue
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import timedelta
from types import TracebackType
from typing import Any, Final, Self

import zenoh
from zenoh import ext

from gazemap.errors import GazemapError, InputError
from gazemap.wire.schemas import SCHEMAS
from grounding.errors import GroundingError
from services.bus.base import Answer, Inbox, Message
from services.bus.keys import LOSSY, Stream, alive_key, key

DEFAULT_ENDPOINT: Final = "tcp/127.0.0.1:7447"
_CACHE_COUNT: Final = 20_000
_RECOVERY_PERIOD_S: Final = 1.0
_ALIVE_TIMEOUT_S: Final = 2.0
# Opening a session blocks in native code, where no signal is heard: each attempt is short.
_ATTEMPT_S: Final = 1.0
_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class ZenohConfig:
    """How to reach the router.

    Attributes:
        rig: name of the rig, the third part of every key.
        endpoint: where the router listens.
        user: name the router knows this role by; empty for none.
        password: its password.
        connect_timeout_s: how long to wait for the router; None waits for ever.
    """

    rig: str = "rig"
    endpoint: str = DEFAULT_ENDPOINT
    user: str = ""
    password: str = ""
    connect_timeout_s: float | None = None


class ZenohBus:
    """The streams of one rig over a Zenoh session; always close it, an exit without may hang."""

    def __init__(
        self, config: ZenohConfig, *, is_wanted: Callable[[], bool] = lambda: True
    ) -> None:
        """Connect to the router, waiting for it as configured.

        Args:
            config: how to reach it.
            is_wanted: asked again and again; False ends the waiting.

        Raises:
            InputError: if the router cannot be reached in time or refuses this user.
        """
        self._config = config
        self._session = _open(config, is_wanted=is_wanted)
        self._publishers: dict[Stream, Callable[[bytes], None]] = {}
        # Held so that they are not undeclared when they go out of scope.
        self._declared: list[Any] = []
        self._questions: list[queue.SimpleQueue[zenoh.Query | None]] = []

    def publish(self, stream: Stream, payload: bytes) -> None:
        """Send a message; see the module for what may be dropped."""
        if stream not in self._publishers:
            self._publishers[stream] = self._declare_publisher(stream)
        self._publishers[stream](payload)

    def _declare_publisher(self, stream: Stream) -> Callable[[bytes], None]:
        name, drop = key(self._config.rig, stream), zenoh.CongestionControl.DROP
        if stream in LOSSY:
            plain = self._session.declare_publisher(
                name, congestion_control=drop, encoding=_encoding(stream)
            )
            self._declared.append(plain)
            return plain.put
        kept = ext.declare_advanced_publisher(
            self._session,
            name,
            congestion_control=drop,
            encoding=_encoding(stream),
            cache=ext.CacheConfig(max_samples=_CACHE_COUNT),
            sample_miss_detection=ext.MissDetectionConfig(
                heartbeat=None, sporadic_heartbeat=_RECOVERY_PERIOD_S
            ),
            publisher_detection=True,
        )
        self._declared.append(kept)
        return kept.put

    def subscribe(self, stream: Stream, inbox: Inbox) -> None:
        """Put every message of a stream into an inbox, those before the subscription included."""

        def take(sample: zenoh.Sample) -> None:
            inbox.put(Message(stream=stream, payload=sample.payload.to_bytes()))

        name = key(self._config.rig, stream)
        if stream in LOSSY:
            self._declared.append(self._session.declare_subscriber(name, take))
            return
        period: Any = timedelta(seconds=_RECOVERY_PERIOD_S)  # the stub says float, which raises
        subscriber = ext.declare_advanced_subscriber(
            self._session,
            name,
            take,
            history=ext.HistoryConfig(detect_late_publishers=True),
            recovery=ext.RecoveryConfig(periodic_queries=period, heartbeat=None),
        )
        self._declared.append(subscriber)

    def answer(self, stream: Stream, handler: Answer) -> None:
        """Answer queries on a key, one after the other; what a handler raises is the answer."""
        name = key(self._config.rig, stream)
        asked: queue.SimpleQueue[zenoh.Query | None] = queue.SimpleQueue()
        # A callback that works holds up every message of the session: it only enqueues.
        declared = self._session.declare_queryable(name, asked.put, complete=True)
        self._declared.append(declared)
        self._questions.append(asked)
        threading.Thread(target=_answer_all, args=(asked, handler, name), daemon=True).start()

    def ask(self, stream: Stream, payload: bytes, *, timeout_s: float) -> bytes | None:
        """Return the first answer to a query; None if there was none in time, or a refusal."""
        name = key(self._config.rig, stream)
        for reply in self._session.get(name, payload=payload, timeout=timeout_s):
            if reply.ok is not None:
                return reply.ok.payload.to_bytes()
            if reply.err is not None:
                _log.warning("%s: %s", name, reply.err.payload.to_bytes().decode(errors="replace"))
        return None

    def announce(self, service: str) -> None:
        """Show that a service lives, until the bus is closed or the process ends."""
        token = self._session.liveliness().declare_token(alive_key(self._config.rig, service))
        self._declared.append(token)

    def alive(self) -> frozenset[str]:
        """Return the names of the services that live."""
        pattern = alive_key(self._config.rig, "*")
        replies = self._session.liveliness().get(pattern, timeout=_ALIVE_TIMEOUT_S)
        tokens = [str(reply.ok.key_expr) for reply in replies if reply.ok is not None]
        return frozenset(token.rsplit("/", 1)[-1] for token in tokens)

    def close(self) -> None:
        """Leave the bus."""
        for asked in self._questions:
            asked.put(None)
        self._session.close()  # type: ignore[no-untyped-call]

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def _answer_all(asked: "queue.SimpleQueue[zenoh.Query | None]", handler: Answer, name: str) -> None:
    """Answer the queries of one key until there is None."""
    while (query := asked.get()) is not None:
        with query:
            payload = b"" if query.payload is None else query.payload.to_bytes()
            try:
                query.reply(name, handler(payload))
            except (GazemapError, GroundingError) as error:
                _log.warning("query on %s: %s", name, error)
                query.reply_err(str(error).encode())
            except Exception as error:  # noqa: BLE001  a service's boundary
                _log.exception("query on %s failed", name)
                query.reply_err(str(error).encode())


def _encoding(stream: Stream) -> zenoh.Encoding:
    """Return what tells a subscriber which message it gets."""
    schema = SCHEMAS.get(stream)
    plain = zenoh.Encoding.APPLICATION_PROTOBUF
    return plain if schema is None else plain.with_schema(schema.full_name)


def connect(config: ZenohConfig, *, stop: threading.Event) -> ZenohBus | None:
    """Return the bus once the router is there, or None if asked to stop before.

    Raises:
        InputError: if the router cannot be reached in the configured time or refuses this user.
    """
    try:
        return ZenohBus(config, is_wanted=lambda: not stop.is_set())
    except InputError:
        if stop.is_set():
            return None
        raise


def _open(config: ZenohConfig, *, is_wanted: Callable[[], bool]) -> zenoh.Session:
    native, began_s, has_complained = _client_config(config), time.monotonic(), False
    while True:
        attempt_s = time.monotonic()
        try:
            return zenoh.open(native)
        except zenoh.ZError as error:
            now_s = time.monotonic()
            limit_s = config.connect_timeout_s
            failure = _not_reached(config)
            if not is_wanted() or (limit_s is not None and now_s - began_s >= limit_s):
                raise failure from error
            if not has_complained:
                _log.warning("waiting: %s", failure)
            has_complained = True
            time.sleep(max(0.0, min(_ATTEMPT_S, limit_s or _ATTEMPT_S) - (now_s - attempt_s)))


def _not_reached(config: ZenohConfig) -> InputError:
    todo = "start `gazemap router`, or correct the endpoint, user and password"
    return InputError("no router reached", where=config.endpoint, todo=todo)


def _client_config(config: ZenohConfig) -> zenoh.Config:
    attempt_s = min(_ATTEMPT_S, config.connect_timeout_s or _ATTEMPT_S)
    settings: dict[str, object] = {
        "mode": "client",
        "connect/endpoints": [config.endpoint],
        "connect/timeout_ms": int(attempt_s * 1000),
        "connect/exit_on_failure": True,
        "connect/retry": {
            "period_init_ms": 100,
            "period_max_ms": 1000,
            "period_increase_factor": 2,
        },
        "scouting/multicast/enabled": False,
        "timestamping/enabled": True,
    }
    if config.user:
        settings["transport/auth/usrpwd/user"] = config.user
        settings["transport/auth/usrpwd/password"] = config.password
    native = zenoh.Config()
    try:
        for name, value in settings.items():
            native.insert_json5(name, json.dumps(value))
    except zenoh.ZError as error:
        todo = f"give one like {DEFAULT_ENDPOINT}"
        raise InputError("no endpoint of Zenoh's", where=config.endpoint, todo=todo) from error
    return native
