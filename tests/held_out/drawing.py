"""Robots and jobs drawn at random: trees and industrial arms, every kind of joint, coordinate and policy."""

import math

import numpy as np
from mechanics import Robot, frame, rotation_exp, rpy_angles
from paths import JointPath, PosePath, joints_of, lines_of, poses_of, rpm_of

# The widest range of spindle speeds that a job may have.
MOST_RPM = 1_000_000


def draw_inertia(rng, mass, size):
    """A tensor of a cloud of points: always physical."""
    points = rng.normal(size=(8, 3)) * size * rng.uniform(0.3, 1, 3)
    points -= points.mean(axis=0)
    i = mass / 8 * sum(np.dot(p, p) * np.eye(3) - np.outer(p, p) for p in points)
    return {"ixx": i[0, 0], "iyy": i[1, 1], "izz": i[2, 2], "ixy": i[0, 1], "ixz": i[0, 2], "iyz": i[1, 2]}


def draw_link(rng, name, mass, size):
    return {
        "name": name,
        "mass": float(mass),
        "com": list(rng.normal(size=3) * size * 0.4),
        "rpy": list(rng.uniform(-3, 3, 3)),
        "inertia": draw_inertia(rng, mass, size * 0.5),
    }


def draw_pose(robot, rng, reach):
    low, high = np.maximum(robot.lower, -reach), np.minimum(robot.upper, reach)
    q = rng.uniform(low, high)
    return np.where(robot.slides, np.clip(rng.uniform(-0.3, 0.3, len(q)), robot.lower, robot.upper), q)


def draw_elasticity(rng, links, joints, yaml, stiff=1e5):
    """Springs, extra coordinates, drives, payload: into yaml."""
    moving = [j for j in joints if j["type"] != "fixed" and not j.get("branch")]
    springs, drives = {}, {}
    size = stiff
    for i, j in enumerate(moving):
        if rng.random() < 0.15 and not (i == len(moving) - 1 and not springs):
            continue  # rigid
        k = size * math.exp(rng.normal() * 0.7) * 0.6**i
        spring = {"stiffness_n_per_m": 30 * k} if j["type"] == "prismatic" else {"stiffness_nm_per_rad": k}
        if rng.random() < 0.6:
            spring["damping_ratio"] = float(rng.uniform(0.005, 0.09))
        if rng.random() < 0.2:
            spring["source"] = "drawn: a # b"
        springs[j["name"]] = spring
        if rng.random() < 0.35:
            drives[j["name"]] = {"reflected_inertia_kgm2": float(rng.uniform(0, 3))}
    extra = []
    spots = [j["child"] for j in joints] + [joints[0]["parent"]]
    for i in range(int(rng.integers(0, 4))):
        link = str(rng.choice(spots)) if rng.random() < 0.6 else yaml.get("base", joints[0]["parent"])
        turns = rng.random() < 0.6
        entry = {
            "name": f"extra_{i}",
            "link": link,
            "kind": "rotation" if turns else "translation",
            "axis": list(rng.normal(size=3) * 2),
            "stiffness": float(size * rng.uniform(0.3, 4) * (1 if turns else 20)),
        }
        if rng.random() < 0.6:
            entry["origin_m"] = list(rng.normal(size=3) * 0.2)
        if rng.random() < 0.5:
            entry["damping_ratio"] = float(rng.uniform(0.01, 0.08))
        extra.append(entry)
    yaml["elasticity"] = {"joints": springs, "extra": extra}
    if rng.random() < 0.6:
        yaml["elasticity"]["damping_ratio"] = float(rng.uniform(0.01, 0.05))
    if rng.random() < 0.4:
        yaml["elasticity"]["gravity"] = True
    if drives:
        yaml["drives"] = drives


def draw_payload(rng, link, mass):
    payload = {"link": link, "mass_kg": float(mass), "com_m": list(rng.normal(size=3) * 0.1)}
    if rng.random() < 0.7:
        payload["inertia_kgm2"] = draw_inertia(rng, mass, 0.08)
    return payload


def usable(robot, rng):
    """Nothing singular or indefinite over the poses that jobs may ask for, frequencies a machine may have."""
    q = np.array([draw_pose(robot, rng, 3.0) for _ in range(200)])
    m, k, *_ = robot.matrices(q)
    d = np.sqrt(np.einsum("kii->ki", m))
    scaled = m / (d[:, :, None] * d[:, None, :])
    if not np.isfinite(scaled).all() or np.linalg.eigvalsh(scaled).min() < 1e-7 or np.linalg.eigvalsh(k / np.sqrt(np.outer(robot.k, robot.k))).min() < 0.05:
        return False
    f = robot.frequencies(q)
    return 1.0 < f.min() and f[:, 0].max() < 300


def draw_random_robot(rng):
    """Any tree: 6 or 7 moving joints of all kinds, fixed joints between, branches, links without mass."""
    while True:
        links, joints = [draw_link(rng, "root", 40, 0.3)], []
        above_base = rng.random() < 0.25
        parent = "root"
        yaml = {"name": "Drawn", "urdf": "robot.urdf"}
        if above_base:
            links.append(draw_link(rng, "plinth", 20, 0.2))
            kind = str(rng.choice(["fixed", "revolute"]))
            joints.append(draw_joint(rng, "mount", kind, "root", "plinth", branch=True))
            yaml["base"] = parent = "plinth"
        count = int(rng.choice([6, 7]))
        slides = set(rng.choice(count, size=int(rng.choice([0, 0, 1, 1, 2])), replace=False).tolist())
        moving_branch = False
        for i in range(count):
            kind = "prismatic" if i in slides else str(rng.choice(["revolute", "continuous"], p=[0.75, 0.25]))
            name = f"arm_{i + 1}"
            massless = i < count - 1 and rng.random() < 0.15
            links.append({"name": name} if massless else draw_link(rng, name, 60 * 0.65**i * rng.uniform(0.5, 1.5), 0.4))
            joints.append(draw_joint(rng, f"axis {i + 1}" if rng.random() < 0.2 else f"axis_{i + 1}", kind, parent, name))
            parent = name
            if rng.random() < 0.2:
                fixed = f"flange_{i + 1}"
                links.append(draw_link(rng, fixed, 2, 0.1) if rng.random() < 0.5 else {"name": fixed})
                joints.append(draw_joint(rng, f"fix_{i + 1}", "fixed", parent, fixed))
                parent = fixed
            if rng.random() < 0.25:
                side = f"side_{i + 1}"
                kind = str(rng.choice(["fixed", "revolute", "prismatic", "continuous"]))
                moving_branch |= kind != "fixed"
                links.append(draw_link(rng, side, 4, 0.2))
                joints.append(draw_joint(rng, f"branch_{i + 1}", kind, name, side, branch=True))
        last_moving = f"arm_{count}"
        chain_tip = parent
        choice = rng.random()
        if moving_branch or choice < 0.5:
            yaml["tip"] = chain_tip if rng.random() < 0.7 else last_moving
        elif choice < 0.6:
            yaml["tip"] = f"arm_{count - 1}"  # in mid-chain: what lies beyond is carried
        draw_elasticity(rng, links, [j for j in joints if not (above_base and j["name"] == "mount")], yaml)
        carried = [l["name"] for l in links if not (above_base and l["name"] == "root")]
        if rng.random() < 0.5:
            yaml["payload"] = draw_payload(rng, str(rng.choice(carried)), rng.uniform(1, 12))
        if rng.random() < 0.3:
            yaml["calibration"] = {"poses": 20, "heldout_rms_percent": float(rng.uniform(0.5, 6)), "date": "2026-11-21"}
        robot = Robot(links, joints, yaml)
        if rng.random() < 0.5:
            turning = [n for n, slides in zip(robot.names, robot.slides) if not slides]
            yaml["arm_angles"] = {"beta2": {"terms": {turning[0]: -1.0, turning[-1]: 0.5}, "offset_rad": 0.25}}
        if len(robot.moving) >= 5 and usable(robot, rng):
            return robot


def draw_joint(rng, name, kind, parent, child, branch=False):
    joint = {
        "name": name,
        "type": kind,
        "parent": parent,
        "child": child,
        "xyz": list(rng.normal(size=3) * 0.25),
        "rpy": list(rng.uniform(-3, 3, 3)),
        "axis": list(rng.normal(size=3)),
    }
    if kind != "fixed":
        joint["velocity"] = float(rng.uniform(0.5, 4))
    if kind == "revolute":
        joint["lower"], joint["upper"] = (float(rng.uniform(0.1, 0.4)), 2.0) if branch and rng.random() < 0.5 else (-3.2, 3.2)
    if kind == "prismatic":
        joint["lower"], joint["upper"] = -0.6, 0.6
    if branch:
        joint["branch"] = True
    return joint


def draw_arm(rng, spherical):
    """An industrial 6R arm: the IRB 1600's figures, or one with a wrist whose axes do not meet."""
    while True:
        off = np.zeros(6) if spherical else rng.choice([0.0, 0.06, -0.08], size=6, p=[0.2, 0.5, 0.3])
        stretch = 1.0 if spherical and rng.random() < 0.5 else rng.uniform(0.8, 1.2)
        origins = [
            [0, 0, 0],
            [0.15, off[0], 0.4865],
            [0, off[1], 0.7 * stretch],
            [0.3, 0, off[2]],
            [0.3 * stretch, 0, 0 if spherical else 0.07],
            [0.065, 0, 0 if spherical else -0.05],
        ]
        if not spherical:
            origins[5][1] = 0.09
        axes = [[0, 0, 1], [0, 1, 0], [0, 1, 0], [1, 0, 0], [0, 1, 0], [1, 0, 0]]
        limits = [(-180, 180), (-90, 120), (-245, 65), (-200, 200), (-115, 115), (-400, 400)]
        speeds = [180, 180, 185, 385, 400, 460]
        masses = [70, 25, 34, 6, 3, 1]
        links, joints = [draw_link(rng, "base_link", 110, 0.3)], []
        for i in range(6):
            parent = "base_link" if i == 0 else f"link_{i}"
            links.append(draw_link(rng, f"link_{i + 1}", masses[i] * rng.uniform(0.7, 1.4), [0.3, 0.4, 0.25, 0.2, 0.1, 0.08][i]))
            joints.append(
                {
                    "name": f"joint_{i + 1}",
                    "type": "revolute",
                    "parent": parent,
                    "child": f"link_{i + 1}",
                    "xyz": [float(v) for v in origins[i]],
                    "rpy": [0, 0, 0],
                    "axis": axes[i],
                    "lower": math.radians(limits[i][0]),
                    "upper": math.radians(limits[i][1]),
                    "velocity": math.radians(speeds[i]),
                }
            )
        links.append({"name": "tool0"})
        joints.append({"name": "flange", "type": "fixed", "parent": "link_6", "child": "tool0", "xyz": [0, 0, 0], "rpy": [0, math.pi / 2, 0]})
        yaml = {"name": "Arm", "urdf": "robot.urdf", "base": "base_link", "tip": "tool0"}
        draw_elasticity(rng, links, joints, yaml, stiff=5e5)
        if rng.random() < 0.6:
            yaml["payload"] = draw_payload(rng, "tool0", rng.uniform(1, 8))
        robot = Robot(links, joints, yaml)
        if usable(robot, rng):
            return robot


def draw_policy(rng):
    policy = {"min_tip_response_um_per_n": 0}
    if rng.random() < 0.6:
        policy["tooth_passing_harmonics"] = int(rng.integers(1, 4))
    if rng.random() < 0.6:
        policy["spindle_harmonics"] = int(rng.integers(0, 4))
    if rng.random() < 0.7:
        policy["separation_percent"] = float(rng.choice([1, 3, 5, 10, 20]))
    if rng.random() < 0.6:
        policy["model_uncertainty_percent"] = float(rng.choice([0, 0.5, 4, 9]))
    return policy


def draw_job(rng, robot, posed):
    """A job that the arm can run: along poses (a six-axis arm) or joint positions."""
    job = {"name": "Drawn: job", "robot": "robot.yaml", "tool": {"teeth": int(rng.integers(1, 7))}}
    if rng.random() < 0.75:
        job["tcp"] = {"xyz_m": list(rng.normal(size=3) * 0.1), "rpy_rad": list(rng.uniform(-1, 1, 3))}
    if posed or rng.random() < 0.3:
        job["work_object"] = {"xyz_m": list(rng.uniform(-0.3, 0.3, 3)), "rpy_rad": list(rng.uniform(-2, 2, 3))}
    job["spindle"] = {"min_rpm": 1, "max_rpm": MOST_RPM}
    job["policy"] = draw_policy(rng)
    tcp = frame(job.get("tcp"))
    job["operations"] = []
    for i in range(int(rng.choice([1, 1, 2, 3]))):
        operation = {"name": f"op {i + 1}", "feed_mm_per_min": float(round(math.exp(rng.uniform(4, 9)), 1))}
        if posed:
            operation["path"], start = draw_pose_path(rng, robot, job, tcp)
            path = PosePath(robot, poses_of(job, operation["path"]["poses"]), operation["feed_mm_per_min"] / 60000, tcp, start)
            if not path.ok or path.least_singular < 0.02:
                return draw_job(rng, robot, posed)
        else:
            operation["path"] = draw_joint_path(rng, robot)
            path = JointPath(robot, joints_of(robot, operation["path"]["joints_deg"]), operation["feed_mm_per_min"] / 60000, tcp)
        draw_speed(rng, robot, job, operation, path)
        job["operations"].append(operation)
    draw_filters(rng, robot, job, path, tcp)
    return job


def draw_joint_path(rng, robot):
    count = int(rng.choice([1, 2, 2, 3, 5, 12, 40]))
    q = draw_pose(robot, rng, 1.5)
    step = rng.choice([0.05, 0.3, 1.0])
    rows = [q]
    for _ in range(count - 1):
        choice = rng.random()
        if choice < 0.08:
            new = rows[-1].copy()  # repeated
        elif choice < 0.25:
            new = rows[-1].copy()
            i = int(rng.integers(len(q)))
            new[i] += rng.normal() * step * (0.3 if robot.slides[i] else 1)
        else:
            new = rows[-1] + rng.normal(size=len(q)) * step * np.where(robot.slides, 0.3, 1)
        rows.append(np.clip(new, np.maximum(robot.lower, -6) + 0.01, np.minimum(robot.upper, 6) - 0.01))
    rows = np.array(rows)
    shown = np.where(robot.slides, 1000 * rows, np.degrees(rows)).round(int(rng.choice([1, 3, 9])))
    return {"joints_deg": shown.tolist()}


def draw_pose_path(rng, robot, job, tcp):
    """A zigzag around a place that the arm reaches well."""
    start = np.array([rng.uniform(-1, 1), rng.uniform(-0.3, 0.8), rng.uniform(-0.5, 0.7), rng.uniform(-1, 1), rng.uniform(0.5, 1.3) * rng.choice([-1, 1]), rng.uniform(-2, 2)])
    r, p, _ = robot.tool(start[None], *tcp)
    r, p = r[0], p[0]
    rw, pw = frame(job.get("work_object"))
    rows = []
    for i in range(int(rng.choice([2, 3, 5, 9]))):
        if i:
            choice = rng.random()
            if choice > 0.12:
                p = p + rng.normal(size=3) * 0.08
            if choice < 0.6:
                r = r @ rotation_exp(rng.normal(size=3) * 0.12)
        angles = np.degrees(rpy_angles(rw.T @ r))
        rows.append({"xyz_mm": (1000 * (rw.T @ (p - pw))).tolist(), "rpy_deg": angles.tolist()})
    # The first row is rounded by its text only; the start solves it.
    goal = poses_of(job, rows[:1])[0]
    q, _ = robot.solve_pose(goal[0][None], goal[1][None], *tcp, start[None])
    return {"poses": rows}, q[0]


def draw_speed(rng, robot, job, operation, path):
    """A speed at which some line comes near some mode somewhere, or just touches a band."""
    s = np.linspace(0, 1, 401)
    f = robot.frequencies(path.at(s))
    line = lines_of(job)[int(rng.integers(len(lines_of(job))))]
    r = int(rng.integers(robot.n)) if rng.random() < 0.5 else 0
    separation = job["policy"].get("separation_percent", 10) / 100
    wide = separation + job["policy"].get("model_uncertainty_percent", robot.uncertainty) / 100
    choice = rng.random()
    if choice < 0.3:
        # The edge of a band just touched, near the highest or the lowest point of the mode.
        edge = float(rng.choice([separation, wide]))
        if rng.random() < 0.5:
            peak = int(f[:, r].argmax())
            shift = max(peak - 1, 0) if peak else 1
            near = f[peak, r] + (f[shift, r] - f[peak, r]) * rng.uniform(0.02, 0.5)
            hz = near * (1 + edge)
        else:
            dip = int(f[:, r].argmin())
            shift = max(dip - 1, 0) if dip else 1
            near = f[dip, r] + (f[shift, r] - f[dip, r]) * rng.uniform(0.02, 0.5)
            hz = near * (1 - edge)
    else:
        hz = f[int(rng.integers(len(s))), r] * rng.uniform(0.8, 1.2)
    if len(np.unique(f[:, r])) == 1:
        hz *= 1 + 1e-7  # nothing moves: not on an edge itself, where rounding decides
    rpm = float(np.clip(60 * hz / line[2], 2, 0.95 * MOST_RPM))
    if choice < 0.75:
        operation["spindle_rpm"] = rpm
    else:
        points = np.sort(rng.uniform(0.02, 0.98, int(rng.integers(0, 4))))
        points = [0.0, *map(float, points), 1.0]
        operation["spindle_schedule"] = [{"s": p, "rpm": float(np.clip(rpm * rng.uniform(0.7, 1.4), 1, MOST_RPM))} for p in points]


def draw_filters(rng, robot, job, path, tcp):
    operation = job["operations"][-1]
    if rng.random() < 0.3:
        line = lines_of(job)[0]
        hz = line[2] * rpm_of(operation, np.array([0.5]))[0] / 60
        job["policy"]["ignore_hz"] = [[hz * 0.97, hz * 1.01], [hz * 1.49, hz * 1.61]]
    if rng.random() < 0.3:
        _, _, tip = robot.modes(path.at(np.linspace(0, 1, 101)), tcp[1])
        job["policy"]["min_tip_response_um_per_n"] = 1.0003 * float(np.median(tip[:, int(rng.integers(robot.n))]))
