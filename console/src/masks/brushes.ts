import { h } from '../ui/dom';
import { colourOf } from './drawing';
import { BRUSHES, RADII, type Part } from './strokes';

/** Magnifications of the images. */
const ZOOMS = [1, 2, 4, 8] as const;

/** Columns of an image for each pixel of the first brush's radius. */
const COLUMNS_PER_PX = 200;

/** What the tools call. */
export interface ToolActions {
  undo(): void;
  redo(): void;
  zoom(factor: number): void;
  /** Something is to be drawn in another way. */
  changed(): void;
}

/** The brush, its size, the way back, magnification, and whether masks are shown. */
export class Tools {
  readonly element: HTMLElement;
  part: Part = 'object';
  radius: number = RADII.initial;
  showsMasks = true;
  readonly #brushes: Map<Part, HTMLButtonElement>;
  readonly #undo: HTMLButtonElement;
  readonly #redo: HTMLButtonElement;
  readonly #zoom: HTMLSelectElement;
  readonly #size: HTMLInputElement;

  constructor(private readonly actions: ToolActions) {
    this.#brushes = new Map(
      BRUSHES.map(({ part, label, key }) => {
        const swatch = h('span', { class: `masks-swatch masks-swatch-${part}`, 'aria-hidden': 'true' });
        swatch.style.backgroundColor = colourOf(part);
        const choose = (): void => this.choose(part);
        return [
          part,
          h('button', { type: 'button', onclick: choose, 'aria-keyshortcuts': key }, swatch, label, h('kbd', {}, key)),
        ];
      }),
    );
    const button = (text: string, keys: string, onclick: () => void): HTMLButtonElement =>
      h('button', { type: 'button', 'aria-keyshortcuts': keys, title: `${text} (${keys.replace('Control', 'Ctrl')})`, onclick }, text);
    this.#undo = button('Undo', 'Control+Z', () => actions.undo());
    this.#redo = button('Redo', 'Control+Shift+Z', () => actions.redo());
    this.#size = h('input', { type: 'range', min: RADII.least, max: RADII.most, value: RADII.initial });
    this.#size.addEventListener('input', () => this.#resize());
    this.#zoom = h('select', {}, ...ZOOMS.map((factor) => h('option', { value: factor }, `${factor} ×`)));
    this.#zoom.addEventListener('change', () => actions.zoom(this.factor));
    const shows = h('input', { type: 'checkbox', checked: true });
    shows.addEventListener('change', () => {
      this.showsMasks = shows.checked;
      actions.changed();
    });
    this.element = h(
      'div',
      { class: 'masks-tools', role: 'group', 'aria-label': 'Tools' },
      h('div', { class: 'row', role: 'group', 'aria-label': 'Brush' }, ...this.#brushes.values()),
      h(
        'div',
        { class: 'row' },
        this.#undo,
        this.#redo,
        h('label', { class: 'masks-choice' }, 'Size', this.#size),
        h('label', { class: 'masks-choice' }, 'Zoom', this.#zoom),
        h('label', { class: 'masks-choice' }, shows, 'Show masks'),
      ),
    );
    this.choose('object');
  }

  /** Takes a brush. */
  choose(part: Part): void {
    this.part = part;
    for (const [own, button] of this.#brushes) button.setAttribute('aria-pressed', String(own === part));
    this.actions.changed();
  }

  /** Magnification of the images. */
  get factor(): number {
    return Number(this.#zoom.value);
  }

  /** Makes the brush small enough for images of this many columns. */
  suit(columns: number): void {
    const radius = Math.max(Math.round(columns / COLUMNS_PER_PX), RADII.least);
    if (radius >= this.radius) return;
    this.#size.value = String(radius);
    this.#resize();
  }

  /** The next larger magnification, or the next smaller one. */
  zoomBy(direction: 1 | -1): void {
    const index = ZOOMS.findIndex((factor) => String(factor) === this.#zoom.value) + direction;
    const factor = ZOOMS[index];
    if (factor === undefined) return;
    this.#zoom.value = String(factor);
    this.actions.zoom(factor);
  }

  #resize(): void {
    this.radius = this.#size.valueAsNumber;
    this.#size.setAttribute('aria-valuetext', `radius of ${this.radius} pixels`);
    this.actions.changed();
  }

  /** Shows which ways back there are. */
  show({ canUndo, canRedo }: { readonly canUndo: boolean; readonly canRedo: boolean }): void {
    // A button that is disabled loses the focus.
    this.#undo.setAttribute('aria-disabled', String(!canUndo));
    this.#redo.setAttribute('aria-disabled', String(!canRedo));
  }
}
