"""A peer of Eclipse Zenoh's own package: prints what it receives as lines of JSON.

    python zenoh_peer.py PORT SECONDS
"""

import json
import sys
import time

import zenoh


def show(sample: zenoh.Sample) -> None:
    message = json.loads(sample.payload.to_string())
    print(json.dumps({"key": str(sample.key_expr), "encoding": str(sample.encoding), "message": message}), flush=True)


config = zenoh.Config()
config.insert_json5("mode", '"peer"')
config.insert_json5("listen/endpoints", json.dumps([f"tcp/127.0.0.1:{sys.argv[1]}"]))
config.insert_json5("scouting/multicast/enabled", "false")
with zenoh.open(config) as session:
    subscriber = session.declare_subscriber("ridgetone/**", show)
    print(json.dumps({"ready": True}), flush=True)
    time.sleep(float(sys.argv[2]))
