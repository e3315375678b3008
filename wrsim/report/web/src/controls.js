// What pages share of their controls: groups of buttons, the camera and the exaggeration of a vehicle, numbers as text.
export const $ = (id) => document.getElementById(id);

export const words = (v, digits = 4) => (Number.isFinite(v) ? Number(v.toPrecision(digits)).toString().replace("-", "\u2212") : "\u2013");

/** Show which button of a group, [data-group=value], is pressed. */
export function press(group, value) {
  for (const button of document.querySelectorAll(`[data-${group}]`)) button.setAttribute("aria-pressed", String(button.dataset[group] === String(value)));
}

/** A page with a vehicle on its track: `stage`, `show()`, `data.called`. */
export class VehiclePage {
  /** A wheelset with its number from the front, as in the tables; anything else by its name. */
  called(name) {
    return this.data.called[name] ?? name;
  }

  exaggerate(factor) {
    this.factor = factor;
    press("factor", factor);
    this.show();
  }

  beginCamera() {
    for (const button of document.querySelectorAll("[data-factor]")) {
      button.addEventListener("click", () => this.exaggerate(Number(button.dataset.factor)));
    }
    if (!this.stage) return;
    const look = (from) => {
      this.stage.view(from, $("focus").value || null);
      this.show();
    };
    for (const button of document.querySelectorAll("[data-view]")) button.addEventListener("click", () => look(button.dataset.view));
    for (const name of this.stage.parts.keys()) $("focus").append(new Option(this.called(name), name));
    $("focus").addEventListener("change", () => look("oblique"));
  }
}
