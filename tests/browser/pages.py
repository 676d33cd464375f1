"""The pages of detune in a real browser: python3 tests/browser/pages.py DETUNE [--shots FOLDER]"""

import argparse
import json
import math
import os
import struct
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
    # Also of operations that are not chosen: they are printed.
    empty = "[...document.querySelectorAll('[data-operation]')].filter((o) => o.querySelectorAll('path.live').length !== 3)"
    assert page.run(f"{empty}.length") == 0, "an operation has no receptance"
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


def poses_answer(page, robot, lines):
    """The arm of a map: where the URDF and the CSV have it; slider, plot and mode."""
    heads, rows = lines[0].split(","), [line.split(",") for line in lines[1:]]
    places = page.run("detune.data.jobs[0].operations[0].places")
    assert len(places) == len(rows)
    for i in five(places):
        place, arm = places[i], f"detune.data.jobs[0].arm, detune.data.jobs[0].operations[0].places[{i}]"
        told = [float(rows[i][heads.index(f"f{mode}_hz")]) for mode in range(1, 7)]
        assert place["natural_frequencies_hz"] == told, f"{place['natural_frequencies_hz']}, not {told}"
        outside = point(tip(*robot, place["joints_rad"]), [0, 0, 0])
        for axis, own in enumerate(page.run(f"detune.tcp({arm})")):
            close(own, outside[axis], "tool centre point against the URDF")
            close(place["tcp_m"][axis], outside[axis], "tool centre point of the data")
        for own, expected in zip(page.run(f"detune.tipResponses({arm})"), place["tip_response_um_per_n"]):
            close(own / max(expected, 1e-9), expected / max(expected, 1e-9), "tip response of a mode")
    read = "document.querySelector('[data-is=here]').textContent"
    cursor = "document.querySelector('.cursor').getAttribute('x1')"
    slider = "document.querySelector('[data-is=place]')"
    before, at = page.run(read), page.run(cursor)
    page.run(f"{slider}.focus()")
    for _ in range(3):
        page.key("ArrowRight")
    assert "pose 4 of 25" in page.run(read) and "joint_2 -45°" in page.run(read), page.run(read)
    assert page.run(read) != before and page.run(cursor) != at, "the slider changes nothing"
    picture = "document.querySelector('canvas').toDataURL()"
    first = page.run(picture)
    time.sleep(0.35)
    assert page.run(picture) != first and len(first) > 20_000, "the arm does not move"


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


def scrolled(page):
    """Median and largest time between two pictures while the page is scrolled from top to foot, ms."""
    took = page.run("""new Promise(done => {
        const times = [], steps = 60, foot = document.documentElement.scrollHeight - innerHeight;
        const next = now => {
            times.push(now);
            scrollTo(0, foot * times.length / steps);
            times.length > steps ? done(times.slice(1).map((t, i) => t - times[i])) : requestAnimationFrame(next);
        };
        requestAnimationFrame(next);
    })""")
    return sorted(took)[len(took) // 2], max(took)


def size(file, most):
    found = os.path.getsize(file)
    assert found < most, f"{file}: {found} bytes"
    return found


def with_places(count):
    """A job whose check looks at many poses; the first of its ten operations meets hundreds of lines."""
    with open(os.path.join(JOBS, "pocket.yaml")) as file:
        head = file.read().split("operations:")[0].replace("../robots", os.path.join(ROOT, "robots"))
    text = head + "operations:\n"
    for i in range(10):
        rows = "".join(
            f"        - {{xyz_mm: [{240 * (k % 2)}, {k * 120 / count:.6f}, {i}], rpy_deg: [0, 180, 0]}}\n"
            for k in range(count // 10))
        text += (f"  - name: layer {i}\n    spindle_rpm: {24000 if i else 1000}\n    feed_mm_per_min: 4000\n"
                 f"    path:\n      poses:\n{rows}")
    return text


def ball(rings, radius, at):
    """Triangles of a sphere; facets far more than a picture needs."""
    def point(i, j):
        theta, phi = math.pi * i / rings, 2 * math.pi * j / rings
        return [at[0] + radius * math.sin(theta) * math.cos(phi),
                at[1] + radius * math.sin(theta) * math.sin(phi), at[2] + radius * math.cos(theta)]
    for i in range(rings):
        for j in range(rings):
            a, b, c, d = point(i, j), point(i + 1, j), point(i, j + 1), point(i + 1, j + 1)
            yield from ([a, b, c], [b, d, c])


def write_stl(path, triangles):
    triangles = list(triangles)
    with open(path, "wb") as out:
        out.write(b"solid in name alone".ljust(80))
        out.write(struct.pack("<I", len(triangles)))
        for triangle in triangles:
            out.write(struct.pack("<12fH", 0, 0, 0, *[v for p in triangle for v in p], 0))


def with_meshes(folder):
    """The pocket with a robot whose links have meshes: two links share one, one mesh is missing."""
    with open(os.path.join(ROOT, "robots", "irb1600", "irb1600.urdf")) as file:
        urdf = file.read()
    os.makedirs(os.path.join(folder, "arm_description", "meshes"))
    own = os.path.join(folder, "arm_description")
    write_stl(os.path.join(own, "meshes", "ball.stl"), ball(120, 0.12, [0, 0, 0]))
    with open(os.path.join(own, "meshes", "box.obj"), "w") as out:
        for k in range(8):
            out.write(f"v {0.2 * (k & 1) - 0.1} {0.2 * (k >> 1 & 1) - 0.1} {0.4 * (k >> 2 & 1)}\n")
        for face in ["1 2 4 3", "5 6 8 7", "1 2 6 5", "3 4 8 7", "1 3 7 5", "2 4 8 6"]:
            out.write(f"f {face}\n")
    for link, mesh in [("base_link", "package://arm_description/meshes/ball.stl"),
                       ("link_1", "meshes/box.obj"), ("link_2", "meshes/ball.stl"),
                       ("link_3", "package://nowhere/lost.dae")]:
        urdf = urdf.replace(f'<link name="{link}">',
                            f'<link name="{link}"><visual><geometry><mesh filename="{mesh}"/></geometry></visual>')
    with open(os.path.join(own, "irb1600.urdf"), "w") as out:
        out.write(urdf)
    with open(os.path.join(ROOT, "robots", "irb1600", "robot.yaml")) as file:
        robot = file.read()
    with open(os.path.join(own, "robot.yaml"), "w") as out:
        out.write(robot)
    with open(os.path.join(JOBS, "pocket.yaml")) as file:
        job = file.read().replace("../robots/irb1600/robot.yaml", "arm_description/robot.yaml")
    path = os.path.join(folder, "meshes.yaml")
    with open(path, "w") as out:
        out.write(job)
    return path


def meshes_are_drawn(page):
    arm = "detune.data.jobs[0].arm"
    surfaces = page.run("Object.values(detune.data.surfaces).map((s) => atob(s.triangles).length / 6)")
    assert len(surfaces) == 2 and 12 in surfaces, surfaces
    assert all(0 < count <= 3000 for count in surfaces), surfaces
    drawn = page.run(f"{arm}.parts.map((part, i) => [part.meshes.length, detune.jobs[0].view.parts[i].links.count])")
    dressed = [count for meshes, count in drawn if meshes]
    assert sorted(dressed) == sorted([3 * surfaces[0], 3 * surfaces[1], 3 * max(surfaces)]), (drawn, surfaces)
    missing = page.run(f"{arm}.missing_meshes")
    assert [(m["link"], m["why"]) for m in missing] == [("link_3", "no such file")], missing
    assert "lost.dae" in page.run("document.body.textContent")


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

        path = write("meshes", "report", with_meshes(folder))
        page = browser.page(path)
        meshes_are_drawn(page)
        assert not page.faults(), page.faults()
        print(f"report with meshes: {size(path, 5_000_000)} bytes, ready in {page.seconds:.2f} s")
        if asked.shots:
            shots(page, asked.shots, "meshes", browser, path)
        page.close()

        job = os.path.join(JOBS, "contour.yaml")
        own = json.loads(detune(program, "report", "--format", "json", job))
        page = browser.page(write("advise", "advise", "--format", "html", job))
        assert page.run("detune.data") == own, "the numbers of the page are not those of the JSON"
        advice = json.loads(detune(program, "advise", "--format", "json", job))
        first = page.run("document.querySelector('article').innerText")
        assert f"{advice['operations'][0]['recommended_rpm']:.0f} rpm" in first, first
        assert not page.faults(), page.faults()
        page.close()

        two_link = os.path.join(ROOT, "robots", "two-link")
        robot = os.path.join(two_link, "robot.yaml")
        for name, least, told, arguments in [
            ("map", 3, "f2 Hz", ["map", robot, "--joint", "joint_2", "--from-deg", "0", "--to-deg", "150",
                                 "--steps", "31", "--intervals", "--shapes"]),
            ("identify", 6, "Shapes on the marked points",
             ["identify", os.path.join(two_link, "session.yaml")]),
            ("diagnose", 4, "its error, 95 %",
             ["diagnose", robot, os.path.join(two_link, "measured.csv")]),
        ]:
            path = write(name, *arguments, "--format", "html")
            page = browser.page(path)
            assert page.run("document.querySelectorAll('svg').length") >= least, name
            assert told in page.run("document.body.textContent"), f"{name} does not tell {told}"
            # Nothing drawn is lost outside its drawing.
            lost = page.run("[...document.querySelectorAll('svg text')].filter((t) => { const a = "
                            "t.getBoundingClientRect(), b = t.ownerSVGElement.getBoundingClientRect(); return t.textContent && (a.left "
                            "< b.left - 1 || a.right > b.right + 1 || a.bottom > b.bottom + 1); })"
                            ".map((t) => t.textContent)")
            assert not lost, f"{name}: {lost}"
            assert page.run("[...document.querySelectorAll('svg')].every((s) => s.getAttribute('aria-label'))"), \
                f"{name}: a drawing without words"
            assert not page.faults(), page.faults()
            size(path, 1_000_000)
            if asked.shots:
                shots(page, asked.shots, name, browser, path)
            page.close()
        lines = detune(program, *["map", robot, "--joint", "joint_2", "--from-deg", "0", "--to-deg", "150",
                                  "--steps", "31", "--format", "csv"]).splitlines()
        page = browser.page(os.path.join(folder, "map.html"))
        shown = page.run("[...document.querySelectorAll('[data-csv=map] tbody tr')].map((row) => [...row.cells].map("
                         "(cell) => Number(cell.dataset.value ?? cell.textContent)))")
        in_csv = lines[0].split(",").index("f1_hz")
        in_page = page.run("[...document.querySelectorAll('[data-csv=map] th')].findIndex((h) => h.textContent === 'f1 Hz')")
        expected = [float(line.split(",")[in_csv]) for line in lines[1:]]
        assert [cells[in_page] for cells in shown] == expected, "f1 of the page is not that of the CSV"
        page.close()

        six = os.path.join(ROOT, "robots", "irb1600")
        sweep = ["map", six, "--joint", "joint_2", "--from-deg", "-60", "--to-deg", "60", "--steps", "25"]
        path = write("arm", *sweep, "--format", "html")
        page = browser.page(path)
        poses_answer(page, arms["pocket"], detune(program, *sweep, "--format", "csv").splitlines())
        assert not page.faults(), page.faults()
        size(path, 1_000_000)
        if asked.shots:
            shots(page, asked.shots, "map-arm", browser, path)
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
        print("scrolled: {:.0f} ms a picture, at most {:.0f} ms".format(*scrolled(page)))
        assert count >= 20_000, count
        assert not page.faults(), page.faults()
        page.close()
    print("pages: all hold")


if __name__ == "__main__":
    main()
