/** A picture that stands in a video beside others. */
export interface Panel {
  readonly source: HTMLCanvasElement;
  readonly label: string;
}

/** Place of a panel [pixels]. */
export interface Box {
  readonly x: number;
  readonly width: number;
}

/** Sizes in a video [pixels]. */
export interface Layout {
  readonly width: number;
  readonly height: number;
  /** Height of the panels, which stand above a bar with text. */
  readonly pictures: number;
  readonly boxes: readonly Box[];
}

/** Height of panels, and largest width of all together [pixels]. */
const PICTURES = 540;
const WIDEST = 1600;
/** Height of the bar with text, and the gap between panels [pixels]. */
const BAR = 56;
const GAP = 4;

/** Places for panels of these ratios of width to height, beside each other. Encoders want even sizes. */
export function layoutOf(aspects: readonly number[]): Layout {
  const room = WIDEST - GAP * (aspects.length - 1);
  const all = aspects.reduce((sum, aspect) => sum + aspect, 0);
  const pictures = even(Math.min(PICTURES, room / all));
  let x = 0;
  const boxes = aspects.map((aspect) => {
    const box = { x, width: even(aspect * pictures) };
    x += box.width + GAP;
    return box;
  });
  return { width: x - GAP, height: pictures + BAR, pictures, boxes };
}

/** Draws a picture of a video: panels with their labels, and texts at both ends of the bar below them. */
export function compose(
  context: CanvasRenderingContext2D,
  { width, height, pictures, boxes }: Layout,
  panels: readonly Panel[],
  [left, right]: readonly [left: string, right: string],
): void {
  context.fillStyle = '#11151a';
  context.fillRect(0, 0, width, height);
  context.textBaseline = 'middle';
  panels.forEach(({ source, label }, i) => {
    const box = boxes[i]!;
    context.drawImage(source, box.x, 0, box.width, pictures);
    context.font = '600 20px system-ui, sans-serif';
    context.textAlign = 'left';
    const room = context.measureText(label).width + 20;
    context.fillStyle = 'rgb(17 21 26 / 72%)';
    context.fillRect(box.x + 10, 10, Math.min(room, box.width - 20), 34);
    context.fillStyle = '#ffffff';
    context.fillText(label, box.x + 20, 28, box.width - 40);
  });
  const middle = pictures + BAR / 2;
  context.font = '600 28px system-ui, sans-serif';
  context.textAlign = 'right';
  context.fillStyle = '#ffffff';
  context.fillText(right, width - 16, middle, 0.7 * width);
  const rest = width - 48 - Math.min(context.measureText(right).width, 0.7 * width);
  context.font = '22px system-ui, sans-serif';
  context.textAlign = 'left';
  context.fillStyle = '#b6c0cc';
  if (rest > 60) context.fillText(left, 16, middle, rest);
}

function even(value: number): number {
  return Math.max(2 * Math.round(value / 2), 2);
}
