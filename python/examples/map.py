"""The first natural frequency over two joints as a picture.

pip install matplotlib
python python/examples/map.py robots/irb1600 map.png
"""

import sys

import numpy as np

import detune

robot = detune.Robot(sys.argv[1] if len(sys.argv) > 1 else "robots/irb1600")
names = robot.joint_names
a, b = np.radians(np.linspace(-60, 90, 151)), np.radians(np.linspace(-90, 60, 151))
q = np.zeros((a.size * b.size, len(names)))
q[:, 1], q[:, 2] = (axis.ravel() for axis in np.meshgrid(a, b))
first = robot.frequencies(q)[:, 0].reshape(b.size, a.size)
print(f"mode 1 from {first.min():.2f} to {first.max():.2f} Hz over {q.shape[0]} poses")

if len(sys.argv) > 2:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots()
    contours = axes.contour(np.degrees(a), np.degrees(b), first, levels=12)
    axes.clabel(contours, fmt="%.1f Hz")
    axes.set(xlabel=f"{names[1]}, °", ylabel=f"{names[2]}, °", title=f"{robot.name}: mode 1")
    figure.savefig(sys.argv[2], dpi=150)
