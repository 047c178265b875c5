"""A headless Chromium, spoken to through its pipe: opens a page, listens to its complaints and requests, takes pictures of it."""

import base64
import json
import os
import select
import subprocess
import sys
import tempfile
import time


class Browser:
    """`with Browser() as browser: browser.open(path)`; then errors, requests, evaluate(), screenshot()."""

    def __enter__(self):
        self.profile = tempfile.TemporaryDirectory(prefix="tern-test-", ignore_cleanup_errors=True)
        to_browser, self.write_end = os.pipe()
        self.read_end, from_browser = os.pipe()

        sandbox = ["--no-sandbox"] if os.geteuid() == 0 else []
        # DevTools over a pipe: descriptor 3 is read by the browser, 4 is written.
        connect = f'exec "$@" 10<&{to_browser} 11>&{from_browser} 3<&10 4>&11'
        self.process = subprocess.Popen(
            ["bash", "-c", connect, "bash", "chromium", "--headless", "--remote-debugging-pipe", "--disable-gpu",
             "--disable-dev-shm-usage", "--hide-scrollbars", "--disable-background-networking", "--disable-component-update",
             "--no-first-run", *sandbox, f"--user-data-dir={self.profile.name}", "about:blank"],
            pass_fds=(to_browser, from_browser), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
        os.close(to_browser)
        os.close(from_browser)
        self.pending, self.number, self.session = b"", 0, None
        self.errors, self.requests, self.loaded = [], [], False
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        return self

    def __exit__(self, *_):
        self.session = None
        try:
            self.call("Browser.close")
            self.process.wait(10)
        except (OSError, AssertionError, subprocess.TimeoutExpired):
            self.process.kill()
            self.process.wait()
        os.close(self.write_end)
        os.close(self.read_end)
        self.profile.cleanup()

    def _receive(self, seconds):
        """The next message; None when none comes in time."""
        deadline = time.monotonic() + seconds
        while b"\0" not in self.pending:
            left = deadline - time.monotonic()
            if left <= 0 or not select.select([self.read_end], [], [], left)[0]:
                return None
            part = os.read(self.read_end, 1 << 20)
            assert part, "the browser has gone"
            self.pending += part
        message, _, self.pending = self.pending.partition(b"\0")
        message = json.loads(message)
        self._note(message.get("method"), message.get("params", {}))
        return message

    def _note(self, event, details):
        if event == "Page.loadEventFired":
            self.loaded = True
        elif event == "Runtime.exceptionThrown":
            self.errors.append(details["exceptionDetails"].get("exception", {}).get("description", "exception"))
        elif event == "Log.entryAdded" and details["entry"]["level"] in ("error", "warning"):
            self.errors.append(details["entry"]["text"])
        elif event == "Runtime.consoleAPICalled" and details["type"] in ("error", "warning", "assert"):
            self.errors.append(str(details["args"]))
        elif event == "Network.requestWillBeSent" and not details["request"]["url"].startswith(("data:", "file:")):
            self.requests.append(details["request"]["url"])

    def call(self, method, **parameters):
        """One command of the DevTools protocol; returns its result."""
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters} | ({"sessionId": self.session} if self.session else {})
        words = json.dumps(message).encode() + b"\0"
        while words:
            words = words[os.write(self.write_end, words):]
        deadline = time.monotonic() + 60
        while (answer := self._receive(deadline - time.monotonic())) is not None:
            if answer.get("id") == self.number:
                assert "error" not in answer, f"{method}: {answer['error']}"
                return answer["result"]
        raise AssertionError(f"the browser did not answer {method} within 60 s")

    def open(self, path, width=1200, height=900, dark=False):
        """Opens a file; the lists of errors and requests start anew."""
        self.errors, self.requests, self.loaded = [], [], False
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=width < 600)
        self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])
        self.call("Page.navigate", url=path.resolve().as_uri())
        deadline = time.monotonic() + 60
        while not self.loaded:
            assert self._receive(deadline - time.monotonic()) is not None, f"{path} did not load within 60 s"
        while self._receive(0.3) is not None:
            pass  # what comes late: a request, an exception in a script

    def evaluate(self, expression):
        """The value of a JavaScript expression in the page."""
        answer = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def screenshot(self, path, whole=True):
        """PNG of the whole page, or of what a screen shows of it."""
        picture = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
        path.write_bytes(base64.b64decode(picture["data"]))


if __name__ == "__main__":
    sys.exit("This module holds what the tests beside it share; run those.")
