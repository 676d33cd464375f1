"""Writes the tables of this folder: `python tests/data/arrow/make.py`, PyArrow 26."""

from pathlib import Path

import pyarrow as pa
from pyarrow import feather, ipc

HERE = Path(__file__).parent
# Every number is a float32 as well.
POSES = [[0.125, -0.25], [0.5, 1.25], [-1.5, 2.0]]
TITLES = ["joint_1_rad", "joint_2_rad"]


def table(kind=pa.float64(), poses=POSES, titles=TITLES):
    columns = [pa.array(column, kind) for column in zip(*poses)]
    # A column that is none of detune's business, and joints in another order than the robot's.
    columns = [columns[1], pa.array(["a", "b", "c"][: len(poses)]), columns[0]]
    return pa.table(columns, names=[titles[1], "id", titles[0]])


def stream(name, content, rows=2):
    with ipc.new_stream(HERE / name, content.schema) as writer:
        writer.write_table(content, max_chunksize=rows)


stream("stream.arrows", table())
stream("single.arrows", table(pa.float32()))
stream("whole_numbers.arrows", table(pa.int64(), [[0, 1], [2, 3], [4, 5]]))
stream("holes.arrows", table(poses=[[0.0, 1.0], [None, 2.0], [0.5, float("nan")]]))
stream("misspelt.arrows", table(titles=["joint_1_rad", "joint2_rad"]))
feather.write_feather(table(), HERE / "packed.feather", compression="lz4", chunksize=2)
feather.write_feather(table(), HERE / "plain.feather", compression="uncompressed")
