// The page's keys: the emergency stop, Escape, and keys that click an element (data-hotkey).
import { request, stopRobots } from "./studio.js";

// Returns the focused control, if a person reached it with the keyboard.
function reached() {
  const element = document.activeElement;
  return element?.matches("button, summary, a, input, [role=button]") && element.matches(":focus-visible")
    ? element
    : null;
}

// The emergency stop works with any focus, also in forms and dialogs.
document.addEventListener("keydown", (event) => {
  if (event.key !== "Enter" || !(event.ctrlKey || event.metaKey)) return;
  event.preventDefault();
  event.stopImmediatePropagation();
  if (!event.repeat) stopRobots();
}, true);

const TEXT = new Set(["INPUT", "SELECT", "TEXTAREA"]);

document.addEventListener("keydown", (event) => {
  if (event.key === "Escape") {
    if (window.studioField?.cancelDrag()) return; // Escape has cancelled a drag
    const active = document.activeElement;
    if (active?.matches("input[type=search]") && active.value) {
      event.preventDefault(); // the browser would clear the field without an input event
      active.value = "";
      active.dispatchEvent(new Event("input", { bubbles: true }));
      return;
    }
    const cell = active?.matches("td input");
    if (cell) active.value = active.defaultValue; // discard the input
    if (TEXT.has(active?.tagName)) active.blur();
    if (!cell) request("escape");
    return;
  }
  if (event.key === "Enter" || event.key === " ") {
    const element = reached();
    if (element?.matches("[role=button]")) {
      event.preventDefault();
      element.dispatchEvent(new MouseEvent("click", { bubbles: true, cancelable: true }));
    }
    if (element) return; // the browser presses it
  }
  const writing = TEXT.has(document.activeElement?.tagName) && document.activeElement.type !== "range";
  if (writing || event.ctrlKey || event.metaKey || event.altKey) return;
  // With Shift, keyboards have different characters on the keys of comma and period.
  const shifted = event.shiftKey && { Comma: "<", Period: ">" }[event.code];
  const key = shifted || (event.key === " " ? "space" : event.key.toLowerCase());
  const open = document.querySelector("[data-modal]");
  const element = (open || document).querySelector(`[data-hotkey="${CSS.escape(key)}"]`);
  if (event.repeat && element?.dataset.repeats === undefined) return;
  if (element && !element.disabled) {
    event.preventDefault();
    element.click();
    element.classList.add("pressed");
    setTimeout(() => element.classList.remove("pressed"), 160);
  } else if (!open) {
    window.studioField?.key(key);
  }
});
