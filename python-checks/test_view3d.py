"""The page of `report --interactive`: its data against the run file, and what it says without a script.

Where Chromium is installed (Debian: `apt-get install chromium`) also what the script makes of it.
"""

import base64
import html
import json
import re
import shutil
import subprocess
import zlib
from pathlib import Path

import h5py
import numpy as np
import pytest
from matplotlib import image

from conftest import ROOT

CHROMIUM = shutil.which("chromium")
# Reads the page as a hand would use it: slider, field, keys, a click in the middle of the picture.
HANDS = """
<script>
window.addEventListener("load", () => setTimeout(() => {
  const byId = (name) => document.getElementById("view3d-" + name);
  const body = byId("body"), box = body.getBoundingClientRect(), said = { ...byId("figure").dataset };
  const place = { clientX: box.x + box.width / 2, clientY: box.y + box.height / 2, bubbles: true };
  const increment = byId("increment");
  increment.value = 2;
  increment.dispatchEvent(new Event("input"));
  const field = byId("field");
  field.value = "contact_pressure";
  field.dispatchEvent(new Event("change"));
  body.dispatchEvent(new PointerEvent("pointerdown", place));
  body.dispatchEvent(new PointerEvent("pointerup", place));
  const picked = { ...byId("figure").dataset };
  body.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowLeft" }));
  const turned = { ...byId("figure").dataset };
  const requests = performance.getEntriesByType("resource").map((e) => e.name);
  const hidden = !document.querySelector("details.picture").open;
  byId("figure").dataset.hands = JSON.stringify({ said, picked, turned, requests, hidden });
}, 1000));
</script>
"""


def arrays_of(text: str) -> tuple[dict, dict[str, np.ndarray]]:
    """What the page says of its data, and each array as [frame, row, column]."""
    block = r'<script id="view3d-{}" type="[a-z/]*">(.*?)</script>'
    page, packed = (
        re.search(block.format(name), text, flags=re.DOTALL)[1]
        for name in ("data", "arrays")
    )
    page, raw = json.loads(page), zlib.decompress(base64.b64decode(packed), wbits=-15)
    found, at = {}, 0
    for said in page["arrays"]:
        shape = [said["frames"], 4, said["rows"], said["columns"]]
        size = int(np.prod(shape))
        planes = np.frombuffer(raw, np.uint8, size, at).astype(np.uint32).reshape(shape)
        at += size
        change = sum(planes[:, k] << np.uint32(8 * k) for k in range(4))
        bits = np.bitwise_xor.accumulate(change, axis=0)
        found[said["key"]] = bits.view(np.float32).astype(float)
    assert at == len(raw)
    return page, found


def alike(found: np.ndarray, expected: np.ndarray) -> bool:
    """Whether values are others in single precision: half a unit in the last place."""
    return bool((np.abs(found - expected) <= 0.6e-7 * np.abs(expected)).all())


@pytest.fixture(scope="module")
def history(contact3d, tmp_path_factory) -> tuple[Path, Path]:
    """A load history, and its page."""
    folder = tmp_path_factory.mktemp("view3d")
    file, out = folder / "run.h5", folder / "page.html"
    small = ["--set", "body.brick.cells=[6,2,2]"]
    contact3d(
        "run", ROOT / "pipelines" / "history.toml", file, "--no-figures", *small
    )
    contact3d("report", file, "--interactive", out)
    return file, out


def test_the_data_are_those_of_the_file(history):
    file, out = history
    page, arrays = arrays_of(out.read_text(encoding="utf-8"))

    def agree(key: str, values: np.ndarray):
        assert alike(arrays[key], values), key

    with h5py.File(file) as run:
        mesh, records = run["mesh"], run["history"]
        facets = mesh["facets"][:]
        corners = mesh["coordinates"][:][facets]
        assert len(page["frames"]) == len(records["time"]) == 25
        triangles = arrays["triangles"][0].astype(int)
        found = arrays["points"][0][triangles]
        # Each triangle of the page lies on one of the boundary, in the same orientation.
        order = [np.abs(corners - one).max(axis=(1, 2)).argmin() for one in found]
        assert sorted(order) == list(range(len(facets)))
        assert alike(found, corners[order])
        displacement = records["displacement"][:][:, facets[order]]
        assert alike(arrays["displacement"][:, triangles], displacement)
        stresses = records["von_mises"][:][:, facets[order], None]
        assert alike(arrays["von_mises"][:, triangles], stresses)
        pane = np.full(len(facets), np.nan)
        pane[mesh["contact_facets"][:]] = mesh["contact_facet_pane"][:]
        assert np.array_equal(
            arrays["triangle_pane"][0, :, 0], pane[order], equal_nan=True
        )
        agree("contact_pressure", records["multiplier_normal"][:][..., None])
        agree("friction_stress", -records["multiplier_tangential"][:])
        agree("contact_zone", records["contact_zone"][:][..., None])
        agree("contact_gap", records["gap"][:][..., None])
        for axis in (0, 1):
            agree(f"friction_{axis + 1}", records["friction"][..., axis][..., None])
        error = next(said for said in page["arrays"] if said["key"] == "error")
        assert error["first"] == 24 and error["frames"] == 1
        # The foundation is where the contact face is, and goes on beyond it.
        contact = mesh["coordinates"][:][np.unique(facets[mesh["contact_facets"][:]])]
        ground = arrays["obstacle_points"][0]
        assert np.abs(arrays["obstacle_gaps"]).max() == 0.0
        assert alike(ground[:, 2], contact[0, 2])
        assert ground[:, 0].max() > contact[:, 0].max()


def test_only_its_own_script_runs_and_nothing_is_loaded(history):
    text = history[1].read_text(encoding="utf-8")
    policy = html.unescape(
        re.search(r'http-equiv="Content-Security-Policy" content="(.*?)"', text)[1]
    )
    nonce = re.search(r"script-src 'nonce-([0-9a-f]{32})'", policy)[1]
    script = re.findall(rf'<script nonce="{nonce}">(.*?)</script>', text, flags=re.DOTALL)
    style = re.findall(rf'<style nonce="{nonce}">(.*?)</style>', text, flags=re.DOTALL)
    assert len(script) == len(style) == 1
    assert len(re.findall("<style", text)) == 1 and text.count(nonce) == 4

    assert policy.split("; ") == [
        "default-src 'none'",
        f"script-src 'nonce-{nonce}'",
        f"style-src 'nonce-{nonce}'",
        "img-src data:",
        "base-uri 'none'",
        "form-action 'none'",
    ]
    assert not re.search(r"https?://", script[0]) and "fetch(" not in script[0]


def test_without_a_script_there_are_pictures_and_words(history):
    text = history[1].read_text(encoding="utf-8")
    pictures = re.findall(r'<img src="data:image/png;base64,([^"]*)" alt="', text)
    assert len(pictures) == 3
    assert all(base64.b64decode(p).startswith(b"\x89PNG\r\n") for p in pictures)
    assert text.count('<details class="picture" open>') == 3
    assert 'id="view3d-figure" hidden' in text.replace('class="view3d" ', "")
    assert "needs JavaScript" in text and 'id="load-history"' in text


@pytest.mark.parametrize(
    "scene", ["elastic_only", "hertz_sphere", "dry_and_greased", "nodal"]
)
def test_other_bodies_have_what_they_have(contact3d, tmp_path, scene):
    file, out = tmp_path / "run.h5", tmp_path / "page.html"
    contact3d("run", ROOT / "pipelines" / f"{scene}.toml", file, "--no-figures")
    contact3d("report", file, "--interactive", out)
    page, arrays = arrays_of(out.read_text(encoding="utf-8"))
    assert len(page["frames"]) == 1
    with h5py.File(file) as run:
        is_in_contact = "contact_facets" in run["mesh"]
        assert ("contact_pressure" in arrays) == ("obstacle_points" in arrays) == is_in_contact
        if not is_in_contact:
            return
        panes = arrays["triangle_pane"][0, :, 0]
        n_panes = len(run["post/normal_stress"])
        assert set(panes[~np.isnan(panes)]) == set(range(n_panes))
        assert alike(arrays["contact_pressure"][0, :, 0], -run["post/normal_stress"][:])
    corners = arrays["points"][0][arrays["triangles"][0].astype(int)]
    sides = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    # The boundary is closed: its area vectors cancel, up to the rounding of points.
    extent = np.abs(corners).max()
    assert np.abs(sides.sum(axis=0)).max() <= 1e-5 * extent**2


SWEEP = """
scene = "{scene}"

[[axis]]
keys = ["traction.0.value", "body.brick.cells"]
rows = [
    [[1e7, 0.0, 2e7], [6, 2, 2]],
    [[5e6, 0.0, 2e7], [6, 2, 2]],
    [[1e7, 0.0, 2e7], [8, 2, 2]],
    [[2e7, 0.0, 2e7], [6, 2, 2]],
]
"""


def test_a_sweep_has_no_body(contact3d, tmp_path):
    cases, file, out = (tmp_path / name for name in ("cases", "sweep.toml", "page.html"))
    file.write_text(SWEEP.format(scene=ROOT / "pipelines" / "newton.toml"))
    cases.mkdir()
    contact3d("sweep", "summary", file, cases)
    refused = contact3d("report", cases, "--interactive", out, expect=2)
    assert "take the run file of a case" in refused.stderr and not out.exists()


def chromium(address: str, *more: str) -> str:
    """The page after its script, without network; WebGL draws in software."""
    command = [CHROMIUM, "--headless=new", "--no-sandbox"]
    command += ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    command += ["--host-resolver-rules=MAP * ~NOTFOUND", "--window-size=1300,950"]
    command += ["--enable-logging=stderr", "--v=0", "--virtual-time-budget=5000", *more]
    done = subprocess.run(
        [*command, address], capture_output=True, text=True, check=True, timeout=120
    )
    console = [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    # What software drivers say of themselves.
    console = [line for line in console if "WebGL" not in line]
    assert not console, console
    return done.stdout


def state(dom: str) -> dict[str, str]:
    figure = re.search(r'<div [^>]*id="view3d-figure"[^>]*>', dom)[0]
    return {
        key: html.unescape(v) for key, v in re.findall(r'data-([a-z]+)="(.*?)"', figure)
    }


@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")
def test_a_browser_follows_address_slider_pointer_and_keys(history, tmp_path):
    file, out = history
    words = "increment=3&field=contact_zone&pane=1"
    address = f"{out.as_uri()}#view3d?{words}"
    with h5py.File(file) as run:
        zones = ["open", "stick", "slip"]
        zone = zones[run["history/contact_zone"][2, 1]]
        pressure = run["history/multiplier_normal"][:]
    shown = state(chromium(address, "--dump-dom"))
    assert shown["ready"] == "true"
    assert (shown["increment"], shown["field"], shown["pane"]) == ("3", "contact_zone", "1")
    assert f"zone {zone}" in shown["values"]
    said = float(re.search(r"contact pressure (\S+) Pa", shown["values"])[1])
    # Shown with six digits.
    assert said == pytest.approx(pressure[2, 1], rel=1e-5)

    # A policy keeps other scripts out, so hands work on a copy without one.
    copy = tmp_path / "copy.html"
    text = out.read_text(encoding="utf-8")
    text = re.sub(r'<meta http-equiv="Content-Security-Policy"[^>]*>', "", text)
    copy.write_text(text.replace("</footer>", HANDS + "</footer>"), encoding="utf-8")
    dom = chromium(copy.as_uri(), "--dump-dom")
    seen = json.loads(state(dom)["hands"])
    assert seen["said"]["increment"] == "25" and seen["said"]["field"] == "displacement"
    picked = seen["picked"]
    assert (picked["increment"], picked["field"]) == ("2", "contact_pressure")
    pane = int(picked["pane"])
    assert picked["values"].startswith(f"pane {pane}; contact pressure")
    said = float(re.search(r"contact pressure (\S+) Pa", picked["values"])[1])
    assert said == pytest.approx(pressure[1, pane], rel=1e-5)
    assert seen["turned"]["azimuth"] != picked.get("azimuth")
    assert seen["requests"] == [] and seen["hidden"]


@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")
def test_a_browser_without_webgl_shows_pictures(history):
    address = history[1].as_uri() + "#view3d?field=contact_zone"
    dom = chromium(address, "--disable-3d-apis", "--dump-dom")
    assert "ready" not in state(dom)
    assert "The view cannot be shown (it needs WebGL 2)" in dom
    assert re.search(r'<div [^>]*id="view3d-figure"[^>]* hidden', dom)
    assert dom.count('<details class="picture" open') == 3


@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")
def test_a_browser_draws_a_picture(history, tmp_path):
    picture = tmp_path / "picture.png"
    # High enough not to scroll, which leaves screenshots white.
    size = "--window-size=1300,6000"
    address = history[1].as_uri() + "#view3d?field=contact_zone"
    chromium(address, f"--screenshot={picture}", size)
    colours = image.imread(picture)[..., :3].reshape(-1, 3)
    # Slip on the contact face, shaded by the light on it.
    slip = np.array([0xC4, 0x4E, 0x00]) / 255
    share = colours[:, :1] / slip[0]
    alike = np.abs(colours - share * slip).max(axis=1) < 0.02
    assert (alike & (share[:, 0] > 0.7)).sum() > 5_000
