// Exports of the page: texts to copy, one page that needs no program, and the link.

import { element } from "./elements.js";
import { post } from "./server.js";
import { place } from "./state.js";

// Cells along each axis of an exported configuration.
const USUAL = 256;
// Styles that differ in the saved page: it scrolls, and its plane is in the normal flow.
const ALONE = `html, body { height: auto; overflow: visible; } body { display: block; max-width: 70rem; margin: auto; padding: 1rem; }
#overlay { position: static; display: block; height: auto; cursor: auto; touch-action: auto; }
#point { overflow-x: auto; }
.figure svg { max-width: 42rem; }
.hint { overflow-wrap: anywhere; }`;

function save(blob, name) {
  const link = element("a", { href: URL.createObjectURL(blob), download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

export class Leave {
  constructor(app) {
    Object.assign(this, { app, dialog: document.getElementById("leave"), box: document.getElementById("leave-box"), cells: USUAL });
    document.getElementById("open-leave").addEventListener("click", () => this.show());
  }

  body() {
    const { state } = this.app;
    const sides = { x: { ...state.x, points: this.cells }, y: { ...state.y, points: this.cells } };
    return { ...place(state), ...sides, show: state.show, curves: state.curves };
  }

  async show() {
    this.dialog.showModal();
    const cells = element("input", { class: "number", type: "number", min: 2, max: 1024, value: this.cells, "aria-label": "cells along each axis" });
    cells.addEventListener("change", () => {
      this.cells = Math.round(Math.min(1024, Math.max(2, Number(cells.value) || USUAL)));
      this.tell();
    });
    this.problem = element("p", { class: "problem", role: "alert" });
    this.texts = element("div");
    const page = element("button", { type: "button", "data-file": "html", onclick: () => this.keep_page() }, "This page, HTML");
    const link = element("input", { readonly: true, value: location.href, "aria-label": "link to this state", id: "link" });
    link.addEventListener("focus", () => link.select());
    this.box.replaceChildren(
      element("h3", {}, "Link"), element("div", { class: "copied" }, link, this.copier(() => location.href, "Copy the link")),
      element("h3", {}, "As it is"), page,
      element("h3", {}, "As a map and as figures"), element("label", { class: "field" }, "cells along each axis", cells),
      this.problem, this.texts,
    );
    await this.tell();
  }

  copier(text, label) {
    const button = element("button", { type: "button", "aria-label": label }, "Copy");
    button.addEventListener("click", async () => {
      await navigator.clipboard.writeText(text());
      button.textContent = "Copied";
      setTimeout(() => (button.textContent = "Copy"), 1500);
    });
    return button;
  }

  complain(problem) {
    this.problem.textContent = problem && !problem.overtaken ? problem.message : "";
  }

  async tell() {
    try {
      const { command, commands, toml, python, table } = await post("/api/texts", this.body(), "texts");
      const block = (title, text) => element("section", {},
        element("div", { class: "title" }, element("h3", {}, title), this.copier(() => text, `Copy: ${title}`)),
        element("pre", { tabindex: "0", "aria-label": title }, text));
      this.texts.replaceChildren(
        block("Command for the point", command),
        block("Configuration, plane.toml", toml),
        ...(table ? [block("Table, friction.csv", table)] : []),
        block("Commands for the map and its figure", commands),
        block("Python", python),
      );
      this.complain(null);
    } catch (problem) {
      this.complain(problem);
    }
  }

  // Saves one file that shows the present contents: pictures and tables as they are, without requests.
  async keep_page() {
    const style = await (await fetch("/assets/style.css")).text();
    const { state } = this.app;
    const { canvas, overlay, legendBox } = this.app.plane;
    const stage = overlay.cloneNode(true);
    for (const name of ["tabindex", "role", "aria-describedby", "style"]) stage.removeAttribute(name);
    const { clientWidth, clientHeight } = overlay.parentElement;
    stage.setAttribute("viewBox", `0 0 ${clientWidth} ${clientHeight}`);
    stage.setAttribute("role", "img");
    const cells = document.createElementNS("http://www.w3.org/2000/svg", "image");
    const { x, y, w, h } = this.app.plane.rect;
    for (const [name, value] of Object.entries({ href: canvas.toDataURL(), x, y, width: w, height: h })) cells.setAttribute(name, value);
    stage.prepend(cells);
    const legend = legendBox.cloneNode(true);
    const swatches = legendBox.querySelectorAll("canvas");
    legend.querySelectorAll("canvas").forEach((copy, i) => copy.replaceWith(element("img", { src: swatches[i].toDataURL(), alt: "", class: copy.className, width: copy.width, height: copy.height })));
    const point = document.getElementById("point").cloneNode(true);
    point.querySelectorAll("button, p.problem").forEach((it) => it.remove());
    // Copies of input fields are empty.
    const fields = document.querySelectorAll("#point input");
    point.querySelectorAll("input").forEach((copy, i) => copy.replaceWith(`= ${fields[i].value}`));
    const words = state.axes.map(({ name, symbol }) => `${symbol} = ${state.at[name]}`).join(", ");
    const law = state.law.phi ?? state.law.file ?? state.law.name;
    const page = document.implementation.createHTMLDocument(document.title);
    page.documentElement.lang = "en";
    page.documentElement.dataset.theme = "light";
    page.head.prepend(Object.assign(page.createElement("meta"), { httpEquiv: "Content-Security-Policy", content: "default-src 'none'; img-src data:; style-src 'unsafe-inline'" }));
    page.body.append(
      element("h1", {}, document.title), element("p", {}, `Friction law: ${law}. Held: ${words}.`),
      stage, legend, point,
      element("p", { class: "hint" }, `Made by slipmap explore ${this.app.catalogue.version}. Its state, for a running program: ${location.hash}`),
    );
    // As text: a style element would be subject to the policy of this page.
    const sheet = `<style>${style}\n${ALONE}</style>`;
    const text = page.documentElement.outerHTML.replace("</head>", () => `${sheet}</head>`);
    save(new Blob([`<!DOCTYPE html>\n${text}`], { type: "text/html" }), "plane.html");
  }
}
