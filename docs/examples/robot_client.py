"""A robot that waits for what it is asked to do: needs zenoh, protobuf and the schema alone.

Run: python docs/examples/robot_client.py [ENDPOINT] [RIG]
"""

import json
import queue
import sys

import zenoh

from gazemap.wire.generated import gazemap_grounding_pb2, gazemap_streams_pb2

endpoint = sys.argv[1] if len(sys.argv) > 1 else "tcp/127.0.0.1:7447"
rig = sys.argv[2] if len(sys.argv) > 2 else "rig"

config = zenoh.Config()
config.insert_json5("mode", '"client"')
config.insert_json5("connect/endpoints", json.dumps([endpoint]))
config.insert_json5("connect/timeout_ms", "-1")  # wait for the router
config.insert_json5("scouting/multicast/enabled", "false")

samples: queue.Queue[zenoh.Sample] = queue.Queue()
with zenoh.open(config) as session:
    # A callback only enqueues: work in it would hold up the whole session.
    plans = session.declare_subscriber(f"gazemap/v1/{rig}/plan", samples.put)
    states = session.declare_subscriber(f"gazemap/v1/{rig}/grounding/status", samples.put)
    revision, is_over = 0, False
    while not is_over:
        sample = samples.get()
        if str(sample.key_expr).endswith("status"):
            status = gazemap_streams_pb2.ServiceStatus.FromString(sample.payload.to_bytes())
            if not (is_over := bool(status.figures.get("finished"))):
                continue
            # The last plan may have been overtaken: a query is answered with the latest.
            sample = next(reply.ok for reply in session.get(plans.key_expr) if reply.ok)
        plan = gazemap_grounding_pb2.Plan.FromString(sample.payload.to_bytes())
        if plan.revision > revision:  # the whole plan as it is believed now
            print(plan.json, flush=True)
            revision = plan.revision
