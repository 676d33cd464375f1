"""The pages of detune in a real browser: python3 tests/browser/pages.py DETUNE [--shots FOLDER]"""

import argparse
import json
import math
import os
import subprocess
import tempfile
import time

from chromium import Chromium
from kinematics import point, tip

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
JOBS = os.path.join(ROOT, "jobs")
TOLERANCE = 1e-6

# What may stand in a name, and must stay text.
HOSTILE = "</script><script>window.broken = 1</script><img src=x onerror='window.broken=1'>\"'&<!-- 机器人 \u202e é"


def detune(program, *arguments):
    done = subprocess.run([program, *arguments], capture_output=True, text=True)
    assert done.returncode in (0, 1), done.stderr
    return done.stdout


def close(a, b, what, tolerance=TOLERANCE):
    assert math.isfinite(a) and abs(a - b) <= tolerance * max(1.0, abs(b)), f"{what}: {a}, not {b}"


def five(places):
    return [round(i * (len(places) - 1) / 4) for i in range(5)]


def same_numbers(page, checked, robot):
    """Kinematics, modes and shapes of the page: those of the JSON, and of the URDF alone."""
    for at, operation in enumerate(checked["jobs"][0]["operations"]):
        of_page = f"detune.data.jobs[0].operations[{at}]"
        samples = {sample["s"]: sample for sample in operation["samples"]}
        count = page.run(f"{of_page}.places.length")
        for i in five(range(count)):
            place = page.run(f"{of_page}.places[{i}]")
            sample = samples[place["s"]]
            for key in sample:
                assert place[key] == sample[key], f"{key}: {place[key]}, not {sample[key]}"
            arm = f"detune.data.jobs[0].arm, {of_page}.places[{i}]"
            tcp = page.run(f"detune.tcp({arm})")
            outside = point(tip(*robot, sample["joints_rad"]), place["tool_m"])
            for axis in range(3):
                close(tcp[axis], place["tcp_m"][axis], "tool centre point against detune")
                close(tcp[axis], outside[axis], "tool centre point against the URDF")
            responses = page.run(f"detune.tipResponses({arm})")
            assert len(responses) == len(sample["tip_response_um_per_n"]) > 0
            for own, expected in zip(responses, sample["tip_response_um_per_n"]):
                close(own / max(expected, 1e-9), expected / max(expected, 1e-9), "tip response of a mode")


def answers(page):
    """Slider, pointer and keys do what they should; the mode moves."""
    read = "document.querySelector('[data-is=here]').textContent"
    slider = "document.querySelector('[data-is=place]')"
    assert page.run(f"{slider}.focus(), document.activeElement === {slider}")
    before, cursor = page.run(read), page.run("document.querySelector('.cursor').getAttribute('x1')")
    for _ in range(3):
        page.key("ArrowRight" if int(page.run(f"{slider}.value")) < 5 else "ArrowLeft")
    assert page.run(read) != before, "the slider changes nothing"
    assert page.run("document.querySelector('.cursor').getAttribute('x1')") != cursor
    page.run("document.querySelector('.sense').scrollIntoView({block: 'center'})")
    box = page.run("(() => { const b = [...document.querySelectorAll('.sense')].find((e) => e.getBoundingClientRect()"
                   ".width > 0).getBoundingClientRect(); return [b.left + b.width * 0.4, b.top + b.height / 2]; })()")
    page.mouse("mouseMoved", *box)
    told = page.run("document.querySelector('.tip').hidden ? '' : document.querySelector('.tip').innerText")
    assert "line " in told and "mode 1" in told, f"the pointer is told {told!r}"
    page.mouse("mousePressed", *box, button="left", clickCount=1)
    page.mouse("mouseReleased", *box, button="left", clickCount=1)
    assert "40 %" in page.run(read) or "39." in page.run(read) or "40." in page.run(read), page.run(read)
    page.run("scrollTo(0, 0); document.querySelector('canvas').scrollIntoView()")
    picture = "document.querySelector('canvas').toDataURL()"
    first = page.run(picture)
    time.sleep(0.35)
    assert page.run(picture) != first, "the mode does not move"
    page.run("document.querySelector('[data-is=animate]').click()")
    time.sleep(0.1)
    still = page.run(picture)
    time.sleep(0.2)
    assert page.run(picture) == still, "the mode moves though it was stopped"
    assert len(still) > 20_000, "the arm is not drawn"
    radios = "document.querySelectorAll('[data-is=modes] input')"
    page.run(f"{radios}[{radios}.length - 1].click()")
    assert page.run(picture) != still, "another mode looks the same"


def shots(page, folder, name, browser, file):
    page.run("scrollTo(0, 0)")
    page.shot(os.path.join(folder, f"{name}-light.png"))
    page.pdf(os.path.join(folder, f"{name}-print.pdf"))
    for kind, options in [("dark", {"dark": True}), ("phone", {"width": 390, "height": 844})]:
        other = browser.page(file, **options)
        time.sleep(0.3)
        other.shot(os.path.join(folder, f"{name}-{kind}.png"))
        wide = other.run("document.documentElement.scrollWidth - innerWidth")
        assert wide <= 0, f"{name} on a {kind}: {wide} px wider than the screen"
        assert not other.faults(), other.faults()
        other.close()


def size(file, most):
    found = os.path.getsize(file)
    assert found < most, f"{file}: {found} bytes"
    return found


def with_places(count):
    """A job whose check looks at many poses."""
    with open(os.path.join(JOBS, "pocket.yaml")) as file:
        head = file.read().split("operations:")[0].replace("../robots", os.path.join(ROOT, "robots"))
    text = head + "operations:\n"
    for i in range(10):
        rows = "".join(
            f"        - {{xyz_mm: [{240 * (k % 2)}, {k * 120 / count:.6f}, {i}], rpy_deg: [0, 180, 0]}}\n"
            for k in range(count // 10))
        text += (f"  - name: layer {i}\n    spindle_rpm: {1000 + 100 * i}\n    feed_mm_per_min: 4000\n"
                 f"    path:\n      poses:\n{rows}")
    return text


def main():
    asked = argparse.ArgumentParser()
    asked.add_argument("program")
    asked.add_argument("--shots")
    asked = asked.parse_args()
    program = os.path.abspath(asked.program)
    if asked.shots:
        os.makedirs(asked.shots, exist_ok=True)
    arms = {name: (os.path.join(ROOT, "robots", robot, urdf), base, tip_link) for name, robot, urdf, base, tip_link in [
        ("pocket", "irb1600", "irb1600.urdf", "base_link", "tool0"),
        ("contour", "irb1600", "irb1600.urdf", "base_link", "tool0"),
        ("rail", "rail-mill", "rail-mill.urdf", "rail", "tool0")]}
    with tempfile.TemporaryDirectory() as folder, Chromium() as browser:
        def write(name, *arguments):
            path = os.path.join(folder, f"{name}.html")
            detune(program, *arguments, "--output", path)
            return path

        for name in ["pocket", "rail", "contour"]:
            job = os.path.join(JOBS, f"{name}.yaml")
            path = write(name, "report", job)
            page = browser.page(path)
            if name in arms:
                checked = json.loads(detune(program, "check", "--format", "json", job))
                same_numbers(page, checked, arms[name])
            answers(page)
            assert not page.faults(), page.faults()
            print(f"report {name}: {size(path, 1_000_000)} bytes, ready in {page.seconds:.2f} s")
            if asked.shots:
                shots(page, asked.shots, f"report-{name}", browser, path)
            page.close()

        both = [os.path.join(JOBS, f"{name}.yaml") for name in ["pocket", "contour"]]
        page = browser.page(write("check", "check", "--format", "html", *both))
        assert page.run("detune.jobs.length") == 2
        assert not page.faults(), page.faults()
        if asked.shots:
            shots(page, asked.shots, "check", browser, os.path.join(folder, "check.html"))
        page.close()

        job = os.path.join(folder, "hostile.yaml")
        with open(os.path.join(JOBS, "pocket.yaml")) as file:
            text = file.read().replace("../robots", os.path.join(ROOT, "robots"))
        text = text.replace("Pocket in a bracket", json.dumps(HOSTILE)).replace("name: rough", "name: " + json.dumps(HOSTILE))
        with open(job, "w") as file:
            file.write(text)
        page = browser.page(write("hostile", "report", job))
        assert page.run("window.broken === undefined && document.images.length === 0")
        assert page.run("document.scripts.length") == 2
        assert page.run("detune.data.jobs[0].name") == HOSTILE
        shown = page.run("document.querySelector('h1').textContent")
        assert "window.broken = 1" in shown and "机器人" in shown, shown
        assert not page.faults(), page.faults()
        page.close()

        job = os.path.join(folder, "long.yaml")
        with open(job, "w") as file:
            file.write(with_places(4000))
        checked = json.loads(detune(program, "check", "--format", "json", job))
        count = sum(len(operation["samples"]) for operation in checked["jobs"][0]["operations"])
        path = write("long", "check", "--format", "html", job)
        page = browser.page(path)
        print(f"{count} samples: {size(path, 1_000_000)} bytes, ready in {page.seconds:.2f} s")
        assert count >= 20_000 and page.seconds < 2, (count, page.seconds)
        assert not page.faults(), page.faults()
        page.close()
    print("pages: all hold")


if __name__ == "__main__":
    main()
