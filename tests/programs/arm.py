"""Where an arm has its tool, from its URDF."""

import math
import xml.etree.ElementTree as xml

from lists import OBJECT, TCP


def multiply(a, b):
    return [[sum(a[i][k] * b[k][j] for k in range(4)) for j in range(4)] for i in range(4)]


def turn(axis, angle):
    x, y, z = axis
    c, s, v = math.cos(angle), math.sin(angle), 1 - math.cos(angle)
    return [
        [x * x * v + c, x * y * v - z * s, x * z * v + y * s, 0],
        [y * x * v + z * s, y * y * v + c, y * z * v - x * s, 0],
        [z * x * v - y * s, z * y * v + x * s, z * z * v + c, 0],
        [0, 0, 0, 1],
    ]


def place(xyz, rpy):
    found = multiply(turn((0, 0, 1), rpy[2]), multiply(turn((0, 1, 0), rpy[1]), turn((1, 0, 0), rpy[0])))
    for row, value in zip(found, xyz):
        row[3] = value
    return found


class Arm:
    """The chain of a URDF from its root to the child of its last moving joint."""

    def __init__(self, urdf):
        numbers = lambda text: [float(word) for word in text.split()]
        joints = {}
        for joint in xml.parse(urdf).getroot().findall("joint"):
            origin, axis = joint.find("origin"), joint.find("axis")
            joints[joint.find("parent").get("link")] = (
                joint.get("type"),
                place(
                    numbers(origin.get("xyz", "0 0 0")) if origin is not None else [0, 0, 0],
                    numbers(origin.get("rpy", "0 0 0")) if origin is not None else [0, 0, 0],
                ),
                numbers(axis.get("xyz")) if axis is not None else [1, 0, 0],
                joint.find("child").get("link"),
            )
        children = {joint[3] for joint in joints.values()}
        link = next(parent for parent in joints if parent not in children)
        self.chain = []
        while link in joints:
            self.chain.append(joints[link])
            link = joints[link][3]

    def tip(self, q):
        """The frame of the child of the last moving joint in that of the root."""
        q, found = list(q), place((0, 0, 0), (0, 0, 0))
        for kind, origin, axis, _ in self.chain:
            found = multiply(found, origin)
            if kind in ("revolute", "continuous"):
                found = multiply(found, turn(axis, q.pop(0)))
        return found

    def tool(self, q):
        """The point of the tool, mm: carried from the last joint to the first, as thousands of samples ask for it."""
        q, at = list(q), (0.0, 0.0, TCP)
        for kind, origin, axis, _ in reversed(self.chain):
            for rows in (turn(axis, q.pop()), origin) if kind in ("revolute", "continuous") else (origin,):
                x, y, z = at
                at = tuple(a * x + b * y + c * z + d for a, b, c, d in rows[:3])
        return [1000 * (at[i] - OBJECT[i]) for i in range(3)]
