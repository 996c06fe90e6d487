"""The page of a served session in a real browser: it draws, slides, and nothing goes wrong."""

import html
import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from served_flown import flown

from crosstrack.show.served_page import served_page

BROWSER = next(filter(None, map(shutil.which, ["chromium", "chromium-browser", "google-chrome"])), None)
FLAGS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--window-size=1280,900",
    "--virtual-time-budget=20000",
    "--dump-dom",
]
SCRIPT = """
<script>
const errors = [];
addEventListener("error", (event) => errors.push(event.message));
addEventListener("securitypolicyviolation", (event) => errors.push(event.blockedURI));
for (const kind of ["error", "warn"]) console[kind] = (...words) => errors.push(words.join(" "));
const byId = (name) => document.getElementById(name);
const pause = (time) => new Promise((done) => setTimeout(done, time));
const look = () => {
  const [space, above] = ["space", "plan"].map((name) => byId(name).data.at(-1));
  return { space: [space.x, space.y, space.z].map((axis) => Array.from(axis)), above: Array.from(above.x),
    cursor: byId("times").layout.shapes[0].x0, now: byId("now").textContent };
};
(async () => {
  for (let tries = 0; tries < 300 && !document.body.dataset.ready; tries += 1) await pause(50);
  const end = look();
  byId("slider").value = 100;
  byId("slider").dispatchEvent(new Event("input"));
  await pause(200);
  const middle = look();
  const cut = [...document.querySelectorAll(".card, h1, h2, th")]
    .filter((element) => element.scrollWidth > element.clientWidth + 1).map((element) => element.textContent);
  const shown = ["space", "plan", "times"].map((name) => byId(name).data.map((trace) => trace.name));
  const gl = Boolean(document.createElement("canvas").getContext("webgl"));
  const wide = document.documentElement.scrollWidth > innerWidth;
  const text = JSON.stringify({ errors, end, middle, cut, shown, gl, wide });
  const pre = document.createElement("pre");
  pre.id = "seen";
  pre.textContent = text;
  document.body.append(pre);
})();
</script>
"""


@pytest.mark.browser
@pytest.mark.skipif(BROWSER is None, reason="no Chromium")
def test_the_page_works_in_a_browser(tmp_path: Path) -> None:
    path = served_page(flown().session, tmp_path / "a.html")
    path.write_text(path.read_text().replace('<script id="data"', SCRIPT + '<script id="data"', 1))
    command = [str(BROWSER), *FLAGS, f"--user-data-dir={tmp_path / 'profile'}", path.as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    match = re.search(r'<pre id="seen">(.*?)</pre>', done.stdout, re.DOTALL)
    assert match, done.stdout[-2000:]
    seen: dict[str, Any] = json.loads(html.unescape(match[1]))
    assert seen["errors"] == []
    assert seen["gl"]
    assert (seen["cut"], seen["wide"]) == ([], False)
    space, above, times = seen["shown"]
    assert {"objects", "points", "lines", "arrows", "strings", "transforms", "One", "Two"} <= set(space) & set(above)
    assert {"One", "Two"} == set(times)
    for look, time in ((seen["end"], flown().session.duration), (seen["middle"], seen["middle"]["cursor"])):
        assert look["cursor"] == pytest.approx(time, abs=1e-3)
        for number, track in enumerate(flown().session.tracks.values()):
            row = max(np.searchsorted(track.time, time, side="right") - 1, 0)
            near = track.position[max(row - 1, 0) : row + 2]
            here = [axis[number] for axis in look["space"]]
            assert np.abs(near - here).max(axis=1).min() < 0.01
            assert look["above"][number] == here[0]
    assert seen["middle"]["now"] != seen["end"]["now"]
