# SPDX-License-Identifier: Apache-2.0
"""A headless Chromium for tests of pages, with the page's console output and network requests."""

import json
import shutil
from contextlib import contextmanager

import pytest


@contextmanager
def chromium(folder, width=1300, height=900):
    """Yield a browser with its profile below `folder`; skip the test without a browser."""
    webdriver = pytest.importorskip("selenium.webdriver", reason="the browser tests need selenium")
    program = shutil.which("chromium") or shutil.which("google-chrome")
    driver = shutil.which("chromedriver")
    if program is None or driver is None:
        pytest.skip("no browser: apt install chromium chromium-driver")
    options = webdriver.ChromeOptions()
    options.binary_location = program
    for argument in (
        "--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking",
        "--disable-dev-shm-usage", f"--window-size={width},{height}", f"--user-data-dir={folder / 'profile'}",
    ):  # fmt: skip
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    browser = webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))
    try:
        yield browser
    finally:
        browser.quit()


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

    return WebDriverWait(browser, 15, 0.1).until(lambda b: b.execute_script(f"return {script}", *given))


def show(browser, selector):
    """Scroll to an element."""
    browser.execute_script("document.querySelector(arguments[0]).scrollIntoView({behavior: 'instant'})", selector)
