"""A headless Chromium with WebGL and without a network, in which tests load pages and run scripts.

It is driven by the DevTools protocol over two pipes, so nothing but the browser is needed.
"""

from __future__ import annotations

import base64
import fcntl
import itertools
import json
import os
import select
import subprocess
import time
from contextlib import contextmanager

from tests.helpers.pages import CHROMIUM

SECONDS = 120  # for one answer: SwiftShader draws with the CPU, which other tests may use as well
FLAGS = (
    *("--headless", "--no-sandbox", "--no-first-run", "--disable-dev-shm-usage"),
    *("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
    *("--host-resolver-rules=MAP * ~NOTFOUND", "--remote-debugging-pipe"),
)
READY = "document.documentElement?.dataset.ready ?? ''"
RUN = """(async () => {
  const view = window.izoView;
  const wait = (ms) => new Promise((done) => setTimeout(done, ms));
  %s
})()"""


@contextmanager
def started_browser(folder):
    """Yield a `Browser`, which ends with the block.

    Args:
        folder: For its profile.
    """
    to_browser, commands = os.pipe()
    answers, from_browser = os.pipe()
    # the browser reads from 3 and writes to 4, which may be in use here
    own = [fcntl.fcntl(end, fcntl.F_DUPFD, 10) for end in (to_browser, from_browser)]

    def place():
        os.dup2(own[0], 3)
        os.dup2(own[1], 4)

    process = subprocess.Popen(
        [CHROMIUM, *FLAGS, f"--user-data-dir={folder}", "about:blank"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        preexec_fn=place,
        pass_fds=(3, 4),
    )
    for end in (to_browser, from_browser, *own):
        os.close(end)
    try:
        yield Browser(commands, answers)
    finally:
        os.close(commands)
        os.close(answers)
        process.kill()
        process.wait()


class Browser:
    """A browser with one page.

    Attributes:
        console: What the page wrote on its console, and errors of scripts and of loading.
    """

    def __init__(self, commands, answers):
        """Open a page; the arguments are the ends of the pipes."""
        self._commands, self._answers, self._rest = commands, answers, b""
        self._numbers, self._session, self.console = itertools.count(1), None, []
        target = self._call("Target.createTarget", url="about:blank")["targetId"]
        attached = self._call("Target.attachToTarget", targetId=target, flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Log"):
            self._call(f"{domain}.enable")

    def load(self, path, fragment="", size=(1280, 800), theme="light"):
        """Load a page, and wait until it is ready.

        Args:
            path: Its file.
            fragment: What follows `#` in the address.
            size: Width and height of the window [px].
            theme: `light` or `dark`, what the user prefers.
        """
        named = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": False}
        self._call("Emulation.setDeviceMetricsOverride", **named)
        feature = {"name": "prefers-color-scheme", "value": theme}
        self._call("Emulation.setEmulatedMedia", features=[feature])
        self._call("Page.navigate", url="about:blank")  # otherwise `#` alone would not load anew
        self.console.clear()
        self._call("Page.navigate", url=path.as_uri() + (f"#{fragment}" if fragment else ""))
        end = time.monotonic() + SECONDS
        while not self.evaluate(READY):
            assert time.monotonic() < end, f"the page is not ready; its console: {self.console}"
            time.sleep(0.02)

    def run(self, script):
        """Run the body of an async function; return what it returns.

        `view` are the controls of the page, and `wait(ms)` waits.
        """
        return self.evaluate(RUN % script)

    def evaluate(self, expression):
        """Return the value of an expression, which is waited for if it is a promise."""
        named = {"expression": expression, "awaitPromise": True, "returnByValue": True}
        answer = self._call("Runtime.evaluate", **named)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def screenshot(self, path):
        """Write a PNG of the window."""
        path.write_bytes(base64.b64decode(self._call("Page.captureScreenshot")["data"]))

    def _call(self, method, **parameters):
        number = next(self._numbers)
        message = {"id": number, "method": method, "params": parameters}
        if self._session is not None:
            message["sessionId"] = self._session
        os.write(self._commands, json.dumps(message).encode() + b"\0")
        end = time.monotonic() + SECONDS
        while True:
            answer = self._next(end)
            if answer.get("id") == number:
                assert "error" not in answer, answer
                return answer["result"]
            self._keep(answer)

    def _keep(self, event):
        """Keep what the page says on its console."""
        shown = ("Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Log.entryAdded")
        if event.get("method") in shown:
            self.console.append(json.dumps(event["params"])[:2000])

    def _next(self, end):
        while b"\0" not in self._rest:
            ready, _, _ = select.select([self._answers], [], [], max(end - time.monotonic(), 0))
            assert ready, f"the browser did not answer; its console: {self.console}"
            piece = os.read(self._answers, 1 << 20)
            assert piece, "the browser ended"
            self._rest += piece
        line, _, self._rest = self._rest.partition(b"\0")
        return json.loads(line)
