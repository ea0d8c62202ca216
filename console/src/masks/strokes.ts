/** Part of a scene that a stroke marks. */
export type Part = 'object' | 'hand' | 'background';

/** Stroke of a brush in one image, as an ingest's settings have it. A click has one point. */
export interface Stroke {
  readonly part: Part;
  /** Index of the camera. */
  readonly camera: number;
  readonly frame: number;
  /** Column and row [recorded pixels]; the centre of the first pixel is (0, 0). */
  readonly points: readonly (readonly [number, number])[];
  readonly radius_px: number;
}

/** Brushes with their words, and the keys that choose them. */
export const BRUSHES: readonly { readonly part: Part; readonly label: string; readonly key: string }[] = [
  { part: 'object', label: 'Object', key: '1' },
  { part: 'hand', label: 'Hand', key: '2' },
  { part: 'background', label: 'Background', key: '3' },
];

/** Bounds of the server for strokes: their number, their points, and their radius [px]. */
export const MOST_STROKES = 1000;
export const MOST_POINTS = 4096;
export const RADII = { least: 1, most: 40, initial: 4 } as const;

/** Word for a part. */
export function wordOf(part: Part): string {
  return BRUSHES.find((brush) => brush.part === part)?.label ?? part;
}

/** The strokes in the settings of an ingest; what is not one is left out. */
export function readStrokes(settings: Readonly<Record<string, unknown>>): Stroke[] {
  const { strokes } = settings;
  if (!Array.isArray(strokes)) return [];
  return strokes.flatMap((value: unknown) => {
    const { part, camera, frame = 0, points, radius_px = RADII.initial } = (value ?? {}) as Partial<Stroke>;
    const isPart = BRUSHES.some((brush) => brush.part === part);
    const isPlace = (point: unknown): boolean =>
      Array.isArray(point) && point.length === 2 && point.every((x) => Number.isFinite(x));
    if (!isPart || !Number.isInteger(camera) || !Number.isInteger(frame)) return [];
    if (!Array.isArray(points) || points.length === 0 || !points.every(isPlace)) return [];
    return [{ part, camera, frame, points, radius_px } as Stroke];
  });
}

/** The list of strokes, with the way back through its changes. */
export class Strokes {
  #all: readonly Stroke[];
  readonly #before: (readonly Stroke[])[] = [];
  readonly #undone: (readonly Stroke[])[] = [];

  /** `changed` is called after each change. */
  constructor(
    initial: readonly Stroke[],
    private readonly changed: () => void,
  ) {
    this.#all = initial;
  }

  get all(): readonly Stroke[] {
    return this.#all;
  }

  get canUndo(): boolean {
    return this.#before.length > 0;
  }

  get canRedo(): boolean {
    return this.#undone.length > 0;
  }

  /** Strokes in an image. */
  in(camera: number, frame: number): Stroke[] {
    return this.#all.filter((stroke) => stroke.camera === camera && stroke.frame === frame);
  }

  has(part: Part): boolean {
    return this.#all.some((stroke) => stroke.part === part);
  }

  /** Adds a stroke, whose points are thinned to those that the server takes; false if there are too many. */
  add(stroke: Stroke): boolean {
    if (this.#all.length >= MOST_STROKES) return false;
    this.#set([...this.#all, { ...stroke, points: thinned(stroke.points) }]);
    return true;
  }

  remove(index: number): void {
    this.#set(this.#all.filter((_, i) => i !== index));
  }

  clear(): void {
    if (this.#all.length > 0) this.#set([]);
  }

  /** Puts others in the place of all. */
  replace(strokes: readonly Stroke[]): void {
    this.#set(strokes);
  }

  undo(): void {
    const last = this.#before.pop();
    if (last === undefined) return;
    this.#undone.push(this.#all);
    this.#all = last;
    this.changed();
  }

  redo(): void {
    const next = this.#undone.pop();
    if (next === undefined) return;
    this.#before.push(this.#all);
    this.#all = next;
    this.changed();
  }

  /** True if these are others than the given ones. */
  differFrom(others: readonly Stroke[]): boolean {
    return JSON.stringify(this.#all.map(values)) !== JSON.stringify(others.map(values));
  }

  #set(strokes: readonly Stroke[]): void {
    this.#before.push(this.#all);
    this.#undone.length = 0;
    this.#all = strokes;
    this.changed();
  }
}

function values({ part, camera, frame, points, radius_px }: Stroke): unknown[] {
  return [part, camera, frame, points, radius_px];
}

/** Points of a stroke rounded to tenths of a pixel; every second is left out until the server takes their number. */
function thinned(points: Stroke['points']): Stroke['points'] {
  let kept = points.map(([x, y]) => [tenth(x), tenth(y)] as const);
  while (kept.length > MOST_POINTS) kept = kept.filter((_, i) => i % 2 === 0);
  return kept;
}

function tenth(value: number): number {
  return Math.round(10 * value) / 10;
}
