// Draws the field: ground, things, names, orders and messages.
import { drawArrow } from "./arrow.js";

// As in markers.py.
export const STATE_COLORS = [
  "#3b82d6", "#2fa36b", "#e08a2c", "#a66bd4", "#d6568a", "#2aa5b8",
  "#8f8a2e", "#d65a4a", "#6b7bd6", "#4f9a8f", "#b87a4b", "#8a93a3",
];
const NAMED = 26; // maximum number of things for which all names are shown, not only the selected
export const MANY = 120; // number of things above which they are drawn smaller
const TINY = 2000; // number of visible things above which each is a square in the color of its state
const SILENT = 5; // mode of an agent that does not answer
export const KNOB = 4.5; // px; radius of the knob that turns a thing
const HANDLE = 24; // px; from a thing's edge to its knob

export function draw(field) {
  const { context: c, now } = field;
  if (!field.width) return;
  const time = performance.now();
  field.drawn += 1;
  c.setTransform(field.ratio, 0, 0, field.ratio, 0, 0);
  c.clearRect(0, 0, field.width, field.height);
  drawGround(field, c);
  if (!now) return;
  const at = (time - now.at) / now.gap;
  field.shown = field.cycleAt(at);
  const screen = field.onScreen(at);
  field.robots.drawScans(c);
  if (field.trails) drawTrails(field, c);
  drawOrders(field, c, screen, time);
  drawThings(field, c, screen);
  drawHandles(field, c, screen);
  drawNames(field, c, screen);
  drawPreviews(field, c, screen);
  drawArrow(field, c, screen);
  drawCalls(field, c, screen, time);
  if (at < 1 || field.calls.length || field.orders.length) field.redraw();
}

function drawGround(field, c) {
  const [w, h] = field.roster.size;
  const [mx, my] = field.roster.center;
  const [west, east, south, north] = [mx - w / 2, mx + w / 2, my - h / 2, my + h / 2];
  const [left, top] = field.toScreen(west, north);
  const { scale } = field.view;
  const [width, height] = [w * scale, h * scale];
  c.fillStyle = field.colors.field;
  c.fillRect(left, top, width, height);
  c.lineWidth = 1;
  c.strokeStyle = field.colors.grid;
  const step = [1, 2, 5, 10, 20, 50, 100, 200].find((s) => s * scale >= 42) || 500;
  c.beginPath();
  for (let x = Math.ceil(west / step) * step; x <= east; x += step) {
    const px = Math.round(field.toScreen(x, 0)[0]) + 0.5;
    c.moveTo(px, top);
    c.lineTo(px, top + height);
  }
  for (let y = Math.ceil(south / step) * step; y <= north; y += step) {
    const py = Math.round(field.toScreen(0, y)[1]) + 0.5;
    c.moveTo(left, py);
    c.lineTo(left + width, py);
  }
  c.stroke();
  field.robots.drawMap(c);
  c.strokeStyle = field.colors.line;
  c.lineWidth = 1.5;
  c.strokeRect(left, top, width, height);
  c.fillStyle = field.colors.faint;
  c.font = `11px ${field.font}`;
  c.textAlign = "right";
  c.textBaseline = "top";
  c.fillText(`${w.toFixed(0)} × ${h.toFixed(0)} m · grid ${step} m`, left + width, top + height + 4);
}

export function fill(field, i) {
  const color = field.now.colors[i];
  return color !== 255 ? STATE_COLORS[color] : field.looks[i].color;
}

function drawThings(field, c, screen) {
  const visible = field.order.filter((i) => {
    const [px, py] = [screen[3 * i], screen[3 * i + 1]];
    return px >= -30 && py >= -30 && px <= field.width + 30 && py <= field.height + 30;
  });
  const marked = new Set([...field.chosen].map((name) => field.index.get(name))).add(field.hovered);
  const tiny = visible.length > TINY;
  for (const i of visible) {
    if (tiny && field.now.modes[i] < 3 && !marked.has(i)) drawSquare(field, c, screen, i);
    else drawThing(field, c, screen, i);
  }
}

function drawSquare(field, c, screen, i) {
  const radius = field.radius(i);
  c.fillStyle = fill(field, i);
  c.fillRect(screen[3 * i] - radius, screen[3 * i + 1] - radius, 2 * radius, 2 * radius);
}

function drawThing(field, c, screen, i) {
  const { now } = field;
  const many = now.n > MANY;
  const [px, py, heading] = screen.subarray(3 * i, 3 * i + 3);
  const radius = field.radius(i);
  const look = field.looks[i];
  const mode = now.modes[i];
  if (mode === 3 || mode === 4) {
    c.strokeStyle = mode === 3 ? field.colors.training : field.colors.testing;
    c.lineWidth = 3;
    c.beginPath();
    c.arc(px, py, radius + 4.5, 0, 2 * Math.PI);
    c.stroke();
  }
  const silent = mode === SILENT;
  c.fillStyle = silent ? field.colors.faint : fill(field, i);
  c.globalAlpha = silent ? 0.3 : look.opacity;
  c.beginPath();
  if (look.shape === "square") c.rect(px - radius, py - radius, 2 * radius, 2 * radius);
  else if (look.faces && many) dart(c, px, py, 1.5 * radius, -heading);
  else c.arc(px, py, radius, 0, 2 * Math.PI);
  c.fill();
  c.globalAlpha = 1;
  if (silent) {
    c.strokeStyle = field.colors.faint;
    c.lineWidth = 1.5;
    c.setLineDash([3, 3]);
    c.stroke();
    c.setLineDash([]);
  }
  if (look.shape === "ball") {
    c.strokeStyle = field.colors.ink;
    c.lineWidth = 1;
    c.stroke();
  }
  if (look.faces && !many) {
    c.strokeStyle = field.colors.ink;
    c.lineWidth = 2;
    c.lineCap = "round";
    c.beginPath();
    c.moveTo(px + 0.35 * radius * Math.cos(heading), py - 0.35 * radius * Math.sin(heading));
    c.lineTo(px + 1.65 * radius * Math.cos(heading), py - 1.65 * radius * Math.sin(heading));
    c.stroke();
  }
  const chosen = field.chosen.has(field.roster.names[i]);
  if (chosen || i === field.hovered) {
    c.strokeStyle = chosen ? field.colors.accent : field.colors.faint;
    c.lineWidth = 2;
    c.setLineDash(chosen ? [] : [3, 3]);
    c.beginPath();
    c.arc(px, py, radius + (mode === 3 || mode === 4 ? 8.5 : 5), 0, 2 * Math.PI);
    c.stroke();
    c.setLineDash([]);
  }
}

// Adds the arrowhead that represents a robot among many things, and shows its heading.
function dart(c, x, y, size, angle) {
  const corner = (turn, away) => [
    x + away * size * Math.cos(angle + turn),
    y + away * size * Math.sin(angle + turn),
  ];
  c.moveTo(...corner(0, 1.25));
  c.lineTo(...corner(2.45, 1));
  c.lineTo(...corner(Math.PI, 0.35));
  c.lineTo(...corner(-2.45, 1));
  c.closePath();
}

// Draws the knobs that turn the selected things.
function drawHandles(field, c, screen) {
  field.handles = [];
  if (field.fixed) return;
  for (const name of field.chosen) {
    const i = field.index?.get(name);
    if (i === undefined || i >= field.now.n || !field.looks[i].faces) continue;
    const [px, py, heading] = screen.subarray(3 * i, 3 * i + 3);
    const away = field.radius(i) + HANDLE;
    const [x, y] = [px + away * Math.cos(heading), py - away * Math.sin(heading)];
    const root = [px + (away - 16) * Math.cos(heading), py - (away - 16) * Math.sin(heading)];
    field.handles.push({ i, x, y });
    c.strokeStyle = field.colors.accent;
    c.fillStyle = field.colors.paper;
    c.lineWidth = 1.5;
    c.beginPath();
    c.moveTo(...root);
    c.lineTo(x, y);
    c.stroke();
    c.beginPath();
    c.arc(x, y, KNOB, 0, 2 * Math.PI);
    c.fill();
    c.stroke();
  }
}

// Draws each name below its thing, or else beside or above, without overlaps; selected things first.
function drawNames(field, c, screen) {
  const { now, roster, chosen, hovered } = field;
  const important = (i) => (chosen.has(roster.names[i]) ? 2 : i === hovered ? 1 : 0);
  const named = now.n <= NAMED ? now.colors.keys() : [...chosen].map((name) => field.index.get(name));
  const wanted = [...new Set([...named, hovered])].filter(
    (i) => i >= 0 && i < now.n && (important(i) || field.looks[i].labelled),
  );
  wanted.sort((a, b) => important(b) - important(a));
  const taken = [];
  c.textAlign = "center";
  c.textBaseline = "top";
  for (const i of wanted) {
    const strong = important(i) === 2;
    c.font = `${strong ? 600 : 400} 11px ${field.font}`;
    const half = c.measureText(roster.names[i]).width / 2;
    const [px, py] = screen.subarray(3 * i, 3 * i + 2);
    const away = field.radius(i) + (now.modes[i] > 2 || strong ? 10 : 7);
    const places = [[px, py + away], [px + away + half, py - 6], [px - away - half, py - 6], [px, py - away - 13]];
    const isFree = ([x, y]) => !taken.some((t) => Math.abs(t.x - x) < t.half + half && Math.abs(t.y - y) < 13);
    const [x, y] = places.find(isFree) ?? (important(i) ? places[0] : [NaN]);
    if (Number.isNaN(x)) continue;
    taken.push({ x, y, half, name: roster.names[i] });
    c.fillStyle = strong ? field.colors.ink : field.colors.faint;
    c.fillText(roster.names[i], x, y + 1);
  }
  field.named = taken;
}

// Draws beside each agent what it would do next: filled if it is sure, dashed if it is unsure.
function drawPreviews(field, c, screen) {
  c.font = `600 10px ${field.font}`;
  c.textAlign = "left";
  c.textBaseline = "middle";
  for (const [name, [state, full, unsure]] of Object.entries(field.previews)) {
    const i = field.index?.get(name);
    if (i === undefined || i >= field.now.n) continue;
    const text = `→ ${state}`;
    const x = screen[3 * i] + field.radius(i) + 8;
    const y = screen[3 * i + 1] - field.radius(i) - 10;
    c.fillStyle = c.strokeStyle = field.colors.testing;
    c.lineWidth = 1.2;
    c.setLineDash(unsure ? [3, 3] : []);
    c.beginPath();
    c.roundRect(x, y - 8, c.measureText(text).width + 10, 16, 8);
    c.globalAlpha = unsure || !full ? 0.75 : 1;
    if (full && !unsure) c.fill();
    else c.stroke();
    if (full && !unsure) c.fillStyle = field.colors.paper;
    c.fillText(text, x + 5, y);
    c.globalAlpha = 1;
    c.setLineDash([]);
  }
}

function drawTrails(field, c) {
  c.lineWidth = 1.5;
  for (const [i, trail] of field.trails) {
    if (i >= field.now.n) continue;
    c.strokeStyle = fill(field, i);
    c.globalAlpha = 0.45;
    c.beginPath();
    trail.forEach(([x, y], k) => c[k ? "lineTo" : "moveTo"](...field.toScreen(x, y)));
    c.stroke();
  }
  c.globalAlpha = 1;
}

function drawOrders(field, c, screen, time) {
  field.orders = field.orders.filter((order) => order.until > time);
  for (const order of field.orders) {
    const ids = order.to.map((name) => field.index?.get(name)).filter((i) => i !== undefined);
    if (!ids.length) continue;
    const x = ids.reduce((sum, i) => sum + screen[3 * i], 0) / ids.length;
    const y = ids.reduce((sum, i) => sum + screen[3 * i + 1], 0) / ids.length;
    c.globalAlpha = Math.min(1, (order.until - time) / 900);
    c.strokeStyle = field.colors.accent;
    c.lineWidth = 1.2;
    c.beginPath();
    for (const i of ids) {
      c.moveTo(x, y);
      c.lineTo(screen[3 * i], screen[3 * i + 1]);
    }
    c.stroke();
    if (field.orders.length <= 6) {
      const { accent, paper } = field.colors;
      bubble(field, c, `${order.from}: ${order.order}`, x, y, accent, paper);
    }
    c.globalAlpha = 1;
  }
}

function drawCalls(field, c, screen, time) {
  field.calls = field.calls.filter((call) => call.until > time && call.i < field.now.n);
  for (const { i, text, until } of field.calls) {
    c.globalAlpha = Math.min(1, (until - time) / 400);
    const [px, py] = [screen[3 * i], screen[3 * i + 1]];
    const { ink, paper } = field.colors;
    bubble(field, c, `“${text}”`, px, py - field.radius(i) - 16, ink, paper);
    c.globalAlpha = 1;
  }
}

function bubble(field, c, text, x, y, back, front) {
  c.font = `600 11px ${field.font}`;
  const width = c.measureText(text).width + 14;
  c.fillStyle = back;
  c.beginPath();
  c.roundRect(x - width / 2, y - 10, width, 20, 10);
  c.fill();
  c.fillStyle = front;
  c.textAlign = "center";
  c.textBaseline = "middle";
  c.fillText(text, x, y);
}
