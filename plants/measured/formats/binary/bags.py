"""Reading MCAP files and ROS bags, by mcap and rosbags; no ROS is needed.

Each number in a message is a channel, by its topic and its place in the message: ``/joint.position[0]``.  Its
time is that of the message's header, and where that has none the time at which it was logged.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from plants.measured.formats.binary.extras import needed
from plants.measured.formats.channel import LoggedChannel

LONGEST = 16
"""Elements up to which an array in a message makes channels: a point cloud is none."""

SI = {"position": "rad", "fluid_pressure": "Pa"}
"""Units of two fields of ROS's own messages, JointState and FluidPressure, which are in SI."""

Message = tuple[str, int, Any]
"""Topic, time of logging [ns], message."""


def read_mcap(path: Path) -> list[LoggedChannel]:
    """The numbers in the messages of an MCAP file that are written in JSON or as ROS 2 does.

    Raises InputError where mcap is missing.
    """
    reader = needed("mcap.reader", "mcap", path)
    ros2 = needed("mcap_ros2.decoder", "mcap", path).DecoderFactory()

    def messages() -> Iterator[Message]:
        import json

        decoders: dict[int, Any] = {}
        with path.open("rb") as file:
            for schema, channel, message in reader.make_reader(file).iter_messages():
                if channel.message_encoding == "json":
                    yield channel.topic, message.log_time, json.loads(message.data)
                    continue
                if channel.id not in decoders:
                    decoders[channel.id] = ros2.decoder_for(channel.message_encoding, schema)
                if decoders[channel.id] is not None:
                    yield channel.topic, message.log_time, decoders[channel.id](message.data)

    return _channels(messages())


def read_bag(path: Path) -> list[LoggedChannel]:
    """The numbers in the messages of a ROS bag: the folder of one of ROS 2, or a ``.bag`` of ROS 1.

    Raises InputError where rosbags is missing.
    """
    highlevel = needed("rosbags.highlevel", "ros", path)
    stores = needed("rosbags.typesys", "ros", path)

    def messages() -> Iterator[Message]:
        store = stores.get_typestore(stores.Stores.LATEST)
        with highlevel.AnyReader([path], default_typestore=store) as reader:
            for connection, stamp, raw in reader.messages():
                yield connection.topic, stamp, reader.deserialize(raw, connection.msgtype)

    return _channels(messages())


def _channels(messages: Iterator[Message]) -> list[LoggedChannel]:
    times: defaultdict[str, list[float]] = defaultdict(list)
    values: defaultdict[str, list[float]] = defaultdict(list)
    start: int | None = None
    for topic, logged, message in messages:
        at = _stamp(message) or logged
        start = at if start is None else start
        for name, value in _numbers(topic, message):
            times[name].append(1e-9 * (at - start))
            values[name].append(value)
    return [
        LoggedChannel(n, _unit(n), np.array(times[n]), np.array(values[n]))
        for n in values
        if len(values[n]) > 1
    ]


def _stamp(message: Any) -> int:
    """Time in the header of a message [ns], 0 where there is none."""
    stamp = _fields(_fields(message).get("header")).get("stamp")
    found = _fields(stamp)
    seconds = found.get("sec", found.get("secs", 0))
    return int(seconds) * 10**9 + int(found.get("nanosec", found.get("nsecs", 0)))


def _fields(message: Any) -> Mapping[str, Any]:
    """Fields of a message, whichever library made its class."""
    if isinstance(message, Mapping):
        return message
    names: Any = getattr(message, "__dataclass_fields__", None) or getattr(message, "__slots__", ())
    return {n: getattr(message, n) for n in names if not n.startswith("_")}


def _numbers(name: str, value: Any) -> Iterator[tuple[str, float]]:
    if isinstance(value, bool | int | float | np.number | np.bool_):
        yield name, float(value)
    elif isinstance(value, list | tuple | np.ndarray):
        if len(value) <= LONGEST:
            for i, inner in enumerate(value):
                yield from _numbers(f"{name}[{i}]", inner)
    elif not isinstance(value, str | bytes):
        for field, inner in _fields(value).items():
            if field != "header" and field != "__msgtype__":
                yield from _numbers(f"{name}.{field}", inner)


def _unit(name: str) -> str:
    """The unit of a field that ROS defines, "" of others."""
    return SI.get(name.rpartition(".")[2].partition("[")[0], "")
