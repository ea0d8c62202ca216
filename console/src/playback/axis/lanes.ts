import { ticks } from './ticks';

/** A number in each frame; null where it is not known. */
export interface Line {
  readonly values: readonly (number | null)[];
  /** Variable with its colour. */
  readonly series: string;
}

/** A number for all frames that were fitted to, and one for the others. */
export interface Level {
  readonly label: string;
  readonly train: number | null;
  readonly future: number | null;
  readonly series: string;
}

/** Numbers along time, with an axis for them. */
export interface Lane {
  /** [pixels] */
  readonly height: number;
  readonly unit: string;
  /** Factor from the numbers to those of the axis. */
  readonly scale: number;
  readonly lines: readonly Line[];
  readonly levels: readonly Level[];
  /** Places with a ring around them. */
  readonly marks: readonly { readonly frame: number; readonly value: number }[];
}

/** The time that lanes lie along. */
export interface Span {
  readonly frameCount: number;
  readonly fps: number;
  /** Frames before this one are for fitting. */
  readonly trainFrameCount: number;
}

/** Room for the labels left of all lanes, and beside their other end [pixels]. */
export const LEFT = 58;
export const RIGHT = 12;
/** Room for the knob below all lanes, and for the labels of time below that [pixels]. */
const KNOB = 18;
export const FOOT = KNOB + 18;
/** Room above the largest number of a lane [pixels]. */
const HEAD = 18;
/** A level up to this many times the largest number of the lines is within the axis; a higher one is named at its edge. */
const WITHIN = 2;
const FONT = '11px system-ui, sans-serif';

/** Pixel of a frame in a drawing of this width. */
export function xOf(frame: number, { frameCount }: Span, width: number): number {
  return LEFT + (frame / Math.max(frameCount - 1, 1)) * Math.max(width - LEFT - RIGHT, 1);
}

/** The frame at a pixel of a drawing of this width; one beyond the ends for pixels beside it. */
export function frameAt(x: number, { frameCount }: Span, width: number): number {
  return Math.round(((x - LEFT) / Math.max(width - LEFT - RIGHT, 1)) * (frameCount - 1));
}

/** Largest number of the axis of a lane. */
export function mostOf({ lines, levels }: Lane): number {
  const largest = (values: readonly (number | null)[]): number => {
    return values.reduce<number>((most, x) => Math.max(most, x ?? 0), 0);
  };
  const ofLines = largest(lines.flatMap(({ values }) => values));
  const ofLevels = levels.flatMap(({ train, future }) => [train, future]).filter((x) => (x ?? 0) <= WITHIN * ofLines);
  return Math.max(ofLines, largest(ofLevels), 1e-9);
}

/** Draws lanes one below the other, and time below them. `colour` is the value of a variable. */
export function drawLanes(
  context: CanvasRenderingContext2D,
  width: number,
  lanes: readonly Lane[],
  span: Span,
  colour: (name: string) => string,
): void {
  const bottom = lanes.reduce((sum, { height }) => sum + height, 0);
  const pen: Pen = { context, colour, x: (frame) => xOf(frame, span, width), right: width - RIGHT };
  context.font = FONT;
  drawSpan(pen, span, bottom);
  let top = 0;
  for (const lane of lanes) {
    drawLane(pen, lane, top, span);
    top += lane.height;
  }
  drawTime(pen, span, bottom, width);
}

interface Pen {
  readonly context: CanvasRenderingContext2D;
  readonly colour: (name: string) => string;
  readonly x: (frame: number) => number;
  readonly right: number;
}

/** The pixel between the last frame that is for fitting and the first that is not. */
function boundaryOf({ x, right }: Pen, { trainFrameCount, frameCount }: Span): number {
  if (trainFrameCount >= frameCount) return right;
  return trainFrameCount <= 0 ? LEFT : x(trainFrameCount - 0.5);
}

/** Shades the frames that are for fitting, and names both parts. */
function drawSpan(pen: Pen, span: Span, bottom: number): void {
  const { context, colour, right } = pen;
  const boundary = boundaryOf(pen, span);
  context.fillStyle = colour('--surface-raised');
  context.fillRect(LEFT, 0, boundary - LEFT, Math.max(bottom, 4));
  if (bottom === 0) return;
  context.fillStyle = colour('--muted');
  context.textBaseline = 'top';
  context.textAlign = 'left';
  if (boundary - LEFT > 60) context.fillText('for fitting', LEFT + 5, 4);
  if (right - boundary > 45) context.fillText('future', boundary + 5, 4);
  if (boundary <= LEFT || boundary >= right) return;
  stroke(context, colour('--border-strong'), [3, 3], [[boundary, 0], [boundary, bottom]]);
}

function drawLane(pen: Pen, lane: Lane, top: number, span: Span): void {
  const { context, colour, x, right } = pen;
  const { height, unit, scale, lines, marks } = lane;
  const most = mostOf(lane);
  const floor = top + height - 4;
  const y = (value: number): number => floor - (value / most) * (height - HEAD - 4);
  context.fillStyle = colour('--muted');
  context.textAlign = 'right';
  context.textBaseline = 'middle';
  const all = ticks(most * scale, Math.max(Math.floor(height / 30), 1));
  all.forEach((tick, i) => {
    const at = y(tick / scale);
    stroke(context, colour('--border'), [], [[LEFT, at], [right, at]]);
    context.fillText(i === all.length - 1 ? `${tick} ${unit}` : String(tick), LEFT - 5, Math.max(at, top + 6));
  });
  drawLevels(pen, lane, span, { most, top, y });
  for (const { values, series } of lines) {
    context.beginPath();
    let isDown = false;
    values.forEach((value, frame) => {
      if (value === null) isDown = false;
      else if (isDown) context.lineTo(x(frame), y(value));
      else context.moveTo(x(frame), y(value));
      isDown = value !== null;
    });
    context.strokeStyle = colour(series);
    context.lineWidth = 1.75;
    context.lineJoin = 'round';
    context.stroke();
  }
  for (const { frame, value } of marks) {
    context.beginPath();
    context.arc(x(frame), y(value), 4.5, 0, 2 * Math.PI);
    context.strokeStyle = colour('--bad');
    context.lineWidth = 1.75;
    context.stroke();
  }
}

/** Dashed lines; those that are above the axis are named at its upper edge. */
function drawLevels(
  pen: Pen,
  { levels, unit, scale }: Lane,
  span: Span,
  { most, top, y }: { most: number; top: number; y: (value: number) => number },
): void {
  const { context, colour, right } = pen;
  const boundary = boundaryOf(pen, span);
  let end = right - 4;
  context.textAlign = 'right';
  context.textBaseline = 'top';
  for (const { label, train, future, series } of levels) {
    const parts = [[train, LEFT, boundary], [future, boundary, right]] as const;
    for (const [value, from, to] of parts) {
      if (value === null || value > most || to <= from) continue;
      stroke(context, colour(series), [6, 4], [[from, y(value)], [to, y(value)]], 1.5);
    }
    const above = parts.find(([value, from, to]) => value !== null && value > most && to > from && from === boundary)?.[0];
    if (above === undefined || above === null) continue;
    const text = `▲ ${label} ${Number((above * scale).toPrecision(3))} ${unit}`;
    const room = context.measureText(text).width + 14;
    if (end - room < boundary + 50) continue;
    context.fillStyle = colour(series);
    context.fillText(text, end, top + 4);
    end -= room;
  }
}

function drawTime({ context, colour, x, right }: Pen, { frameCount, fps }: Span, bottom: number, width: number): void {
  const line = Math.max(bottom, 4);
  stroke(context, colour('--border-strong'), [], [[LEFT, line], [right, line]]);
  context.fillStyle = colour('--muted');
  context.textBaseline = 'top';
  const seconds = ticks((frameCount - 1) / fps, Math.max(Math.floor(width / 90), 2));
  seconds.forEach((second, i) => {
    const at = x(second * fps);
    stroke(context, colour('--border-strong'), [], [[at, line], [at, line + 4]]);
    context.textAlign = at > right - 14 ? 'right' : 'center';
    context.fillText(i === 0 ? '0 s' : String(second), at > right - 14 ? right : at, line + KNOB + 2);
  });
}

function stroke(
  context: CanvasRenderingContext2D,
  colour: string,
  dash: number[],
  points: readonly (readonly [number, number])[],
  lineWidth = 1,
): void {
  context.beginPath();
  points.forEach(([x, y], i) => (i === 0 ? context.moveTo(x, y) : context.lineTo(x, y)));
  context.setLineDash(dash);
  context.strokeStyle = colour;
  context.lineWidth = lineWidth;
  context.stroke();
  context.setLineDash([]);
}
