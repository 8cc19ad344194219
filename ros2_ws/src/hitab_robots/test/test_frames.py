"""Where a sensor sits comes from tf2, where there is one."""

import math
import sys
from types import ModuleType, SimpleNamespace

import pytest

from hitab_robots import Mount
from hitab_robots.frames import mounts_of_tf


class Missing(Exception):
    """As tf2's own."""


def tf2(known):
    """Return a tf2_ros with some transforms to base_link, by frame."""

    class Buffer:
        def __init__(self, node):
            pass

        def lookup_transform(self, target, source, time):
            assert target == "base_link"
            if source not in known:
                raise Missing(source)
            return SimpleNamespace(transform=known[source])

    module = ModuleType("tf2_ros")
    module.Buffer, module.TransformException = Buffer, Missing
    module.TransformListener = lambda buffer, node: object()
    return module


def transform(x, y, yaw):
    rotation = SimpleNamespace(x=0.0, y=0.0, z=math.sin(yaw / 2), w=math.cos(yaw / 2))
    return SimpleNamespace(translation=SimpleNamespace(x=x, y=y, z=0.2), rotation=rotation)


def test_a_frame_is_known_once_tf2_knows_it(monkeypatch):
    known = {}
    monkeypatch.setitem(sys.modules, "tf2_ros", tf2(known))
    mounts = mounts_of_tf(None, "base_link")
    assert mounts("laser") is None
    known["laser"] = transform(0.1, 0.0, math.pi / 2)
    mount = mounts("laser")
    assert (mount.x, mount.y, mount.upside_down) == (0.1, 0.0, False)
    assert mount.yaw == pytest.approx(math.pi / 2)
    assert isinstance(mount, Mount)
