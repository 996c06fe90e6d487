"""The report in a real browser, driven over the DevTools protocol."""

import json
import os
import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
import pytest
from encounters import MOVERS, meeting

from crosstrack.flight.flight import Flight
from crosstrack.mission import loads
from crosstrack.mission.certified import certified
from crosstrack.show.plan_page import plan_page
from crosstrack.show.report import report

BROWSER = next(filter(None, map(shutil.which, ["chromium", "chromium-browser", "google-chrome"])), None)
FLAGS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--window-size=1280,900",
    "--remote-debugging-pipe",
]
PATIENCE = 60


class Browser:
    """One page of a Chromium that listens on its descriptors 3 and 4; `events` are all that it tells unasked."""

    def __init__(self, folder: Path) -> None:
        self.events: list[dict[str, Any]] = []
        self._count = 0
        here, there = os.pipe(), os.pipe()
        script = f'exec "$0" "$@" 3<&{here[0]} 4>&{there[1]}'
        command = ["bash", "-c", script, str(BROWSER), *FLAGS, f"--user-data-dir={folder / 'profile'}", "about:blank"]
        self._process = subprocess.Popen(command, pass_fds=(here[0], there[1]), stderr=subprocess.DEVNULL)
        os.close(here[0])
        os.close(there[1])
        self._ask, self._hear = os.fdopen(here[1], "wb", 0), os.fdopen(there[0], "rb")
        self._messages = self._listen()
        self._session: dict[str, str] = {}
        targets = self.call("Target.getTargets")["targetInfos"]
        page = next(target["targetId"] for target in targets if target["type"] == "page")
        attached = self.call("Target.attachToTarget", targetId=page, flatten=True)
        self._session = {"sessionId": attached["sessionId"]}
        for domain in ("Page", "Network", "Runtime", "Log"):
            self.call(f"{domain}.enable")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._ask.close()
        self._process.terminate()
        self._process.wait(PATIENCE)
        self._hear.close()

    def _listen(self) -> Iterator[dict[str, Any]]:
        rest = b""
        while data := os.read(self._hear.fileno(), 1 << 16):
            *whole, rest = (rest + data).split(b"\0")
            yield from map(json.loads, whole)

    def call(self, method: str, **parameters: Any) -> Any:
        """Ask for something and return the answer."""
        self._count += 1
        request = {"id": self._count, "method": method, "params": parameters} | self._session
        self._ask.write(json.dumps(request).encode() + b"\0")
        for message in self._messages:
            if message.get("id") == self._count:
                assert "error" not in message, message
                return message["result"]
            self.events.append(message)
        raise EOFError("the browser is gone")

    def run(self, script: str) -> Any:
        """Return what the body of an async function returns."""
        expression = f"(async () => {{ {TOOLS} {script} }})()"
        answer = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def told(self, method: str) -> list[dict[str, Any]]:
        """Return the events of a kind."""
        return [event["params"] for event in self.events if event["method"] == method]


TOOLS = """
const pause = (time) => new Promise((done) => setTimeout(done, time));
const byId = (name) => document.getElementById(name);
const trace = (name) => byId("space").data.find((trace) => trace.name === name);
const look = () => ({
  vehicle: ["x", "y", "z"].map((axis) => trace("vehicle")[axis][6]),
  carrot: ["x", "y", "z"].map((axis) => trace("carrot")[axis][1]),
  mark: ["x", "y"].map((axis) => byId("plan").data.at(-1)[axis][0]),
  cursor: byId("times").layout.shapes[0].x0,
  now: byId("now").textContent,
  stop: +byId("slider").value,
});
"""
READY = """
for (let tries = 0; tries < 1200 && !document.body?.dataset.ready; tries += 1) await pause(50);
return look();
"""
SLIDE = "byId('slider').value = 120; byId('slider').dispatchEvent(new Event('input')); return look();"
COLOURS = """
const image = new Image();
image.src = await Plotly.toImage(byId("space"), { format: "png", width: 500, height: 400 });
await image.decode();
const pen = Object.assign(document.createElement("canvas"), { width: 500, height: 400 }).getContext("2d");
pen.drawImage(image, 0, 0);
const pixels = pen.getImageData(0, 0, 500, 400).data, found = new Set();
for (let at = 0; at < pixels.length; at += 4) found.add(pixels.slice(at, at + 3).join());
return found.size;
"""
RECOLOUR = """
byId("coloring").value = "speed";
byId("coloring").dispatchEvent(new Event("change"));
return trace("flown").line.colorbar.title.text;
"""
PLAY = """
const before = look();
byId("play").click();
while (look().stop <= before.stop + 3) await pause(20);
byId("play").click();
const stopped = look();
await pause(300);
return [before, stopped, look()];
"""
CUT_OFF = """
const cut = [...document.querySelectorAll(".card, h1, h2, th, td")]
  .filter((element) => element.scrollWidth > element.clientWidth + 1).map((element) => element.textContent);
return [cut, document.documentElement.scrollWidth > innerWidth];
"""


@pytest.fixture
def browser(tmp_path: Path) -> Iterator[Browser]:
    with Browser(tmp_path) as started:
        yield started


def visit(browser: Browser, path: Path) -> Any:
    """Open a report and return what it shows at first."""
    browser.call("Page.navigate", url=path.as_uri())
    return browser.run(READY)


def check_quiet(browser: Browser, path: Path) -> None:
    """No error, no warning, and nothing fetched but the page."""
    assert browser.told("Runtime.exceptionThrown") == []
    loud = [event for event in browser.told("Runtime.consoleAPICalled") if event["type"] in ("error", "warning")]
    assert loud == []
    assert [event["entry"] for event in browser.told("Log.entryAdded") if event["entry"]["level"] == "error"] == []
    asked = {event["request"]["url"] for event in browser.told("Network.requestWillBeSent")}
    assert {url for url in asked if not url.startswith(("data:", "blob:"))} == {path.as_uri()}


@pytest.mark.browser
@pytest.mark.skipif(BROWSER is None, reason="no Chromium")
def test_report_works_in_a_browser(flight: Flight, browser: Browser, tmp_path: Path) -> None:
    path = report([flight], tmp_path / "a.html")
    start = visit(browser, path)
    assert start["stop"] == 0
    np.testing.assert_allclose(start["vehicle"], flight.record.position[0], atol=1e-4)
    check_slider(browser.run(SLIDE), flight)
    assert browser.run(COLOURS) > 200
    assert browser.run(RECOLOUR) == "speed (m/s)"
    before, stopped, later = browser.run(PLAY)
    assert before["stop"] < stopped["stop"]
    assert before["mark"] != stopped["mark"]
    assert stopped == later
    assert browser.run(CUT_OFF) == [[], False]
    check_quiet(browser, path)


def check_slider(seen: Any, flight: Flight) -> None:
    record = flight.record
    row = np.searchsorted(record.time, seen["cursor"], side="right") - 1
    assert record.time[row] == pytest.approx(record.time[-1] * 120 / 199, abs=0.03)
    np.testing.assert_allclose(seen["vehicle"], record.position[row], atol=1e-4)
    np.testing.assert_allclose(seen["carrot"], record.aim[row], atol=1e-4)
    np.testing.assert_allclose(seen["mark"], record.position[row, :2], atol=1e-4)
    assert "m/s" in seen["now"]


@pytest.mark.browser
@pytest.mark.skipif(BROWSER is None, reason="no Chromium")
def test_several_flights_work_in_a_browser(fly_square: Callable[..., Flight], browser: Browser, tmp_path: Path) -> None:
    flights = [fly_square(name="calm <b>"), fly_square(name="windy & far", wiggle=0.5, duration=12.0)]
    path = report(flights, tmp_path / "a.html")
    visit(browser, path)
    seen, record = browser.run(SLIDE), flights[1].record
    row = np.searchsorted(record.time, seen["cursor"], side="right") - 1
    np.testing.assert_allclose(seen["mark"], record.position[row, :2], atol=1e-4)
    assert browser.run(COLOURS) > 200
    assert browser.run(CUT_OFF) == [[], False]
    check_quiet(browser, path)


MET = """
const mover = (plot) => byId(plot).data.filter((trace) => trace.meta === "mover").map((trace) => Array.from(trace.x));
const before = [mover("space"), mover("plan")];
const seen = look();
SLIDE
return [before, [mover("space"), mover("plan")], look().cursor];
""".replace("SLIDE", SLIDE.replace("return look();", ""))


@pytest.mark.browser
@pytest.mark.skipif(BROWSER is None, reason="no Chromium")
def test_moving_obstacles_move_with_the_slider_in_a_browser(flight: Flight, browser: Browser, tmp_path: Path) -> None:
    path = report([meeting(flight)], tmp_path / "a.html")
    visit(browser, path)
    before, after, now = browser.run(MET)
    for first, second in zip(before, after, strict=True):
        for mover, early, late in zip(MOVERS, first, second, strict=True):
            np.testing.assert_allclose(np.subtract(late, early), mover.shift(now)[0], atol=1e-3)
    assert browser.run(COLOURS) > 200
    assert browser.run(CUT_OFF) == [[], False]
    check_quiet(browser, path)


PLAN_READY = """
for (let tries = 0; tries < 1200 && !document.body?.dataset.ready; tries += 1) await pause(50);
return ["space", "plan", "times"].map((name) => byId(name).data.map((trace) => trace.name));
"""


@pytest.mark.browser
@pytest.mark.skipif(BROWSER is None, reason="no Chromium")
def test_the_page_of_a_plan_works_in_a_browser(browser: Browser, tmp_path: Path) -> None:
    text = "start: {position: [0, 0, 5]}\nroute: [[6, 0, 5], [6, 5, 6]]\nplanner: {kind: minimum_snap, guide: auto}\n"
    mission = loads(text + "world: {shapes: [{box: {min: [1, 2, 0], max: [3, 4, 9]}}]}")
    path = plan_page(certified(mission, mission.build()), tmp_path / "plan.html")
    browser.call("Page.navigate", url=path.as_uri())
    space, above, times = browser.run(PLAN_READY)
    assert {"route", "trajectory", "corridor", "obstacles", "start", "goal"} <= set(space) & set(above)
    assert {"all", "vertical", "limit", "vertical limit", "allowed"} <= set(times)
    assert browser.run(COLOURS) > 200
    assert browser.run(CUT_OFF) == [[], False]
    check_quiet(browser, path)
