"""Reports in a browser: a page opens without an error, shows the numbers of the tables, and its controls do what they say.

COMMINUTE_COMMAND names the command. Needs selenium and Debian's chromium-driver.
"""

from __future__ import annotations

import csv
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select, WebDriverWait

ROOT = Path(__file__).resolve().parents[2]
COMMAND = os.environ.get("COMMINUTE_COMMAND", "comminute")


def comminute(*words: str | Path) -> None:
    subprocess.run([COMMAND, *map(str, words), "--quiet"], cwd=ROOT, check=True)


@pytest.fixture(scope="session")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The oedometer of petroleum coke, made so small that it takes a second; some grains break."""
    small = {
        "specimen.scale": 4.0,
        "specimen.grains": 240,
        "specimen.porosity": 0.46,
        "preparation.growth_friction": 0.4,
        "preparation.growth_steps": 1500,
        "preparation.porosity_tolerance": 0.02,
        "loading.settle_steps": 500,
        "loading.max_stress_kPa": 600,
    }
    sets = [word for key, value in small.items() for word in ("--set", f"{key}={value}")]
    out = tmp_path_factory.mktemp("runs") / "run"
    comminute("run", "experiments/petroleum_coke/h-c-2.toml", *sets, "--out", out)
    return out


@pytest.fixture(scope="session")
def browser() -> Iterator[webdriver.Chrome]:
    options = webdriver.ChromeOptions()
    flags = ["--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    for flag in [*flags, "--window-size=1300,1000"]:
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))
    yield driver
    driver.quit()


def opened(browser: webdriver.Chrome, page: Path) -> float:
    """Opens a page, waits until all of it is there, and checks that nothing went wrong; gives the milliseconds until then."""
    browser.get(page.as_uri())
    WebDriverWait(browser, 120).until(lambda b: b.execute_script("return window.report?.ready"))
    unharmed(browser)
    took: float = browser.execute_script("return report.opened")
    return took


def unharmed(browser: webdriver.Chrome) -> None:
    assert browser.execute_script("return report.errors") == []
    # the software renderer reports that reading pixels is slow; nothing else may be said
    said = [entry["message"] for entry in browser.get_log("browser") if "GPU stall" not in entry["message"]]
    assert said == []


def rows(table: Path) -> list[dict[str, str]]:
    with table.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


@pytest.fixture(scope="session")
def page(run: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("pages") / "one.html"
    comminute("report", run, "--out", out)
    return out


CHARTS = """return report.charts.map(({ name, chart }) => ({ name, points: chart.data.datasets.filter((set) => !set.edge).flatMap((set) => set.data.map(({ x, y }) => [x, y])),
    shown: chart.getSortedVisibleDatasetMetas().length, log: ["x", "y"].map((axis) => chart.options.scales[axis].type === "logarithmic"),
    box: ["x", "y"].map((axis) => [chart.scales[axis].min, chart.scales[axis].max]) }))"""


def charts(browser: webdriver.Chrome) -> dict[str, dict[str, Any]]:
    return {chart["name"]: chart for chart in browser.execute_script(CHARTS)}


def test_every_figure_is_a_chart_with_the_numbers_of_its_csv(browser: webdriver.Chrome, page: Path, run: Path) -> None:
    opened(browser, page)
    shown = charts(browser)
    figures = {path.stem for path in (run / "figures").glob("*.csv")} - {"specimen", "force_chains", "section", "bodies", "points"}
    assert figures == shown.keys()
    for name, chart in shown.items():
        drawn = [[float(x) for x in list(row.values())[2:4]] for row in rows(run / "figures" / f"{name}.csv")]
        assert chart["points"] == drawn, name
        assert len(drawn) > 1
    assert shown["compression"]["log"] == [True, False]
    low, high = shown["compression"]["box"][0]
    assert low <= 0.005 and high >= 0.3, "the axis reaches from the first to the last stress, MPa"


def test_keys_show_values_and_zoom(browser: webdriver.Chrome, page: Path) -> None:
    opened(browser, page)
    canvas = browser.find_element(By.CSS_SELECTOR, "#figure-compression canvas")
    browser.execute_script("arguments[0].focus()", canvas)
    before = charts(browser)["compression"]["box"]
    canvas.send_keys(Keys.ARROW_RIGHT, Keys.ARROW_RIGHT)
    tip = "return report.charts.find((c) => c.name === 'compression').chart.tooltip.dataPoints?.[0].dataIndex"
    assert browser.execute_script(tip) == 1
    canvas.send_keys("+")
    near = charts(browser)["compression"]["box"]
    assert near[1][1] - near[1][0] < before[1][1] - before[1][0]
    canvas.send_keys("0")
    assert charts(browser)["compression"]["box"] == before
    browser.find_element(By.CSS_SELECTOR, "#figure-compression .tools button").click()
    assert charts(browser)["compression"]["log"] == [False, False]
    unharmed(browser)


def pixels(browser: webdriver.Chrome) -> str:
    seen: str = browser.execute_script("return report.view.pixels()")
    return seen


def move(browser: webdriver.Chrome, selector: str, value: float) -> None:
    """Puts a slider to a value, as a hand does."""
    script = "const s = document.querySelector(arguments[0]); s.value = arguments[1]; s.dispatchEvent(new Event('input'))"
    browser.execute_script(script, selector, value)


def grains(run: Path) -> list[int]:
    """Number of grains in each snapshot, of the files."""
    heads = [path.read_bytes()[:2000].decode("ascii", "replace") for path in sorted((run / "snapshots").glob("step_*.vtp"))]
    return [int(head.split('NumberOfPoints="')[1].split('"')[0]) for head in heads]


def test_slider_colours_cut_and_keys_change_the_scene(browser: webdriver.Chrome, page: Path, run: Path) -> None:
    opened(browser, page)
    counts = grains(run)
    assert len(counts) >= 2 and counts[-1] > counts[0], "some have broken"
    layers = "return report.view.layers().filter((l) => l.kind === 'grains').map((l) => l.count)"
    seen = [pixels(browser)]
    assert browser.execute_script(layers) == [counts[-1]]
    move(browser, "#snapshot", 0)
    assert browser.execute_script(layers) == [counts[0]]
    seen.append(pixels(browser))
    Select(browser.find_element(By.ID, "field")).select_by_value("force")
    low, high = browser.execute_script("return report.view.limits")
    assert 0 <= low < high
    seen.append(pixels(browser))
    Select(browser.find_element(By.CSS_SELECTOR, "#specimen .controls fieldset:nth-of-type(3) select")).select_by_value("y")
    seen.append(pixels(browser))
    move(browser, "[aria-label='place of the cut']", 0.2)
    seen.append(pixels(browser))
    browser.find_element(By.CSS_SELECTOR, "#specimen canvas").send_keys(Keys.ARROW_LEFT)
    seen.append(pixels(browser))
    assert len(set(seen)) == len(seen), "each of them shows something else"
    unharmed(browser)


def test_the_log_is_sorted_by_its_heads(browser: webdriver.Chrome, page: Path, run: Path) -> None:
    opened(browser, page)
    forces = sorted(float(row["force_N"]) for row in rows(run / "breakage.csv"))
    head = browser.find_element(By.XPATH, "//section[@id='breakages']//th[button[starts-with(., 'force_N')]]")
    column = head.find_elements(By.XPATH, "preceding-sibling::th")
    first = f"#breakages tbody tr:first-child td:nth-child({len(column) + 1})"
    for order, want in [("ascending", forces[0]), ("descending", forces[-1])]:
        browser.execute_script("arguments[0].click()", head.find_element(By.TAG_NAME, "button"))
        assert head.get_attribute("aria-sort") == order
        assert float(browser.find_element(By.CSS_SELECTOR, first).text) == pytest.approx(want, rel=1e-5)


def test_runs_and_their_band_are_switched_on_and_off(browser: webdriver.Chrome, run: Path, tmp_path: Path) -> None:
    other = tmp_path / "other"
    shutil.copytree(run, other)
    summary = json.loads((other / "summary.json").read_text())
    summary["seed"] = {"packing": 99, "strength": 99}
    (other / "summary.json").write_text(json.dumps(summary))
    comminute("report", run, other, "--out", tmp_path / "two.html")
    opened(browser, tmp_path / "two.html")
    # two lines, and a median with the two edges of its band
    assert charts(browser)["compression"]["shown"] == 5
    for i, left in enumerate([4, 3, 0]):
        browser.find_elements(By.CSS_SELECTOR, "#figures > .row input")[i].click()
        assert charts(browser)["compression"]["shown"] == left
    unharmed(browser)


def snapshot(path: Path, count: int, seed: int) -> None:
    """Writes grains at random places as the program does."""
    draw = np.random.default_rng(seed)
    arrays = {
        "radius": draw.uniform(1e-3, 3e-3, count),
        "generation": draw.integers(0, 6, count, dtype=np.uint32),
        "strength": draw.uniform(1e6, 1e7, count),
        "force": draw.exponential(10.0, count),
        "velocity": draw.normal(0.0, 1e-3, (count, 3)),
        "mean_stress_Pa": draw.exponential(1e6, count),
        "Points": draw.uniform(0.0, 0.1, (count, 3)),
    }
    lines, blobs = {}, b""
    for name, values in arrays.items():
        kind = "UInt32" if values.dtype == np.uint32 else "Float64"
        lines[name] = f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{values.size // count}" format="appended" offset="{len(blobs)}"/>\n'
        data = values.tobytes()
        blobs += len(data).to_bytes(8, "little") + data
    points = lines.pop("Points")
    head = f'<VTKFile>\n<PolyData>\n<FieldData>\n<DataArray type="Float64" Name="sigma_v_kPa">{100.0 * seed}</DataArray>\n</FieldData>\n<Piece NumberOfPoints="{count}">\n'
    text = head + "<PointData>\n" + "".join(lines.values()) + "</PointData>\n<Points>\n" + points + '</Points>\n<AppendedData encoding="raw">\n_'
    path.write_bytes(text.encode() + blobs + b"\n</AppendedData>\n</VTKFile>\n")


def test_a_large_run_opens(browser: webdriver.Chrome, run: Path, tmp_path: Path) -> None:
    large = tmp_path / "large"
    shutil.copytree(run, large, ignore=shutil.ignore_patterns("snapshots", "*.pvd"))
    (large / "snapshots").mkdir()
    names = [f"snapshots/step_{i:08}.vtp" for i in range(10)]
    for i, name in enumerate(names):
        snapshot(large / name, 20_000, i)
    entries = "".join(f'<DataSet timestep="{i}" group="" part="0" file="{name}"/>\n' for i, name in enumerate(names))
    (large / "snapshots.pvd").write_text(f"<VTKFile>\n<Collection>\n{entries}</Collection>\n</VTKFile>\n")
    comminute("report", large)
    took = opened(browser, large / "report.html")
    print(f"20 000 grains, 10 snapshots: open after {took:.0f} ms", file=sys.stderr)
    assert browser.execute_script("return report.view.layers()") == [{"kind": "grains", "count": 20_000}]
    last = pixels(browser)
    move(browser, "#snapshot", 4)
    assert browser.execute_script("return report.view.state.frame") == 4
    assert pixels(browser) != last
    unharmed(browser)
