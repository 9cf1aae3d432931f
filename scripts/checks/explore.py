#!/usr/bin/env python3
"""What a browser makes of `slipmap explore`: every part of the page, used as people use it.

    scripts/checks/explore.py SLIPMAP [--pictures FOLDER] [--only NAME]

Debian's chromium, driven by playwright, opens the page of a program that this script starts, and the page as a file. FOLDER of
--pictures receives what was seen. Exit code 0 if all holds.
"""

import argparse
import csv
import io
import json
import re
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from urllib.parse import parse_qs

import axe_playwright_python
from playwright.sync_api import expect, sync_playwright

expect.set_options(timeout=30_000)

AXE = Path(axe_playwright_python.__file__).with_name("axe.min.js")
# Rules that WCAG 2.2 requires, and the best practices of axe.
RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"]
FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-background-networking"]
BISTABLE = "#law=exponential&x=V,0.2,2.5&y=c,0,0.4&show=regime&p.epsilon=1&p.mu=0.5&p.vs=0.5&p.eta=0&p.V=1.5&p.c=0.1"
STRIBECK = "#law=stribeck&x=gamma,0,8&y=c,0,6&show=verdict_simulation&p.epsilon=0.2&p.alpha=0.3&p.beta=0&p.V=1&p.gamma=4&p.c=2"
FORMULA = "#law=expression&phi=mu%2B(1-mu)*exp(-u/vs)&x=V,0.2,2.5&y=c,0,0.4&show=verdict_simulation&p.epsilon=1&p.mu=0.5&p.vs=0.5&p.V=1.5&p.c=0.1"


class Server:
    """A running `slipmap explore`."""

    def __init__(self, program, *arguments, port=0):
        command = [program, "explore", "--no-browser", "--port", str(port), *arguments]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.address = self.process.stdout.readline().strip()
        assert self.address.startswith("http://127.0.0.1:"), self.process.stderr.read()
        self.port = int(self.address.split(":")[2].split("/")[0])

    def end(self):
        """Ends it as Ctrl-C does; seconds that it took."""
        started = time.monotonic()
        self.process.send_signal(signal.SIGINT)
        code = self.process.wait(timeout=10)
        assert code == 130, f"Ctrl-C ends it with {code}"
        return time.monotonic() - started

    def kill(self):
        self.process.kill()
        self.process.wait()


class Session:
    """A browser, the program, and the page that the tests use."""

    def __init__(self, browser, arguments):
        self.browser, self.arguments = browser, arguments
        self.program = str(Path(arguments.slipmap).resolve())
        self.servers = [Server(self.program)]
        self.complaints = []

    @property
    def server(self):
        """The one of which pages are opened."""
        return self.servers[-1]

    def serve(self, *arguments, port=0):
        """Opens pages of another server until the test ends."""
        self.servers.append(Server(self.program, *arguments, port=port))

    def end_others(self):
        while len(self.servers) > 1:
            self.servers.pop().kill()

    def open(self, link="", width=1280, height=860, dark=False, touch=False):
        """A page with this link in a window of its own."""
        context = self.browser.new_context(
            viewport={"width": width, "height": height}, color_scheme="dark" if dark else "light", has_touch=touch)
        page = context.new_page()
        page.set_default_timeout(30_000)
        page.on("console", lambda message: message.type == "error" and self.complaints.append(message.text))
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.goto(self.server.address + link)
        return page

    def picture(self, page, name):
        if self.arguments.pictures:
            folder = Path(self.arguments.pictures)
            folder.mkdir(parents=True, exist_ok=True)
            page.screenshot(path=folder / f"{name}.png")

    def probe(self, *arguments):
        return subprocess.run([self.program, "probe", *arguments], check=True, capture_output=True, text=True).stdout


def wait(page, expression, argument=None, seconds=120):
    """Waits until an expression holds. (Playwright's own way to do so is forbidden by the page's security policy.)"""
    end = time.monotonic() + seconds
    while not page.evaluate(expression, argument):
        assert time.monotonic() < end, f"this does not come true: {expression}"
        page.wait_for_timeout(50)


def settle(page):
    """Waits until the plane is at rest and as fine as it gets."""
    # Movements count as ended a moment after the last.
    page.wait_for_timeout(200)
    wait(page, "document.getElementById('cells').dataset.settled !== undefined")


def drawn(page):
    """Waits until the plane shows the present inputs, however coarsely."""
    page.wait_for_timeout(200)
    wait(page, "(() => { const { dataset, classList } = document.getElementById('cells');"
               "return dataset.cells !== undefined && !classList.contains('of-other-inputs') })()")


def box(page, selector):
    """Where an element is in the window. Asked in one step, since a drawing that is made anew replaces its elements."""
    find = "(selector) => { const { x, y, width, height } = document.querySelector(selector).getBoundingClientRect(); return { x, y, width, height } }"
    wait(page, "(selector) => document.querySelector(selector) !== null", selector)
    return page.evaluate(find, selector)


def pixels(page):
    """The picture as a text that tells pictures apart."""
    return page.evaluate("document.getElementById('cells').toDataURL()")


def state(page):
    """What the link says."""
    return {key: values[0] for key, values in parse_qs(page.evaluate("location.hash")[1:]).items()}


def the_gallery_opens_examples(session):
    page = session.open()
    cards = page.locator("#cards .card")
    expect(cards.first).to_be_visible()
    assert cards.count() >= 7
    # Every card has a picture of its own.
    wait(page, "[...document.querySelectorAll('#cards canvas')].every((canvas) => canvas.width === 288)")
    session.picture(page, "gallery")
    thumbnails = page.evaluate("[...document.querySelectorAll('#cards canvas')].map((canvas) => canvas.toDataURL())")
    assert len(set(thumbnails)) == len(thumbnails)
    for number in range(cards.count()):
        if number:
            page.get_by_role("button", name="Examples").click()
        cards.nth(number).click()
        # The first picture is enough here: some examples are refined for seconds.
        wait(page, "document.getElementById('cells').dataset.cells !== undefined")
        expect(page.locator("#notice")).to_be_hidden()
        session.picture(page, f"example-{number}")
    page.context.close()


def a_slider_changes_the_plane(session):
    page = session.open(STRIBECK)
    settle(page)
    before = pixels(page)
    slider = page.get_by_role("slider", name="belt speed")
    track = slider.bounding_box()
    page.mouse.move(track["x"] + 0.3 * track["width"], track["y"] + track["height"] / 2)
    page.mouse.down()
    seen = set()
    for step in range(12):
        page.mouse.move(track["x"] + (0.3 + 0.04 * step) * track["width"], track["y"] + track["height"] / 2)
        page.wait_for_timeout(40)
        seen.add(pixels(page))
    page.mouse.up()
    settle(page)
    assert pixels(page) != before and len(seen) > 3, f"{len(seen)} pictures during the drag"
    assert float(state(page)["p.V"]) > 1.5
    # A typed value does the same.
    page.get_by_label("belt speed (V): value").fill("1")
    settle(page)
    assert pixels(page) == before
    page.context.close()


def cells_are_those_of_the_engine(session):
    """At 1,000 positions the colour is that of the engine's own answer, by `slipmap probe --points`."""
    generator = random.Random(20)
    for name, link, kinds_of in [("regime", BISTABLE, "regime"), ("verdict_simulation", STRIBECK, "verdict_simulation")]:
        page = session.open(link)
        settle(page)
        said = state(page)
        width, height = page.evaluate("() => { const { width, height } = document.getElementById('cells'); return [width, height] }")
        across, up = map(int, page.evaluate("document.getElementById('cells').dataset.cells").split("x"))
        sides = {side: said[side].split(",") for side in "xy"}
        rows, places = [], []
        for _ in range(500):
            x, y = generator.randrange(width), generator.randrange(height)
            column, line = int((x + 0.5) / width * across), int((height - y - 0.5) / height * up)
            point = {key[2:]: value for key, value in said.items() if key.startswith("p.")}
            for side, cell, cells in [("x", column, across), ("y", line, up)]:
                axis, start, end = sides[side][:3]
                half = (float(end) - float(start)) / (2 * cells)
                first, last = float(start) + half, float(end) - half
                point[axis] = repr((first * (cells - 1 - cell) + last * cell) / (cells - 1))
            rows.append(point)
            places.append([x, y])
        with tempfile.TemporaryDirectory() as folder:
            table = Path(folder) / "points.csv"
            with open(table, "w", newline="") as file:
                writer = csv.DictWriter(file, rows[0].keys())
                writer.writeheader()
                writer.writerows(rows)
            law = [] if said["law"] == "stribeck" else ["--law", said["law"]]
            answers = session.probe("--points", str(table), "--out", "-", "--quiet", *law)
        kinds = page.evaluate(
            "([show]) => slipmap.begin.catalogue[show === 'regime' ? 'regimes' : 'verdicts']", [name])
        by_name = {kind["name"]: kind for kind in kinds}
        drawn = page.evaluate(
            "(places) => { const context = document.getElementById('cells').getContext('2d');"
            "return places.map(([x, y]) => [...context.getImageData(x, y, 1, 1).data]) }", places)
        for answer, colour in zip(csv.DictReader(io.StringIO(answers)), drawn):
            kind = by_name[answer[kinds_of]]
            legal = {kind["ground"], kind["ink"]} if "ground" in kind else None
            colour = "#%02x%02x%02x" % tuple(colour[:3])
            assert colour in legal, f"{answer} is drawn {colour}, not {legal}"
        assert len({answer[kinds_of] for answer in csv.DictReader(io.StringIO(answers))}) > 1
        page.context.close()


def tells(page, value):
    """Whether the answer about the point shows the number, to six digits at least, before its error."""
    told = re.findall(r"([-+0-9.e]+) ± ", page.locator("#point").inner_text())
    return any(abs(float(one) - value) <= 1e-6 * abs(value) for one in told)


def a_click_gives_the_numbers_of_probe(session):
    page = session.open(BISTABLE)
    drawn(page)
    stage = box(page, "#overlay")
    page.mouse.click(stage["x"] + 0.55 * stage["width"], stage["y"] + 0.55 * stage["height"])
    expect(page.locator("table.verdicts tbody tr").first).to_be_visible()
    wait(page, "document.querySelectorAll('.figure svg').length === 3")
    said = state(page)
    # A law without a drop and with the exponent 1 has no such parameters.
    absent = {"p.drop": "0", "p.exponent": "1"}
    values = [
        word
        for key, value in said.items()
        if key.startswith("p.") and absent.get(key) != value
        for word in (f"--{key[2:]}", value)
    ]
    probe = json.loads(session.probe("--law", said["law"], "--json", *values))
    for name, answer in probe["methods"].items():
        shown = page.locator(f"tr[data-method={name}] .say").inner_text()
        assert shown == answer["verdict"], f"{name}: {shown}, and probe says {answer['verdict']}"
    assert page.locator("#point").get_attribute("data-regime") == probe["regime"]
    assert tells(page, probe["critical_c"]["value"])
    # Every line of it.
    page.get_by_text("Every number").click()
    listed = page.evaluate("[...document.querySelectorAll('dl.numbers dd')].map((it) => it.textContent)")

    def leaves(value):
        if isinstance(value, (dict, list)):
            return [leaf for entry in (value.values() if isinstance(value, dict) else value) for leaf in leaves(entry)]
        return [value]

    assert len(listed) == len(leaves(probe)), f"{len(listed)} numbers of {len(leaves(probe))}"
    session.picture(page, "point")
    # Another start, by a click into the portrait.
    before = page.locator(".figure svg").first.inner_html()
    page.locator(".figure svg").first.click(position={"x": 200, "y": 90})
    wait(page, "(before) => document.querySelector('.figure svg').innerHTML !== before", before)
    # Dragging the pin moves the point and its portrait.
    where = box(page, "circle.pin")
    page.mouse.move(where["x"] + 8, where["y"] + 8)
    page.mouse.down()
    page.mouse.move(where["x"] + 90, where["y"] - 40, steps=5)
    page.mouse.up()
    wait(page, "(old) => !location.hash.includes(old)", f"p.V={said['p.V']}&")
    page.context.close()


def a_link_restores_the_state(session):
    page = session.open(BISTABLE + "&pin=1&r.mu=0.2,0.9")
    settle(page)
    link, first = page.evaluate("location.hash"), pixels(page)
    # The other link also has unknown keys.
    other = session.open(link + "&colour=blue&r.future=1,2")
    settle(other)
    assert pixels(other) == first
    expect(other.locator("circle.pin")).to_be_visible()
    assert state(other)["r.mu"] == "0.2,0.9"
    bare = session.open("#law=lorentzian")
    wait(bare, "location.hash.includes('y=c')")
    assert state(bare)["law"] == "lorentzian" and state(bare)["y"].startswith("c,")
    # A link that is opened over the examples takes their place.
    examples = session.open()
    expect(examples.locator("#gallery")).to_be_visible()
    examples.evaluate("(link) => { location.hash = link }", link)
    expect(examples.locator("#gallery")).to_be_hidden()
    drawn(examples)
    assert state(examples)["r.mu"] == "0.2,0.9"
    for opened in (page, other, bare, examples):
        opened.context.close()


def numbers_of_the_previous_state_are_marked(session):
    page = session.open(FORMULA + "&pin=1")
    drawn(page)
    expect(page.locator("table.verdicts tbody tr").first).to_be_visible()
    expect(page.locator(".previous")).to_have_count(0)
    # The answers to the next state wait until they are let go.
    held = []
    page.route("**/point", lambda route: held.append(route))
    page.route("**/figure", lambda route: held.append(route))
    page.get_by_label("Friction over slip speed u, as a formula").fill("mu + (1 - mu)/(1 + u/vs)^2")
    for part in (".regime", "div:has(> div > table.verdicts)"):
        expect(page.locator(f"#point {part}.previous").first).to_be_visible()
    assert page.locator("#point").get_attribute("data-regime") is None
    for route in held:
        route.continue_()
    page.unroute("**/point")
    page.unroute("**/figure")
    expect(page.locator(".previous")).to_have_count(0)
    assert page.locator("#point").get_attribute("data-regime")
    page.context.close()


def a_formula_with_an_error_is_told_with_its_place(session):
    page = session.open(FORMULA)
    settle(page)
    before = pixels(page)
    formula = page.get_by_label("Friction over slip speed u, as a formula")
    formula.fill("mu + (1 - mu)*exp(-u//vs)")
    expect(page.locator(".problem pre")).to_contain_text("^")
    marks = page.locator(".problem pre").inner_text().splitlines()
    assert marks[0][marks[1].index("^")] == "/", marks
    assert pixels(page) == before, "the plane stays"
    formula.fill("mu + (1 - mu)/(1 + u/vs)^2")
    expect(page.locator(".problem pre")).to_have_count(0)
    wait(page, "(before) => document.getElementById('cells').toDataURL() !== before", before)
    # A measured table.
    page.get_by_label("Friction law").first.select_option("table")
    wait(page, "location.hash.includes('law=table')")
    settle(page)
    page.get_by_label("Slip speed and friction, row by row").fill("0,1\n0.5,0.7\n0.4,much\n")
    expect(page.locator(".problem").first).to_contain_text("friction.csv:3")
    # Coefficients are refused without units; the text stays, and is legal for a machine.
    measured = "0,0.43\n0.02,0.39\n0.05,0.35\n0.1,0.31\n0.2,0.28\n0.5,0.26\n2,0.26\n"
    page.get_by_label("Slip speed and friction, row by row").fill(measured)
    expect(page.locator(".problem").first).to_contain_text("phi(0) is 0.43")
    expect(page.locator("body")).to_have_class("of-other-inputs")
    session.picture(page, "refused")
    page.get_by_role("button", name="As a machine in SI units").click()
    wait(page, "location.hash.includes('motion=translation') && location.hash.includes('0.43')")
    assert page.get_by_label("Slip speed and friction, row by row").input_value() == measured
    expect(page.locator("body")).not_to_have_class("of-other-inputs")
    expect(page.locator("#law-editor .problem")).to_have_text("")
    # A law that is illegal in any units stays too, with its message.
    page.get_by_label("Slip speed and friction, row by row").fill(measured + "3,much\n")
    expect(page.locator(".problem").first).to_contain_text("friction.csv:8")
    page.get_by_role("button", name="Without units").click()
    wait(page, "!location.hash.includes('motion=')")
    expect(page.locator(".problem").first).to_contain_text("friction.csv:8")
    assert page.get_by_label("Slip speed and friction, row by row").input_value() == measured + "3,much\n"
    page.context.close()
    # Refusals are the point of this test.
    session.complaints[:] = [text for text in session.complaints if "422" not in text]


def a_refused_number_says_why(session):
    page = session.open(BISTABLE + "&pin=1")
    drawn(page)
    body = page.locator("body")
    # The text typed into each input, and the reason shown next to it.
    for label, typed, why in [
        ("across: from", "3", "across: from: must be less than the other end, 2.5"),
        ("up: to", "", "up: to: a number is missing"),
        ("up: to", "much", "not a number"),
        ("kinetic to static friction ratio (μ): value", "1.5", "must be 1 at most"),
        ("kinetic to static friction ratio (μ): value", "0,5", "the decimal sign is a point: 0.5"),
        ("kinetic to static friction ratio (μ): lower end of the slider", "1", "must be less than the other end"),
    ]:
        typed_into = page.get_by_label(label, exact=True)
        before = typed_into.input_value()
        typed_into.fill(typed)
        problem = page.locator(".problem:not(:empty)")
        expect(problem).to_contain_text(why)
        expect(typed_into).to_have_attribute("aria-invalid", "true")
        assert typed_into.get_attribute("aria-describedby") == problem.get_attribute("id")
        assert problem.get_attribute("role") == "alert"
        # The reason is shown below its own input.
        place, of_input = problem.bounding_box(), typed_into.bounding_box()
        assert 0 <= place["y"] - of_input["y"] < 90, (place, of_input)
        expect(body).to_have_class("of-other-inputs")
        expect(page.locator(".plane")).to_have_css("opacity", "0.35")
        if typed == "1.5":
            session.picture(page, "refused-number")
        # A refused text and its message disappear when the input loses the focus.
        page.locator("#overlay").focus()
        expect(problem).to_have_count(0)
        expect(typed_into).to_have_value(before)
        expect(body).not_to_have_class("of-other-inputs")
    typed_into = page.get_by_label("across: to", exact=True)
    typed_into.fill("0.1")
    expect(page.locator(".problem:not(:empty)")).to_have_count(1)
    typed_into.fill("2")
    expect(page.locator(".problem:not(:empty)")).to_have_count(0)
    expect(body).not_to_have_class("of-other-inputs")
    # A refused coordinate of the point: the plane stays, and the answers about the point are grey.
    of_point = page.locator("#point .where input").first
    of_point.fill("-1")
    of_point.press("Enter")
    expect(page.locator("#point .where .problem")).to_contain_text("must be greater than 0")
    expect(page.locator("#point .regime")).to_have_css("opacity", "0.35")
    of_point.fill("1")
    of_point.press("Enter")
    expect(page.locator("#point .where .problem")).to_have_text("")
    expect(page.locator("#point .regime")).to_have_css("opacity", "1")
    # A picture of other inputs is grey until the picture of the present inputs has arrived.
    settle(page)
    page.route("**/plane", lambda route: (time.sleep(2), route.continue_()))
    page.get_by_label("kinetic to static friction ratio (μ): value", exact=True).fill("0.6")
    expect(page.locator("#cells")).to_have_css("opacity", "0.35")
    expect(page.locator("#cells")).to_have_css("opacity", "1")
    page.unroute_all(behavior="ignoreErrors")
    page.context.close()


def a_page_whose_program_has_ended_says_so(session):
    session.serve()
    page = session.open(STRIBECK)
    settle(page)
    session.server.kill()
    page.get_by_label("belt speed (V): value").fill("2")
    expect(page.locator("#notice")).to_contain_text("has ended")
    wait(page, "location.hash.includes('p.V=2&')")
    session.serve()
    again = session.open(page.evaluate("location.hash"))
    settle(again)
    assert state(again)["p.V"] == "2"
    page.context.close()
    again.context.close()
    took = session.server.end()
    assert took < 2, f"Ctrl-C took {took:.1f} s"
    # The requests to the dead program are the point of this test: one under way when it died is reset, or gets an
    # empty answer, later ones are refused.
    ended = ("ERR_CONNECTION_REFUSED", "ERR_CONNECTION_RESET", "ERR_EMPTY_RESPONSE", "Failed to fetch")
    session.complaints[:] = [text for text in session.complaints if not any(word in text for word in ended)]


def the_keyboard_suffices(session):
    page = session.open(BISTABLE)
    settle(page)
    page.locator("#overlay").focus()
    page.keyboard.press("Enter")
    expect(page.locator("circle.pin")).to_be_visible()
    before = state(page)
    for key in ("ArrowLeft", "Shift+ArrowUp"):
        page.keyboard.press(key)
    page.wait_for_timeout(300)
    after = state(page)
    assert float(after["p.V"]) < float(before["p.V"]) and float(after["p.c"]) > float(before["p.c"])
    page.keyboard.press("+")
    page.keyboard.press("Alt+ArrowRight")
    page.wait_for_timeout(300)
    zoomed = state(page)
    assert zoomed["x"] != after["x"] and zoomed["y"] != after["y"]
    page.keyboard.press("Home")
    page.keyboard.press("Escape")
    page.wait_for_timeout(300)
    assert "pin" not in state(page)
    # Everything else is reached by Tab.
    reached = set()
    for _ in range(40):
        page.keyboard.press("Tab")
        reached.add(page.evaluate("document.activeElement.getAttribute('aria-label') ?? document.activeElement.id"))
    for wanted in ("law", "show", "open-gallery", "Axis across", "across: from"):
        assert wanted in reached, f"{wanted} is not reached by Tab: {reached}"
    page.context.close()


def everything_can_be_taken_along(session):
    page = session.open(BISTABLE + "&pin=1")
    drawn(page)
    wait(page, "document.querySelectorAll('.figure svg').length === 3")
    expect(page.locator("table.verdicts")).to_be_visible()
    page.get_by_role("button", name="Share and export").click()
    expect(page.locator("#leave pre").first).to_contain_text("slipmap probe --law exponential")
    session.picture(page, "leave")
    page.get_by_label("cells along each axis").fill("40")
    page.get_by_label("cells along each axis").press("Tab")
    expect(page.locator("#leave pre").nth(1)).to_contain_text("points = 40")
    with tempfile.TemporaryDirectory() as folder:
        # The commands make the map of the configuration, and its figure.
        configuration, commands = (page.locator("#leave pre").nth(number).text_content() for number in (1, 2))
        (Path(folder) / "plane.toml").write_text(configuration)
        for command in commands.splitlines():
            subprocess.run([session.program, *command.split()[1:]], check=True, capture_output=True, cwd=folder)
        assert "<svg " in (Path(folder) / "plane.svg").read_text() and (Path(folder) / "cells.csv").read_text().startswith("V,c,regime")
    page.context.close()


def a_machine_is_in_si_units(session):
    config = Path(__file__).parents[2] / "configs" / "brake_pad.toml"
    session.serve(str(config))
    page = session.open()
    settle(page)
    expect(page.locator("#overlay")).to_contain_text("belt speed, m/s")
    assert page.get_by_label("across: to").input_value() == "0.4"
    stage = box(page, "#overlay")
    page.mouse.click(stage["x"] + 0.3 * stage["width"], stage["y"] + 0.8 * stage["height"])
    expect(page.locator("table.verdicts tbody tr").first).to_be_visible()
    said = state(page)
    set_to = [f"--set={name}={said[f'p.{name}']}" for name in ("belt_speed", "damping")]
    probe = json.loads(session.probe("--machine", str(config), "--json", *set_to))
    assert page.locator("#point").get_attribute("data-regime") == probe["machine"]["regime"]
    # The answer is seen without scrolling.
    expect(page.locator("#answer")).to_contain_text(f": {probe['machine']['regime'].replace('_', ' ')}")
    answer = box(page, "#answer")
    assert answer["y"] + answer["height"] <= page.viewport_size["height"], answer
    expect(page.locator("table.verdicts thead")).to_contain_text("critical damping, N s/m")
    assert tells(page, probe["machine"]["critical_damping"]), "c* in SI units"
    page.get_by_text("Every number").click()
    assert str(probe["machine"]["natural_frequency"]) in page.locator("#point").text_content()
    before = pixels(page)
    page.get_by_label("normal force: value").fill("300")
    wait(page, "(before) => document.getElementById('cells').toDataURL() !== before", before)
    drawn(page)
    assert page.get_by_label("across: to").input_value() == "0.4", "speeds stay what they are"
    # The pinned point is typed in SI units too; the plane reaches as far as the point.
    page.get_by_label("belt speed of the point").fill("0.5")
    page.get_by_label("belt speed of the point").press("Enter")
    wait(page, "location.hash.includes('p.belt_speed=0.5')")
    assert page.get_by_label("across: to").input_value() == "0.5"
    page.get_by_label("across: to").fill("0.4")
    session.picture(page, "machine")
    # The sensitivity of the critical damping to each quantity, in per cent for one per cent.
    expect(page.locator("table.sensitivities")).to_contain_text("Stribeck velocity")
    # Any quantity is an axis: at each mass the critical damping of the machine's page.
    page.get_by_label("Axis across").select_option("mass")
    drawn(page)
    expect(page.locator("#overlay")).to_contain_text("mass, kg")
    wait(page, "document.querySelectorAll('#overlay path.curve').length >= 2")
    session.picture(page, "machine-mass")
    page.get_by_label("Axis up").select_option("normal force")
    drawn(page)
    assert page.locator("#notice").is_hidden()
    # A formula in SI units.
    page.get_by_label("Friction law").first.select_option("expression")
    wait(page, "location.hash.includes('law=expression')")
    drawn(page)
    expect(page.get_by_label("muk: value")).to_be_visible()
    session.picture(page, "machine-formula")
    page.get_by_role("button", name="Without units").click()
    wait(page, "!location.hash.includes('motion=')")
    drawn(page)
    assert state(page)["phi"] != said.get("phi") and "p.V" in state(page)
    page.get_by_label("Friction law").first.select_option("stribeck")
    wait(page, "location.hash.includes('law=stribeck')")
    page.get_by_role("button", name="As a machine in SI units").click()
    wait(page, "location.hash.includes('motion=translation')")
    drawn(page)
    assert "p.mass" in state(page) and "p.V" not in state(page), state(page)
    page.context.close()


def a_working_point_is_pinned(session):
    """In the units of its file."""
    with tempfile.TemporaryDirectory() as folder:
        config = Path(folder) / "one.toml"
        config.write_text('[friction]\nlaw = "exponential"\n[machine]\nmass = 2.0\nstiffness = 5e5\nnormal_force = "1 kN"\nstatic_friction = "40 %"\n'
                          'kinetic_friction = 0.25\nstribeck_velocity = 0.05\nbelt_speed = "150 mm/s"\ndamping = 30.0\n')
        session.serve(str(config))
        page = session.open()
        settle(page)
        probe = json.loads(session.probe("--machine", str(config), "--json"))["machine"]
        said = state(page)
        most = float(said["y"].split(",")[2])
        assert said["pin"] == "1" and 1.1 < most / max(probe["critical_damping"], 30.0) < 1.3, said
        expect(page.locator("#answer")).to_contain_text(f"belt speed = 150 mm/s, damping = 30 N s/m: {probe['regime'].replace('_', ' ')}")
        expect(page.locator("#overlay")).to_contain_text("belt speed, mm/s")
        inputs = [page.get_by_label(f"{name}: value").input_value() for name in ("normal force", "static friction", "kinetic friction")]
        assert inputs == ["1", "40", "0.25"], inputs
        assert tells(page, probe["critical_damping"])
        expect(page.locator(".figure").first).to_contain_text("velocity, mm/s")
        curve = page.locator("#overlay path.curve").first.get_attribute("d")
        # The same in the link; the configuration that leaves the page has the units of the file.
        again = session.open(page.evaluate("location.hash"))
        settle(again)
        wait(again, "document.querySelectorAll('#overlay path.curve').length >= 2")
        assert again.locator("#overlay path.curve").first.get_attribute("d") == curve
        again.get_by_label("kinetic friction: value").fill("0.5")
        expect(again.locator("#parameters")).to_contain_text("must be 0.4 at most")
        again.get_by_role("button", name="Share and export").click()
        expect(again.locator("#leave pre").first).to_contain_text("--set belt_speed=0.15")
        expect(again.locator("#leave pre").nth(1)).to_contain_text('normal_force = "1.0 kN"')
        session.picture(again, "machine-units")
        again.context.close()
        page.context.close()


def the_legend_never_shrinks(session):
    """Else a finer picture with a kind of cell more, whose word wraps, would shrink the plane, which began anew for ever."""
    page = session.open(BISTABLE + "&curves=0", 360, 740)
    keys = page.locator("#legend .key")
    height = "document.getElementById('legend').offsetHeight"
    settle(page)
    many, tall = keys.count(), page.evaluate(height)
    page.locator("#show").select_option("verdict_simulation")
    settle(page)
    assert keys.count() < many and page.evaluate(height) == tall, (keys.count(), many, page.evaluate(height), tall)
    page.context.close()


def nobody_is_shut_out(session):
    """axe-core finds nothing to complain of, and nothing is wider than the window."""
    source = AXE.read_text()
    for width, height, dark in [(2560, 1440, True), (1280, 860, True), (360, 740, False)]:
        page = session.open(BISTABLE + "&pin=1", width, height, dark)
        drawn(page)
        wait(page, "document.querySelectorAll('table.verdicts tr').length > 7")
        over = page.evaluate("document.documentElement.scrollWidth - innerWidth")
        assert over <= 0, f"at {width} px the page is {over} px too wide"
        session.picture(page, f"page-{width}{'-dark' if dark else ''}")
        if width > 2000:
            page.context.close()
            continue
        # Its script is injected through the browser, since the policy of the page forbids other scripts.
        page.evaluate(source)
        for opened in (None, "Examples", "Share and export"):
            if opened:
                page.keyboard.press("Escape")
                page.get_by_role("button", name=opened).click()
            found = page.evaluate("(values) => axe.run({ runOnly: { type: 'tag', values } })", RULES)["violations"]
            told = [f"{it['id']}: {it['help']}: {[node['html'][:120] for node in it['nodes']]}" for it in found]
            assert not told, f"at {width} px: " + "\n".join(told)
        page.context.close()


TESTS = [
    the_gallery_opens_examples,
    a_slider_changes_the_plane,
    cells_are_those_of_the_engine,
    a_click_gives_the_numbers_of_probe,
    a_link_restores_the_state,
    numbers_of_the_previous_state_are_marked,
    a_formula_with_an_error_is_told_with_its_place,
    a_refused_number_says_why,
    a_page_whose_program_has_ended_says_so,
    the_keyboard_suffices,
    everything_can_be_taken_along,
    a_machine_is_in_si_units,
    a_working_point_is_pinned,
    the_legend_never_shrinks,
    nobody_is_shut_out,
]


def run_all(session, tests):
    """The number of tests that fail."""
    failures = 0
    for test in tests:
        started = time.monotonic()
        try:
            test(session)
            # Answers that take too long on a busy machine are refused, and the browser logs that.
            session.complaints[:] = [text for text in session.complaints if "503" not in text]
            assert not session.complaints, f"the browser complains: {session.complaints}"
            print(f"ok     {test.__name__} ({time.monotonic() - started:.1f} s)", flush=True)
        except Exception as error:
            failures += 1
            session.complaints.clear()
            print(f"FAILED {test.__name__}: {error}", flush=True)
        session.end_others()
    return failures


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("slipmap")
    parser.add_argument("--pictures")
    parser.add_argument("--only")
    arguments = parser.parse_args()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=FLAGS)
        session = Session(browser, arguments)
        failures = run_all(session, [test for test in TESTS if (arguments.only or "") in test.__name__])
        browser.close()
        session.server.end()
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
