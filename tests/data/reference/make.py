#!/usr/bin/env python3
"""Makes the reference data of this folder, by two computations that share nothing with the crate.

    python -m venv VENV && VENV/bin/pip install pin==4.1.0 example-robot-data==6.0.0 numpy scipy mpmath pyyaml
    VENV/bin/python tests/data/reference/make.py

1. Pinocchio: every elastic coordinate becomes a joint of a URDF of its own (extra coordinates through massless
   links); M by its CRBA, gravity's stiffness by its analytic derivatives, the tip's Jacobian, the modes by
   scipy.linalg.eigh. Double precision.
2. mpmath with 40 digits: M as the sum of Jᵀ I J over the bodies, gravity's stiffness by central differences of the
   potential, the modes by eigsy.

What is written is (2), rounded to doubles. It stands only if (1) agrees, see `agree`; the worst differences are
written into summary.json.
"""

import json
import pathlib
import sys
import xml.etree.ElementTree as ET

import mpmath as mp
import numpy as np
import pinocchio as pin
import scipy.linalg
import yaml

HERE = pathlib.Path(__file__).resolve().parent
ROBOTS = HERE.parents[2] / "robots"
mp.mp.dps = 40
PUBLIC = next(
    p for p in (pathlib.Path(q) / "cmeel.prefix/share/example-robot-data/robots" for q in sys.path) if p.exists()
)


# ---- reading -----------------------------------------------------------------------------------------------------


def numbers(element, key, default):
    return [float(v) for v in (element.get(key) if element is not None and element.get(key) else default).split()]


def read_urdf(text):
    root = ET.fromstring(text)
    links, joints = {}, []
    for link in root.findall("link"):
        body, inertial = None, link.find("inertial")
        if inertial is not None:
            inertia = {k: float(v) for k, v in inertial.find("inertia").attrib.items()}
            origin = inertial.find("origin")
            body = {
                "mass": float(inertial.find("mass").get("value")),
                "xyz": numbers(origin, "xyz", "0 0 0"),
                "rpy": numbers(origin, "rpy", "0 0 0"),
                "inertia": inertia,
            }
        links[link.get("name")] = body
    for joint in root.findall("joint"):
        limit = joint.find("limit")
        joints.append(
            {
                "name": joint.get("name"),
                "type": joint.get("type"),
                "parent": joint.find("parent").get("link"),
                "child": joint.find("child").get("link"),
                "xyz": numbers(joint.find("origin"), "xyz", "0 0 0"),
                "rpy": numbers(joint.find("origin"), "rpy", "0 0 0"),
                "axis": numbers(joint.find("axis"), "xyz", "1 0 0"),
                "limit": None
                if limit is None or limit.get("lower") is None
                else (float(limit.get("lower")), float(limit.get("upper"))),
            }
        )
    return links, joints


class Case:
    """A robot as its two files describe it."""

    def __init__(self, robot, urdf):
        self.robot = robot
        self.links, self.joints = read_urdf(urdf)
        elasticity = robot["elasticity"]
        self.springs = elasticity.get("joints", {})
        self.extras = elasticity.get("extra", [])
        self.default_damping = elasticity.get("damping_ratio", 0.02)
        self.gravity = elasticity.get("gravity_m_per_s2", [0, 0, -9.80665])
        self.with_gravity = elasticity.get("gravity", False)
        self.drives = {n: d["reflected_inertia_kgm2"] for n, d in robot.get("drives", {}).items()}
        self.above = {j["child"]: j for j in self.joints}
        root = next(l for l in self.links if l not in self.above)
        self.base, self.tip = robot.get("base", root), robot["tip"]
        self.chain = []
        link = self.tip
        while link != self.base:
            self.chain.insert(0, self.above[link])
            link = self.above[link]["parent"]
        self.moving = [j["name"] for j in self.chain if j["type"] != "fixed"]
        # Links from the base outwards.
        self.order = [self.base]
        for link in self.order:
            self.order += [j["child"] for j in self.joints if j["parent"] == link]
        self.coordinates = []
        for link in self.order:
            joint = self.above.get(link)
            if link != self.base and joint["name"] in self.springs:
                spring = self.springs[joint["name"]]
                self.coordinates.append(
                    {
                        "name": joint["name"],
                        "link": link,
                        "turns": joint["type"] != "prismatic",
                        "axis": joint["axis"],
                        "origin": [0.0, 0.0, 0.0],
                        "stiffness": spring.get("stiffness_nm_per_rad", spring.get("stiffness_n_per_m")),
                        "drive": self.drives.get(joint["name"], 0.0),
                        **self.damping(spring),
                    }
                )
            for extra in self.extras:
                if extra["link"] == link:
                    self.coordinates.append(
                        {
                            "name": extra["name"],
                            "link": link,
                            "turns": extra["kind"] == "rotation",
                            "axis": extra["axis"],
                            "origin": extra.get("origin_m", [0.0, 0.0, 0.0]),
                            "stiffness": extra["stiffness"],
                            "drive": 0.0,
                            **self.damping(extra),
                        }
                    )

    def damping(self, entry):
        viscous = entry.get("damping_nms_per_rad", entry.get("damping_ns_per_m"))
        return {"viscous": viscous, "ratio": None if viscous else entry.get("damping_ratio", self.default_damping)}

    def held(self, joint):
        """Where a moving joint off the chain stays: at zero, or at the limit nearest to it."""
        if joint["type"] == "fixed" or joint["limit"] is None:
            return 0.0
        return min(max(0.0, joint["limit"][0]), joint["limit"][1])


# ---- forty digits ------------------------------------------------------------------------------------------------


def vec(values):
    return mp.matrix([mp.mpf(v) for v in values])


def cross(a, b):
    return mp.matrix([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def dot(a, b):
    return sum(a[i] * b[i] for i in range(3))


def unit(axis):
    axis = vec(axis)
    return axis / mp.sqrt(dot(axis, axis))


def turn(axis, angle):
    k = mp.matrix([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return mp.eye(3) + mp.sin(angle) * k + (1 - mp.cos(angle)) * k * k


def from_rpy(rpy):
    x, y, z = vec([1, 0, 0]), vec([0, 1, 0]), vec([0, 0, 1])
    return turn(z, mp.mpf(rpy[2])) * turn(y, mp.mpf(rpy[1])) * turn(x, mp.mpf(rpy[0]))


def tensor(i):
    return mp.matrix(
        [
            [mp.mpf(i["ixx"]), mp.mpf(i.get("ixy", 0)), mp.mpf(i.get("ixz", 0))],
            [mp.mpf(i.get("ixy", 0)), mp.mpf(i["iyy"]), mp.mpf(i.get("iyz", 0))],
            [mp.mpf(i.get("ixz", 0)), mp.mpf(i.get("iyz", 0)), mp.mpf(i["izz"])],
        ]
    )


class Exact:
    """One case in forty digits."""

    def __init__(self, case):
        self.case = case
        self.fixed = {j["child"]: (from_rpy(j["rpy"]), vec(j["xyz"])) for j in case.joints}
        self.bodies = []
        for link in case.order:
            body = case.links[link]
            if body and body["mass"] > 0:
                r = from_rpy(body["rpy"])
                self.bodies.append((link, mp.mpf(body["mass"]), vec(body["xyz"]), r * tensor(body["inertia"]) * r.T))
        if "payload" in case.robot:
            p = case.robot["payload"]
            self.bodies.append((p["link"], mp.mpf(p["mass_kg"]), vec(p["com_m"]), tensor(p["inertia_kgm2"])))

    def place(self, q, alpha):
        """Frames of the links, and axis, point and outer links of each coordinate."""
        case = self.case
        frames, axes = {case.base: (mp.eye(3), vec([0, 0, 0]))}, []
        for link in case.order:
            if link != case.base:
                joint = case.above[link]
                r, p = frames[joint["parent"]]
                fixed_r, fixed_p = self.fixed[link]
                r, p = r * fixed_r, p + r * fixed_p
                if joint["type"] != "fixed":
                    value = mp.mpf(q[joint["name"]] if joint["name"] in q else case.held(joint))
                    axis = unit(joint["axis"])
                    if joint["type"] == "prismatic":
                        p = p + r * axis * value
                    else:
                        r = r * turn(axis, value)
            else:
                r, p = frames[link]
            for i, c in enumerate(case.coordinates):
                if c["link"] == link:
                    axis, origin = unit(c["axis"]), vec(c["origin"])
                    axes.append((i, r * axis, p + r * origin))
                    if c["turns"]:
                        p = p + r * origin
                        r = r * turn(axis, alpha[i])
                        p = p - r * origin
                    else:
                        p = p + r * axis * alpha[i]
            frames[link] = (r, p)
        return frames, axes

    def carries(self, i, link):
        outer = self.case.coordinates[i]["link"]
        while link != outer:
            if link == self.case.base:
                return False
            link = self.case.above[link]["parent"]
        return True

    def columns(self, axes, link, point):
        n = len(self.case.coordinates)
        linear, angular = mp.zeros(3, n), mp.zeros(3, n)
        for i, direction, origin in axes:
            if self.carries(i, link):
                turns = self.case.coordinates[i]["turns"]
                linear[:, i] = cross(direction, point - origin) if turns else direction
                if turns:
                    angular[:, i] = direction
        return linear, angular

    def mass(self, q):
        n = len(self.case.coordinates)
        frames, axes = self.place(q, [mp.mpf(0)] * n)
        total = mp.zeros(n, n)
        for link, m, com, inertia in self.bodies:
            r, p = frames[link]
            linear, angular = self.columns(axes, link, p + r * com)
            total += m * linear.T * linear + angular.T * (r * inertia * r.T) * angular
        for i, c in enumerate(self.case.coordinates):
            total[i, i] += mp.mpf(c["drive"])
        return total

    def tip(self, q, tcp):
        frames, axes = self.place(q, [mp.mpf(0)] * len(self.case.coordinates))
        r, p = frames[self.case.tip]
        point = p + r * vec(tcp)
        return r, p, self.columns(axes, self.case.tip, point)

    def potential(self, q, alpha):
        frames, _ = self.place(q, alpha)
        g = vec(self.case.gravity)
        return -sum(m * dot(g, frames[link][1] + frames[link][0] * com) for link, m, com, _ in self.bodies)

    def gravity_stiffness(self, q):
        n = len(self.case.coordinates)
        h = mp.mpf(10) ** -9  # error h² relative; 40 digits leave 22 after the second difference
        result = mp.zeros(n, n)

        def at(*steps):
            alpha = [mp.mpf(0)] * n
            for i, s in steps:
                alpha[i] += s * h
            return self.potential(q, alpha)

        rest = at()
        for i in range(n):
            result[i, i] = (at((i, 1)) - 2 * rest + at((i, -1))) / h**2
            for j in range(i):
                value = at((i, 1), (j, 1)) - at((i, 1), (j, -1)) - at((i, -1), (j, 1)) + at((i, -1), (j, -1))
                result[i, j] = result[j, i] = value / (4 * h**2)
        return result

    def modes(self, mass, stiffness):
        """Frequencies in Hz, mass-normalised shapes, damping ratios by strain energy and dashpots."""
        n = mass.rows
        lower = mp.cholesky(stiffness)
        inverse = lower**-1
        eigenvalues, vectors = mp.eigsy(inverse * mass * inverse.T)
        order = sorted(range(n), key=lambda r: -eigenvalues[r])
        omega = [1 / mp.sqrt(eigenvalues[r]) for r in order]
        shapes = mp.zeros(n, n)
        ratios = []
        for column, r in enumerate(order):
            phi = inverse.T * vectors[:, r] * omega[column]
            shapes[:, column] = phi
            strain = lost = viscous = mp.mpf(0)
            for i, c in enumerate(self.case.coordinates):
                energy = mp.mpf(c["stiffness"]) * phi[i] ** 2
                strain += energy
                if c["viscous"] is None:
                    lost += mp.mpf(c["ratio"]) * energy
                else:
                    viscous += mp.mpf(c["viscous"]) * phi[i] ** 2
            ratios.append(lost / strain + viscous / (2 * omega[column]))
        return [w / (2 * mp.pi) for w in omega], shapes, ratios


# ---- Pinocchio ---------------------------------------------------------------------------------------------------


class Pinocchio:
    """The same case as a URDF in which every elastic coordinate is a joint."""

    def __init__(self, case):
        self.case = case
        self.text = ['<robot name="augmented"><link name="ground__"/>']
        self.count = 0
        for link in case.order:
            joint = case.above.get(link) if link != case.base else None
            at = joint["parent"] if joint else "ground__"
            if joint:
                at = self.step(at, "fixed", joint["xyz"], joint["rpy"])
                if joint["type"] != "fixed":
                    kind = "prismatic" if joint["type"] == "prismatic" else "revolute"
                    axis = np.array(joint["axis"]) / np.linalg.norm(joint["axis"])
                    if joint["name"] in case.moving:
                        # Pose and spring share the axis, so one joint serves both.
                        at = self.step(at, kind, name=joint["name"], axis=axis)
                    else:
                        held = case.held(joint)
                        if kind == "prismatic":
                            at = self.step(at, "fixed", axis * held)
                        else:
                            at = self.step(at, "fixed", rpy=pin.rpy.matrixToRpy(pin.exp3(axis * held)))
                        if joint["name"] in case.springs:
                            at = self.step(at, kind, name=joint["name"], axis=axis)
            for extra in case.extras:
                if extra["link"] == link:
                    origin = np.array(extra.get("origin_m", [0, 0, 0]), float)
                    kind = "revolute" if extra["kind"] == "rotation" else "prismatic"
                    axis = np.array(extra["axis"], float) / np.linalg.norm(extra["axis"])
                    at = self.step(at, "fixed", origin)
                    at = self.step(at, kind, name=extra["name"], axis=axis)
                    at = self.step(at, "fixed", -origin)
            self.step(at, "fixed", link=link, body=case.links[link])
        if "payload" in case.robot:
            p = case.robot["payload"]
            body = {"mass": p["mass_kg"], "xyz": p["com_m"], "rpy": [0, 0, 0], "inertia": p["inertia_kgm2"]}
            self.step(p["link"], "fixed", link="payload__", body=body)
        self.model = pin.buildModelFromXML("\n".join(self.text) + "</robot>")
        self.model.gravity.linear = np.array(case.gravity, float)
        armature = np.zeros(self.model.nv)
        for c in case.coordinates:
            armature[self.index(c["name"])] = c["drive"]
        self.model.armature = armature
        self.data = self.model.createData()
        self.elastic = [self.index(c["name"]) for c in case.coordinates]

    def step(self, parent, kind, xyz=(0, 0, 0), rpy=(0, 0, 0), name=None, axis=None, link=None, body=None):
        self.count += 1
        link = link or f"step_{self.count}__"
        name = name or f"fixed_{self.count}__"
        three = lambda v: " ".join(repr(float(x)) for x in v)
        inertial = ""
        if body and body["mass"] > 0:
            products = " ".join(f'{k}="{float(body["inertia"].get(k, 0.0))!r}"' for k in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"))
            inertial = (
                f'<inertial><origin xyz="{three(body["xyz"])}" rpy="{three(body["rpy"])}"/>'
                f'<mass value="{float(body["mass"])!r}"/><inertia {products}/></inertial>'
            )
        moves = "" if axis is None else f'<axis xyz="{three(axis)}"/><limit effort="1e9" velocity="1e9" lower="-1e3" upper="1e3"/>'
        self.text.append(
            f'<link name="{link}">{inertial}</link><joint name="{name}" type="{kind}"><parent link="{parent}"/>'
            f'<child link="{link}"/><origin xyz="{three(xyz)}" rpy="{three(rpy)}"/>{moves}</joint>'
        )
        return link

    def index(self, name):
        return self.model.joints[self.model.getJointId(name)].idx_v

    def at(self, q, tcp):
        case, model, data = self.case, self.model, self.data
        full = np.zeros(model.nq)
        for name, value in q.items():
            full[model.joints[model.getJointId(name)].idx_q] = value
        mass = pin.crba(model, data, full)
        mass = np.triu(mass) + np.triu(mass, 1).T
        pick = np.ix_(self.elastic, self.elastic)
        hessian = pin.computeGeneralizedGravityDerivatives(model, data, full)[pick].copy()
        pin.forwardKinematics(model, data, full)
        pin.updateFramePlacements(model, data)
        frame = model.getFrameId(case.tip)
        jacobian = pin.computeFrameJacobian(model, data, full, frame, pin.LOCAL_WORLD_ALIGNED)[:, self.elastic].copy()
        placed = data.oMf[frame]
        arm = placed.rotation @ np.array(tcp)
        jacobian[:3] += np.cross(jacobian[3:].T, arm).T
        return mass[pick], hessian, jacobian, placed.rotation.copy(), placed.translation.copy()


# ---- both, side by side ------------------------------------------------------------------------------------------


def doubles(matrix):
    return np.array([[float(matrix[i, j]) for j in range(matrix.cols)] for i in range(matrix.rows)])


def agree(what, found, expected, scale, limit, worst):
    difference = float(np.max(np.abs(np.asarray(found) - np.asarray(expected)) / scale))
    worst[what] = max(worst.get(what, 0.0), difference)
    assert difference < limit, f"{what}: the two computations differ by {difference}"


def solve(case, poses, tcp, worst):
    exact, peer = Exact(case), Pinocchio(case)
    springs = mp.diag([mp.mpf(c["stiffness"]) for c in case.coordinates])
    result = []
    for q in poses:
        mass = exact.mass(q)
        m = doubles(mass)
        rotation, position, (linear, angular) = exact.tip(q, tcp)
        jacobian = np.vstack([doubles(linear), doubles(angular)])
        peer_mass, peer_gravity, peer_jacobian, peer_rotation, peer_position = peer.at(q, tcp)
        scale = np.sqrt(np.outer(np.diag(m), np.diag(m)))
        agree("mass", peer_mass, m, scale, 1e-12, worst)
        agree("tip_jacobian", peer_jacobian, jacobian, 1.0, 1e-12, worst)
        agree("tip_pose", peer_rotation, doubles(rotation), 1.0, 1e-12, worst)
        agree("tip_pose", peer_position, [float(v) for v in position], 1.0, 1e-12, worst)
        stiffness = springs
        if case.with_gravity:
            hessian = exact.gravity_stiffness(q)
            largest = np.abs(doubles(hessian)).max()
            agree("gravity_stiffness", peer_gravity, doubles(hessian), largest, 1e-11, worst)
            stiffness = springs + hessian
        frequencies, shapes, ratios = exact.modes(mass, stiffness)
        f = np.array([float(v) for v in frequencies])
        square, _ = scipy.linalg.eigh(doubles(springs) + (peer_gravity if case.with_gravity else 0.0), peer_mass)
        agree("frequency", np.sqrt(square) / (2 * np.pi), f, f, 1e-9, worst)
        entry = {
            "q": q,
            "tip_position_m": [float(v) for v in position],
            "tip_rotation": doubles(rotation).tolist(),
            "mass": m.tolist(),
            "tip_jacobian": jacobian.tolist(),
            "frequencies_hz": f.tolist(),
            "damping_ratios": [float(v) for v in ratios],
            "shapes": doubles(shapes).tolist(),
        }
        if case.with_gravity:
            entry["gravity_stiffness"] = doubles(hessian).tolist()
        result.append(entry)
    return result


def random_poses(case, rng, count):
    poses = []
    for _ in range(count):
        q = {}
        for joint in case.chain:
            if joint["type"] != "fixed":
                low, high = joint["limit"] or (-3.0, 3.0)
                low, high = max(low, -3.0), min(high, 3.0)
                q[joint["name"]] = round(float(rng.uniform(low, high)), 6)
        poses.append(q)
    return poses


# ---- robots ------------------------------------------------------------------------------------------------------


def stripped(path, source):
    """A public URDF without meshes, transmissions and simulator tags."""
    root = ET.parse(path).getroot()
    for child in list(root):
        if child.tag not in ("link", "joint"):
            root.remove(child)
    for link in root.findall("link"):
        for child in list(link):
            if child.tag != "inertial":
                link.remove(child)
    for joint in root.findall("joint"):
        for child in list(joint):
            if child.tag not in ("parent", "child", "origin", "axis", "limit", "mimic"):
                joint.remove(child)
    ET.indent(root)
    return f'<?xml version="1.0"?>\n<!-- {source} Meshes, transmissions and simulator tags taken out. -->\n' + ET.tostring(root, encoding="unicode") + "\n"


def random_rotation_inertia(rng, mass):
    """A possible tensor: that of a random box, turned."""
    a, b, c = rng.uniform(0.05, 0.5, 3) ** 2
    return {k: round(float(mass / 12 * v), 6) for k, v in (("ixx", b + c), ("iyy", a + c), ("izz", a + b))}


def random_robot(rng, moving):
    """URDF and robot.yaml of a tree: a chain of `moving` joints with fixed ones between, and branches."""
    three = lambda low, high: " ".join(f"{v:.6f}" for v in rng.uniform(low, high, 3))
    links, joints = [], []

    def link(name, massless=False):
        if massless:
            links.append(f'  <link name="{name}"/>')
            return
        mass = round(float(rng.uniform(0.5, 30)), 4)
        moments = " ".join(f'{k}="{v!r}"' for k, v in random_rotation_inertia(rng, mass).items())
        links.append(
            f'  <link name="{name}"><inertial><origin xyz="{three(-0.2, 0.2)}" rpy="{three(-3, 3)}"/>'
            f'<mass value="{mass!r}"/><inertia {moments} ixy="0" ixz="0" iyz="0"/></inertial></link>'
        )

    def joint(name, kind, parent, child, limit=None):
        axis = rng.normal(size=3)
        moves = "" if kind == "fixed" else f'<axis xyz="{" ".join(f"{v:.6f}" for v in axis * rng.uniform(0.3, 3))}"/>'
        if kind in ("revolute", "prismatic"):
            low, high = limit or ((-2.9, 2.9) if kind == "revolute" else (-0.8, 0.8))
            moves += f'<limit lower="{low!r}" upper="{high!r}" effort="0" velocity="2"/>'
        joints.append(
            f'  <joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{three(-0.5, 0.5)}" rpy="{three(-3, 3)}"/>{moves}</joint>'
        )

    springs, extra, drives = {}, [], {}

    def spring(name, kind):
        stiffness = round(float(10 ** rng.uniform(4.5, 6.5)), 1)
        entry = {"stiffness_n_per_m" if kind == "prismatic" else "stiffness_nm_per_rad": stiffness}
        draw = rng.uniform()
        if draw < 0.4:
            entry["damping_ratio"] = round(float(rng.uniform(0.01, 0.08)), 4)
        elif draw < 0.6:
            key = "damping_ns_per_m" if kind == "prismatic" else "damping_nms_per_rad"
            entry[key] = round(float(rng.uniform(5, 200)), 3)
        springs[name] = entry

    link("ground")
    at = "ground"
    for i in range(1, moving + 1):
        if rng.uniform() < 0.25:
            link(f"spacer_{i}", massless=rng.uniform() < 0.5)
            joint(f"weld_{i}", "fixed", at, f"spacer_{i}")
            at = f"spacer_{i}"
        kind = str(rng.choice(["revolute", "revolute", "continuous", "prismatic"]))
        link(f"link_{i}", massless=i < moving and rng.uniform() < 0.15)
        joint(f"axis_{i}", kind, at, f"link_{i}")
        at = f"link_{i}"
        if rng.uniform() < 0.75:
            spring(f"axis_{i}", kind)
            if rng.uniform() < 0.4:
                drives[f"axis_{i}"] = {"reflected_inertia_kgm2": round(float(rng.uniform(0, 5)), 4)}
    link("tool", massless=True)
    joint("weld_tool", "fixed", at, "tool")
    for b in range(1, int(rng.integers(1, 4))):
        parent = f"link_{int(rng.integers(1, moving + 1))}"
        kind = str(rng.choice(["fixed", "revolute", "prismatic"]))
        link(f"branch_{b}")
        joint(f"branch_axis_{b}", kind, parent, f"branch_{b}", (0.1, 0.6) if rng.uniform() < 0.5 else None)
        if kind != "fixed" and rng.uniform() < 0.5:
            spring(f"branch_axis_{b}", kind)
    for e in range(int(rng.integers(0, 4))):
        where = str(rng.choice(["ground", "link_1", f"link_{moving}", f"link_{moving // 2}"]))
        extra.append(
            {
                "name": f"extra_{e}",
                "link": where,
                "kind": str(rng.choice(["rotation", "translation"])),
                "axis": [round(float(v), 4) for v in rng.normal(size=3)],
                "origin_m": [round(float(v), 4) for v in rng.uniform(-0.3, 0.3, 3)],
                "stiffness": round(float(10 ** rng.uniform(5, 7)), 1),
                "damping_ratio": round(float(rng.uniform(0.01, 0.08)), 4),
            }
        )
    robot = {"base": "ground", "tip": "tool", "elasticity": {"damping_ratio": 0.03, "joints": springs, "extra": extra}, "drives": drives}
    if rng.uniform() < 0.6:
        robot["elasticity"]["gravity"] = True
        robot["elasticity"]["gravity_m_per_s2"] = [round(float(v), 4) for v in rng.uniform(-7, 7, 3)]
    if rng.uniform() < 0.7:
        mass = round(float(rng.uniform(1, 15)), 3)
        robot["payload"] = {
            "link": str(rng.choice(["tool", f"link_{moving}"])),
            "mass_kg": mass,
            "com_m": [round(float(v), 4) for v in rng.uniform(-0.2, 0.2, 3)],
            "inertia_kgm2": random_rotation_inertia(rng, mass) | {"ixy": 0.0, "ixz": 0.0, "iyz": 0.0},
        }
    urdf = '<?xml version="1.0"?>\n<!-- Made at random by make.py. -->\n<robot name="random">\n' + "\n".join(links + joints) + "\n</robot>\n"
    return robot, urdf


UR10_JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]


def public_robots():
    """(name, robot, urdf file). Springs, payload and drives are invented: they only have to be used."""
    payload = lambda link: {
        "link": link,
        "mass_kg": 4.2,
        "com_m": [0.03, -0.02, 0.11],
        "inertia_kgm2": {"ixx": 0.021, "iyy": 0.025, "izz": 0.012, "ixy": 0.001, "ixz": -0.002, "iyz": 0.0005},
    }
    spring = lambda k, **more: {"stiffness_nm_per_rad": k, **more}
    tilt = [
        {"name": "base_tilt_x", "link": "base_link", "kind": "rotation", "axis": [1, 0, 0], "origin_m": [0, 0, -0.1], "stiffness": 3.0e5},
        {"name": "base_tilt_y", "link": "base_link", "kind": "rotation", "axis": [0, 2, 0], "origin_m": [0.02, 0, -0.1], "stiffness": 2.0e5, "damping_ratio": 0.05},
    ]
    stiffness = [3.1e4, 2.6e4, 2.2e4, 9.0e3, 8.0e3, 7.0e3]
    yield "ur10-payload-base-drives", {
        "base": "base_link",
        "tip": "tool0",
        "elasticity": {"damping_ratio": 0.025, "joints": {n: spring(k) for n, k in zip(UR10_JOINTS, stiffness)}, "extra": tilt},
        "drives": {"shoulder_lift_joint": {"reflected_inertia_kgm2": 1.7}, "wrist_1_joint": {"reflected_inertia_kgm2": 0.21}},
        "payload": payload("tool0"),
    }, "ur10.urdf"
    yield "ur10-rigid-wrist-on-a-wall", {
        "base": "base_link",
        "tip": "tool0",
        "elasticity": {
            "joints": {n: spring(k, damping_nms_per_rad=40.0) for n, k in list(zip(UR10_JOINTS, stiffness))[1:3]},
            "extra": [
                {"name": "elbow_bending", "link": "forearm_link", "kind": "rotation", "axis": [1, 0, 0], "stiffness": 5.0e4},
                {"name": "upper_arm_stretch", "link": "upper_arm_link", "kind": "translation", "axis": [0, 0, 1], "stiffness": 4.0e7},
            ],
            "gravity": True,
            "gravity_m_per_s2": [9.80665, 0.0, 0.0],
        },
        "payload": payload("wrist_3_link"),
    }, "ur10.urdf"
    panda = [f"panda_joint{i}" for i in range(1, 8)]
    yield "panda-seven-axes-gravity", {
        "tip": "panda_hand",
        "elasticity": {
            "damping_ratio": 0.04,
            "joints": {n: spring(k) for n, k in zip(panda, [1.4e4, 1.4e4, 1.2e4, 1.2e4, 6.0e3, 6.0e3, 5.0e3])},
            "extra": [{"name": "foot", "link": "panda_link0", "kind": "translation", "axis": [1, 1, 0], "stiffness": 8.0e5}],
            "gravity": True,
        },
        "drives": {"panda_joint4": {"reflected_inertia_kgm2": 0.6}},
        "payload": payload("panda_hand"),
    }, "panda.urdf"
    yield "panda-upper-part", {
        "base": "panda_link2",
        "tip": "panda_link8",
        "elasticity": {"joints": {n: spring(9.0e3) for n in panda[3:]}},
    }, "panda.urdf"


def main():
    rng = np.random.default_rng(20230060)
    tcp = [0.012, -0.034, 0.15]
    summary = {"made_with": {"pinocchio": pin.__version__, "mpmath": mp.__version__, "digits": mp.mp.dps}, "cases": {}}
    (HERE / "ur10.urdf").write_text(stripped(PUBLIC / "ur_description/urdf/ur10_robot.urdf", "Universal Robots UR10, from ROS-Industrial ur_description; see SOURCES.md."))
    (HERE / "panda.urdf").write_text(stripped(PUBLIC / "panda_description/urdf/panda.urdf", "Franka Emika Panda, from franka_description; see SOURCES.md."))
    cases = [(name, robot, urdf, None) for name, robot, urdf in public_robots()]
    for number, moving in enumerate([3, 5, 6, 6, 7, 7, 8, 9], start=1):
        robot, urdf = random_robot(rng, moving)
        name = f"random-{number}-{moving}-axes"
        (HERE / f"{name}.urdf").write_text(urdf)
        cases.append((name, robot, f"{name}.urdf", None))
    for own in ("irb1600", "rail-mill"):
        cases.append((own, yaml.safe_load((ROBOTS / own / "robot.yaml").read_text()), None, own))
    for name, robot, urdf, own in cases:
        if own is None:
            robot = {"name": name, "urdf": urdf, **robot}
            path = HERE / f"{name}.yaml"
            path.write_text("# Made by make.py.\n" + yaml.safe_dump(robot, sort_keys=False, allow_unicode=True, width=110))
            robot = yaml.safe_load(path.read_text())
            text, file = (HERE / urdf).read_text(), path.name
        else:
            text, file = (ROBOTS / own / robot["urdf"]).read_text(), f"../../../robots/{own}/robot.yaml"
        case, worst = Case(robot, text), {}
        poses = random_poses(case, rng, 3)
        reference = {
            "robot": file,
            "tcp_m": tcp,
            "joints": case.moving,
            "coordinates": [c["name"] for c in case.coordinates],
            "poses": solve(case, poses, tcp, worst),
        }
        (HERE / f"{name}.json").write_text(json.dumps(reference) + "\n")
        summary["cases"][name] = {"coordinates": len(case.coordinates), "peers_differ_by": worst}
        print(f"{name:28} n = {len(case.coordinates):2}  " + "  ".join(f"{k} {v:.1e}" for k, v in worst.items()))
    (HERE / "summary.json").write_text(json.dumps(summary, indent=2) + "\n")


if __name__ == "__main__":
    main()
