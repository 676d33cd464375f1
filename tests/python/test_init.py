"""`detune init` at a terminal, where it asks, and in folders that take no files."""

import os
import pathlib
import pty
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
DETUNE = [sys.executable, "-m", "detune"]
LINK = '<link name="{0}">{1}<collision><geometry><box size="0.2 0.2 0.6"/></geometry></collision></link>'
JOINT = (
    '<joint name="joint_{0}" type="revolute"><parent link="link_{1}"/><child link="link_{0}"/>'
    '<origin xyz="0 0 0.6"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="2" effort="9"/></joint>'
)
MASS = (
    '<inertial><mass value="40"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
)


def arm(folder, mass=""):
    """A URDF of two boxes that turn."""
    links = "".join(LINK.format(f"link_{i}", mass) for i in range(3))
    joints = "".join(JOINT.format(i + 1, i) for i in range(2))
    (folder / "arm.urdf").write_text(f'<robot name="arm">{links}{joints}</robot>')


def at_terminal(folder, answer):
    """Exit code of `detune init` and what a terminal shows, where somebody types an answer."""
    child, terminal = pty.fork()
    if child == 0:
        try:
            os.chdir(folder)
            os.execv(DETUNE[0], [*DETUNE, "init", "arm.urdf"])
        finally:
            os._exit(127)
    shown, is_answered = b"", False
    while True:
        try:
            read = os.read(terminal, 4096)
        except OSError:  # Linux: the other end is closed
            read = b""
        if not read:
            break
        shown += read
        if not is_answered and b"data sheet: " in shown:
            os.write(terminal, answer)
            is_answered = True
    os.close(terminal)
    assert is_answered, shown
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), shown.decode()


def test_a_terminal_is_asked_for_the_mass(tmp_path):
    arm(tmp_path)
    code, shown = at_terminal(tmp_path, b"120\n")
    assert code == 0, shown
    assert "total_mass_kg: 120" in (tmp_path / "robot.yaml").read_text()
    assert (tmp_path / "jobs/first.yaml").exists()


# \x04 is Ctrl-D: the end of what is typed.
@pytest.mark.parametrize("answer", [b"\n\x04", b"\x04", b"heavy\n\x04\x04", b"-3\n\x04\x04"])
def test_no_mass_is_made_of_another_answer(tmp_path, answer):
    arm(tmp_path)
    code, shown = at_terminal(tmp_path, answer)
    assert code == 2, shown
    assert os.listdir(tmp_path) == ["arm.urdf"]


def test_without_a_terminal_nothing_is_asked(tmp_path):
    arm(tmp_path)
    ended = subprocess.run([*DETUNE, "init", "arm.urdf"], cwd=tmp_path, input=b"120\n", capture_output=True)
    assert ended.returncode == 2 and b"--total-mass-kg" in ended.stderr and b"data sheet: " not in ended.stderr


def test_the_gitlab_template_is_what_init_writes(tmp_path):
    arm(tmp_path, MASS)
    arguments = ["init", "arm.urdf", "--ci", "gitlab"]
    ended = subprocess.run([*DETUNE, *arguments], cwd=tmp_path, capture_output=True)
    assert ended.returncode == 0, ended.stderr
    template = ROOT / ".gitlab/detune.gitlab-ci.yml"
    assert (tmp_path / "detune.gitlab-ci.yml").read_text() == template.read_text()


def read_only(tmp_path):
    """A folder that takes no files, whoever asks: permissions do not stop root."""
    if os.geteuid() != 0:
        folder = tmp_path / "shut"
        folder.mkdir(mode=0o555)
        return folder
    return pathlib.Path("/proc/self/task")


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="needs /proc")
@pytest.mark.parametrize(
    "arguments",
    [
        ["check", ROOT / "jobs/rail.yaml", "--fail-on", "never", "--output", "{}/out.txt"],
        ["advise", ROOT / "jobs/rail.yaml", "--write", "{}/job.yaml"],
        ["map", ROOT / "robots/two-link", "--random", "9", "--output", "{}/map.csv"],
        ["init", "arm.urdf", "--output", "{}/cell"],
    ],
    ids=lambda arguments: arguments[0],
)
def test_a_read_only_folder_is_told(tmp_path, arguments):
    arm(tmp_path, MASS)
    shut = read_only(tmp_path)
    named = [str(one).format(shut) for one in arguments]
    ended = subprocess.run([*DETUNE, *named], cwd=tmp_path, capture_output=True, text=True)
    assert ended.returncode == 2, (ended.returncode, ended.stderr)
    assert str(shut) in ended.stderr, ended.stderr
    assert ended.stdout == ""
    assert sorted(os.listdir(tmp_path)) in (["arm.urdf"], ["arm.urdf", "shut"])
