"""The page of a comparison in a real browser: it draws, trackers come and go, nothing is cut off."""

import html
import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from crosstrack.campaign.flights import fly
from crosstrack.mission import loads
from crosstrack.show.comparison import comparison_page

BROWSER = next(filter(None, map(shutil.which, ["chromium", "chromium-browser", "google-chrome"])), None)
FLAGS = ["--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=20000", "--dump-dom"]
PANELS = ("plan", "boxes", "speeds", "times")
MISSION = "start: {position: [0, 0, 5]}\nroute: [[6, 0, 5], [6, 5, 6]]\nspeed: 3\n"
SCRIPT = """
<script>
const errors = [];
addEventListener("error", (event) => errors.push(event.message));
addEventListener("securitypolicyviolation", (event) => errors.push(event.blockedURI));
const byId = (name) => document.getElementById(name);
const pause = (time) => new Promise((done) => setTimeout(done, time));
const shown = (name) => byId(name).data.filter((trace) => trace.meta !== undefined && trace.visible !== false)
  .map((trace) => trace.meta);
const look = () => ({
  visible: Object.fromEntries(["plan", "boxes", "speeds", "times"].map((name) => [name, [...new Set(shown(name))]])),
  pressed: [...document.querySelectorAll("#legend [data-tracker]")].map((button) => button.ariaPressed),
  lines: byId("plan").querySelectorAll(".scatterlayer path.js-line").length,
  title: [...document.querySelectorAll(".group .title")].filter((title) => title.offsetParent)
    .map((title) => title.textContent),
  outside: outside(),
  filled: byId("speeds").querySelector("svg").clientWidth / byId("speeds").parentElement.clientWidth,
  tracking: Boolean(byId("tracking").offsetParent),
});
const outside = () => [...document.querySelectorAll(".plot")].flatMap((plot) => {
  const room = plot.getBoundingClientRect();
  return [...plot.querySelectorAll("svg text")].filter((text) => {
    const box = text.getBoundingClientRect();
    return box.width && (box.left < room.left - 1 || box.right > room.right + 1 || box.bottom > room.bottom + 1);
  }).map((text) => text.textContent);
});
const cut = () => [...document.querySelectorAll("h1, h2, th, td, button, small")]
  .filter((element) => element.scrollWidth > element.clientWidth + 1 && getComputedStyle(element).display !== "inline")
  .map((element) => element.textContent.trim());
(async () => {
  while (!document.body.dataset.ready) await pause(50);
  const seen = { start: look() };
  const [first, second] = document.querySelectorAll("#legend [data-tracker]");
  first.click();
  await pause(300);
  seen.hidden = look();
  first.click();
  second.dispatchEvent(new MouseEvent("dblclick"));
  await pause(300);
  seen.alone = look();
  byId("all").click();
  byId("group").value = "1";
  byId("group").dispatchEvent(new Event("change"));
  await pause(300);
  seen.other = look();
  seen.cut = cut();
  seen.wide = document.documentElement.scrollWidth > innerWidth;
  seen.errors = errors;
  const told = document.createElement("output");
  told.id = "seen";
  told.textContent = JSON.stringify(seen);
  document.body.append(told);
})();
</script>
"""


@pytest.fixture(scope="module")
def results() -> list[dict[str, Any]]:
    """Two trackers on a mission with and without a trajectory."""
    found = []
    for name, more in (("planned", "planner: {kind: minimum_snap, guide: 0}"), ("bend", "")):
        for word, tracker in (
            ("carrot", "{kind: carrot}"),
            ("carrot:lookahead=3,heading_gain=0.25", "{kind: carrot, lookahead: 3}"),
        ):
            mission = loads(f"{MISSION}name: {name}\ntracker: {tracker}\n{more}")
            labels = {"mission": name, "tracker": word, "wind": "calm", "seed": 1}
            found.append(fly({"document": mission.document(), "files": {}, "labels": labels}))
    return found


@pytest.mark.browser
@pytest.mark.skipif(BROWSER is None, reason="no Chromium")
@pytest.mark.parametrize("width", [1200, 480])
def test_the_page_works_in_a_browser(results: list[dict[str, Any]], width: int, tmp_path: Path) -> None:
    path = comparison_page(results, tmp_path / "a.html")
    path.write_text(path.read_text("utf-8").replace("<body>", f"<body>{SCRIPT}"), encoding="utf-8")
    command = [
        str(BROWSER),
        *FLAGS,
        f"--window-size={width},1600",
        f"--user-data-dir={tmp_path}/profile",
        path.as_uri(),
    ]
    page = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True).stdout
    found = re.search(r'<output id="seen">(.*?)</output>', page, re.S)
    assert found is not None
    seen = json.loads(html.unescape(found[1]))
    assert seen["errors"] == []
    shown = {name: sorted(trackers) for name, trackers in seen["start"]["visible"].items()}  # boxes stand as ranked
    assert shown == {name: [0, 1] for name in PANELS}
    assert seen["start"]["lines"] == 3
    assert seen["start"]["title"] == ["planned"]
    assert seen["start"]["tracking"]
    assert seen["hidden"]["visible"] == {name: [1] for name in PANELS}
    assert seen["hidden"]["pressed"] == ["false", "true"]
    assert seen["hidden"]["lines"] == 2
    assert seen["alone"]["visible"]["times"] == [1]
    assert seen["alone"]["pressed"] == ["false", "true"]
    assert seen["other"]["title"] == ["bend"]
    assert seen["other"]["visible"]["plan"] == [0, 1]
    assert not seen["other"]["tracking"]
    assert seen["other"]["filled"] > 0.9
    assert seen["start"]["outside"] == seen["other"]["outside"] == []
    assert (seen["cut"], seen["wide"]) == ([], False)
