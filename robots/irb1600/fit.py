#!/usr/bin/env python3
"""Fits the masses of irb1600.urdf to the measured frequencies of its planar section, and writes the file.

    python -m venv /some/where && /some/where/bin/pip install numpy scipy
    /some/where/bin/python robots/irb1600/fit.py            # writes irb1600.urdf, prints the figures

Measured: ../two-link/measured.csv (Pietruś & Gierlak 2023, DOI 10.2478/ama-2023-0060, Table 2). The section
has two springs, k2 and k3 of the paper's Table 1, and the wrist straight (q4 = q5 = q6 = 0). With
upper arm = link_2 and forearm = link_3 ... link_6 as one body of mass m, centre (x, z) from the elbow,

    M = [[a1 + 2 a2 cos(beta2 + delta), a3 + a2 cos(beta2 + delta)], [.., a3]]
    a1 = I_A + a3 + m l^2,  a2 = m l hypot(x, z),  a3 = inertia about the elbow,  delta = atan2(z, x)

which is the paper's Eqs. (30) and (33) with the forearm's centre of mass allowed off its axis by delta.
"""

import csv
import pathlib

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import least_squares

HERE = pathlib.Path(__file__).resolve().parent
UPPER_ARM_M = 0.700  # kinematics
STIFFNESS = np.array([555000.0, 138000.0])  # Table 1, N·m/rad
# Assumed, as in robot.yaml; joints 2 and 3 from the paper.
SIX_STIFFNESSES = np.array([6.0e5, 5.55e5, 1.38e5, 6.0e4, 5.0e4, 4.0e4])
TOTAL_KG = 250.0  # ABB data sheet PR10282EN
LINK_1_KG = 70.0  # assumed

# Where each link's frame lies along the straight forearm, m from the elbow.
ALONG_FOREARM = {"link_3": 0.0, "link_4": 0.3, "link_5": 0.6, "link_6": 0.665}

# (link, quantity): lowest, assumed nominal, highest. kg; m in the link's frame; radius of gyration about y in m.
# Bounds: the body must fit into the link's housing (upper arm 0.7 m; elbow housing with the motors of axes
# 4 to 6; forearm tube; wrist; flange).
UNKNOWNS = {
    ("link_2", "mass"): (10.0, 20.0, 40.0),
    ("link_2", "z"): (0.20, 0.32, 0.45),
    ("link_2", "gyration"): (0.20, 0.22, 0.30),
    ("link_3", "mass"): (6.0, 20.0, 40.0),
    ("link_3", "x"): (-0.20, -0.05, 0.15),
    ("link_3", "z"): (0.0, 0.04, 0.10),
    ("link_3", "gyration"): (0.08, 0.15, 0.22),
    ("link_4", "mass"): (3.0, 8.0, 15.0),
    ("link_4", "x"): (0.0, 0.12, 0.22),
    ("link_4", "gyration"): (0.08, 0.13, 0.16),
    ("link_5", "mass"): (2.0, 4.0, 6.0),
    ("link_5", "x"): (0.0, 0.01, 0.04),
    ("link_5", "gyration"): (0.04, 0.06, 0.08),
    ("link_6", "mass"): (0.3, 0.6, 1.5),
    ("link_6", "x"): (-0.02, -0.01, 0.0),
    ("link_6", "gyration"): (0.02, 0.03, 0.04),
}
# The frequencies fix four numbers, the links have sixteen: the rest is held near the nominal by this weight,
# small enough to cost nothing in the fit (it moves the rms by 1e-11).
PULL = 3e-3

# Moments about x and z as shares of that about y: by the shape of the housing (assumed).
SHAPE = {
    "link_2": (1.0, 0.25),  # long in z
    "link_3": (0.8, 1.0),
    "link_4": (0.25, 1.0),  # long in x
    "link_5": (0.8, 1.0),
    "link_6": (1.6, 1.0),  # a disc about x
}


def measured():
    with open(HERE.parent / "two-link" / "measured.csv", encoding="utf-8") as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        return np.array(
            [[float(r["beta2_rad"]), float(r["f1_hz"]), float(r["f2_hz"])] for r in rows if r["f1_hz"]]
        )


def section_frequencies(a1, a2, a3, angle):
    """Eq. (45), Hz, shape (2, len(angle)); NaN where M is not positive."""
    k1, k2 = STIFFNESS
    cosine = np.cos(angle)
    d1 = a1 * k2 + 2 * a2 * k2 * cosine + a3 * k1
    d2 = a1 * a3 - a3**2 - (a2 * cosine) ** 2
    with np.errstate(invalid="ignore"):
        root = np.sqrt((d1 / d2 / 2) ** 2 - k1 * k2 / d2)
        return np.sqrt(np.array([d1 / d2 / 2 - root, d1 / d2 / 2 + root])) / (2 * np.pi)


def errors(parameters, data):
    a1, a2, a3, delta = parameters
    return (section_frequencies(a1, a2, a3, data[:, 0] + delta) / data[:, 1:].T - 1).ravel()


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def lumped(x):
    value = dict(zip(UNKNOWNS, x))
    mass = first_x = first_z = second = 0.0
    for link, along in ALONG_FOREARM.items():
        m = value[link, "mass"]
        px, pz = along + value[link, "x"], value.get((link, "z"), 0.0)
        mass += m
        first_x += m * px
        first_z += m * pz
        second += m * (value[link, "gyration"] ** 2 + px**2 + pz**2)
    upper = value["link_2", "mass"] * (value["link_2", "gyration"] ** 2 + value["link_2", "z"] ** 2)
    a1 = upper + second + mass * UPPER_ARM_M**2
    return a1, UPPER_ARM_M * np.hypot(first_x, first_z), second, np.arctan2(first_z, first_x)


def best_of(problem, starts, **options):
    """The best local minimum over many starts."""
    best = None
    for x0 in starts:
        try:
            found = least_squares(problem, x0, xtol=1e-14, ftol=1e-14, gtol=1e-14, max_nfev=3000, **options)
        except ValueError:  # a start where M is not positive
            continue
        if best is None or found.cost < best.cost:
            best = found
    return best.x


def unconstrained(data, with_angle):
    """The best a1, a2, a3 (and delta) whatever body they may belong to."""
    rng = np.random.default_rng(1)
    size = 4 if with_angle else 3
    starts = [np.array([rng.uniform(10, 45), rng.uniform(0.5, 5), rng.uniform(1, 8), 0.1])[:size] for _ in range(60)]
    pad = lambda a: a if with_angle else np.append(a, 0.0)
    found = pad(best_of(lambda a: errors(pad(a), data), starts))
    return found, rms(errors(found, data))


def six_axis_modes(bodies, q):
    """Frequencies in Hz and shapes of all six springs: M as the sum of Jᵀ I J over the bodies."""
    origins = [(0, 0, 0), (0.15, 0, 0.4865), (0, 0, 0.7), (0.3, 0, 0), (0.3, 0, 0), (0.065, 0, 0)]
    axes = [(0, 0, 1), (0, 1, 0), (0, 1, 0), (1, 0, 0), (0, 1, 0), (1, 0, 0)]
    rotation, position = np.eye(3), np.zeros(3)
    seen, mass = [], np.zeros((6, 6))
    for i, (origin, axis, angle) in enumerate(zip(origins, axes, q)):
        position = position + rotation @ np.array(origin, float)
        axis = np.array(axis, float)
        seen.append((rotation @ axis, position))
        cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
        rotation = rotation @ (np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross)
        m, com, moments = bodies[f"link_{i + 1}"]
        centre = position + rotation @ com
        linear, angular = np.zeros((3, 6)), np.zeros((3, 6))
        for j, (direction, point) in enumerate(seen):
            linear[:, j] = np.cross(direction, centre - point)
            angular[:, j] = direction
        mass += m * linear.T @ linear + angular.T @ rotation @ np.diag(moments) @ rotation.T @ angular
    square, shapes = eigh(np.diag(SIX_STIFFNESSES), mass)
    return np.sqrt(square) / (2 * np.pi), shapes


def in_plane_of_six(bodies, data):
    """The two lowest modes that move axes 2 and 3, for the measured poses (beta1 = 120 deg)."""
    found = []
    for beta2 in data[:, 0]:
        hz, shapes = six_axis_modes(bodies, [0, -np.pi / 6, -beta2 - np.pi / 2, 0, 0, 0])
        energy = SIX_STIFFNESSES[:, None] * shapes**2
        share = (energy / energy.sum(axis=0))[[1, 2, 4]].sum(axis=0)
        found.append(hz[share > 0.5][:2])
    return np.array(found).T


def rounded(x):
    digits = {"mass": 2, "x": 3, "z": 3, "gyration": 4}
    return np.array([round(value, digits[quantity]) for (_, quantity), value in zip(UNKNOWNS, x)])


def bodies_of(x):
    """link -> mass, centre of mass, moments about it (x, y, z)."""
    value = dict(zip(UNKNOWNS, x))
    bodies = {}
    for link, (share_x, share_z) in SHAPE.items():
        m = value[link, "mass"]
        about_y = round(m * value[link, "gyration"] ** 2, 5)
        com = np.array([value.get((link, "x"), 0.0), 0.0, value.get((link, "z"), 0.0)])
        bodies[link] = (m, com, np.round([share_x * about_y, about_y, share_z * about_y], 5))
    # Assumed: column with the motors of axes 1 and 2, as a block of 0.45 x 0.40 x 0.50 m.
    bodies["link_1"] = (LINK_1_KG, np.array([0.05, 0.0, 0.33]), np.array([2.4, 2.6, 2.1]))
    rest = round(TOTAL_KG - sum(m for m, _, _ in bodies.values()), 2)
    # Assumed: foot, as a block of 0.50 x 0.50 x 0.30 m. It stands still unless the foundation gives.
    bodies["base_link"] = (rest, np.array([-0.03, 0.0, 0.13]), np.round(rest * np.array([0.028, 0.028, 0.042]), 2))
    return bodies


ORIGIN = {
    "base_link": "mass: data sheet (250 kg in all) less the other links; the rest assumed. Stands still.",
    "link_1": "assumed: column with the motors of axes 1 and 2.",
    "link_2": "fitted: iyy + mass z^2 about axis 2; split, ixx and izz assumed.",
    "link_3": "fitted with links 4 to 6 as one body; split, ixx and izz assumed. Elbow with the motors of axes 4 to 6.",
    "link_4": "fitted with links 3, 5 and 6; split, ixx and izz assumed.",
    "link_5": "fitted with links 3, 4 and 6; split, ixx and izz assumed.",
    "link_6": "fitted with links 3 to 5; split, ixx and izz assumed. Flange without tool.",
}

# name, origin, axis, limits in deg, speed in deg/s (IRB 1600-x/1.45 and 10/1.45)
JOINTS = [
    ("joint_1", "0 0 0", "0 0 1", (-180, 180), 180),
    ("joint_2", "0.15 0 0.4865", "0 1 0", (-90, 120), 180),
    ("joint_3", "0 0 0.700", "0 1 0", (-245, 65), 185),
    ("joint_4", "0.3 0 0", "1 0 0", (-200, 200), 385),
    ("joint_5", "0.3 0 0", "0 1 0", (-115, 115), 400),
    ("joint_6", "0.065 0 0", "1 0 0", (-400, 400), 460),
]

HEAD = """<?xml version="1.0" encoding="UTF-8"?>
<!--
  ABB IRB 1600-x/1.45. Written by fit.py; change it there.

  Kinematics (origins, axes) and limits: data, as in ROS-Industrial's abb_irb1600_support and the data sheet.
  Speeds: data sheet of the IRB 1600-10/1.45. Whole mass, 250 kg: data sheet PR10282EN.
  Masses and inertias of single links are NOT published by the maker. What stands here is fitted to measured
  frequencies (Pietruś & Gierlak 2023, DOI 10.2478/ama-2023-0060, Table 2) or assumed, as each link says.
-->
<robot name="irb1600">
"""


def urdf(bodies):
    text = [HEAD]
    for link in ["base_link"] + [f"link_{i}" for i in range(1, 7)]:
        m, com, moments = bodies[link]
        ixx, iyy, izz = moments
        text.append(
            f"""  <!-- {ORIGIN[link]} -->
  <link name="{link}">
    <inertial>
      <origin xyz="{com[0]:g} {com[1]:g} {com[2]:g}" rpy="0 0 0"/>
      <mass value="{m:g}"/>
      <inertia ixx="{ixx:g}" ixy="0" ixz="0" iyy="{iyy:g}" iyz="0" izz="{izz:g}"/>
    </inertial>
  </link>

"""
        )
    text.append('  <link name="tool0"/>\n\n')
    parent = "base_link"
    for i, (name, origin, axis, (lower, upper), speed) in enumerate(JOINTS):
        child = f"link_{i + 1}"
        low, high, fast = (repr(float(np.deg2rad(v))) for v in (lower, upper, speed))
        text.append(
            f"""  <joint name="{name}" type="revolute">
    <parent link="{parent}"/>
    <child link="{child}"/>
    <origin xyz="{origin}" rpy="0 0 0"/>
    <axis xyz="{axis}"/>
    <!-- {lower}..{upper} deg, {speed} deg/s -->
    <limit effort="0" lower="{low}" upper="{high}" velocity="{fast}"/>
  </joint>

"""
        )
        parent = child
    text.append(
        f"""  <joint name="link_6-tool0" type="fixed">
    <parent link="link_6"/>
    <child link="tool0"/>
    <origin xyz="0 0 0" rpy="0 {np.pi / 2!r} 0"/>
  </joint>
</robot>
"""
    )
    return "".join(text)


def main():
    data = measured()
    plain, plain_rms = unconstrained(data, with_angle=False)
    free, free_rms = unconstrained(data, with_angle=True)
    print(f"poses {len(data)}, modes 2, k = {STIFFNESS}")
    print(f"unconstrained (a1, a2, a3)        = {plain[:3].round(4)}  rms {100 * plain_rms:.4f} %")
    print(f"unconstrained (a1, a2, a3, delta) = {free.round(4)}  rms {100 * free_rms:.4f} %")

    low, nominal, high = np.array(list(UNKNOWNS.values())).T
    span = high - low
    rng = np.random.default_rng(2)
    starts = [low + span * rng.uniform(0.05, 0.95, len(low)) for _ in range(24)]
    problem = lambda x: np.append(errors(lumped(x), data), PULL * (x - nominal) / span)
    exact = best_of(problem, starts, bounds=(low, high), x_scale=span)
    print(f"links within bounds               = {np.round(lumped(exact), 4)}  rms {100 * rms(errors(lumped(exact), data)):.4f} %")
    x = rounded(exact)
    attained = errors(lumped(x), data).reshape(2, -1)
    print(f"rounded as written                = {np.round(lumped(x), 4)}  rms {100 * rms(attained):.4f} %")
    print(f"  by mode: {[round(100 * rms(mode), 3) for mode in attained]} %, worst {100 * np.abs(attained).max():.2f} %")
    bodies = bodies_of(x)
    six = in_plane_of_six(bodies, data) / data[:, 1:].T - 1
    print(f"six axes elastic, in-plane modes: rms {100 * rms(six):.4f} %, by mode {[round(100 * rms(mode), 3) for mode in six]} %")
    (HERE / "irb1600.urdf").write_text(urdf(bodies), encoding="utf-8")
    print(f"mass in all {sum(m for m, _, _ in bodies.values()):.2f} kg")
    hz, _ = six_axis_modes(bodies, [0, -np.pi / 6, -np.pi, 0, 0, 0])
    print(f"six axes at beta1 = 120 deg, beta2 = 90 deg: {hz.round(2)} Hz")


if __name__ == "__main__":
    main()
