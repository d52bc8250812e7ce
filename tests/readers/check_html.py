#!/usr/bin/env python3
"""Opens a page of dynemo-export in headless Chromium and uses it: check_html.py PAGE [SCREENSHOT.png].

Speaks the DevTools protocol over Chromium's pipe, so that nothing but Python's standard library is needed. Exit status 0
when the page works, 1 with the reason when not, 77 where there is no Chromium.
"""
import base64
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

LIMIT_S = 200
NAMES = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")


class Browser:
    """One tab. Answers are matched by id; events are kept."""

    def __init__(self, program, profile):
        to_child_r, self.to_child = os.pipe()
        self.from_child, from_child_w = os.pipe()

        def pipes_as_3_and_4():
            # Chromium reads from 3 and writes to 4; copies, so that neither overwrites the other.
            r, w = os.dup(to_child_r), os.dup(from_child_w)
            os.dup2(r, 3)
            os.dup2(w, 4)

        self.process = subprocess.Popen(
            [program, "--headless", "--no-sandbox", "--disable-gpu-sandbox", "--use-angle=swiftshader",
             "--enable-unsafe-swiftshader", "--remote-debugging-pipe", "--user-data-dir=" + profile,
             "--window-size=960,600", "--hide-scrollbars", "about:blank"],
            preexec_fn=pipes_as_3_and_4, close_fds=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_child_r)
        os.close(from_child_w)
        self.buffer, self.events, self.next_id, self.session = b"", [], 0, None
        self.deadline = time.monotonic() + LIMIT_S

    def read_message(self):
        while b"\0" not in self.buffer:
            if time.monotonic() > self.deadline:
                raise SystemExit("the browser took too long")
            chunk = os.read(self.from_child, 1 << 20)
            if not chunk:
                raise SystemExit("the browser ended")
            self.buffer += chunk
        text, self.buffer = self.buffer.split(b"\0", 1)
        return json.loads(text)

    def call(self, method, **params):
        self.next_id += 1
        message = {"id": self.next_id, "method": method, "params": params}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.to_child, json.dumps(message).encode() + b"\0")
        while True:
            answer = self.read_message()
            if answer.get("id") == self.next_id:
                if "error" in answer:
                    raise SystemExit(f"{method}: {answer['error']}")
                return answer["result"]
            self.events.append(answer)

    def open(self, url):
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Runtime", "Log", "Network", "Page"):
            self.call(domain + ".enable")
        self.call("Page.navigate", url=url)

    def evaluate(self, expression):
        result = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in result:
            raise SystemExit(f"{expression}: {result['exceptionDetails']}")
        return result["result"].get("value")

    def complaints(self):
        found = []
        for event in self.events:
            method, params = event.get("method"), event.get("params", {})
            if method == "Runtime.exceptionThrown":
                found.append(str(params["exceptionDetails"]))
            elif method == "Runtime.consoleAPICalled" and params["type"] in ("error", "assert"):
                found.append("console: " + str(params["args"]))
            elif method == "Log.entryAdded" and params["entry"]["level"] == "error":
                found.append("log: " + params["entry"]["text"])
            elif method == "Network.requestWillBeSent":
                url = params["request"]["url"]
                if not url.startswith(("file:", "data:", "blob:", "about:")):
                    found.append("the page asks the network for " + url)
        return found


LOOK = """(() => {
  const small = document.createElement('canvas');
  small.width = 320; small.height = 200;
  const context = small.getContext('2d');
  context.drawImage(document.getElementById('view'), 0, 0, small.width, small.height);
  const bytes = context.getImageData(0, 0, small.width, small.height).data, colors = new Set();
  let sum = 7;
  for (let i = 0; i < bytes.length; i += 4) {
    const color = bytes[i] << 16 | bytes[i + 1] << 8 | bytes[i + 2];
    colors.add(color);
    sum = (Math.imul(sum, 31) + color) | 0;
  }
  return [colors.size, sum];
})()"""


def drawn(browser):
    """Number of colours, and a checksum, of what WebGL has drawn, without the panels around it."""
    two_frames(browser)
    return browser.evaluate(LOOK)


def two_frames(browser):
    browser.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))")


def check_legend(browser):
    """The colours beside the layers' names are those that the layers are drawn in."""
    parts = browser.evaluate("dynemo.robot()")
    shown = browser.evaluate(
        "getComputedStyle(document.querySelector('input[data-layer=Robot]').nextSibling).background")
    for part in parts:
        rgb = "rgb({}, {}, {})".format(*(int(part[i:i + 2], 16) for i in (1, 3, 5)))
        if rgb not in shown:
            raise SystemExit(f"the robot is {parts}, in the legend it is {shown}")
    for name in ("Keyframes", "Floors", "Planes", "Trajectory", "Robot", "Entities"):
        layer = browser.evaluate(f"dynemo.layer('{name}')")
        if layer and layer["colors"][0] not in layer["swatch"]:
            raise SystemExit(f"{name} is drawn in {layer['colors']}, in the legend it is {layer['swatch']}")


def use(browser):
    while not browser.evaluate("document.readyState === 'complete' && !!window.dynemo"):
        time.sleep(0.2)
        if browser.complaints():
            raise SystemExit("; ".join(browser.complaints()))
    colors, before = drawn(browser)
    if colors < 50:
        raise SystemExit(f"the view is blank: {colors} colours")

    agents = browser.evaluate("dynemo.entities().filter(id => dynemo.entity(id).class === 'agent')")
    move = ("(t => { const s = document.getElementById('slider'); s.value = t;"
            " s.dispatchEvent(new Event('input')); return dynemo.time(); })")
    moved = 0.0
    duration = browser.evaluate("dynemo.duration")
    places = {}
    for step in range(9):
        shown = browser.evaluate(f"{move}({duration * step / 8})")
        if abs(shown - duration * step / 8) > 0.01:
            raise SystemExit(f"the slider shows {shown} s instead of {duration * step / 8}")
        for agent in agents:
            place = browser.evaluate(f"dynemo.entity({agent}).position")
            first = places.setdefault(agent, place)
            moved = max(moved, sum((a - b) ** 2 for a, b in zip(place, first)) ** 0.5)
    if agents and moved < 0.3:
        raise SystemExit(f"the slider moves no agent: {moved} m")
    browser.evaluate(f"{move}({duration / 2})")
    if drawn(browser)[1] == before:
        raise SystemExit("the picture does not change with time")

    layers = browser.evaluate("document.querySelectorAll('#layer-list input[data-layer]').length")
    if layers < 8:
        raise SystemExit(f"only {layers} layers can be switched")
    check_legend(browser)
    browser.evaluate("document.querySelector('input[data-layer=Points]').click()")
    without = drawn(browser)[0]
    browser.evaluate("document.querySelector('input[data-layer=Points]').click()")
    if without >= colors:
        raise SystemExit("switching the points off changes nothing")

    tips = browser.evaluate(
        "(() => { const found = new Set(); for (let x = 250; x < 720; x += 20) for (let y = 60; y < 520; y += 20)"
        " { const t = dynemo.textAt(x, y); if (t) found.add(t.text.split('\\n')[0].replace(/[0-9]+/g, '#')); }"
        " return [...found]; })()")
    if not any("edge" in tip for tip in tips):
        raise SystemExit(f"no edge tells its residual: {tips}")
    browser.evaluate(f"{move}({duration})")
    for control in ("by-residual", "grow"):
        browser.evaluate(f"document.getElementById('{control}').click()")
    browser.evaluate("(s => { s.value = 2; s.dispatchEvent(new Event('input')); })(document.getElementById('spread'))")
    two_frames(browser)
    errors = browser.complaints() + browser.evaluate("dynemo.errors")
    if errors:
        raise SystemExit("; ".join(errors))
    print(f"{colors} colours, agents move by {moved:.2f} m, {layers} layers, tips: {sorted(tips)}")


def main():
    page = pathlib.Path(sys.argv[1]).resolve()
    program = next(filter(None, map(shutil.which, NAMES)), None)
    if not program:
        print("no Chromium on this system")
        return 77
    with tempfile.TemporaryDirectory() as profile:
        browser = Browser(program, profile)
        try:
            browser.open(page.as_uri())
            use(browser)
            if len(sys.argv) > 2:
                for control in ("by-residual", "grow"):
                    browser.evaluate(f"document.getElementById('{control}').click()")
                two_frames(browser)
                shot = browser.call("Page.captureScreenshot", format="png")["data"]
                pathlib.Path(sys.argv[2]).write_bytes(base64.b64decode(shot))
        finally:
            browser.process.kill()
            browser.process.wait()
    return 0


if __name__ == "__main__":
    sys.exit(main())
