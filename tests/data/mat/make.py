"""Writes the files of this folder: `python tests/data/mat/make.py`, SciPy 1.x, NumPy 2.x."""

from pathlib import Path

import numpy as np
from scipy.io import savemat

HERE = Path(__file__).parent
K = np.arange(16)
# Every number is a float32 as well.
RECORD = {
    "t": K / 128,
    "x_mm": 0.5 * K,
    "acc": np.stack([K, -K, 3 * K], axis=1).astype(np.int16),
    "hammer_n": (K * 0.25).astype(np.float32).reshape(-1, 1),
    "shaker": np.ones(4),
    "mass_kg": 2.5,
    "is_on": K > 3,
    "spectrum": K * 1j,
    "wide": np.zeros((2, 16)),
    "note": "a tap at the tool",
    "rig": {"operator": "me", "x": K},
    "cells": np.array([K, "a"], dtype=object),
}
savemat(HERE / "plain.mat", RECORD)
savemat(HERE / "compressed.mat", RECORD, do_compression=True)
savemat(HERE / "rate.mat", {"fs": 128.0, "y": K.astype(np.uint8)}, do_compression=True)
savemat(HERE / "clock.mat", {"stamp_ms": 5.0 * K, "x_mm": 0.5 * K})
savemat(HERE / "level_4.mat", {"y": K * 1.0}, format="4")
savemat(HERE / "structure.mat", {"rig": {"x": K}})
savemat(HERE / "not_finite.mat", {"y": np.where(K == 3, np.nan, K)})
savemat(HERE / "step.mat", {"dt": 0.0078125, "y": K * 1.0})

# Responses of a mode of 12 Hz and 2 % of damping: one alone, two as a matrix, one in two parts.
LINES = np.arange(64) * 0.5
MODE = 1 / (12**2 - LINES**2 + 2j * 0.02 * 12 * LINES)
savemat(
    HERE / "responses.mat",
    {
        "freq_hz": LINES.reshape(-1, 1),
        "tip": MODE,
        "H": np.stack([0.5 * MODE, -2j * MODE], axis=1),
        "elbow_re": MODE.real,
        "elbow_im": MODE.imag,
        "fs": 64.0,
        "window": np.ones(7),
        "wide": np.zeros((2, 64)) * 1j,
        "coh_tip": np.ones(64),
    },
    do_compression=True,
)
savemat(HERE / "few_lines.mat", {"f": K[:4] * 1.0, "y": K[:4] * 1j})

# A free decay of 12 Hz with 2 % of damping in two channels.
TIME = np.arange(600) / 200
OMEGA = 2 * np.pi * 12
DECAY = np.exp(-0.02 * OMEGA * TIME) * np.sin(OMEGA * np.sqrt(1 - 0.02**2) * TIME)
NOISE = np.random.default_rng(1).normal(size=(2, 600)) * 1e-3
savemat(
    HERE / "decay.mat",
    {"stamp_ms": 1e3 * TIME, "tip_mm": DECAY + NOISE[0], "elbow_mm": 0.4 * DECAY + NOISE[1]},
    do_compression=True,
)
