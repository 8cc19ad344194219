// The field on one canvas: the frames of the stream, interpolated, and their place on the screen.
import { MANY, draw } from "./drawing.js";
import { drawMinute, listenToMinute, takeMinute } from "./minute.js";
import { cancelDrag, listen } from "./pointing.js";
import { Robots } from "./robots.js";
import { openStream } from "./stream.js";

const ROOM = 128; // px; between the field and the strip, for two rows of behaviors
const ABOVE = 92; // px; above the field, for a banner and the legend
const SMALL_HEIGHT = 500; // px; height below which the field is on a phone
const BESIDE = 46; // px; at either side, for the buttons at the right
const JUMP = 2.5; // m; a thing that moves farther in a cycle was placed, and is not interpolated
const CALL_MS = 1400;
const TRAIL = 90;
const SLOW_MS = 16;
const CLOSE = 24; // px per m, at least, of an agent that deserves a look
const SMALL = 26; // number of things above which they are drawn smaller

class Field {
  constructor(canvas, page) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.roster = { names: [], kinds: [], radii: [], size: [20, 20], center: [0, 0], legend: [] };
    this.now = this.before = null;
    this.shown = 0; // the cycle nearest to the last drawing
    this.chosen = new Set();
    this.calls = [];
    this.orders = [];
    this.trails = null;
    this.minute = null;
    this.previews = {};
    this.view = { scale: 0, x: 0, y: 0, fitted: true };
    this.drag = null;
    this.hovered = -1;
    this.handles = []; // knobs that turn the selected things, in screen coordinates
    this.drawn = this.frames = 0;
    this.robots = new Robots(this);
    this.recolor();
    listen(this);
    listenToMinute(this);
    openStream(page, (message) => this.take(message));
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.resize();
    // On a phone, the overlay covers much of the field, and its height changes.
    setInterval(() => this.view.fitted && this.height < SMALL_HEIGHT && this.fit(), 500);
  }

  // -- messages of the server

  take(message) {
    if (message.t === "frame") this.takeFrame(message);
    else if (message.t === "roster") this.takeRoster(message);
    else if (message.t === "say") this.takeCalls(message.said);
    else if (message.t === "order") this.orders.push({ ...message, until: performance.now() + 2200 });
    else if (message.t === "heard") window.studioHeard(message.id);
    else if (message.t === "replay") this.replay = message.on;
    else if (message.t === "center") this.centerOn(message.name);
    else if (message.t === "chosen") this.chosen = new Set(message.names);
    else if (message.t === "minute") takeMinute(this, message);
    else if (message.t === "remember") remember(message.name, message.value);
    else this.robots.take(message);
    this.redraw();
  }

  takeRoster(roster) {
    const { size, real } = this.roster;
    const ground = ({ names, size, center }) => JSON.stringify([names, size, center]);
    const before = ground(this.roster);
    if (roster.names.join() !== this.roster.names.join()) {
      this.cancelDrag(); // the index of the dragged thing is no longer valid
      this.before = this.now = null;
      this.trails = this.trails && new Map();
    }
    this.roster = { center: [0, 0], ...roster };
    if (!roster.real) this.robots.clear();
    this.looks = roster.kinds.map((kind) => roster.looks[kind]);
    // From the lowest layer to the highest, each in the order of the roster.
    this.order = [...roster.names.keys()].sort((a, b) => this.looks[a].layer - this.looks[b].layer);
    this.index = new Map(roster.names.map((name, i) => [name, i]));
    // The ground of real robots grows as they see more, but the field stays the same.
    const another = !real !== !roster.real || (!real && size[0] !== roster.size[0]);
    // At another moment of the same things, the view stays the same.
    if (another || (this.view.fitted && ground(this.roster) !== before)) this.fit();
    document.getElementById("field-empty")?.setAttribute("hidden", "");
  }

  takeFrame(frame) {
    const at = performance.now();
    if (frame.n !== this.roster.names.length) return;
    this.frames += 1;
    const gap = this.now ? Math.min(Math.max(at - this.now.at, 20), 400) : 100;
    this.before = this.now;
    this.now = { ...frame, at, gap };
    if (this.trails) this.keepTrails();
  }

  takeCalls(said) {
    const until = performance.now() + CALL_MS;
    for (const [i, text] of said) {
      this.calls = this.calls.filter((call) => call.i !== i);
      this.calls.push({ i, text, until });
    }
  }

  keepTrails() {
    const { places, n } = this.now;
    for (let i = 0; i < n; i++) {
      if (n > MANY && !this.chosen.has(this.roster.names[i])) continue;
      let trail = this.trails.get(i);
      if (!trail) this.trails.set(i, (trail = []));
      const [x, y] = [places[3 * i], places[3 * i + 1]];
      const last = trail[trail.length - 1];
      if (last && Math.hypot(x - last[0], y - last[1]) > JUMP) trail.length = 0;
      trail.push([x, y]);
      if (trail.length > TRAIL) trail.shift();
    }
  }

  // -- screen coordinates

  resize() {
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    const ratio = window.devicePixelRatio || 1;
    this.canvas.width = Math.max(1, clientWidth * ratio);
    this.canvas.height = Math.max(1, clientHeight * ratio);
    this.canvas.style.width = `${clientWidth}px`;
    this.canvas.style.height = `${clientHeight}px`;
    this.width = clientWidth;
    this.height = clientHeight;
    this.ratio = ratio;
    if (this.view.fitted) this.fit();
    drawMinute(this);
    this.redraw();
  }

  fit() {
    const [w, h] = this.roster.size;
    const [top, bottom] = this.margins();
    const scale = Math.min((this.width - 2 * BESIDE) / w, (this.height - top - bottom) / h);
    const [x, y] = this.roster.center;
    const [mx, my] = [this.width / 2, top + (this.height - top - bottom) / 2];
    this.view = { scale, x: mx - x * scale, y: my + y * scale, fitted: true };
    this.redraw();
  }

  // Returns the heights of the overlay at the top and bottom, with room for some rows of behaviors.
  margins() {
    const high = (part) => document.querySelector(part)?.offsetHeight ?? 0;
    const small = this.height < SMALL_HEIGHT; // a phone has no room to spare
    const above = Math.max(small ? 0 : ABOVE, high(".notices") + (small ? 30 : ABOVE - 40));
    const below = Math.max(small ? 0 : ROOM + high(".minute"), high(".bottom") + 28, high("#camera") + 34);
    return [Math.min(above, 0.25 * this.height), Math.min(below, 0.36 * this.height)];
  }

  toScreen(x, y) {
    return [this.view.x + x * this.view.scale, this.view.y - y * this.view.scale];
  }

  toField(px, py) {
    return [(px - this.view.x) / this.view.scale, (this.view.y - py) / this.view.scale];
  }

  zoom(factor, px = this.width / 2, py = this.height / 2) {
    const scale = Math.min(Math.max(this.view.scale * factor, 0.5), 400);
    const ratio = scale / this.view.scale;
    this.view = {
      scale,
      x: px - (px - this.view.x) * ratio,
      y: py - (py - this.view.y) * ratio,
      fitted: false,
    };
    this.redraw();
  }

  centerOn(name) {
    const i = this.index.get(name);
    if (i === undefined || !this.now) return;
    const [x, y] = this.place(i, 1);
    const [top, bottom] = this.margins();
    const scale = Math.max(this.view.scale, CLOSE);
    const [mx, my] = [this.width / 2, top + (this.height - top - bottom) / 2];
    this.view = { scale, x: mx - x * scale, y: my + y * scale, fitted: false };
  }

  // Returns the cycle at a time between two frames.
  cycleAt(at) {
    const { now, before } = this;
    const between = before && at < 1 && before.cycle < now.cycle;
    return between ? Math.round(before.cycle + (now.cycle - before.cycle) * at) : now.cycle;
  }

  // Returns the screen coordinates and the heading of each thing.
  onScreen(at) {
    const { scale, x: left, y: top } = this.view;
    const screen = new Float32Array(3 * this.now.n);
    for (let i = 0; i < screen.length; i += 3) {
      const [x, y, heading] = this.place(i / 3, at);
      screen[i] = left + x * scale;
      screen[i + 1] = top - y * scale;
      screen[i + 2] = heading;
    }
    return screen;
  }

  place(i, at) {
    const { now, before } = this;
    const k = 3 * i;
    const [x, y, heading] = [now.places[k], now.places[k + 1], now.places[k + 2]];
    if (this.drag?.moved) {
      const [dragged, turned] = [this.drag.places.get(i), this.drag.headings.get(i)];
      if (dragged) return [...dragged, heading];
      if (turned !== undefined) return [x, y, turned];
    }
    if (!before || before.n !== now.n || at >= 1) return [x, y, heading];
    const [x0, y0, heading0] = [before.places[k], before.places[k + 1], before.places[k + 2]];
    if (Math.abs(x - x0) > JUMP || Math.abs(y - y0) > JUMP) return [x, y, heading];
    const turn = Math.atan2(Math.sin(heading - heading0), Math.cos(heading - heading0));
    return [x0 + (x - x0) * at, y0 + (y - y0) * at, heading0 + turn * at];
  }

  radius(i) {
    const real = this.roster.radii[i] * this.view.scale;
    const n = this.roster.names.length;
    const least = n > MANY ? 2.2 : n > SMALL || this.looks[i].shape === "ball" ? 5 : 8;
    return Math.max(real, least);
  }

  thingAt(px, py, slack = 6) {
    if (!this.now) return -1;
    let best = -1;
    let nearest = Infinity;
    for (let i = 0; i < this.now.n; i++) {
      const [x, y] = this.toScreen(this.now.places[3 * i], this.now.places[3 * i + 1]);
      const away = Math.hypot(px - x, py - y) - this.radius(i);
      if (away < slack && away < nearest) [best, nearest] = [i, away];
    }
    return best;
  }

  // -- drawing

  recolor() {
    const style = getComputedStyle(document.documentElement);
    const color = (name) => style.getPropertyValue(name).trim();
    this.font = style.getPropertyValue("--font");
    this.colors = {
      field: color("--field"), line: color("--field-line"), grid: color("--field-grid"),
      ink: color("--ink"), faint: color("--ink-3"), paper: color("--surface"),
      training: color("--training"), testing: color("--testing"), accent: color("--accent"),
      past: color("--replay"), bad: color("--bad"),
    };
    drawMinute(this);
    this.robots.recolor();
    this.redraw();
  }

  redraw() {
    if (this.waiting) return;
    this.waiting = true;
    const now = () => {
      this.waiting = false;
      const began = performance.now();
      draw(this);
      this.took = performance.now() - began;
    };
    // After a drawing that takes long, the browser has as much time for messages and input.
    if (this.took > SLOW_MS) setTimeout(() => requestAnimationFrame(now), this.took);
    else requestAnimationFrame(now);
  }

  // -- input

  // Whether things cannot be placed, as in a recording and with real robots.
  get fixed() {
    return this.replay || this.roster.real;
  }

  key(key) {
    if (key === "f") this.fit();
    else if (key === "l") this.toggleTrails();
    else if (key === "+" || key === "=") this.zoom(1.25);
    else if (key === "-") this.zoom(0.8);
  }

  toggleTrails() {
    this.trails = this.trails ? null : new Map();
    document.getElementById("trails")?.setAttribute("aria-pressed", String(!!this.trails));
    this.redraw();
  }

  // Cancels the drag; returns whether there was one.
  cancelDrag() {
    return cancelDrag(this);
  }
}

// Keeps the person's name or an option for the server, which reads it when a page is opened.
function remember(name, value) {
  const year = 365 * 24 * 3600;
  document.cookie = `hitab_${name}=${encodeURIComponent(value)}; max-age=${year}; SameSite=Strict; path=/`;
}

// This cookie identifies the browser, whose tabs belong to one person, until the browser ends.
if (!document.cookie.includes("hitab_browser=")) {
  const identity = crypto.getRandomValues(new Uint32Array(4)).join("-");
  document.cookie = `hitab_browser=${identity}; SameSite=Strict; path=/`;
}

function begin() {
  const canvas = document.getElementById("field");
  if (!canvas) return requestAnimationFrame(begin);
  window.studioField = new Field(canvas, window.STUDIO_PAGE);
}
begin();
