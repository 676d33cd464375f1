"""Where a tool stands, from the URDF alone: nothing of detune."""

import math
import xml.etree.ElementTree as ElementTree


def times(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(4)) for j in range(4)] for i in range(4)]


def frame(xyz, rotation):
    return [[*rotation[i], xyz[i]] for i in range(3)] + [[0, 0, 0, 1]]


def rpy(r, p, y):
    """Fixed axes x, y, z in turn."""
    cr, sr, cp, sp, cy, sy = (f(a) for a in (r, p, y) for f in (math.cos, math.sin))
    return [[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr]]


def about(axis, angle):
    size = math.sqrt(sum(v * v for v in axis))
    x, y, z = (v / size for v in axis)
    c, s = math.cos(angle), math.sin(angle)
    v = 1 - c
    return [[c + x * x * v, x * y * v - z * s, x * z * v + y * s],
            [y * x * v + z * s, c + y * y * v, y * z * v - x * s],
            [z * x * v - y * s, z * y * v + x * s, c + z * z * v]]


ONE = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]


def numbers(element, name, default):
    text = element.get(name) if element is not None else None
    return [float(v) for v in (text or default).split()]


def tip(urdf, base, tip, q):
    """The tip frame in the base frame; `q` in the order of the moving joints from base to tip."""
    joints = {j.find("child").get("link"): j for j in ElementTree.parse(urdf).getroot().findall("joint")}
    chain, link = [], tip
    while link != base:
        chain.insert(0, joints[link])
        link = joints[link].find("parent").get("link")
    pose, q = frame([0, 0, 0], ONE), list(q)
    for joint in chain:
        origin = joint.find("origin")
        pose = times(pose, frame(numbers(origin, "xyz", "0 0 0"), rpy(*numbers(origin, "rpy", "0 0 0"))))
        axis = numbers(joint.find("axis"), "xyz", "1 0 0")
        if joint.get("type") in ("revolute", "continuous"):
            pose = times(pose, frame([0, 0, 0], about(axis, q.pop(0))))
        elif joint.get("type") == "prismatic":
            by = q.pop(0)
            pose = times(pose, frame([v * by for v in axis], ONE))
    assert not q, "more joints in the pose than in the chain"
    return pose


def point(pose, at):
    return [sum(pose[i][k] * v for k, v in enumerate([*at, 1])) for i in range(3)]
