#!/usr/bin/env python3
"""The report's page in a browser without a screen: the canvas shows the body, a drag turns it, the slider moves
it, the mouse reads a plot, and the page has nothing to complain about.

    report_page.py TURGOR FOLDER     makes its own run in FOLDER; ends with 77 where there is no browser
"""
import contextlib
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time
import urllib.request

SCENE = """
[world]
duration = 0.6
[body.liver]
model = "rhombus"
surface = { phantom = "liver", detail = 0.4 }
[tool.forceps]
body = "liver"
shape = { forceps = "phantom" }
grasp = { at_fraction = [0.3, 0.5, 1], depth = 0.006, pull = 0.012, start = 0, duration = 0.15 }
[output]
snapshots = { every = 0.1, size = [240, 180] }
video = false
"""
PORT = 9519


def request(method, path, body=None):
    data = json.dumps(body or {}).encode() if method == "POST" else None
    asked = urllib.request.Request(f"http://127.0.0.1:{PORT}{path}", data, {"Content-Type": "application/json"},
                                   method=method)
    with urllib.request.urlopen(asked, timeout=60) as answer:
        return json.load(answer)["value"]


class Browser:
    def __init__(self, driver, program):
        self.process = subprocess.Popen([driver, f"--port={PORT}"], stdout=subprocess.DEVNULL,
                                        stderr=subprocess.DEVNULL, start_new_session=True)
        arguments = ["--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader",
                     "--enable-unsafe-swiftshader", "--window-size=1200,1400"]
        options = {"binary": program, "args": arguments}
        wanted = {"browserName": "chrome", "goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL"}}
        self.patient(lambda: request("GET", "/status"))
        session = request("POST", "/session", {"capabilities": {"alwaysMatch": wanted}})
        self.session, self.browser = "/session/" + session["sessionId"], session["capabilities"]["goog:processID"]

    @staticmethod
    def patient(ask, seconds=30):
        end = time.time() + seconds
        while True:
            try:
                return ask()
            except OSError:
                if time.time() > end:
                    raise
                time.sleep(0.2)

    def post(self, what, body):
        return request("POST", f"{self.session}/{what}", body)

    def script(self, text):
        return self.post("execute/sync", {"script": text, "args": []})

    def wait(self, condition, seconds=60):
        end = time.time() + seconds
        while not self.script(f"return Boolean({condition})"):
            assert time.time() < end, f"waited in vain for {condition}"
            time.sleep(0.2)

    def move(self, points, press):
        """The mouse along points of the window, with its button down or not."""
        actions = [{"type": "pointerMove", "duration": 50, "x": int(x), "y": int(y)} for x, y in points]
        if press:
            actions = [actions[0], {"type": "pointerDown", "button": 0}, *actions[1:], {"type": "pointerUp", "button": 0}]
        self.post("actions", {"actions": [{"type": "pointer", "id": "mouse", "actions": actions}]})

    def middle(self, selector):
        self.script(f"document.querySelector('{selector}').scrollIntoView({{block: 'center'}})")
        box = self.script(f"const b = document.querySelector('{selector}').getBoundingClientRect();"
                          "return [b.x + b.width / 2, b.y + b.height / 2]")
        return box

    def canvas(self):
        """Red, green and blue of every second pixel of every second row of the canvas."""
        time.sleep(0.3)
        return bytes.fromhex(self.script(
            "const view = document.getElementById('motion-view'), small = document.createElement('canvas');"
            "small.width = view.width / 2; small.height = view.height / 2;"
            "const to = small.getContext('2d'); to.imageSmoothingEnabled = false;"
            "to.drawImage(view, 0, 0, small.width, small.height);"
            "const rgba = to.getImageData(0, 0, small.width, small.height).data; let hex = '';"
            "for (let i = 0; i < rgba.length; i++) if (i % 4 < 3) hex += rgba[i].toString(16).padStart(2, '0');"
            "return hex;"))

    def close(self):
        try:
            request("DELETE", self.session)
        finally:
            self.process.terminate()
            for kill, number in (os.killpg, self.process.pid), (os.kill, self.browser):  # browsers outlive their driver
                with contextlib.suppress(ProcessLookupError):
                    kill(number, signal.SIGKILL)


def share_of_body(picture):
    """How much of the picture is reddish, as flesh is."""
    return sum(red > blue + 30 for red, blue in zip(picture[::3], picture[2::3])) / (len(picture) // 3)


def difference(a, b):
    """Share of pixels that differ."""
    assert len(a) == len(b) > 30000, f"pictures of {len(a)} and {len(b)} bytes"
    return sum(a[i:i + 3] != b[i:i + 3] for i in range(0, len(a), 3)) / (len(a) // 3)


def check(browser, page):
    browser.post("url", {"url": page.as_uri()})
    browser.wait("document.getElementById('motion-view') && document.getElementById('motion-view').dataset.ready")
    x, y = browser.middle("#motion-view")
    first = browser.canvas()
    assert 0.05 < share_of_body(first) < 0.9, f"the body covers {share_of_body(first):.3f} of the canvas"
    browser.move([(x, y), (x + 60, y + 10), (x + 120, y + 20)], press=True)
    turned = browser.canvas()
    assert difference(first, turned) > 0.02, "a drag turned nothing"
    browser.script("const s = document.getElementById('motion-time'); s.value = 0; s.dispatchEvent(new Event('input'))")
    earlier = browser.canvas()
    assert 0.0005 < difference(turned, earlier), "the slider moved nothing"
    assert browser.script("return document.getElementById('motion-now').textContent").startswith("0.00 s")
    browser.script("const c = document.getElementById('motion-color'); c.value = 'displacement';"
                   "c.dispatchEvent(new Event('change'))")
    assert difference(earlier, browser.canvas()) > 0.02, "the colors changed nothing"
    browser.move([browser.middle(".turgor-plot")], press=False)
    read = browser.script("return document.querySelector('.plot-read').textContent")
    assert "," in read, f"the mouse read '{read}' from a plot"
    largest, told, quantum = browser.script(
        "const thing = motion.things[0]; let most = 0; for (const frame of motion.frames) { const m = frame.things[0].moved,"
        "n = m.length / 3; for (let v = 0; v < n; v++) most = Math.max(most, Math.hypot(m[v], m[n + v], m[2 * n + v])); }"
        "return [most * thing.quantum, thing.largest_m, thing.quantum];")
    assert told > 1e-4 and abs(largest - told) <= quantum, f"unpacked {largest} m, packed {told} m"
    complaints = browser.post("se/log", {"type": "browser"})
    assert complaints == [], complaints


def main():
    driver = shutil.which("chromedriver")
    program = shutil.which("chromium-headless-shell") or shutil.which("chromium")
    three = pathlib.Path("/usr/share/javascript/three/three.min.js")
    if not (driver and program and three.exists()):
        print("skipped: chromedriver, chromium or three.js is missing (Debian: chromium-driver "
              "chromium-headless-shell libjs-three)")
        return 77
    turgor, folder = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "press.toml").write_text(SCENE)
    subprocess.run([turgor, "run", str(folder / "press.toml"), "-o", str(folder / "out")], check=True,
                   stdout=subprocess.DEVNULL)
    page = folder / "out" / "report.html"
    assert page.stat().st_size < 8_000_000, f"the page has {page.stat().st_size} bytes"
    browser = Browser(driver, program)
    try:
        check(browser, page)
    finally:
        browser.close()
    print("the page works")
    return 0


if __name__ == "__main__":
    sys.exit(main())
