"""A subscriber of Eclipse Cyclone DDS, without ROS: prints clouds and texts of a finger as lines of JSON.

    python cyclone.py DOMAIN SECONDS

Types and names are those of ROS 2's design pages: a topic /a/b is rt/a/b, and a message p/M has the type p::msg::dds_::M_.
"""

import json
import struct
import sys
import time
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import int32, sequence, uint8, uint32
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration


@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time
    frame_id: str


@dataclass
class PointField(IdlStruct, typename="sensor_msgs::msg::dds_::PointField_"):
    name: str
    offset: uint32
    datatype: uint8
    count: uint32


@dataclass
class PointCloud2(IdlStruct, typename="sensor_msgs::msg::dds_::PointCloud2_"):
    header: Header
    height: uint32
    width: uint32
    fields: sequence[PointField]
    is_bigendian: bool
    point_step: uint32
    row_step: uint32
    data: sequence[uint8]
    is_dense: bool


@dataclass
class String(IdlStruct, typename="std_msgs::msg::dds_::String_"):
    data: str


def main() -> None:
    participant = DomainParticipant(int(sys.argv[1]))
    history = Policy.History.KeepLast(1000)
    best_effort = Qos(Policy.Reliability.BestEffort, history)
    reliable = Qos(Policy.Reliability.Reliable(duration(seconds=1)), history)
    clouds = DataReader(participant, Topic(participant, "rt/ridgetone/f0/frames", PointCloud2), qos=best_effort)
    texts = DataReader(participant, Topic(participant, "rt/ridgetone/f0/health", String), qos=reliable)
    print(json.dumps({"ready": True}), flush=True)
    until = time.monotonic() + float(sys.argv[2])
    while time.monotonic() < until:
        # A sample may be the notice that the writer is gone.
        for cloud in (one for one in clouds.take(1000) if isinstance(one, PointCloud2)):
            numbers = struct.unpack(f"<{len(cloud.data) // 4}f", bytes(cloud.data))
            line = {
                "utc_s": cloud.header.stamp.sec + 1e-9 * cloud.header.stamp.nanosec,
                "frame_id": cloud.header.frame_id,
                "size": [cloud.height, cloud.width, cloud.point_step, cloud.row_step],
                "fields": [[field.name, field.offset, field.datatype, field.count] for field in cloud.fields],
                "flags": [cloud.is_bigendian, cloud.is_dense],
                "numbers": numbers,
            }
            print(json.dumps({"cloud": line}), flush=True)
        for text in (one for one in texts.take(1000) if isinstance(one, String)):
            print(json.dumps({"text": json.loads(text.data)}), flush=True)
        time.sleep(0.005)


main()
