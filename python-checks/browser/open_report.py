"""Open a report in a headless Chromium without network, and look at what it shows.

    python3 python-checks/browser/open_report.py report.html screenshot.png

Pages of `report --interactive` have a test, test_view3d.py. Run by hand (Debian: `apt-get install chromium`); pytest does not collect it. Fails on a
console message, a request, a figure that is not visible, or a value that does not show when
the pointer is over it. The screenshot is for the eye.
"""

import html
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

# Reads, in the page, what a person would see; the result replaces the page's text.
PROBE = """
<script>
window.addEventListener("load", () => {
  const box = (e) => e.getBoundingClientRect();
  const titleAt = (e) => {
    e.scrollIntoView({block: "center"});
    const r = box(e);
    const hit = document.elementFromPoint(r.x + r.width / 2, r.y + r.height / 2);
    const group = hit && hit.closest("g");
    const title = group && group.querySelector(":scope > title");
    return title ? title.textContent : "";
  };
  const valued = [...document.querySelectorAll("figure svg g")]
    .filter((g) => g.querySelector(":scope > title"));
  const result = {
    figures: [...document.querySelectorAll("figure svg")]
      .map((e) => [box(e).width, box(e).height]),
    sections: [...document.querySelectorAll("section")].map((e) => e.id),
    width: [document.documentElement.scrollWidth, window.innerWidth],
    requests: performance.getEntriesByType("resource").map((e) => e.name),
    valued: valued.length,
    hovered: valued.filter((g) => titleAt(g) !== "").length,
  };
  document.body.textContent = "PROBE" + JSON.stringify(result) + "PROBE";
});
</script>
"""


def chromium(*arguments: str) -> subprocess.CompletedProcess:
    with tempfile.TemporaryDirectory() as profile:
        command = [
            "chromium",
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            "--host-resolver-rules=MAP * ~NOTFOUND",
            "--hide-scrollbars",
            "--window-size=1400,5200",
            f"--user-data-dir={profile}",
            "--enable-logging=stderr",
            "--v=0",
            *arguments,
        ]
        return subprocess.run(
            command, capture_output=True, text=True, check=True, timeout=120
        )


def probe(page: Path) -> dict:
    """What the page shows, measured by a script added to a copy of it."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "probed.html"
        text = page.read_text(encoding="utf-8")
        copy.write_text(text.replace("</body>", PROBE + "</body>"), encoding="utf-8")
        dom = chromium("--dump-dom", copy.as_uri()).stdout
    found = re.search("PROBE(.*?)PROBE", dom, flags=re.DOTALL)
    assert found, "the page did not load"
    return json.loads(html.unescape(found[1]))


def main() -> None:
    page, screenshot = (Path(argument).resolve() for argument in sys.argv[1:3])
    shown = chromium(f"--screenshot={screenshot}", page.as_uri())
    console = [line for line in shown.stderr.splitlines() if "CONSOLE" in line]
    assert not console, console
    seen = probe(page)
    print(json.dumps(seen, indent=1))
    assert seen["requests"] == [], seen["requests"]
    assert seen["figures"] and all(w > 300 and h > 100 for w, h in seen["figures"])
    assert seen["width"][0] <= seen["width"][1], "the page is wider than the window"
    # Markers of a chart may hide each other, panes of a map may not.
    assert seen["hovered"] >= 0.95 * seen["valued"], "values that do not show"
    print(f"{page.name}: nothing wrong; now look at {screenshot}")


if __name__ == "__main__":
    main()
