import { HAND, OBJECT } from './labels';
import type { Part, Stroke } from './strokes';

/** Colours of parts on images, red, green, blue; a letter or a pattern says the same. */
const COLOURS: Readonly<Record<Part, readonly [number, number, number]>> = {
  object: [64, 169, 255],
  hand: [255, 153, 51],
  background: [255, 105, 180],
};
/** Opacity of masks, of the stripes of a hand, and of their edges, of 255. */
const OPACITY = { plain: 84, stripe: 150, edge: 255 } as const;
/** Width of a stripe [pixels of the small image]. */
const STRIPE = 4;

/** A part's colour for styles. */
export function colourOf(part: Part): string {
  return `rgb(${COLOURS[part].join(' ')})`;
}

/** Masks as an image to be laid over that of a camera: the object plain, the hand striped, both with edges. */
export function overlayOf(labels: Uint8Array, [columns, rows]: readonly [number, number]): OffscreenCanvas | null {
  const canvas = new OffscreenCanvas(columns, rows);
  const context = canvas.getContext('2d');
  if (context === null) return null;
  context.putImageData(new ImageData(pixelsOf(labels, columns), columns, rows), 0, 0);
  return canvas;
}

/** Red, green, blue and opacity of each pixel of masks. */
export function pixelsOf(labels: Uint8Array, columns: number): Uint8ClampedArray<ArrayBuffer> {
  const pixels = new Uint8ClampedArray(4 * labels.length);
  labels.forEach((label, i) => {
    if (label !== OBJECT && label !== HAND) return;
    const [x, y] = [i % columns, Math.floor(i / columns)];
    const isEdge =
      (x > 0 && labels[i - 1] !== label) ||
      (x < columns - 1 && labels[i + 1] !== label) ||
      (y > 0 && labels[i - columns] !== label) ||
      (i + columns < labels.length && labels[i + columns] !== label);
    const isStripe = label === HAND && (x + y) % (2 * STRIPE) < STRIPE;
    pixels.set(COLOURS[label === HAND ? 'hand' : 'object'], 4 * i);
    pixels[4 * i + 3] = isEdge ? OPACITY.edge : isStripe ? OPACITY.stripe : OPACITY.plain;
  });
  return pixels;
}

/** Draws a stroke with the first letter of its part; `scale` leads from recorded pixels to those of the canvas. */
export function drawStroke(
  context: CanvasRenderingContext2D,
  { part, points, radius_px: radius }: Stroke,
  scale: number,
  ratio: number,
): void {
  const [first] = points;
  if (first === undefined) return;
  // The centre of the first pixel is half a pixel from the edge.
  const place = ([x, y]: readonly [number, number]): [number, number] => [(x + 0.5) * scale, (y + 0.5) * scale];
  const isClick = points.length === 1;
  // A click stays to be seen, however small the brush is.
  const width = Math.max(2 * radius * scale, (isClick ? 16 : 6) * ratio);
  context.save();
  context.lineCap = 'round';
  context.lineJoin = 'round';
  for (const [style, more] of [['rgb(0 0 0 / 60%)', 2 * ratio], [colourOf(part), 0]] as const) {
    context.beginPath();
    if (isClick) {
      context.arc(...place(first), (width + more) / 2, 0, 2 * Math.PI);
      context.fillStyle = style;
      context.fill();
      continue;
    }
    points.forEach((point, i) => (i === 0 ? context.moveTo(...place(point)) : context.lineTo(...place(point))));
    context.strokeStyle = style;
    context.lineWidth = width + more;
    context.stroke();
  }
  const [x, y] = place(first);
  context.font = `bold ${12 * ratio}px system-ui, sans-serif`;
  context.textAlign = 'center';
  context.textBaseline = 'middle';
  context.lineWidth = 3 * ratio;
  context.strokeStyle = '#000';
  context.fillStyle = '#fff';
  const letter = part.charAt(0).toUpperCase();
  context.strokeText(letter, x, y);
  context.fillText(letter, x, y);
  context.restore();
}

/** Draws the outline of the brush where it would mark, with a cross for the keyboard's cursor. */
export function drawBrush(
  context: CanvasRenderingContext2D,
  [column, row]: readonly [number, number],
  brush: { readonly part: Part; readonly radius: number; readonly isCursor: boolean },
  scale: number,
  ratio: number,
): void {
  const [x, y] = [(column + 0.5) * scale, (row + 0.5) * scale];
  const radius = Math.max(brush.radius * scale, 3 * ratio);
  context.save();
  for (const [style, width] of [['#000', 3], [colourOf(brush.part), 1.5]] as const) {
    context.strokeStyle = style;
    context.lineWidth = width * ratio;
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    if (brush.isCursor) {
      const arm = radius + 10 * ratio;
      for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]] as const) {
        context.moveTo(x + dx * radius, y + dy * radius);
        context.lineTo(x + dx * arm, y + dy * arm);
      }
    }
    context.stroke();
  }
  context.restore();
}
