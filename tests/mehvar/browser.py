# SPDX-License-Identifier: Apache-2.0
"""A headless Chromium for tests of pages, with the page's console output and network requests."""

import atexit
import functools
import json
import shutil
import tempfile
from contextlib import contextmanager

import pytest

WINDOW = (1300, 900)


@contextmanager
def chromium():
    """Yield a new tab of the browser of this process, without what earlier pages stored or logged."""
    browser = _started()
    browser.switch_to.new_window("tab")  # what a test emulates ends with its tab
    browser.execute_cdp_cmd("Storage.clearDataForOrigin", {"origin": "*", "storageTypes": "all"})
    for kind in ("browser", "performance"):
        browser.get_log(kind)
    try:
        yield browser
    finally:
        browser.close()
        browser.switch_to.window(browser.window_handles[0])


@functools.cache
def _started():
    """Return a browser that ends with this process; skip the test without one."""
    webdriver = pytest.importorskip("selenium.webdriver", reason="the browser tests need selenium")
    program = shutil.which("chromium") or shutil.which("google-chrome")
    driver = shutil.which("chromedriver")
    if program is None or driver is None:
        pytest.skip("no browser: apt install chromium chromium-driver")
    profile = tempfile.mkdtemp(prefix="mehvar-browser-")
    atexit.register(shutil.rmtree, profile, ignore_errors=True)
    options = webdriver.ChromeOptions()
    options.binary_location = program
    for argument in (
        "--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking",
        "--disable-dev-shm-usage", f"--window-size={WINDOW[0]},{WINDOW[1]}", f"--user-data-dir={profile}",
    ):  # fmt: skip
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    browser = webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))
    atexit.register(browser.quit)
    return browser


def requests(browser):
    """Return the addresses requested by pages since the last call, without data of the page."""
    messages = [json.loads(entry["message"])["message"] for entry in browser.get_log("performance")]
    asked = [m["params"]["request"]["url"] for m in messages if m["method"] == "Network.requestWillBeSent"]
    return [url for url in asked if not url.startswith("data:")]


def prefer(browser, **features):
    """Emulate a reader's preferences: prefers_color_scheme="dark", prefers_reduced_motion="reduce"."""
    values = [{"name": name.replace("_", "-"), "value": value} for name, value in features.items()]
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": values})


def eventually(browser, script, *given):
    """Wait until a script returns a true value, and return it."""
    from selenium.webdriver.support.wait import WebDriverWait

    return WebDriverWait(browser, 15, 0.02).until(lambda b: b.execute_script(f"return {script}", *given))


def show(browser, selector):
    """Scroll to an element."""
    browser.execute_script("document.querySelector(arguments[0]).scrollIntoView({behavior: 'instant'})", selector)
