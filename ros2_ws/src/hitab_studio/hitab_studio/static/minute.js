// The strip under the field: the last minute, with a row for each agent. Dragging on it looks back.
import { STATE_COLORS } from "./drawing.js";

const ROW = 9; // px; height of a row
const GAP = 3;
const NAMES = 66; // px; for the names at the left
const TOP = 4;
const DRAG_MS = 50; // least time between two requests of a drag

export function takeMinute(field, message) {
  field.minute = message;
  field.previews = message.previews;
  drawMinute(field);
}

export function drawMinute(field) {
  const canvas = document.getElementById("minute");
  const { minute } = field;
  if (!minute) return;
  if (!canvas) {
    setTimeout(() => drawMinute(field), 300); // its panel comes later than the stream
    return;
  }
  const high = TOP * 2 + minute.rows.length * (ROW + GAP);
  if (canvas.style.height !== `${high}px`) {
    canvas.style.height = `${high}px`;
    if (field.view.fitted) field.fit();
  }
  canvas.width = Math.max(1, canvas.clientWidth * field.ratio);
  canvas.height = high * field.ratio;
  const c = canvas.getContext("2d");
  c.setTransform(field.ratio, 0, 0, field.ratio, 0, 0);
  const { colors } = field;
  const x = (at) => NAMES + ((at - minute.left) / (minute.right - minute.left)) * (canvas.clientWidth - NAMES);
  c.font = `10px ${field.font}`;
  c.textBaseline = "middle";
  minute.rows.forEach((row, number) => {
    const y = TOP + number * (ROW + GAP);
    c.fillStyle = field.chosen.has(row.name) ? colors.ink : colors.faint;
    c.fillText(row.name, 0, y + ROW / 2, NAMES - 6);
    row.spans.forEach(([at, color, unsure], i) => {
      const [from, to] = [x(at), x(row.spans[i + 1]?.[0] ?? minute.now)];
      c.fillStyle = STATE_COLORS[color] ?? colors.grid;
      c.fillRect(from, y, Math.max(1, to - from), ROW);
      if (unsure) drawUnsure(c, colors, from, to, y);
    });
    for (const [at, kind] of row.marks) drawMark(c, colors, kind, x(at), y);
  });
  c.fillStyle = colors.ink;
  for (const at of minute.episodes) c.fillRect(x(at), 0, 1, high);
  if (minute.past === null) return;
  c.fillStyle = colors.past;
  c.fillRect(x(minute.past) - 1.5, 0, 3, high);
}

function drawUnsure(c, colors, from, to, y) {
  c.fillStyle = colors.paper;
  for (let at = from; at < to; at += 4) c.fillRect(at, y, 1.5, ROW);
}

// A command is a wedge, a question a dot, an unsure moment an open dot, a hold a bar.
function drawMark(c, colors, kind, x, y) {
  c.fillStyle = c.strokeStyle = kind === "held" ? colors.bad : colors.ink;
  c.beginPath();
  if (kind === "command") {
    c.moveTo(x - 4, y - 2);
    c.lineTo(x + 4, y - 2);
    c.lineTo(x, y + 6);
    c.fill();
  } else if (kind === "held") {
    c.fillRect(x - 1.5, y - 2, 3, ROW + 4);
  } else {
    c.arc(x, y + ROW / 2, 3, 0, 2 * Math.PI);
    if (kind === "question") c.fill();
    else c.stroke();
  }
}

// Returns the moment at a place of the strip.
function momentAt(minute, canvas, event) {
  const box = canvas.getBoundingClientRect();
  const part = (event.clientX - box.x - NAMES) / (box.width - NAMES);
  return minute.left + Math.min(Math.max(part, 0), 1) * (minute.right - minute.left);
}

function describe({ minute, replay }, canvas, event) {
  const at = momentAt(minute, canvas, event);
  const row = minute.rows[Math.floor((event.clientY - canvas.getBoundingClientRect().y - TOP) / (ROW + GAP))];
  const span = row?.spans.findLast((one) => one[0] <= at);
  const near = (row?.marks ?? []).filter((mark) => Math.abs(mark[0] - at) < 0.5 * minute.rate);
  const when = minute.cycles ? [`cycle ${Math.round(at)}`] : [];
  const moment = replay ? `at ${at.toFixed(1)} s` : `${((minute.now - at) / minute.rate).toFixed(1)} s ago`;
  return [row?.name, span?.[3] || "in no state", ...near.map((mark) => mark[2]), ...when, moment].join(" · ");
}

export function listenToMinute(field) {
  let [dragged, last] = [false, 0];
  const go = (event) => {
    const to = momentAt(field.minute, event.target, event);
    window.studioTell(!field.replay && to >= field.minute.now ? "present" : "past", { to });
    last = performance.now();
  };
  const isOn = (event) => event.target.id === "minute" && field.minute;
  document.addEventListener("pointerdown", (event) => {
    if (!isOn(event) || event.button !== 0) return;
    event.target.setPointerCapture(event.pointerId);
    dragged = true;
    go(event);
  });
  document.addEventListener("pointermove", (event) => {
    if (!isOn(event)) return;
    if (!dragged) event.target.title = describe(field, event.target, event);
    else if (performance.now() - last > DRAG_MS) go(event);
  });
  document.addEventListener("pointerup", (event) => {
    if (dragged && isOn(event)) go(event);
    dragged = false;
  });
  document.addEventListener("pointercancel", () => (dragged = false));
}
