"""Chromium without a window, over the pipe of its developer protocol: nothing but the standard library."""

import json
import os
import select
import shutil
import subprocess
import tempfile
import time

FLAGS = [
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--no-first-run", "--no-default-browser-check",
    "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars",
    "--remote-debugging-pipe",
]


class Chromium:
    def __init__(self):
        program = shutil.which("chromium") or shutil.which("chromium-browser")
        if not program:
            raise SystemExit("no chromium: apt-get install chromium")
        self.folder = tempfile.mkdtemp(prefix="detune-chromium-")
        to_read, self.out = os.pipe()
        self.inn, to_write = os.pipe()

        def in_place():
            # The protocol comes on 3 and goes on 4, whatever numbers the pipes had.
            spare = [os.dup2(to_read, 100), os.dup2(to_write, 101)]
            os.dup2(spare[0], 3)
            os.dup2(spare[1], 4)

        self.process = subprocess.Popen(
            [program, *FLAGS, f"--user-data-dir={self.folder}", "about:blank"],
            preexec_fn=in_place, close_fds=False,
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_read)
        os.close(to_write)
        self.pending, self.number, self.events = b"", 0, []

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait()
        shutil.rmtree(self.folder, ignore_errors=True)

    def message(self, until):
        while b"\0" not in self.pending:
            ready, _, _ = select.select([self.inn], [], [], max(0.0, until - time.monotonic()))
            if not ready:
                return None
            piece = os.read(self.inn, 1 << 20)
            if not piece:
                raise SystemExit("chromium has gone")
            self.pending += piece
        message, self.pending = self.pending.split(b"\0", 1)
        return json.loads(message)

    def send(self, method, session=None, seconds=30, **parameters):
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if session:
            message["sessionId"] = session
        os.write(self.out, json.dumps(message).encode() + b"\0")
        until = time.monotonic() + seconds
        while (answer := self.message(until)) is not None:
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]
            self.events.append(answer)
        raise SystemExit(f"chromium does not answer {method}")

    def page(self, *arguments, **options):
        return Page(self, *arguments, **options)


class Page:
    """A tab with one file open; `seconds` is how long it took until its script had run."""

    def __init__(self, browser, file, width=1280, height=900, dark=False):
        self.browser = browser
        target = browser.send("Target.createTarget", url="about:blank")["targetId"]
        attached = browser.send("Target.attachToTarget", targetId=target, flatten=True)
        self.session, self.target = attached["sessionId"], target
        for domain in ["Page", "Runtime", "Network", "Log"]:
            self.send(f"{domain}.enable")
        self.send("Emulation.setDeviceMetricsOverride", width=width, height=height,
                  deviceScaleFactor=1, mobile=width < 600)
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.send("Emulation.setEmulatedMedia", features=[scheme])
        self.url = "file://" + os.path.abspath(file)
        start = time.monotonic()
        self.send("Page.navigate", url=self.url)
        while not self.run("location.href !== 'about:blank' && 'ready' in (document.documentElement?.dataset ?? {})"):
            if time.monotonic() - start > 20:
                raise AssertionError(f"{file} is not ready: {self.faults()}")
            time.sleep(0.02)
        self.seconds = time.monotonic() - start

    def send(self, method, **parameters):
        return self.browser.send(method, session=self.session, **parameters)

    def run(self, script):
        answer = self.send("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise AssertionError(f"{script}: {answer['exceptionDetails']}")
        return answer["result"].get("value")

    def of(self, method):
        mine = (e for e in self.browser.events if e.get("sessionId") == self.session)
        return [event["params"] for event in mine if event["method"] == method]

    def faults(self):
        """Errors of scripts, of the console and of the policy, and requests beyond the file."""
        self.run("1")
        said = [p for p in self.of("Runtime.consoleAPICalled") if p["type"] in ("error", "warning", "assert")]
        logged = [p for p in self.of("Log.entryAdded") if p["entry"]["level"] in ("error", "warning")]
        # The software renderer tells how slow it is.
        logged = [p for p in logged if "GPU stall" not in p["entry"]["text"]]
        asked = [p["request"]["url"] for p in self.of("Network.requestWillBeSent")]
        beyond = [url for url in asked if url != self.url and not url.startswith("blob:")]
        return self.of("Runtime.exceptionThrown") + said + logged + beyond

    def key(self, key, code=None):
        for kind in ["keyDown", "keyUp"]:
            numbers = {"ArrowRight": 39, "ArrowLeft": 37, "Tab": 9}
            self.send("Input.dispatchKeyEvent", type=kind, key=key, code=code or key,
                      windowsVirtualKeyCode=numbers.get(key, 0))

    def mouse(self, kind, x, y, **more):
        self.send("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def shot(self, file, whole=True):
        import base64
        picture = self.send("Page.captureScreenshot", captureBeyondViewport=whole)
        with open(file, "wb") as out:
            out.write(base64.b64decode(picture["data"]))

    def pdf(self, file):
        import base64
        printed = self.send("Page.printToPDF", preferCSSPageSize=True, printBackground=True)
        with open(file, "wb") as out:
            out.write(base64.b64decode(printed["data"]))

    def close(self):
        self.browser.send("Target.closeTarget", targetId=self.target)
