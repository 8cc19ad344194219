// The page's keys: the emergency stop, scrolling, Escape, and keys that click an element (data-hotkey).
import { stopRobots, told } from "./studio.js";

// What has the focus because a person went there with the keyboard, if it is to be pressed.
function reached() {
  const element = document.activeElement;
  return element?.matches("button, summary, a, input, [role=button]") && element.matches(":focus-visible")
    ? element
    : null;
}

// The emergency stop works wherever the focus is, in a form and in front of a dialog, too.
document.addEventListener("keydown", (event) => {
  if (event.key !== "Enter" || !(event.ctrlKey || event.metaKey)) return;
  event.preventDefault();
  event.stopImmediatePropagation();
  if (!event.repeat) stopRobots();
}, true);

const TEXT = new Set(["INPUT", "SELECT", "TEXTAREA"]);

// Keys that scroll do so in what was clicked last, in the panel at the right otherwise: the page
// itself is never longer than the window.
const SCROLLS = {
  PageDown: (part) => part.scrollBy(0, 0.9 * part.clientHeight),
  PageUp: (part) => part.scrollBy(0, -0.9 * part.clientHeight),
  Home: (part) => part.scrollTo(0, 0),
  End: (part) => part.scrollTo(0, part.scrollHeight),
};
let clicked = null;
document.addEventListener("pointerdown", ({ target }) => (clicked = target), true);

function scrollable(element) {
  for (let part = element; part && part !== document.body; part = part.parentElement) {
    const { overflowY } = getComputedStyle(part);
    if (part.scrollHeight > part.clientHeight + 1 && /auto|scroll/.test(overflowY)) return part;
  }
  return null;
}

function scrolls(event) {
  const active = document.activeElement;
  if (!(event.key in SCROLLS) || TEXT.has(active?.tagName)) return false;
  if (event.ctrlKey || event.metaKey || event.altKey || event.shiftKey) return false;
  const dialog = document.querySelector("[data-modal] .dialog");
  const part = dialog ? scrollable(active) ?? dialog
    : scrollable(active) ?? scrollable(clicked?.isConnected ? clicked : null)
      ?? document.querySelector(".side .pane");
  if (part) SCROLLS[event.key](part);
  return true;
}

document.addEventListener("keydown", (event) => {
  if (event.key === "Escape") {
    if (window.studioField?.cancelDrag()) return; // that was in front
    const active = document.activeElement;
    if (active?.matches("input[type=search]") && active.value) {
      event.preventDefault(); // the browser would empty the field without a word to the server
      active.value = "";
      active.dispatchEvent(new Event("input", { bubbles: true }));
      return;
    }
    const cell = active?.matches("td input");
    if (cell) active.value = active.defaultValue; // what was typed there is given up
    if (TEXT.has(active?.tagName)) active.blur();
    if (!cell) told("escape");
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
  if (scrolls(event)) {
    event.preventDefault();
    return;
  }
  const writing = TEXT.has(document.activeElement?.tagName) && document.activeElement.type !== "range";
  if (writing || event.ctrlKey || event.metaKey || event.altKey || event.repeat) return;
  const key = event.key === " " ? "space" : event.key.toLowerCase();
  const open = document.querySelector("[data-modal]");
  const element = (open || document).querySelector(`[data-hotkey="${CSS.escape(key)}"]`);
  if (element && !element.disabled) {
    event.preventDefault();
    element.click();
    element.classList.add("pressed");
    setTimeout(() => element.classList.remove("pressed"), 160);
  } else if (!open) {
    window.studioField?.key(key);
  }
});
