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
        "records.contacts": "true",
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
    other = run.with_name("other")  # seeds of one scene in one folder are drawn as a band
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


def array(path: Path, name: str) -> np.ndarray[Any, np.dtype[Any]]:
    """An array of a snapshot that the program has written."""
    file = path.read_bytes()
    head, numbers = file.split(b'encoding="raw">\n_', 1)
    tag = next(tag for tag in head.decode().split("<DataArray ") if f'Name="{name}"' in tag)
    at = int(tag.split('offset="')[1].split('"')[0])
    kind = {"Float64": np.float64, "UInt64": np.uint64, "UInt32": np.uint32}[tag.split('type="')[1].split('"')[0]]
    return np.frombuffer(numbers[at + 8 : at + 8 + int.from_bytes(numbers[at : at + 8], "little")], kind)


def last(run: Path) -> Path:
    return sorted((run / "snapshots").glob("step_*.vtp"))[-1]


def number(text: str) -> tuple[float, str]:
    """The number at the end of a line, and its unit."""
    *_, value, unit = text.split(" ")
    return float(value.replace("−", "-")), unit


def test_a_chosen_grain_shows_its_values_in_every_snapshot(browser: webdriver.Chrome, page: Path, run: Path) -> None:
    opened(browser, page)
    ids, radii, forces, generations = (array(last(run), name) for name in ("id", "radius", "force", "generation"))
    Select(browser.find_element(By.ID, "field")).select_by_value("force")
    values = browser.find_element(By.ID, "values")
    first = array(sorted((run / "snapshots").glob("step_*.vtp"))[0], "id")
    broken = int(next(i for i in first if i not in ids))
    for i in [0, len(ids) - 1]:
        field = browser.find_element(By.ID, "wanted")
        field.clear()
        field.send_keys(str(ids[i]), Keys.TAB)
        lines = values.text.splitlines()
        assert lines[0] == f"grain {ids[i]}" and lines[2] == f"generation {generations[i]}"
        for line, want, factors in [(lines[1], radii[i], {"mm": 1e-3, "µm": 1e-6}), (lines[3], forces[i], {"N": 1.0, "mN": 1e-3, "µN": 1e-6})]:
            got, unit = number(line) if want else (0.0, next(iter(factors)))
            assert got * factors[unit] == pytest.approx(want, rel=1e-3)
    field.clear()
    field.send_keys(str(broken), Keys.TAB)
    assert "is not shown in this snapshot" in values.text
    move(browser, "#snapshot", 0)
    assert values.text.startswith(f"grain {broken}\n")
    # by keys, in the order of the numbers
    canvas = browser.find_element(By.CSS_SELECTOR, "#specimen canvas")
    canvas.send_keys(Keys.ESCAPE, "n", "n", "p", "n")
    assert values.text.startswith(f"grain {sorted(first)[1]}\n")
    unharmed(browser)


def test_a_body_has_the_size_of_its_volume(browser: webdriver.Chrome, tmp_path: Path) -> None:
    # stopped at once: cubes with edges of 100 mm in their places
    stopped = subprocess.run([COMMAND, "run", "experiments/blocks/tower.toml", "--stop-after", "10", "--quiet", "--out", tmp_path / "tower"], cwd=ROOT)
    assert stopped.returncode == 130
    comminute("report", tmp_path / "tower")
    opened(browser, tmp_path / "tower" / "report.html")
    browser.find_element(By.ID, "wanted").send_keys("4", Keys.TAB)
    lines = browser.find_element(By.ID, "values").text.splitlines()
    assert lines[0] == "body 4" and lines[1].endswith(" (ball of its volume)")
    value, unit = number(lines[1].removesuffix(" (ball of its volume)"))
    assert unit == "mm" and value == pytest.approx(100.0 * (6.0 / np.pi) ** (1.0 / 3.0), rel=1e-3)
    unharmed(browser)


# On a grid over the view: whether the pixel is of another colour than the ground, and what stands there
GRID = """const canvas = document.querySelector('#specimen canvas'); report.view.pixels();
    const copy = Object.assign(document.createElement('canvas'), { width: canvas.width, height: canvas.height });
    const ink = copy.getContext('2d'); ink.drawImage(canvas, 0, 0);
    const { data } = ink.getImageData(0, 0, canvas.width, canvas.height);
    const scale = canvas.width / canvas.clientWidth; const out = [];
    const colour = (x, y) => [0, 1, 2].map((k) => data[4 * (Math.floor(y * scale) * canvas.width + Math.floor(x * scale)) + k]);
    const ground = colour(1, 1);
    for (let y = 8; y < canvas.clientHeight; y += 9) for (let x = 8; x < canvas.clientWidth; x += 9)
      out.push([colour(x, y).some((c, k) => Math.abs(c - ground[k]) > 6), report.view.under(x + 0.5, y + 0.5), x, y]);
    return out;"""


def grid(browser: webdriver.Chrome) -> list[tuple[bool, list[str] | None, int, int]]:
    seen: list[tuple[bool, list[str] | None, int, int]] = browser.execute_script(GRID)
    return seen


def hold(browser: webdriver.Chrome, kind: str, shown: bool) -> None:
    """Shows or hides what is of a kind."""
    box = browser.find_element(By.CSS_SELECTOR, f"[data-kind='{kind}']")
    if box.is_selected() != shown:
        browser.execute_script("arguments[0].click()", box)


def cut(browser: webdriver.Chrome, axis: str) -> None:
    Select(browser.find_element(By.CSS_SELECTOR, "#specimen .controls fieldset:nth-of-type(3) select")).select_by_value(axis)


def test_what_is_pointed_at_is_what_is_seen(browser: webdriver.Chrome, page: Path) -> None:
    opened(browser, page)
    hold(browser, "walls", False)
    full = 0
    for axis, slice_only in [("", False), ("y", False), ("z", False), ("x", True)]:
        cut(browser, axis)
        box = browser.find_elements(By.CSS_SELECTOR, "#specimen .controls fieldset:nth-of-type(3) input[type=checkbox]")[1]
        if box.is_selected() != slice_only:
            browser.execute_script("arguments[0].click()", box)
        seen = grid(browser)
        inked = sum(ink for ink, *_ in seen)
        # where they differ, a pixel is at the edge of a grain
        assert sum(ink != (what is not None) for ink, what, *_ in seen) < 0.02 * inked
        full = full or inked
        assert inked > 0.1 * full
        assert axis == "" or inked < full
    unharmed(browser)


def test_contacts_are_lines_with_their_forces(browser: webdriver.Chrome, page: Path, run: Path) -> None:
    opened(browser, page)
    table = [row for row in rows(sorted((run / "snapshots").glob("contacts_*.csv"))[-1])]
    force = lambda row: sum(float(row[f"normal_{axis}_N"]) ** 2 for axis in "xyz") ** 0.5
    table = [row for row in table if force(row) > 0.0]
    assert {"kind": "contacts", "count": len(table)} in browser.execute_script("return report.view.layers()")
    assert browser.find_element(By.ID, "forces").text == ""
    before = pixels(browser)
    hold(browser, "contacts", True)
    assert pixels(browser) != before
    assert "normal force of contacts" in browser.find_element(By.ID, "forces").text
    # grains would hide their contacts
    assert not browser.find_element(By.CSS_SELECTOR, "[data-kind='grains']").is_selected()
    hold(browser, "walls", False)
    seen = grid(browser)
    found = {tuple(what) for _, what, *_ in seen if what}
    assert len(found) > 20
    for name, line in found:
        a, b = name.removeprefix("contact of grain ").split(" and ")
        kind, other = b.split(" ")
        row = next(row for row in table if row["a"] == a and row["kind_b"] == kind and row["b"] == other)
        value, unit = number(line)
        assert value * {"kN": 1e3, "N": 1.0, "mN": 1e-3, "µN": 1e-6}[unit] == pytest.approx(force(row), rel=2e-3)
    unharmed(browser)


def test_figures_of_a_run_without_snapshots_are_shown_as_drawn(browser: webdriver.Chrome, run: Path, tmp_path: Path) -> None:
    bare = tmp_path / "bare"
    shutil.copytree(run, bare, ignore=shutil.ignore_patterns("snapshots", "*.pvd"))
    comminute("report", bare)
    opened(browser, bare / "report.html")
    sizes = browser.execute_script("return [...document.querySelectorAll('#pictures img')].map((image) => [image.alt, image.complete && image.naturalWidth])")
    assert [alt.split(",")[0] for alt, _ in sizes] == ["Specimen", "Normal forces of contacts"]
    assert all(width > 100 for _, width in sizes)


def write_snapshot(path: Path, stress: float, arrays: dict[str, np.ndarray[Any, np.dtype[Any]]]) -> None:
    """Writes grains or points as the program does."""
    count = len(arrays["Points"])
    lines, blobs = {}, b""
    for name, values in arrays.items():
        kind = "UInt32" if values.dtype == np.uint32 else "Float64"
        lines[name] = f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{values.size // count}" format="appended" offset="{len(blobs)}"/>\n'
        data = values.tobytes()
        blobs += len(data).to_bytes(8, "little") + data
    points = lines.pop("Points")
    head = f'<VTKFile>\n<PolyData>\n<FieldData>\n<DataArray type="Float64" Name="sigma_v_kPa">{stress}</DataArray>\n</FieldData>\n<Piece NumberOfPoints="{count}">\n'
    text = head + "<PointData>\n" + "".join(lines.values()) + "</PointData>\n<Points>\n" + points + '</Points>\n<AppendedData encoding="raw">\n_'
    path.write_bytes(text.encode() + blobs + b"\n</AppendedData>\n</VTKFile>\n")


def with_snapshots(run: Path, copy: Path, snapshots: list[dict[str, np.ndarray[Any, np.dtype[Any]]]]) -> None:
    """A copy of a run with other snapshots."""
    shutil.copytree(run, copy, ignore=shutil.ignore_patterns("snapshots", "*.pvd"))
    (copy / "snapshots").mkdir()
    names = [f"snapshots/step_{i:08}.vtp" for i in range(len(snapshots))]
    for i, (name, arrays) in enumerate(zip(names, snapshots)):
        write_snapshot(copy / name, 100.0 * i, arrays)
    entries = "".join(f'<DataSet timestep="{i}" group="" part="0" file="{name}"/>\n' for i, name in enumerate(names))
    (copy / "snapshots.pvd").write_text(f"<VTKFile>\n<Collection>\n{entries}</Collection>\n</VTKFile>\n")


def test_a_cut_continuum_has_the_colours_of_its_nearest_points(browser: webdriver.Chrome, run: Path, tmp_path: Path) -> None:
    edge, side = 2e-3, 8
    lattice = np.stack(np.meshgrid(*[np.arange(side)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    places = edge * (lattice + 0.5 + np.random.default_rng(1).uniform(-0.1, 0.1, lattice.shape))
    count = len(places)
    arrays = {
        "id": np.arange(100, 100 + count, dtype=np.uint32),
        "volume_m3": np.full(count, edge**3),
        "plastic_strain": np.linspace(0.0, 0.1, count),
        "Points": places,
    }
    with_snapshots(run, tmp_path / "points", [arrays])
    comminute("report", tmp_path / "points")
    opened(browser, tmp_path / "points" / "report.html")
    button = browser.find_element(By.XPATH, "//section[@id='specimen']//button[text()='front']")
    browser.execute_script("arguments[0].click()", button)
    assert any(what is None for ink, what, x, y in grid(browser)), "there are gaps between points"
    cut(browser, "y")
    inside = [(what, x, y) for ink, what, x, y in grid(browser) if ink]
    low, high = [[bound(at[k] for at in inside) for k in (1, 2)] for bound in (min, max)]
    # the bounds are those of the balls; the view shows all of them
    reach = [(places[:, a].min() - edge / 2, places[:, a].max() + edge / 2) for a in range(3)]
    middle = sum(reach[1]) / 2
    wrong = 0
    for what, x, y in inside:
        assert what is not None, "the cut has no gaps"
        share = [(x - low[0]) / (high[0] - low[0]), (high[1] - y) / (high[1] - low[1])]
        place = np.array([reach[0][0] + share[0] * (reach[0][1] - reach[0][0]), middle, reach[2][0] + share[1] * (reach[2][1] - reach[2][0])])
        nearest = np.argmin(np.linalg.norm(places - place, axis=1))
        wrong += what[0] != f"point {nearest + 100}"
    # the grid of pixels gives places to half of its distance
    assert wrong < 0.2 * len(inside)
    unharmed(browser)


def random_grains(count: int, seed: int) -> dict[str, np.ndarray[Any, np.dtype[Any]]]:
    draw = np.random.default_rng(seed)
    return {
        "radius": draw.uniform(1e-3, 3e-3, count),
        "generation": draw.integers(0, 6, count, dtype=np.uint32),
        "strength": draw.uniform(1e6, 1e7, count),
        "force": draw.exponential(10.0, count),
        "velocity": draw.normal(0.0, 1e-3, (count, 3)),
        "id": np.arange(count, dtype=np.uint32),
        "mean_stress_Pa": draw.exponential(1e6, count),
        "Points": draw.uniform(0.0, 0.1, (count, 3)),
    }


def test_a_large_run_opens(browser: webdriver.Chrome, run: Path, tmp_path: Path) -> None:
    large = tmp_path / "large"
    with_snapshots(run, large, [random_grains(20_000, i) for i in range(10)])
    comminute("report", large)
    took = opened(browser, large / "report.html")
    print(f"20 000 grains, 10 snapshots: open after {took:.0f} ms", file=sys.stderr)
    assert browser.execute_script("return report.view.layers()") == [{"kind": "grains", "count": 20_000}]
    last = pixels(browser)
    move(browser, "#snapshot", 4)
    assert browser.execute_script("return report.view.state.frame") == 4
    assert pixels(browser) != last
    unharmed(browser)
