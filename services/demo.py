"""The main job in one go: simulate, ground it live over loopback, rebuild it."""

import json
import socket
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

from gazemap.errors import GazemapError
from gazemap.ports import Progress
from gazemap.session.atomic import whole_file
from gazemap.sim.config import Level, SimConfig, preset
from gazemap.sim.simulate import simulate
from gazemap.wire.mapping import decode_status
from gazemap.wire.streams import Stream
from services.bus.base import Bus, Inbox, Message
from services.bus.zenoh import ZenohBus, ZenohConfig
from services.health import FINISHED
from services.processes import ServiceProcesses
from services.rebuild.run import RebuildConfig, rebuild
from services.wire.grounding import decode_plan

SERVICES: Final = ("mapping", "grounding")
_START_WAIT_S: Final = 120.0
_SILENCE_S: Final = 120.0
_ANSWER_S: Final = 5.0
_POLL_S: Final = 0.2
_LEAD_S: Final = 0.5

Plan = dict[str, Any]
PlanWatcher = Callable[[Plan], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class DemoConfig:
    """What is simulated: small and short, so that two cores keep up.

    Attributes:
        seed: of the simulated person and table.
        seconds: length of the session.
        level: how much it asks of the estimators.
        size_px: width and height of the head camera's images.
        rate_hz: their rate.
    """

    seed: int
    seconds: float = 15.0
    level: Level = Level.EASY
    size_px: tuple[int, int] = (640, 480)
    rate_hz: float = 15.0

    @property
    def simulation(self) -> SimConfig:
        """The simulator's settings."""
        base = preset(self.level)
        lens = replace(
            base.scene_lens,
            width_px=self.size_px[0],
            height_px=self.size_px[1],
            rate_hz=self.rate_hz,
        )
        overhead = replace(base.overhead_lens, rate_hz=5.0)
        return replace(
            base, seed=self.seed, seconds=self.seconds, scene_lens=lens, overhead_lens=overhead
        )


def run_demo(out: Path, config: DemoConfig, *, progress: Progress, watch: PlanWatcher) -> Plan:
    """Simulate into OUT/session and OUT/truth, run live, then rebuild into OUT.

    Args:
        out: the folder; the live plan goes to OUT/live-plan.json, the services' logs to OUT/logs.
        config: what is simulated.
        progress: told how far it has come.
        watch: called with each revision of the live plan as it arrives.

    Returns:
        The last live plan.

    Raises:
        GazemapError: if a service fails or falls silent.
    """
    endpoint = f"tcp/127.0.0.1:{_free_port()}"
    with ServiceProcesses(out / "logs") as processes:
        # The services load while the session is simulated.
        processes.start("router", "router", "--listen", endpoint)
        for name in SERVICES:
            processes.start(name, "serve", name, "--connect", endpoint)
        simulate(config.simulation, out, progress=progress)
        with ZenohBus(ZenohConfig(endpoint=endpoint, connect_timeout_s=_START_WAIT_S)) as bus:
            _wait_for_services(bus, processes)
            plan = _replay_and_watch(bus, processes, out, endpoint=endpoint, watch=watch)
    with whole_file(out / "live-plan.json") as partial:
        partial.write_text(json.dumps(plan, indent=1) + "\n")
    rebuild(out / "session", out, RebuildConfig(), progress=progress)
    return plan


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def _wait_for_services(bus: Bus, processes: ServiceProcesses) -> None:
    deadline_s = time.monotonic() + _START_WAIT_S
    while missing := set(SERVICES) - bus.alive():
        processes.check()
        if time.monotonic() > deadline_s:
            raise GazemapError(f"{', '.join(sorted(missing))} did not start in time; see the logs")
        time.sleep(_POLL_S)


def _replay_and_watch(
    bus: Bus, processes: ServiceProcesses, out: Path, *, endpoint: str, watch: PlanWatcher
) -> Plan:
    inbox = Inbox()
    for stream in (Stream.PLAN, Stream.MAPPING_STATUS, Stream.GROUNDING_STATUS):
        bus.subscribe(stream, inbox)
    session = str(out / "session")
    processes.start(
        "replay", "replay", session, "--connect", endpoint, "--max-lead-s", str(_LEAD_S)
    )
    plan: Plan = {}
    moved_s, reached_ns = time.monotonic(), 0
    while time.monotonic() - moved_s < _SILENCE_S:
        message = inbox.get(timeout_s=_POLL_S)
        processes.check()
        if message is None:
            continue
        if message.stream is Stream.PLAN:
            plan = dict(decode_plan(message.payload).plan)
            watch(plan)
        elif _is_finished(message):
            return _latest(bus, plan, watch)
        # A service that speaks but does not get on is waited for no longer than a silent one.
        told_ns = _told_ns(message)
        if told_ns > reached_ns:
            moved_s, reached_ns = time.monotonic(), told_ns
    raise GazemapError(f"the services do not get on; see {out / 'logs'}")


def _latest(bus: Bus, plan: Plan, watch: PlanWatcher) -> Plan:
    """Return the plan at the session's end: the news of the end may have overtaken it."""
    told = bus.ask(Stream.PLAN, b"", timeout_s=_ANSWER_S)
    latest = plan if told is None else dict(decode_plan(told).plan)
    if latest != plan:
        watch(latest)
    return latest


def _told_ns(message: Message) -> int:
    if message.stream is Stream.PLAN:
        return decode_plan(message.payload).t_ns
    return decode_status(message.payload, stream=message.stream).t_ns


def _is_finished(message: Message) -> bool:
    status = decode_status(message.payload, stream=message.stream)
    return message.stream is Stream.GROUNDING_STATUS and bool(status.figures.get(FINISHED))
