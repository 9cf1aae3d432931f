// Exports of the page: texts to copy, and the link.

import { element } from "./elements.js";
import { post } from "./program.js";
import { plane } from "./state.js";

// Cells along each axis of an exported configuration.
const USUAL = 256;
export class Leave {
  constructor(app) {
    Object.assign(this, { app, dialog: document.getElementById("leave"), box: document.getElementById("leave-box"), cells: USUAL });
    document.getElementById("open-leave").addEventListener("click", () => this.show());
  }

  body() {
    const { state } = this.app;
    return { ...plane(state, this.cells, this.cells), show: state.show, curves: state.curves };
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
    const link = element("input", { readonly: true, value: location.href, "aria-label": "link to this state", id: "link" });
    link.addEventListener("focus", () => link.select());
    this.box.replaceChildren(
      element("h3", {}, "Link"), element("div", { class: "copied" }, link, this.copier(() => location.href, "Copy the link")),
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
      const { command, commands, toml, python, table } = await post("texts", this.body(), "texts");
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
}
