"""The CDR codec against bytes put together by hand, and against itself."""

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from storage.formats.mcap.messages import (
    IMU,
    JOINTS,
    TEMPERATURE,
    MalformedError,
    decode,
    encode,
    schema_text,
)

FINITE = st.floats(allow_nan=False)


def temperature_by_hand(order: str, sec: int, frame: bytes, celsius: float) -> bytes:
    message = b"\0\1\0\0" if order == "<" else b"\0\0\0\0"
    message += struct.pack(order + "iII", sec, 5, len(frame) + 1) + frame + b"\0"
    message += bytes(-(len(message) - 4) % 8)
    return message + struct.pack(order + "dd", celsius, 0.25)


def block(*messages: bytes) -> np.ndarray:
    return np.array([list(message) for message in messages], dtype=np.uint8)


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("frame", [b"", b"imu", b"imu_link"])
def test_message_put_together_by_hand_is_decoded(order, frame):
    message = temperature_by_hand(order, -3, frame, 21.5)
    ((rows, numbers, texts),) = decode(TEMPERATURE, block(message, message))
    assert rows.tolist() == [0, 1]
    assert numbers["temperature"][:, 0].tolist() == [21.5, 21.5]
    assert numbers["sec"][0, 0] == -3
    assert texts == {"frame_id": (frame.decode(),)}


def test_encoded_message_is_the_one_put_together_by_hand():
    numbers = {"sec": [[7]], "nanosec": [[5]], "temperature": [[21.5]], "variance": [[0.25]]}
    made = encode(TEMPERATURE, {n: np.array(v) for n, v in numbers.items()}, {"frame_id": ("imu",)})
    assert made[0].tobytes() == temperature_by_hand("<", 7, b"imu", 21.5)


def test_messages_of_one_length_but_other_layouts_are_told_apart():
    little = temperature_by_hand("<", 1, b"a", 1.0)
    big = temperature_by_hand(">", 2, b"b", 2.0)
    found = list(decode(TEMPERATURE, block(little, big, little)))
    assert [rows.tolist() for rows, _, _ in found] == [[0, 2], [1]]
    assert found[1][1]["temperature"][0, 0] == 2.0


@pytest.mark.parametrize("length", [0, 3, 10, 20, 30])
def test_message_that_ends_early_is_malformed(length):
    message = temperature_by_hand("<", 1, b"imu", 1.0)[:length]
    with pytest.raises(MalformedError):
        list(decode(TEMPERATURE, np.frombuffer(message, dtype=np.uint8)[None, :]))


def test_encapsulation_that_is_not_plain_cdr_is_malformed():
    message = b"\0\7" + temperature_by_hand("<", 1, b"imu", 1.0)[2:]
    with pytest.raises(MalformedError, match="encapsulation 0007"):
        list(decode(TEMPERATURE, block(message)))


@given(
    arrays(np.float64, (4, 3), elements=FINITE), st.text(max_size=9).filter(lambda s: "\0" not in s)
)
def test_imu_values_come_back_bit_for_bit(values, frame):
    made = encode(IMU, {"angular_velocity": values}, {"frame_id": (frame,)})
    ((_, numbers, texts),) = decode(IMU, made)
    assert numbers["angular_velocity"].tobytes() == values.tobytes()
    assert not numbers["linear_acceleration"].any()
    assert texts == {"frame_id": (frame,)}


@pytest.mark.parametrize("with_velocity", [True, False])
def test_joint_names_and_sequences_come_back(with_velocity):
    position = np.arange(6.0).reshape(2, 3)
    numbers = {"position": position} | ({"velocity": -position} if with_velocity else {})
    names = ("outer", "middle axis", "z")
    made = encode(JOINTS, numbers, {"frame_id": ("table",), "name": names})
    ((_, back, texts),) = decode(JOINTS, made)
    assert texts["name"] == names
    assert (back["position"] == position).all()
    assert ("velocity" in back.dtype.names) is with_velocity


def test_schema_text_brings_every_type_it_uses_once():
    text = schema_text(IMU)
    used = [line for line in text.splitlines() if line.startswith("MSG: ")]
    assert sorted(used) == [
        "MSG: builtin_interfaces/Time",
        "MSG: geometry_msgs/Quaternion",
        "MSG: geometry_msgs/Vector3",
        "MSG: std_msgs/Header",
    ]
