// What a person does on the page, told to the server; clicks and forms. The page says what is
// meant in its attributes:
//   data-do="name"     on a click, with all other data- attributes
//   data-change="name" when a control changes, with its value
//   data-submit="name" when a form is sent, with all its values
//   data-with-form     on a click or a change, also with all values of the form around it
//   data-seen          with the cycle that the field showed when the key or the button was pressed
//   data-hotkey="k"    pressing the key clicks the element (keys.js)
//   data-off="why"     it does nothing at present, and says why; the server knows whether it still does nothing
//
// The server confirms requests. What was sent into a connection that had broken is sent again,
// with all that came after it.
let nth = 0;
let unheard = [];
let oldest = 0;
export function told(what, more = {}) {
  tellTyped(); // the server hears of everything in the order in which the person did it
  unheard.push({ do: what, ...more, nth: ++nth });
  window.emitEvent("studio", unheard.at(-1));
}
window.studioTell = told;
window.studioHeard = (last) => (unheard = unheard.filter((asked) => asked.nth > last));
setInterval(() => {
  const before = oldest;
  oldest = unheard[0]?.nth;
  if (oldest !== before || !window.socket?.connected) return;
  for (const asked of unheard) window.emitEvent("studio", asked);
}, 1000);

function dataOf(element) {
  const data = { ...element.dataset };
  for (const name of ["do", "change", "submit", "hotkey", "key", "kept", "withForm"]) delete data[name];
  return data;
}

function valuesOf(form) {
  const values = {};
  for (const [name, value] of new FormData(form)) {
    if (name.endsWith("[]")) (values[name.slice(0, -2)] ||= []).push(value);
    else values[name] = value;
  }
  return values;
}

// The emergency stop has a way of its own: it does not need the page's connection, which may be down
// or about to be made anew. It is sent again until the server answers, after a reload of the page too.
const PRESSED = "hitab-stop-pressed";
const GIVE_UP_MS = 30000;
let stopping = false;

function tellOfStop(text) {
  let band = document.getElementById("stop-told");
  if (!band) {
    band = document.createElement("div");
    band.id = "stop-told";
    band.dataset.test = "stop-told";
    band.setAttribute("role", "alert");
    document.body.append(band);
  }
  band.textContent = text;
  band.hidden = !text;
}

async function sendStop() {
  if (stopping) return;
  stopping = true;
  let told = "";
  while (Number(sessionStorage.getItem(PRESSED)) > Date.now() - GIVE_UP_MS) {
    try {
      const signal = AbortSignal.timeout(3000);
      const answer = await fetch(`stop-robots?page=${window.STUDIO_PAGE}`, { method: "POST", signal });
      told = answer.ok ? "" : (await answer.json()).detail;
      break;
    } catch {
      told = "THE ROBOTS WERE NOT STOPPED: the studio does not answer. Use the robots' own switches.";
      tellOfStop("The studio has not answered yet: asking it again to stop the robots. Use their own switches.");
      await new Promise((resolve) => setTimeout(resolve, 300));
    }
  }
  stopping = false;
  sessionStorage.removeItem(PRESSED);
  tellOfStop(told);
}

export function stopRobots() {
  sessionStorage.setItem(PRESSED, Date.now());
  sendStop();
}
if (sessionStorage.getItem(PRESSED)) sendStop();

// The person's agents are free at once, also for the page that a reload makes, and not only when the
// server no longer waits for this one to connect again.
addEventListener("pagehide", () => navigator.sendBeacon(`leave?page=${window.STUDIO_PAGE}`));
addEventListener("pageshow", ({ persisted }) => persisted && location.reload());

// Whether what happens now comes of a further click of a double click: the server tells whether
// that is meant.
let again = false;
document.addEventListener("click", (event) => (again = event.detail > 1), true);
document.addEventListener("keydown", () => (again = false), true);

// A mouse or a finger has pressed before it clicks.
const shown = () => window.studioField?.shown || 0;
let seen = 0;
document.addEventListener("pointerdown", () => (seen = shown()), true);

document.addEventListener("click", (event) => {
  const off = event.target.closest("[data-off]");
  if (off && (!off.dataset.do || off.form)) {
    event.preventDefault();
    told("why", { reason: off.dataset.off });
    return;
  }
  const element = event.target.closest("[data-do]");
  if (!element || element.disabled) return;
  if (element.dataset.do === "stop-robots") return stopRobots();
  const control = event.target.closest("input, select");
  if (control && control !== element && element.contains(control)) return; // of a row that is clickable
  const form = element.closest("form");
  if (element.type !== "submit" || !form) event.preventDefault();
  else return;
  told(element.dataset.do, {
    ...dataOf(element),
    ...(form && element.dataset.withForm !== undefined ? { values: valuesOf(form) } : {}),
    ...(element.dataset.seen !== undefined ? { seen: event.detail ? seen : shown() } : {}),
    ...(event.detail ? {} : { hotkey: element.dataset.hotkey }),
    shift: event.shiftKey || undefined,
    again: again || undefined,
  });
  // A key that is pressed next is meant for the page, unless this was reached with the keyboard.
  if (event.detail) element.blur?.();
});

document.addEventListener("change", (event) => {
  const element = event.target.closest("[data-change]");
  if (!element) return;
  const value = element.type === "checkbox" ? element.checked : element.value;
  const form = element.dataset.withForm !== undefined && element.closest("form");
  told(element.dataset.change, { ...dataOf(element), value, ...(form ? { values: valuesOf(form) } : {}) });
  if (element.type === "number") element.value = element.defaultValue; // until the server agrees
});

// The server hears of what is typed once the person pauses or does something else.
let typed = null;
function tellTyped() {
  const last = typed;
  typed = null;
  if (!last) return;
  clearTimeout(last.timer);
  told(last.what, last.data);
}
document.addEventListener("input", (event) => {
  const element = event.target.closest("[data-input]");
  if (!element) return;
  if (typed?.element === element) clearTimeout(typed.timer);
  else tellTyped();
  const form = element.dataset.withForm !== undefined && element.closest("form");
  const data = { ...dataOf(element), value: element.value, ...(form ? { values: valuesOf(form) } : {}) };
  delete data.input;
  const timer = setTimeout(tellTyped, element.type === "range" ? 30 : 150);
  typed = { element, what: element.dataset.input, data, timer };
});

document.addEventListener("submit", (event) => {
  const form = event.target.closest("form[data-submit]");
  if (!form) return;
  event.preventDefault();
  told(form.dataset.submit, { ...dataOf(form), values: valuesOf(form), again: again || undefined });
});

document.documentElement.lang = "en";

// The theme is the browser's own unless the person chose one.
export function applyTheme(choice) {
  const dark = choice ? choice === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  document.documentElement.dataset.theme = dark ? "dark" : "light";
  window.studioField?.recolor();
}
window.studioTheme = () => {
  const next = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
  try {
    localStorage.setItem("hitab-theme", next);
  } catch {}
  applyTheme(next);
};
let kept = null;
try {
  kept = localStorage.getItem("hitab-theme");
} catch {}
applyTheme(kept);
document.addEventListener("click", (event) => {
  if (event.target.closest("[data-theme-toggle]")) window.studioTheme();
});

// While a dialog is open, the keyboard stays in it; afterwards the focus is where it was.
let dialog = null;
let before = null;
new MutationObserver(() => {
  const modal = document.querySelector("[data-modal]")?.firstElementChild ?? null;
  if (modal === dialog) return;
  if (!dialog) before = document.activeElement;
  dialog = modal;
  for (const part of document.querySelectorAll("#studio > :not(#panel-dialog, #panel-messages, #panel-emergency)")) {
    part.inert = !!modal;
  }
  const first = modal?.querySelector("[autofocus]") ?? modal?.querySelector("input, select, button");
  if (first) first.focus({ preventScroll: true }); // a long dialog begins at its top
  else if (before?.isConnected) before.focus();
}).observe(document.body, { childList: true, subtree: true });
