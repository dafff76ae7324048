"""What the mapping service publishes, and its answers to queries for the latest map."""

import numpy as np

from gazemap.live import LiveMapping, News
from gazemap.types.tracking import Tracked
from gazemap.wire import mapping, surface
from gazemap.wire.streams import Stream
from services.bus.base import Bus
from services.health import SENT, Health
from services.latest import LatestMessages


class MappingOutput:
    """Publishes poses, events, objects, fixations and the map."""

    def __init__(self, bus: Bus, health: Health) -> None:
        self._bus, self._health = bus, health
        self._map = LatestMessages(bus, Stream.MAP_POINTS, Stream.MAP_MESH)

    def say(self, news: News, current: LiveMapping) -> None:
        """Publish what one input led to."""
        self._say_where(news, current)
        for event in news.events:
            self._bus.publish(Stream.MAP_EVENT, mapping.encode_map_event(event))
        for thing in news.objects:
            self._bus.publish(Stream.OBJECT, mapping.encode_object(thing))
            self._health.count(SENT)
        for fixation in news.fixations:
            self._bus.publish(Stream.FIXATION, mapping.encode_fixation(fixation))
            self._health.count(SENT)
        if news.objects:
            self._say_mesh(current)

    def _say_where(self, news: News, current: LiveMapping) -> None:
        if news.T_world_overhead is not None:
            transform = mapping.encode_transform(
                news.T_world_overhead, parent="world", child="overhead", t_ns=self._health.t_ns
            )
            self._bus.publish(Stream.OVERHEAD_POSE, transform)
        if isinstance(news.outcome, Tracked):
            pose = mapping.PublishedPose(tracked=news.outcome, scale=current.tracker.scale)
            self._bus.publish(Stream.POSE, mapping.encode_pose(pose))
        if news.outcome is not None:
            self._health.count("tracked" if isinstance(news.outcome, Tracked) else "lost")

    def _say_mesh(self, current: LiveMapping) -> None:
        mesh, scale = current.scene().mesh, current.tracker.scale
        payload = surface.encode_mesh(mesh, t_ns=self._health.t_ns, scale=scale)
        self._map.publish(Stream.MAP_MESH, payload)

    def say_points(self, current: LiveMapping) -> None:
        """Publish the sparse map."""
        points_world = current.tracker.points_world()
        points = surface.MapPoints(
            t_ns=self._health.t_ns,
            points_world=points_world,
            # The tracker keeps grey patches: points have no colour of their own.
            colours=np.full((len(points_world), 3), 128, dtype=np.uint8),
            scale=current.tracker.scale,
            map_id=current.tracker.map_id,
        )
        self._map.publish(Stream.MAP_POINTS, surface.encode_points(points))
