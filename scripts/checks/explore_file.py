#!/usr/bin/env python3
"""Whether the page of `slipmap explore --out` does in a browser what the program does.

    scripts/checks/explore_file.py SLIPMAP [--places 24] [--planes 12] [--pictures FOLDER]

Debian's chromium opens the file from the disk, used as people use it; at random places of all kinds of law its answers are compared
with those of the program behind a page: words and pictures are equal, numbers within their errors, or within 1e-9 of their size where
none is told. Exit code 0 if all holds.
"""

import argparse
import json
import random
import sys
import tempfile
import time
from pathlib import Path

from playwright.sync_api import expect, sync_playwright

sys.path.append(str(Path(__file__).parent))
import explore

CONFIG = Path(__file__).parents[2] / "configs" / "brake_pad.toml"
FORMULAS = [
    "mu+(1-mu)*exp(-u/vs)", "mu+(1-mu)/(1+u/vs)^2", "1-mu*tanh(u/vs)", "1-0.3*u+0.12*(1-cos(6*u))/6+mu*u^2", "mu+(1-mu)*exp(-(u/vs)^1.5)",
    "1-mu*u/(vs+u)+0.02*u", "1-mu*ln(1+u/vs)/5", "mu+(1-mu)/sqrt(1+(u/vs)^2)",
]  # fmt: skip
# What an answer says of its work, and errors, which are themselves known roughly.
ROUGH = {"rhs", "error"}
SIZE = 1e-9


def random_place(rng):
    """A law, or a machine, and a point."""
    u = rng.uniform
    speed, damping = rng.choice([u(0.1, 2), 10 ** u(-1, 1.3)]), 10 ** u(-3, 0.3)
    kind = rng.choice(["stribeck", "exponential", "lorentzian", "coulomb", "expression", "expression", "table", "machine"])
    law, at = {"name": kind}, {"epsilon": 1.0, "V": speed, "c": damping / 2}
    if kind == "stribeck":
        at |= {"epsilon": u(0.05, 0.5), "alpha": u(0, 0.8), "beta": u(0, 0.3), "gamma": u(0.5, 6), "c": 3 * damping}
    elif kind in ("exponential", "lorentzian"):
        at |= {"mu": u(0.2, 0.95), "vs": 10 ** u(-1, 0.3), "eta": rng.choice([0, u(0, 0.1)])}
        at |= rng.choice([{}, {"exponent": u(1, 4)}, {"drop": u(0, 0.5 * at["mu"])}])
    elif kind == "coulomb":
        at |= {"drop": u(0.05, 0.6), "eta": u(0, 0.05)}
    elif kind == "expression":
        law["phi"] = rng.choice(FORMULAS)
        at |= {"mu": u(0.1, 0.9), "vs": u(0.1, 1), "V": min(speed, 3.0)}
    elif kind == "table":
        low, scale, count = u(0.3, 0.8), u(0.2, 1), rng.randrange(6, 30)
        speeds = [8 * (i / count) ** 1.5 for i in range(count + 1)]
        law |= {"table": "".join(f"{x},{low + (1 - low) * 2.718281828 ** (-x / scale)}\n" for x in speeds), "file": "f.csv"}
        at["V"] = min(speed, 2.0)
    else:
        law["name"] = rng.choice(["stribeck", "exponential"])
        at = {"mass": u(1, 4), "stiffness": u(1e5, 1e6), "damping": u(10, 600), "normal_force": u(300, 2000), "static_friction": 0.4,
              "kinetic_friction": u(0.1, 0.35), "stribeck_velocity": u(0.02, 0.2), "strengthening": 0, "belt_speed": u(0.02, 0.6)}
        return {"law": law, "at": at, "motion": "translation"}
    return {"law": law, "at": at}


def random_plane(rng):
    asked = random_place(rng)
    at = asked["at"]
    across, up = ("belt_speed", "damping") if "motion" in asked else ("V", "c")
    if rng.random() < 0.4:
        up = rng.choice([name for name in at if name not in (across, "strengthening", "exponent", "drop", "eta") and at[name]])
    for side, name, low, high in (("x", across, 0.2, 1.5), ("y", up, 0.1, 1.05 if up in ("mu", "alpha") else 1.9)):
        asked[side] = {"axis": name, "from": low * at[name], "to": high * at[name], "points": 32}
    shows = ["regime", "regime", "verdict_simulation", "decider", "critical_c_simulation", "cycle_period"]
    return asked | {"show": rng.choice(shows)}


def differences(one, other, at="", error=0.0):
    """The places at which two answers differ, with what they say there."""
    if isinstance(one, dict) and isinstance(other, dict) and one.keys() == other.keys():
        for key in one:
            if key in ROUGH or key.endswith("_error"):
                continue
            names = [f"{key}_error", *(["error"] if key == "value" else [])]
            told = [answer.get(name) or 0.0 for answer in (one, other) for name in names]
            yield from differences(one[key], other[key], f"{at}/{key}", sum(told))
    elif isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        for i, (a, b) in enumerate(zip(one, other)):
            yield from differences(a, b, f"{at}/{i}", error)
    elif {type(one), type(other)} <= {int, float}:
        if abs(one - other) > (error or SIZE * max(abs(one), abs(other))):
            yield at, one, other, error
    elif one != other:
        yield at, one, other


ASK = "async ([path, body]) => { try { return await slipmap.post(path, body) } catch (why) { return { refused: why.message } } }"
PICTURE = """async ([body, side]) => {
    try { return [...(await slipmap.picture(body, "plane", side)).cells].map(String) } catch (why) { return why.message }
}"""


class File(explore.Session):
    """Pages that are opened as files."""

    def __init__(self, browser, arguments, folder):
        super().__init__(browser, arguments)
        self.folder, self.requests = Path(folder), []

    def write(self, *arguments):
        name = self.folder / "page.html"
        explore.subprocess.run([self.program, "explore", *arguments, "--out", str(name), "--overwrite"], check=True)
        assert name.stat().st_size < 1_600_000, f"{name.stat().st_size} bytes"
        return name

    def open_file(self, name, link=""):
        page = self.browser.new_context(viewport={"width": 1280, "height": 860}).new_page()
        page.set_default_timeout(30_000)
        page.on("request", lambda request: self.requests.append(request.url))
        page.on("console", lambda message: message.type == "error" and self.complaints.append(message.text))
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.goto(f"file://{name}{link}")
        return page


def the_machine_of_a_file_is_explored_without_a_program(session):
    page = session.open_file(session.write(str(CONFIG)))
    explore.settle(page)
    expect(page.locator("#overlay")).to_contain_text("belt speed, m/s")
    explore.wait(page, "document.querySelectorAll('#overlay path.curve').length >= 2")
    stage = explore.box(page, "#overlay")
    page.mouse.click(stage["x"] + 0.3 * stage["width"], stage["y"] + 0.8 * stage["height"])
    explore.wait(page, "document.querySelectorAll('.figure svg').length === 3")
    expect(page.locator("table.verdicts tbody tr").first).to_be_visible()
    said = explore.state(page)
    set_to = [f"--set={name}={said[f'p.{name}']}" for name in ("belt_speed", "damping")]
    probe = json.loads(session.probe("--machine", str(CONFIG), "--json", *set_to))
    assert page.locator("#point").get_attribute("data-regime") == probe["machine"]["regime"]
    assert explore.tells(page, probe["machine"]["critical_damping"])
    session.picture(page, "file")
    # The pin is dragged: the motion follows while it moves.
    motions = set()
    where = explore.box(page, "circle.pin")
    page.mouse.move(where["x"] + 8, where["y"] + 8)
    page.mouse.down()
    for step in range(20):
        page.mouse.move(where["x"] + 8 + 6 * step, where["y"] + 8 - 4 * step)
        page.wait_for_timeout(50)
        motions.add(page.locator(".figure").first.inner_html())
    page.mouse.up()
    assert len(motions) > 3, f"{len(motions)} motions during the drag"
    explore.settle(page)
    # Everything leaves, as text.
    page.get_by_role("button", name="Share and export").click()
    expect(page.locator("#leave pre").nth(1)).to_contain_text("normal_force")
    command, configuration = (page.locator("#leave pre").nth(number).text_content() for number in (0, 1))
    explore.wait(page, "document.getElementById('point').dataset.regime !== undefined")
    regime = page.locator("#point").get_attribute("data-regime")
    (session.folder / "plane.toml").write_text(configuration)
    link = page.evaluate("location.hash")
    again = session.open_file(session.folder / "page.html", link)
    explore.settle(again)
    assert explore.pixels(again) == explore.pixels(page)
    again.context.close()
    page.context.close()
    told = explore.subprocess.run([session.program, *command.split()[1:], "--json"], cwd=session.folder, capture_output=True, text=True)
    assert told.returncode == 0 and json.loads(told.stdout)["regime"] == regime, told.stderr


def a_table_in_any_encoding_is_taken(session):
    page = session.open_file(session.write(str(CONFIG)))
    explore.drawn(page)
    page.get_by_label("Friction law").first.select_option("table")
    explore.wait(page, "location.hash.includes('law=table')")
    for encoding in ("windows-1252", "utf-8", "utf-16"):
        rows = "v [m/s];µ [-]\n" + "".join(f"{u};{mu}\n" for u, mu in zip((0, 0.02, 0.1, 1), (0.4, 0.3, len(encoding) / 50, 0.2)))
        table = {"name": "rig.csv", "mimeType": "text/csv", "buffer": rows.replace(".", ",").encode(encoding)}
        page.get_by_label("Table of slip speed and friction").set_input_files(table)
        expect(page.get_by_label("Slip speed and friction, row by row")).to_have_value(rows.replace(".", ","))
        expect(page.locator("#law-editor .problem")).to_have_text("")
    page.context.close()


def work_is_given_up_for_other_work(session):
    page = session.open_file(session.write(), explore.FORMULA)
    explore.drawn(page)
    slow = {"law": {"name": "expression", "phi": "mu+(1-mu)*exp(-u/vs)"}, "at": {"epsilon": 1, "mu": 0.5, "vs": 0.5, "V": 1, "c": 0.1},
            "show": "cycle_period", "x": {"axis": "V", "from": 0.1, "to": 3, "points": 1000}, "y": {"axis": "mu", "from": 0.1, "to": 0.9, "points": 1000}}
    quick = slow | {"x": slow["x"] | {"points": 8}, "y": {"axis": "c", "from": 0.1, "to": 0.5, "points": 8}}
    started = time.monotonic()
    told = page.evaluate("""async ([slow, quick]) => {
        const first = slipmap.picture(slow, "plane").catch((why) => why.overtaken);
        await new Promise((resolve) => setTimeout(resolve, 300));
        const second = await slipmap.picture(quick, "plane");
        return [await first, second.cells.length];
    }""", [slow, quick])
    assert told == [True, 64], told
    assert time.monotonic() - started < 20
    page.context.close()


def a_trap_ends_one_worker(session):
    name = session.write()
    text = name.read_text()
    assert text.count("const status = program.ask();") == 1
    name.write_text(text.replace("const status = program.ask();", 'if (path === "glance") program.answer(path.missing.part); const status = program.ask();'))
    page = session.open_file(name, explore.BISTABLE)
    explore.drawn(page)
    place = {"law": {"name": "stribeck"}, "at": {"epsilon": 0.1, "alpha": 0.3, "beta": 0.1, "gamma": 2.0, "V": 1.0, "c": 0.5}}
    for _ in range(2):
        assert "the computation failed" in page.evaluate(ASK, ["glance", place])["refused"]
    assert page.evaluate(ASK, ["point", place])["regime"]
    page.context.close()


def answers_are_those_of_the_program(session):
    rng = random.Random(75)
    served, page = session.open(), session.open_file(session.write())
    for number in range(session.arguments.places):
        asked = random_place(rng)
        one, other = (it.evaluate(ASK, ["point", asked]) for it in (served, page))
        found = list(differences(one, other))
        assert not found, f"place {number}, {json.dumps(asked)}: {found[:3]}"
    for number in range(session.arguments.planes):
        asked = random_plane(rng)
        side = "x" if asked["y"]["axis"] in ("c", "damping") else "y"
        one, other = (it.evaluate(PICTURE, [asked, side]) for it in (served, page))
        if isinstance(one, list) and asked["show"] in ("critical_c_simulation", "cycle_period"):
            pairs = [(float(a), float(b)) for a, b in zip(one, other)]
            assert all(abs(a - b) <= 1e-6 * abs(a) or a != a and b != b for a, b in pairs), f"plane {number}, {json.dumps(asked)}"
        else:
            assert one == other, f"plane {number}, {json.dumps(asked)}"
    # Both refuse some planes.
    session.complaints[:] = [text for text in session.complaints if "status of 4" not in text]
    served.context.close()
    page.context.close()


def nothing_is_requested(session):
    asked = [url for url in session.requests if not url.startswith(("blob:", f"file://{session.folder}", "data:"))]
    assert session.requests and not asked, asked


TESTS = [
    the_machine_of_a_file_is_explored_without_a_program,
    a_table_in_any_encoding_is_taken,
    work_is_given_up_for_other_work,
    a_trap_ends_one_worker,
    answers_are_those_of_the_program,
    nothing_is_requested,
]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("slipmap")
    parser.add_argument("--places", type=int, default=24)
    parser.add_argument("--planes", type=int, default=12)
    parser.add_argument("--pictures")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=explore.FLAGS)
        session = File(browser, arguments, folder)
        failures = explore.run_all(session, TESTS)
        browser.close()
        session.server.end()
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
