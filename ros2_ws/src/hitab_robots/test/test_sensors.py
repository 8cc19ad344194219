"""The standard messages as numbers; nothing infinite, and nothing made up."""

import math

import pytest
from geometry_msgs.msg import Quaternion
from hypothesis import given
from hypothesis import strategies as st
from nav_msgs.msg import Odometry as OdometryMessage
from sensor_msgs.msg import BatteryState, JointState
from sensor_msgs.msg import Imu as ImuMessage
from sensor_msgs.msg import Range as RangeMessage

from hitab_core import VocabularyError
from hitab_robots import Battery, Imu, Joints, Odometry, Range


def read(sensor, message):
    return dict(zip(sensor.fields, sensor.read(message), strict=True))


def quaternion(roll, pitch, yaw):
    cr, sr = math.cos(roll / 2), math.sin(roll / 2)
    cp, sp = math.cos(pitch / 2), math.sin(pitch / 2)
    cy, sy = math.cos(yaw / 2), math.sin(yaw / 2)
    return Quaternion(
        w=cr * cp * cy + sr * sp * sy,
        x=sr * cp * cy - cr * sp * sy,
        y=cr * sp * cy + sr * cp * sy,
        z=cr * cp * sy - sr * sp * cy,
    )


angles = st.floats(-1.5, 1.5)


@given(angles, angles, st.floats(-3.1, 3.1), st.sampled_from([1.0, -1.0]))
def test_angles_come_out_as_they_went_in(roll, pitch, yaw, sign):
    rotation = quaternion(roll, pitch, yaw)
    rotation = Quaternion(**{f: sign * getattr(rotation, f) for f in "xyzw"})
    found = read(Imu(), ImuMessage(orientation=rotation))
    assert found["roll"] == pytest.approx(roll, abs=1e-6)
    assert found["pitch"] == pytest.approx(pitch, abs=1e-6)
    assert found["heading"] == pytest.approx(yaw, abs=1e-6)


def test_odometry():
    message = OdometryMessage()
    message.pose.pose.position.x, message.pose.pose.position.y = 1.0, -2.0
    message.pose.pose.orientation = quaternion(0.0, 0.0, 3.0)
    message.twist.twist.linear.x, message.twist.twist.angular.z = 0.5, math.inf
    found = read(Odometry(), message)
    assert (found["x"], found["y"], found["vx"]) == (1.0, -2.0, 0.5)
    assert found["heading"] == pytest.approx(3.0)
    assert math.isnan(found["turn_rate"])


def test_an_imu_says_what_it_does_not_measure():
    message = ImuMessage(orientation=quaternion(0.1, 0.2, 0.3))
    message.angular_velocity.z, message.linear_acceleration.z = 0.7, 9.8
    assert read(Imu(), message)["turn_rate"] == 0.7
    message.orientation_covariance[0] = message.angular_velocity_covariance[0] = -1.0
    found = read(Imu(), message)
    assert math.isnan(found["roll"])
    assert math.isnan(found["turn_rate"])
    assert found["az"] == 9.8
    message.linear_acceleration_covariance[0] = -1.0
    assert math.isnan(read(Imu(), message)["az"])


def test_a_battery_counts_to_one_or_to_a_hundred():
    message = BatteryState(percentage=50.0, voltage=11.5, power_supply_status=1)
    found = read(Battery(percent=True), message)
    assert found == {"percentage": 0.5, "voltage": 11.5, "charging": 1.0}
    unknown = BatteryState(percentage=math.nan, voltage=math.nan)
    found = read(Battery(), unknown)
    assert math.isnan(found["percentage"])
    assert math.isnan(found["voltage"])
    assert found["charging"] == 0.0


def test_a_range():
    for distance, expected in [
        (1.0, 1.0),
        (math.inf, 4.0),
        (4.5, 4.0),
        (-math.inf, 0.02),
        (0.01, math.nan),
        (0.0, math.nan),
        (math.nan, math.nan),
    ]:
        message = RangeMessage(range=distance, min_range=0.02, max_range=4.0)
        assert read(Range(), message)["range"] == pytest.approx(expected, nan_ok=True)


@given(*[st.floats(width=32) for _ in range(3)])
def test_a_range_is_never_infinite(distance, least, most):
    message = RangeMessage(range=distance, min_range=least, max_range=most)
    assert not math.isinf(read(Range(), message)["range"])


def test_joints_that_a_message_leaves_out_have_no_value():
    sensor = Joints(joints=("left", "right", "arm"))
    message = JointState(name=["arm", "left"], position=[1.0, 2.0], velocity=[0.5])
    found = read(sensor, message)
    assert found["arm.position"] == 1.0
    assert found["arm.velocity"] == 0.5
    assert found["left.position"] == 2.0
    assert math.isnan(found["left.velocity"])
    assert math.isnan(found["right.position"])


def test_a_sensor_is_declared_sensibly():
    with pytest.raises(VocabularyError, match='joints of sensor "joint_states" are none'):
        Joints()
    with pytest.raises(VocabularyError, match="patience of sensor"):
        Odometry(patience=0.0)
    with pytest.raises(VocabularyError, match='"front/scan" is not a name for a sensor'):
        Range(name="front/scan")
    assert Range(name="front", topic="front/sonar").topic_name == "front/sonar"
