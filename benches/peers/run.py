#!/usr/bin/env python3
"""detune's batch kernel and Pinocchio with Eigen, side by side: same robot, same poses, one run, one thread.

    python3 benches/peers/run.py [--poses 20000] [--rounds 5]

Makes its own virtual environment under target/peers (the pin wheel from PyPI holds Pinocchio's headers, cmeel-eigen
Eigen's), compiles pinocchio.cpp with -O3 -march=native, builds the bench `kernel`, and runs all programs in turn,
round after round. Results are compared before a time is printed: frequencies to 1e-9 of themselves, compliances of
the tool to 1e-9 of a pose's largest.
"""

import argparse
import datetime
import json
import pathlib
import platform
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
PEERS = ROOT / "target" / "peers"
PACKAGES = ["pin==4.1.0", "cmeel-eigen==3.4.1", "PyYAML==6.0.3"]
TOOL_M = [0.0, 0.0, 0.15]
AGREEMENT = 1e-9
# Pinocchio's list of joint types is longer than Boost's lists are by default.
FLAGS = (
    "-std=c++17 -O3 -march=native -DNDEBUG -DBOOST_MPL_LIMIT_LIST_SIZE=30 -DBOOST_MPL_LIMIT_VECTOR_SIZE=30 "
    "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS -DBOOST_FUSION_INVOKE_MAX_ARITY=12 -w"
).split()


def in_own_environment():
    """Starts again inside the virtual environment that holds the packages."""
    python = PEERS / "venv" / "bin" / "python"
    stamp = PEERS / "venv" / "packages"
    if not stamp.exists() or stamp.read_text() != "\n".join(PACKAGES):
        subprocess.run([sys.executable, "-m", "venv", PEERS / "venv"], check=True)
        pip = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        subprocess.run([*pip, *PACKAGES], check=True)
        stamp.write_text("\n".join(PACKAGES))
    sys.exit(subprocess.run([python, __file__, "--inside", *sys.argv[1:]]).returncode)


def write_model(folder):
    """The arm as text for the C++ program; the limits of its joints."""
    import numpy as np
    import pinocchio as pin
    import yaml

    robot = ROOT / "robots" / "irb1600" / "robot.yaml"
    described = yaml.safe_load(robot.read_text())
    model = pin.buildModelFromUrdf(str(robot.parent / described["urdf"]))
    axes = {"JointModelRX": [1, 0, 0], "JointModelRY": [0, 1, 0], "JointModelRZ": [0, 0, 1]}
    lines = [str(model.nq)]
    numbers = lambda values: " ".join(repr(float(x)) for x in np.asarray(values).ravel())
    for i in range(1, model.njoints):
        placement, body = model.jointPlacements[i], model.inertias[i]
        spring = described["elasticity"]["joints"][model.names[i]]["stiffness_nm_per_rad"]
        lines.append(f"{model.parents[i]} " + numbers(axes[model.joints[i].shortname()]))
        lines.append(numbers(placement.rotation) + " " + numbers(placement.translation))
        lines.append(f"{body.mass!r} " + numbers(body.lever) + " " + numbers(body.inertia) + f" {spring!r}")
    frame = model.frames[model.getFrameId(described["tip"])]
    assert frame.parentJoint == model.njoints - 1
    tool = frame.placement.act(np.array(TOOL_M))
    lines.append(f"{described['elasticity']['damping_ratio']!r} " + numbers(tool))
    (folder / "model.txt").write_text("\n".join(lines) + "\n")
    return model.lowerPositionLimit, model.upperPositionLimit


def compile_peer():
    prefix = next((PEERS / "venv").glob("lib/python*/site-packages/cmeel.prefix"))
    program = PEERS / "pinocchio"
    source = pathlib.Path(__file__).with_name("pinocchio.cpp")
    if not program.exists() or program.stat().st_mtime < source.stat().st_mtime:
        include = ["-I", prefix / "include", "-I", prefix / "include" / "eigen3"]
        subprocess.run(["g++", *FLAGS, *include, source, "-o", program], check=True)
    return program


def build_ours():
    """The bench `kernel`, as cargo names it."""
    command = ["cargo", "bench", "--bench", "kernel", "--no-run", "--message-format", "json"]
    built = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True)
    for line in built.stdout.splitlines():
        message = json.loads(line)
        if message.get("executable") and message["target"]["name"] == "kernel":
            return message["executable"]
    sys.exit("cargo built no bench named kernel")


def main():
    import numpy as np

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--inside", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--poses", type=int, default=20_000)
    parser.add_argument("--rounds", type=int, default=5)
    arguments = parser.parse_args()

    lower, upper = write_model(PEERS)
    poses = np.random.default_rng(1).uniform(lower, upper, (arguments.poses, len(lower)))
    poses.tofile(PEERS / "poses.bin")
    peer, ours = compile_peer(), build_ours()

    def of_peer(form, what):
        return [peer, PEERS / "model.txt", PEERS / "poses.bin", PEERS / "out.bin", form, what]

    def of_ours(which, what):
        return [ours, "peers", PEERS / "poses.bin", PEERS / "out.bin", which, what]

    sets = subprocess.run([ours, "sets"], check=True, capture_output=True, text=True).stdout.split()
    entries = [("Pinocchio + Eigen, plain", of_peer, "plain"), ("Pinocchio + Eigen, scaled", of_peer, "scaled")]
    entries += [("detune, scalar path", of_ours, "scalar")]
    entries += [(f"detune, batch, {name}", of_ours, name) for name in sets]

    times, results = {}, {}
    for _ in range(arguments.rounds):
        for name, command, which in entries:
            for what in ("frequencies", "tip"):
                run = subprocess.run(command(which, what), cwd=ROOT, check=True, capture_output=True, text=True)
                times.setdefault((name, what), []).append([float(x) for x in run.stdout.split()])
                results[name, what] = np.fromfile(PEERS / "out.bin").reshape(arguments.poses, -1)

    n = len(lower)
    for what in ("frequencies", "tip"):
        expected = results[entries[1][0], what]
        for name, _, _ in entries:
            found = results[name, what]
            worst = np.abs(found[:, :n] / expected[:, :n] - 1).max()
            if what == "tip":
                largest = expected[:, n:].max(axis=1, keepdims=True)
                worst = max(worst, (np.abs(found[:, n:] - expected[:, n:]) / largest).max())
            print(f"{name}: {what} agree with the scaled form to {worst:.1e}")
            if not worst <= AGREEMENT:
                sys.exit(f"{name}: {what} differ by {worst:.1e}; no times are shown")

    cpu = next((l.split(":")[1].strip() for l in open("/proc/cpuinfo") if l.startswith("model name")), platform.machine())
    print(f"\n{datetime.date.today()}, {cpu}, one thread, {arguments.poses} poses; least ns a pose (median in brackets)")
    print(f"\n| | frequencies | × plain | × scaled | with tip participation | × plain | × scaled |")
    print("|---|---|---|---|---|---|---|")
    least = {key: min(t[0] for t in rounds) for key, rounds in times.items()}
    for name, _, _ in entries:
        cells = []
        for what in ("frequencies", "tip"):
            median = sorted(t[1] for t in times[name, what])[arguments.rounds // 2]
            mine = least[name, what]
            cells.append(f"{mine:.0f} ({median:.0f})")
            cells += [f"{least[entries[k][0], what] / mine:.1f}" for k in (0, 1)]
        print(f"| {name} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    if "--inside" in sys.argv:
        main()
    else:
        PEERS.mkdir(parents=True, exist_ok=True)
        in_own_environment()
