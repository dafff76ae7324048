"""The grounding service on a bus in memory: what it is told, what it says, what it answers."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

import services.grounding
from gazemap.errors import InputError
from gazemap.geometry.camera import Camera
from gazemap.geometry.pose import Pose
from gazemap.types.fixation import Fixation3D
from gazemap.types.frame import Frame
from gazemap.types.scene import HitKind, ObjectState, SceneObject
from gazemap.types.session import Cue, Fixation
from gazemap.types.status import Level, ServiceStatus
from gazemap.wire import images, mapping, rig
from gazemap.wire.images import ImageFormat
from gazemap.wire.streams import Stream
from grounding.symbols.teach import Question
from services.bus.base import Inbox
from services.bus.memory import Exchange, MemoryBus
from services.grounding import GroundingService, GroundingServiceConfig
from services.lessons import lesson_of
from services.present import is_covered
from services.translate import instance
from services.wire import grounding as wire
from services.wire import queries

T0_NS = 1_760_000_000_000_000_000
SECOND = 1_000_000_000
HEIGHT_M = 1.2
CAMERA = Camera(
    width_px=640,
    height_px=480,
    K=np.array([[600.0, 0, 319.5], [0, 600, 239.5], [0, 0, 1]]),
    distortion=np.zeros(5),
)
T_WORLD_OVERHEAD = Pose(R=np.diag([1.0, -1.0, -1.0]), t=np.array([0, 0, HEIGHT_M]))
THINGS = {"object-1": ((-0.2, 0.1), (40, 40, 200)), "object-2": ((0.2, -0.1), (200, 60, 40))}
SIZE_M = 0.05


def thing(object_id):
    (x, y), _ = THINGS[object_id]
    state = ObjectState(
        t_ns=T0_NS,
        left_ns=None,
        T_world_body=Pose(R=np.eye(3), t=np.array([x, y, SIZE_M / 2])),
        cov_world=np.eye(3) * 1e-6,
    )
    return SceneObject(
        object_id=object_id, size_m=np.full(3, SIZE_M), track=(state,), mean_bgr=np.zeros(3)
    )


def overhead_image(k):
    image = np.full((480, 640, 3), (150, 170, 190), np.uint8)
    for (x, y), colour in THINGS.values():
        corners = np.array(
            [[x + a, y + b, SIZE_M] for a, b in ((-1, -1), (-1, 1), (1, 1), (1, -1))]
        )
        corners[:, :2] = np.array([x, y]) + (corners[:, :2] - np.array([x, y])) * SIZE_M / 2
        uv = CAMERA.project(T_WORLD_OVERHEAD.inverse().transform(corners))
        cv2.fillConvexPoly(image, np.rint(uv).astype(np.int32), colour)
    return Frame(index=k, t_ns=T0_NS + k * SECOND // 5, image=image)


def fixation(k, object_id):
    (x, y), _ = THINGS[object_id]
    return Fixation3D(
        fixation=Fixation(
            fixation_id=k,
            start_ns=T0_NS + k * SECOND // 2,
            end_ns=T0_NS + k * SECOND // 2 + SECOND * 2 // 5,
            u_px=0.0,
            v_px=0.0,
        ),
        scene_uv_px=np.zeros(2),
        hit=HitKind.OBJECT,
        point_world=np.array([x, y, SIZE_M]),
        cov_world=np.eye(3) * 25e-6,
        object_id=object_id,
        overhead_uv_px=None,
        origin_world=np.array([0.0, -0.6, 0.6]),
    )


@pytest.fixture
def exchange():
    return Exchange()


@pytest.fixture
def service(exchange):
    """A service that has seen a person look at the red thing and ask to pick it up."""
    rig_bus = MemoryBus(exchange)
    one = GroundingService(MemoryBus(exchange), GroundingServiceConfig(period_s=0.0))
    rig_bus.publish(Stream.OVERHEAD_CALIBRATION, images.encode_calibration(CAMERA, frame_id="o"))
    rig_bus.publish(
        Stream.OVERHEAD_POSE,
        mapping.encode_transform(T_WORLD_OVERHEAD, parent="world", child="overhead", t_ns=T0_NS),
    )
    for object_id in THINGS:
        rig_bus.publish(Stream.OBJECT, mapping.encode_object(thing(object_id)))
    for k in range(12):
        payload = images.encode_image(
            overhead_image(k), frame_id="overhead", image_format=ImageFormat.PNG
        )
        rig_bus.publish(Stream.OVERHEAD_IMAGE, payload)
    cue = Cue(start_ns=T0_NS + SECOND, end_ns=T0_NS + 2 * SECOND, text="pick up the red cube")
    rig_bus.publish(Stream.NARRATION, rig.encode_cue(cue))
    for k in range(1, 7):
        rig_bus.publish(Stream.FIXATION, mapping.encode_fixation(fixation(k, "object-1")))
    drain(one)
    return one


def drain(service):
    while (message := service.inbox.get(timeout_s=0.0)) is not None:
        service.take(message)


def ask(exchange, stream, payload):
    return MemoryBus(exchange).ask(stream, payload, timeout_s=1.0)


def latest_plan(exchange):
    return wire.decode_plan(ask(exchange, Stream.PLAN, b"")).plan


def finish(exchange, service, **figures):
    figures = {"finished": 1.0, **figures}
    status = ServiceStatus(service="mapping", t_ns=T0_NS, level=Level.OK, figures=figures)
    MemoryBus(exchange).publish(Stream.MAPPING_STATUS, mapping.encode_status(status))
    drain(service)


def test_what_was_looked_at_is_what_was_meant(exchange, service):
    service.update(is_finished=False)
    instruction = latest_plan(exchange)["instructions"][0]
    assert (instruction["action"], instruction["target"]) == ("pick", ["red", "cube"])
    assert instruction["object"] == "object-1"
    np.testing.assert_allclose(instruction["target_position"], [-0.2, 0.1, 0.025], atol=0.01)


def test_the_plan_is_sent_once_for_each_revision(exchange, service):
    inbox = Inbox()
    MemoryBus(exchange).subscribe(Stream.PLAN, inbox)
    for _ in range(3):
        service.update(is_finished=False)
    assert inbox.get(timeout_s=0.0) is not None
    assert inbox.get(timeout_s=0.0) is None


def test_a_session_that_ends_is_learnt_from_and_said_to_be_finished(exchange, service):
    inbox = Inbox()
    for stream in (Stream.SYMBOLS, Stream.GROUNDING_STATUS):
        MemoryBus(exchange).subscribe(stream, inbox)
    finish(exchange, service)
    said = {}
    while (message := inbox.get(timeout_s=0.0)) is not None:
        said[message.stream] = message.payload
    assert set(wire.decode_symbols(said[Stream.SYMBOLS]).symbols["symbols"]) == {"red", "cube"}
    assert (
        mapping.decode_status(said[Stream.GROUNDING_STATUS], stream="s").figures["finished"] == 1.0
    )


def test_a_broken_message_is_named_in_the_status_and_stops_nothing(exchange, service):
    MemoryBus(exchange).publish(Stream.NARRATION, b"\xff\xff not protobuf")
    drain(service)
    service.update(is_finished=False)
    assert latest_plan(exchange)["instructions"][0]["object"] == "object-1"
    assert service._health.level is Level.WARNING


@pytest.mark.usefixtures("service")
def test_a_sentence_is_parsed_as_the_command_prints_it(exchange):
    request = queries.encode_parse_request(
        queries.ParseRequest(sentences=("take the blue box", "the box is blue"))
    )
    first, second = queries.decode_parse_answer(ask(exchange, Stream.PARSE, request)).plans
    assert first["instructions"][0]["target"] == ["blue", "box"]
    assert second["error"]


def test_a_sentence_is_grounded_in_the_present_scene(exchange, service):
    service.update(is_finished=False)
    request = queries.encode_ground_request(
        queries.GroundRequest(sentences=("take the red cube", "take the green ball"))
    )
    known, unknown = queries.decode_ground_answer(ask(exchange, Stream.GROUND, request))[
        "instructions"
    ]
    assert (known["status"], known["object"]) == ("grounded", "object-1")
    assert unknown["status"] == "unknown-symbol"
    assert "green" in unknown["question"]


def test_not_that_one_takes_the_instruction_away_from_it(exchange, service):
    service.update(is_finished=False)
    before = latest_plan(exchange)["revision"]
    lesson = {"instruction": 0, "object": "object-1", "is_meant": False}
    answer = queries.decode_teach_answer(
        ask(exchange, Stream.TEACH, queries.encode_teach_request(lesson))
    )
    after = latest_plan(exchange)
    assert answer["learnt"]
    assert after["revision"] > before
    assert after["instructions"][0]["object"] != "object-1"


@pytest.mark.usefixtures("service")
def test_a_verb_is_taught_by_one_it_resembles(exchange):
    lesson = queries.encode_teach_request({"verb": "yoink", "like": "take"})
    assert queries.decode_teach_answer(ask(exchange, Stream.TEACH, lesson))["learnt"]
    request = queries.encode_parse_request(queries.ParseRequest(sentences=("yoink the box",)))
    (plan,) = queries.decode_parse_answer(ask(exchange, Stream.PARSE, request)).plans
    assert plan["instructions"][0]["action"] == "pick"


def test_a_word_is_taught_for_a_thing_on_the_table(exchange, service):
    finish(exchange, service)
    lesson = {"words": ["blue"], "object": "object-2", "group": "new"}
    answer = queries.decode_teach_answer(
        ask(exchange, Stream.TEACH, queries.encode_teach_request(lesson))
    )
    assert answer["learnt"]
    symbols = wire.decode_symbols(ask(exchange, Stream.SYMBOLS, b"")).symbols
    assert "blue" in symbols["symbols"]


def test_what_is_no_lesson_is_refused_in_one_line():
    with pytest.raises(InputError, match="a lesson expected"):
        lesson_of({"word": 3})


def test_patches_are_classified_as_the_command_writes_them(exchange, service):
    finish(exchange, service)
    _, coded = cv2.imencode(".png", overhead_image(0).image[100:220, 150:270])
    patch = queries.NamedPatch(name="a.png", image=coded.tobytes(), mm_per_px=2.0)
    request = queries.encode_classify_request((patch,))
    rows = queries.decode_classify_answer(ask(exchange, Stream.CLASSIFY, request)).splitlines()
    assert rows[0] == "image,group,symbol,score,known"
    assert all(row.startswith("a.png,") for row in rows[1:])


def test_the_plan_says_the_scale_that_mapping_has(exchange, service):
    service.update(is_finished=False)
    assert latest_plan(exchange)["scale"] == "arbitrary"
    status = ServiceStatus(
        service="mapping", t_ns=T0_NS, level=Level.OK, figures={"is_metric": 1.0}
    )
    MemoryBus(exchange).publish(Stream.MAPPING_STATUS, mapping.encode_status(status))
    drain(service)
    service.update(is_finished=False)
    assert latest_plan(exchange)["scale"] == "metric"


@pytest.mark.parametrize(
    "lesson",
    [
        {"instruction": 99, "object": "object-1", "is_meant": True},
        {"instruction": -1, "object": "object-1", "is_meant": True},
        {"instruction": 0, "object": "object-99", "is_meant": True},
    ],
)
def test_a_lesson_about_what_is_not_there_is_not_said_to_be_learnt(exchange, service, lesson):
    service.update(is_finished=False)
    assert ask(exchange, Stream.TEACH, queries.encode_teach_request(lesson)) is None


@pytest.mark.parametrize("mm_per_px", [float("nan"), -1.0, 0.0])
def test_a_scale_that_is_none_is_refused(exchange, service, mm_per_px):
    finish(exchange, service)
    _, coded = cv2.imencode(".png", overhead_image(0).image[100:220, 150:270])
    patch = queries.NamedPatch(name="a.png", image=coded.tobytes(), mm_per_px=mm_per_px)
    request = queries.encode_classify_request((patch,))
    assert ask(exchange, Stream.CLASSIFY, request) is None


def test_a_question_after_the_end_leaves_the_plan_as_it_is(exchange, service):
    finish(exchange, service)
    before = latest_plan(exchange)
    assert before["instructions"][0]["patches"]
    nothing = queries.encode_ground_request(queries.GroundRequest())
    answered = queries.decode_ground_answer(ask(exchange, Stream.GROUND, nothing))
    assert answered == before
    assert latest_plan(exchange) == before


def test_the_end_waits_for_what_mapping_sent_before_it(exchange, service):
    sent = len(THINGS) + 6
    finish(exchange, service, sent=float(sent + 1))
    assert not service._is_over
    MemoryBus(exchange).publish(Stream.FIXATION, mapping.encode_fixation(fixation(7, "object-1")))
    drain(service)
    service._finish_if_all_is_there()
    assert service._is_over
    assert latest_plan(exchange)["instructions"][0]["patches"]


def test_a_thing_that_no_word_explains_is_asked_about_once(exchange, service, monkeypatch):
    inbox = Inbox()
    MemoryBus(exchange).subscribe(Stream.QUESTION, inbox)
    asked = Question(group="colour", words=("blue", "yellow"), text="which colour is this?")
    monkeypatch.setattr(
        services.grounding, "strange_things", lambda *_, **__: [("object-2", asked)]
    )
    finish(exchange, service)
    finish(exchange, service)
    said = []
    while (message := inbox.get(timeout_s=0.0)) is not None:
        said.append(wire.decode_question(message.payload))
    assert [(q.object_id, q.text, q.words) for q in said] == [
        ("object-2", "which colour is this?", ("blue", "yellow"))
    ]
    assert said[0].instruction_index == wire.NO_INSTRUCTION


def test_a_thing_under_another_is_covered():
    """From above one sees what stands on it."""
    below = instance(thing("object-2"))
    higher = below.track[-1].position_world + np.array([0, 0, SIZE_M])
    state = replace(below.track[-1], position_world=higher)
    on_top = replace(below, object_id="object-9", track=(state,))
    assert is_covered(below, [below, on_top])
    assert not is_covered(on_top, [below, on_top])
    assert not is_covered(below, [below, instance(thing("object-1"))])
