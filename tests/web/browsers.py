"""Two browsers under one set of words: Chromium through Selenium, Firefox through Mozilla's own Marionette.

Both open files without a network. Firefox without a GPU has no WebGL: there the page's renderer on the CPU is tried.
"""

import base64
import importlib.util
import os
import shutil
import socket
import subprocess
import time
from pathlib import Path

# What browsers themselves say of WebGL without a GPU, and of pixels that are read back
OWN = ("software WebGL has been deprecated", "GPU stall due to ReadPixels", "Failed to create WebGL context")
__all__ = ["Chromium", "Firefox", "axe", "found"]

QUIET = ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--no-first-run")
QUIET += ("--disable-component-update", "--disable-sync", "--force-color-profile=srgb", "--hide-scrollbars")


def _program(*names: str) -> str | None:
    return next((path for path in map(shutil.which, names) if path), None)


def found() -> dict[str, type]:
    """The browsers that this machine can run, with what drives them, by name."""
    there = {}
    if _program("chromium", "google-chrome") and _program("chromedriver") and importlib.util.find_spec("selenium"):
        there["chromium"] = Chromium
    if _program("firefox-esr", "firefox") and importlib.util.find_spec("marionette_driver"):
        there["firefox"] = Firefox
    return there


def axe() -> Path | None:
    """The script of axe-core: in $RELUME_AXE, or where npm puts what is installed for all."""
    npm = shutil.which("npm")
    roots = [os.environ.get("RELUME_AXE", "")]
    if npm:
        roots.append(subprocess.run([npm, "root", "-g"], capture_output=True, text=True).stdout.strip() + "/axe-core")
    return next((Path(root) / "axe.min.js" for root in roots if root and (Path(root) / "axe.min.js").is_file()), None)


def _not_own(heard) -> list[str]:
    return [words for words in heard if not any(own in words for own in OWN)]


class _Browser:
    driver = None

    def open(self, page: Path, words: str = ""):
        """Open a file, and wait until its picture is shown; words: what follows its name, ?query#hash."""
        self._go("about:blank")  # else a new hash alone would not load the page again
        self._go(page.resolve().as_uri() + words)
        self.wait("return document.documentElement.dataset.shown || document.getElementById('status').textContent")
        self.wait("return document.documentElement.dataset.shown")

    def visit(self, page: Path):
        """Open any other file, and wait until all that it shows is there."""
        self._go(page.resolve().as_uri())
        self.wait("return document.readyState === 'complete'")

    def run(self, script: str, *arguments):
        """What a script returns; its arguments are `arguments[0]` and so on."""
        return self.driver.execute_script(script, *arguments)

    def wait(self, script: str, seconds: float = 90.0):
        """Wait until a script returns something true."""
        end = time.monotonic() + seconds
        while not (value := self.run(script)):
            assert time.monotonic() < end, self.run("return document.getElementById('status')?.textContent") or script
            time.sleep(0.1)
        return value

    def barriers(self) -> list[str]:
        """What axe-core finds serious or worse in the page that is open: the rule, and the first place of it."""
        self.run(axe().read_text(encoding="utf-8"))
        self.run("window.found = null; axe.run().then((result) => (window.found = result.violations))")
        (found,) = self.wait("return window.found && [window.found]")
        return [
            f"{each['id']}: {each['nodes'][0]['html']}" for each in found if each["impact"] in ("serious", "critical")
        ]

    def has_webgl(self) -> bool:
        context = "document.createElement('canvas').getContext('webgl2')"
        return bool(self.run(f"return {context}?.getExtension('EXT_color_buffer_float') ? 1 : 0"))

    def pixels(self):
        """(height, width, 4) uint8 of the picture, as the page shows it now."""
        import io

        import numpy as np
        from PIL import Image

        self.run("render()")
        png = self.run("return document.getElementById('picture').toDataURL('image/png')").partition(",")[2]
        return np.asarray(Image.open(io.BytesIO(base64.b64decode(png))).convert("RGBA"))


class Chromium(_Browser):
    def __init__(self, folder: Path):
        from selenium import webdriver

        options = webdriver.ChromeOptions()
        options.binary_location = _program("chromium", "google-chrome")
        for word in (*QUIET, f"--user-data-dir={folder}"):
            options.add_argument(word)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(options, webdriver.ChromeService(_program("chromedriver")))
        self.driver.set_script_timeout(120)

    def _go(self, address: str):
        self.driver.get(address)

    def element(self, selector: str):
        return self.driver.find_element("css selector", selector)

    def size(self, width: int, height: int = 900):
        self.driver.execute_cdp_cmd(
            "Emulation.setDeviceMetricsOverride",
            {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500},
        )

    def scheme(self, name: str):
        """Prefer "light" or "dark"."""
        feature = {"name": "prefers-color-scheme", "value": name}
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [feature]})

    def screenshot(self, path: Path):
        self.driver.save_screenshot(str(path))

    def errors(self) -> list[str]:
        """What the console has heard since it was asked last."""
        heard = self.driver.get_log("browser")
        return _not_own(entry["message"] for entry in heard if entry["level"] in ("SEVERE", "WARNING"))

    def quit(self):
        self.driver.quit()


class Firefox(_Browser):
    def __init__(self, folder: Path):
        from marionette_driver.marionette import Marionette

        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        settings = {
            "marionette.port": port,
            "browser.shell.checkDefaultBrowser": False,
            "app.update.enabled": False,
            "datareporting.policy.dataSubmissionEnabled": False,
            "network.captive-portal-service.enabled": False,
            "network.connectivity-service.enabled": False,
            "services.settings.server": "data:,",
            "gfx.color_management.mode": 0,
            # Else a page that is left in the middle of a handler says that its script was terminated
            "dom.ipc.cancel_content_js_when_navigating": False,
        }
        lines = [
            f"user_pref({str(k)!r}, {str(v).lower() if not isinstance(v, str) else repr(v)});"
            for k, v in settings.items()
        ]
        (folder / "user.js").write_text("\n".join(lines).replace("'", '"'))
        command = [
            _program("firefox-esr", "firefox"),
            "--headless",
            "--marionette",
            "-remote-allow-system-access",
            "--no-remote",
            "--profile",
            str(folder),
        ]
        with open(os.devnull, "wb") as nothing:
            self.process = subprocess.Popen(
                command, stdout=nothing, stderr=nothing, env={**os.environ, "HOME": str(folder)}
            )
        end = time.monotonic() + 90
        while True:
            try:
                self.driver = Marionette(host="127.0.0.1", port=port)
                self.driver.start_session()
                break
            except Exception:
                if self.process.poll() is not None or time.monotonic() > end:
                    raise
                time.sleep(0.5)
        self.driver.timeout.script = 120

    def _go(self, address: str):
        self.driver.navigate(address)

    def run(self, script: str, *arguments):
        return self.driver.execute_script(script, script_args=arguments, sandbox=None)

    def element(self, selector: str):
        return self.driver.find_element("css selector", selector)

    def size(self, width: int, height: int = 900):
        self.driver.set_window_rect(width=width, height=height)

    def screenshot(self, path: Path):
        path.write_bytes(self.driver.screenshot(format="binary", full=False))

    def errors(self) -> list[str]:
        script = """return Services.console.getMessageArray()
            .filter((each) => each instanceof Ci.nsIScriptError && each.sourceName.startsWith("file:")
                && !(each.flags & Ci.nsIScriptError.infoFlag)).map(String);"""
        with self.driver.using_context("chrome"):
            heard = self.driver.execute_script(script)
            self.driver.execute_script("Services.console.reset()")
        return _not_own(heard)

    def quit(self):
        self.driver.delete_session()
        self.process.terminate()
        self.process.wait(30)
