// The tutorial's card and rings. The server says what is marked; the browser finds it on the page,
// puts the card beside it, and keeps where the person was.
import { request } from "./studio.js";

const KEPT = "hitab-tutorial";
const EVERY_MS = 100;
const ABSENT_MAX = 10; // looks, before an optional step is left out
const GAP = 12; // px between the card and what is marked
const COVERED = ".top .bar, .emergency, .banner, .bottom > *, .notice, .dialog, .empty, .field-tools, .agent, .tabs";
const MARK = 1e4; // how much worse it is to cover what is marked
const GRIP = 15; // px; smallest radius of a ring in the field

const ring = document.createElement("div");
const spot = document.createElement("div");
ring.className = "tutorial-ring";
spot.className = "tutorial-ring spot";
ring.dataset.test = "tutorial-ring";
spot.dataset.test = "tutorial-spot";
document.body.append(ring, spot);

let recalled = false;
let written = "";
let looked = ""; // the step and its mark that was scrolled into view
let absent = 0; // looks at which what an optional step marks was not there
let place = null; // of the card, while it covers nothing

function recall() {
  let kept = null;
  try {
    kept = JSON.parse(localStorage.getItem(KEPT));
  } catch {}
  request("tutorial-recall", { kept });
}

const shown = (element) => element?.getClientRects().length && !element.closest("[inert]");

// Returns the first element that a person can press; in front of it, an open dialog is to be closed.
function marked(card) {
  for (const selector of JSON.parse(card.dataset.marks)) {
    const element = [...document.querySelectorAll(selector)].find(shown);
    if (element) return element;
  }
  if (document.querySelector("[data-modal]")) return document.querySelector('[data-modal] [data-do="close"]');
  return null;
}

function around(x, y, r) {
  return new DOMRect(x - r, y - r, 2 * r, 2 * r);
}

// Returns the rectangles of a thing and of its spot in the window.
function inField(card) {
  const field = window.studioField;
  const i = field?.index?.get(card.dataset.thing);
  if (i === undefined || !field.now) return [];
  const at = document.getElementById("field").getBoundingClientRect();
  const [x, y] = JSON.parse(card.dataset.spot);
  return [field.now.places.subarray(3 * i, 3 * i + 2), [x, y]].map((point) => {
    const [px, py] = field.toScreen(...point);
    return around(at.x + px, at.y + py, GRIP);
  });
}

function draw(element, box) {
  element.hidden = !box;
  if (!box) return;
  Object.assign(element.style, {
    left: `${box.x - 4}px`, top: `${box.y - 4}px`, width: `${box.width + 8}px`, height: `${box.height + 8}px`,
  });
}

const overlap = (a, b) =>
  Math.max(0, Math.min(a.right, b.right) - Math.max(a.left, b.left)) *
  Math.max(0, Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top));

// Puts the card where it covers the least: beside what is marked, or in a corner of the field.
function putCard(panel, card, marks) {
  const { width, height } = card.getBoundingClientRect();
  const others = document.querySelectorAll(COVERED);
  const covered = [...others].filter((it) => it.getClientRects().length).map((it) => it.getBoundingClientRect());
  const cost = ([x, y]) => {
    const box = new DOMRect(x, y, width, height);
    return marks.reduce((sum, it) => sum + MARK * overlap(box, it), 0) + covered.reduce((sum, it) => sum + overlap(box, it), 0);
  };
  const inside = ([x, y]) => [
    Math.min(Math.max(x, 4), Math.max(4, innerWidth - width - 4)),
    Math.min(Math.max(y, 4), Math.max(4, innerHeight - height - 4)),
  ];
  const stage = document.getElementById("stage").getBoundingClientRect();
  const low = (document.querySelector(".bottom")?.getBoundingClientRect().top ?? stage.bottom) - height - GAP;
  const corners = [[stage.left + GAP, low], [stage.right - width - GAP, low], [stage.left + GAP, stage.top + 100],
    [stage.left + GAP, stage.bottom + GAP], // on a small screen, below the field
    [innerWidth, innerHeight]];
  const beside = marks.slice(0, 1).flatMap((it) => [
    [it.x, it.bottom + GAP], [it.x, it.y - height - GAP], [it.right + GAP, it.y], [it.x - width - GAP, it.y],
  ]);
  const places = [...(place ? [place] : []), ...(card.dataset.thing ? corners : [...beside, ...corners])].map(inside);
  const best = places.reduce((one, other) => (cost(other) < cost(one) ? other : one));
  place = best;
  Object.assign(panel.style, { left: `${best[0]}px`, top: `${best[1]}px` });
}

function follow() {
  if (!window.socket?.connected) return;
  if (!recalled) {
    recalled = true;
    recall();
    return;
  }
  const panel = document.getElementById("panel-tutorial");
  const kept = panel?.querySelector("[data-tutorial]")?.dataset.tutorial;
  try {
    if (kept && kept !== written) localStorage.setItem(KEPT, kept);
  } catch {}
  written = kept || written; // another tab may write, too
  const card = panel?.querySelector("[data-marks]");
  const waits = card?.dataset.waits !== undefined; // for an answer: nothing is to be pressed
  const element = card && !waits ? marked(card) : null;
  const things = card && !waits && !element ? inField(card) : [];
  draw(ring, element ? element.getBoundingClientRect() : things[0]);
  ring.classList.toggle("thing", things.length > 0);
  draw(spot, things[1]);
  Object.assign(ring.dataset, { step: card?.dataset.step ?? "", of: element?.dataset.test ?? "" });
  if (!card) return;
  const { step } = card.dataset;
  absent = card.dataset.optional !== undefined && !element && !waits ? absent + 1 : 0;
  if (absent > ABSENT_MAX) request("tutorial-skip", { name: step });
  const mark = `${step} ${ring.dataset.of}`;
  if (looked !== mark && (element || things.length)) {
    looked = mark;
    place = null;
    element?.scrollIntoView({ block: "nearest", inline: "nearest" });
  }
  const dialog = element?.dataset.do === "close" ? "Close this dialog first." : "";
  card.querySelector("[data-why]").textContent = element?.dataset.off || dialog;
  putCard(panel, card, element ? [element.getBoundingClientRect()] : things);
}
setInterval(follow, EVERY_MS);

document.addEventListener("click", (event) => {
  const card = document.querySelector("#panel-tutorial [data-marks]");
  if (card?.dataset.optional !== undefined && marked(card)?.contains(event.target)) {
    request("tutorial-skip", { name: card.dataset.step });
  }
  if (!event.target.closest("[data-show-mark]")) return;
  const element = (card && marked(card)) || document.getElementById("field");
  element.scrollIntoView({ block: "nearest", inline: "nearest" });
  element.focus({ focusVisible: true });
});
