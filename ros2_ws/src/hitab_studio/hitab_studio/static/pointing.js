// Input in the field, with a mouse, fingers or the keyboard: selects, moves and turns things, and
// moves and zooms the view.
import { aim, arrowOf, letGo } from "./arrow.js";
import { KNOB } from "./drawing.js";

const FINGER = 16; // px; distance at which a finger still touches a thing
const HOLD_MS = 500; // time after which a resting finger adds to the selection
const STEP = 0.5; // m; step of an arrow key, a fifth of it with Shift
const TURN = Math.PI / 12; // rad; step of a key that turns
const SOON_MS = 1500;

export function listen(field) {
  const { canvas } = field;
  const pointers = new Map();
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    field.zoom(Math.exp(-event.deltaY * 0.0015), event.offsetX, event.offsetY);
  }, { passive: false });
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return; // a menu opens, or the page scrolls
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, [event.offsetX, event.offsetY]);
    if (pointers.size === 2) beginPinch(field, pointers);
    else beginDrag(field, event);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (pointers.has(event.pointerId)) pointers.set(event.pointerId, [event.offsetX, event.offsetY]);
    if (field.pinch) movePinch(field, pointers);
    else if (field.drag) moveDrag(field, event);
    else hover(field, event);
  });
  const end = (event) => {
    if (!pointers.delete(event.pointerId)) return;
    if (field.pinch) field.pinch = pointers.size ? field.pinch : null;
    else if (field.drag && event.type === "pointerup") endDrag(field, event);
    else cancelDrag(field);
  };
  // Only releasing the pointer places a thing. Losing the capture cancels the drag, as when the
  // page is left or something else takes the pointer.
  for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) {
    canvas.addEventListener(name, end);
  }
  canvas.addEventListener("contextmenu", (event) => event.pointerType === "touch" && event.preventDefault());
  window.addEventListener("blur", () => cancelDrag(field));
  canvas.addEventListener("dblclick", () => field.fit());
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || !byKey(field, event)) return;
    event.preventDefault();
    event.stopPropagation();
  });
  document.addEventListener("click", (event) => {
    if (event.target.closest("#trails")) field.toggleTrails();
    else if (event.target.closest("#fit")) field.fit();
    else if (event.target.closest("#zoom-in")) field.zoom(1.25);
    else if (event.target.closest("#zoom-out")) field.zoom(0.8);
  });
}

const near = (marks, px, py, within) =>
  marks.find(({ x, y }) => Math.hypot(px - x, py - y) < within);

function hover(field, event) {
  const found = field.thingAt(event.offsetX, event.offsetY);
  if (found !== field.hovered) {
    field.hovered = found;
    field.canvas.style.cursor = found < 0 ? "default" : field.fixed ? "pointer" : "grab";
    field.redraw();
  }
}

function beginDrag(field, event) {
  const from = [event.offsetX, event.offsetY];
  const finger = event.pointerType === "touch";
  const slack = finger ? FINGER : 6;
  const handle = near(field.handles, ...from, 5 + slack);
  // A knob may lie on another thing: a touch of the visible knob takes the knob, a touch beside it
  // the thing. With Shift, which adds to the selection, any touch takes the thing.
  const knob = !event.shiftKey && near(field.handles, ...from, KNOB + 1.5);
  const thing = knob ? -1 : field.thingAt(...from, handle ? 0 : slack);
  const turning = thing < 0 ? !!handle : event.altKey;
  const i = thing < 0 && handle ? handle.i : thing;
  const starts = new Map();
  if (i >= 0) {
    const name = field.roster.names[i];
    const together = field.fixed ? [] : field.chosen.has(name) ? [...field.chosen] : [name];
    for (const other of together) {
      const k = field.index.get(other);
      if (k !== undefined) starts.set(k, [...field.now.places.subarray(3 * k, 3 * k + 2)]);
    }
  }
  const drag = {
    i, from, starts, turning, places: new Map(), headings: new Map(),
    arrow: turning ? null : arrowOf(field, i), moved: false, least: finger ? 9 : 4, view: { ...field.view },
  };
  field.drag = drag;
  if (finger && i >= 0 && !turning) {
    drag.hold = setTimeout(() => {
      if (field.drag !== drag || drag.moved) return;
      cancelDrag(field);
      window.studioTell("choose", { name: field.roster.names[i], more: true });
    }, HOLD_MS);
  }
}

function moveDrag(field, event) {
  const { drag } = field;
  const [dx, dy] = [event.offsetX - drag.from[0], event.offsetY - drag.from[1]];
  if (!drag.moved && Math.hypot(dx, dy) < drag.least) return;
  drag.moved = true;
  field.canvas.style.cursor = "grabbing";
  if (drag.arrow) {
    aim(field, drag, event);
  } else if (drag.i < 0) {
    const { view } = drag;
    field.view = { ...view, x: view.x + dx, y: view.y + dy, fitted: false };
  } else if (drag.turning) {
    const [x, y] = field.toField(event.offsetX, event.offsetY);
    for (const [k, [x0, y0]] of drag.starts) drag.headings.set(k, Math.atan2(y - y0, x - x0));
  } else {
    const [w, h] = field.roster.size;
    for (const [k, [x, y]] of drag.starts) {
      const to = [x + dx / field.view.scale, y - dy / field.view.scale];
      drag.places.set(k, [clamp(to[0], w / 2), clamp(to[1], h / 2)]);
    }
  }
  field.redraw();
}

function endDrag(field, event) {
  const { drag } = field;
  const { names } = field.roster;
  clearTimeout(drag.hold);
  field.drag = null;
  field.canvas.style.cursor = "default";
  if (drag.arrow && drag.moved) {
    letGo(field, drag);
  } else if (drag.i < 0) {
    if (!drag.moved) window.studioTell("deselect");
  } else if (!drag.moved) {
    if (!drag.turning) window.studioTell("choose", { name: names[drag.i], more: event.shiftKey });
  } else if (drag.starts.size) {
    put(field, drag.places, drag.headings);
  }
  field.redraw();
}

// Draws things at their new places at once, and sends the placement to the world.
function put(field, places, headings) {
  const things = {};
  const { names } = field.roster;
  const shown = [field.now, field.before].filter(Boolean);
  for (const [k, [x, y]] of places) {
    things[names[k]] = { x, y, vx: 0, vy: 0 };
    for (const moment of shown) moment.places.set([x, y], 3 * k);
  }
  for (const [k, heading] of headings) {
    things[names[k]] = { ...things[names[k]], heading };
    for (const moment of shown) moment.places[3 * k + 2] = heading;
  }
  window.studioTell("place", { things });
}

// Cancels the drag; returns whether there was one.
export function cancelDrag(field) {
  const { drag } = field;
  if (!drag) return false;
  clearTimeout(drag.hold);
  field.drag = null;
  if (drag.i < 0 && drag.moved) field.view = drag.view;
  field.canvas.style.cursor = "default";
  field.redraw();
  return true;
}

const MOVES = {
  ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1],
};

// Handles a key in the field; returns whether the key has a meaning there.
function byKey(field, event) {
  if (!field.now) return false;
  const fine = event.shiftKey ? 0.2 : 1;
  if (event.key === "PageUp" || event.key === "PageDown") {
    chooseNext(field, event.key === "PageDown" ? 1 : -1);
  } else if (event.altKey && (event.key === "ArrowLeft" || event.key === "ArrowRight")) {
    const turn = (event.key === "ArrowLeft" ? 1 : -1) * TURN;
    forChosen(field, (_, headings, k, at) => headings.set(k, at[2] + turn));
  } else if (!event.altKey && event.key in MOVES) {
    const [dx, dy] = MOVES[event.key].map((step) => fine * STEP * step);
    const [w, h] = field.roster.size;
    const to = ([x, y]) => [clamp(x + dx, w / 2), clamp(y + dy, h / 2)];
    forChosen(field, (places, _, k, at) => places.set(k, to(at)));
  } else {
    return false;
  }
  field.redraw();
  return true;
}

// Changes the places of the selected things. A key that follows soon starts from the last placement,
// which the world may publish only later.
function forChosen(field, change) {
  const [places, headings] = [new Map(), new Map()];
  const now = performance.now();
  if (!(now - field.keyed?.at < SOON_MS)) field.keyed = { things: new Map() };
  field.keyed.at = now;
  for (const name of field.chosen) {
    const k = field.index.get(name);
    if (k === undefined) continue;
    const at = field.keyed.things.get(name) ?? [...field.now.places.subarray(3 * k, 3 * k + 3)];
    change(places, headings, k, at);
    const [x, y] = places.get(k) ?? at;
    field.keyed.things.set(name, [x, y, headings.get(k) ?? at[2]]);
  }
  if (!field.fixed && (places.size || headings.size)) put(field, places, headings);
}

function chooseNext(field, step) {
  const { names } = field.roster;
  const last = [...field.chosen].pop();
  const here = last === undefined ? (step > 0 ? -1 : 0) : field.index.get(last) ?? -1;
  const i = (here + step + names.length) % names.length;
  window.studioTell("choose", { name: names[i] });
  const [x, y] = field.now.places.subarray(3 * i, 3 * i + 2);
  const report = document.getElementById("field-report");
  if (report) report.textContent = `${names[i]}, x ${x.toFixed(1)} m, y ${y.toFixed(1)} m`;
}

function beginPinch(field, pointers) {
  cancelDrag(field);
  field.pinch = { apart: apart(pointers) };
}

function movePinch(field, pointers) {
  if (pointers.size < 2) return;
  const now = apart(pointers);
  const [[ax, ay], [bx, by]] = [...pointers.values()];
  field.zoom(now / field.pinch.apart, (ax + bx) / 2, (ay + by) / 2);
  field.pinch.apart = now;
}

const clamp = (value, most) => Math.min(Math.max(value, -most), most);

function apart(pointers) {
  const [[ax, ay], [bx, by]] = [...pointers.values()];
  return Math.max(1, Math.hypot(ax - bx, ay - by));
}
