"""Writes the arrays of this folder: `python tests/data/npy/make.py`, NumPy 2.4."""

from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
# Every number is a float32 as well.
POSES = np.array([[0.125, -0.25], [0.5, 1.25], [-1.5, 2.0]])

np.save(HERE / "frequencies.npy", np.array([[20.5, 88.0, 123456.789], [1e-5, 1 / 3, 2e16]]))
np.save(HERE / "poses.npy", POSES)
np.save(HERE / "by_column.npy", np.asfortranarray(POSES))
np.save(HERE / "big_endian.npy", POSES.astype(">f8"))
np.save(HERE / "single.npy", POSES.astype("<f4"))
np.save(HERE / "single_big_by_column.npy", np.asfortranarray(POSES.astype(">f4")))
np.save(HERE / "whole_numbers.npy", POSES.astype(np.int64))
np.save(HERE / "three_columns.npy", np.zeros((2, 3)))
np.save(HERE / "structure.npy", np.zeros(2, dtype=[("a", "f8"), ("b", "f8")]))
np.save(HERE / "not_finite.npy", np.array([[0.0, 0.0], [0.0, np.nan], [-np.inf, 0.0]]))
np.savez(HERE / "archive.npz", POSES)
with open(HERE / "version_2.npy", "wb") as file:
    np.lib.format.write_array(file, POSES, version=(2, 0))
