import type { Capture } from '@bendtwin/client';
import type { PageContext } from '../../../page';
import { h, nodes, type Child } from '../../../ui/dom';
import { facts, field } from '../../../ui/form';
import { guideLink } from '../../../ui/guide';
import { problemBox } from '../../../ui/problem';
import { actionButton, faultPlace } from '../../parts/actions';
import { readAgain } from '../../parts/ingest';
import { DICTIONARIES, PATTERNS, formOf, readBoard, type Board, type BoardForm } from './board';
import type { Calibration } from '../report/report';

/** Settings of the calibration that an ingest had. */
interface InUse {
  readonly board?: Board | null;
  readonly correct?: boolean;
  readonly ground?: 'recorded' | 'detected';
}

/** Calibration settings of a capture's last ingest. */
export function inUse({ ingest }: Capture): InUse {
  return (ingest.settings['calibration'] ?? {}) as InUse;
}

const FIELDS = ['columns', 'rows', 'squareMm', 'markerMm'] as const;

/** The calibration of a capture: what is in use, with buttons that end it, and a form for a board that its cameras see. */
export class CalibrationCard {
  readonly element = h('details', { class: 'card', hidden: true });
  readonly #faults = faultPlace();
  #first: HTMLElement | null = null;
  /** What is shown, as text. */
  #shown = '';

  constructor(
    private readonly context: PageContext,
    private readonly latest: () => Capture,
    /** Called with the capture once it is read again. */
    private readonly onStart: (capture: Capture) => void,
  ) {}

  /** Shows the calibration of the capture, which is open if it lacks. What was typed stays unless it has changed. */
  show(calibration: Calibration | null, isMissing: boolean): void {
    this.element.hidden = false;
    const use = inUse(this.latest());
    const shown = JSON.stringify([use, calibration, isMissing]);
    if (shown === this.#shown) return;
    this.#shown = shown;
    this.#faults.replaceChildren();
    this.element.open = isMissing;
    this.element.replaceChildren(
      h('summary', {}, 'Calibration'),
      ...nodes(this.#uses(use, calibration)),
      h('h3', {}, 'Calibrate with a board'),
      h('p', {},
        'All cameras see the board at rest in the recording. It gives their poses; z = 0 lies on the board. See ',
        guideLink('calibration', 'how to print and record one'), '.'),
      this.#form(use.board ?? null),
      this.#faults,
    );
  }

  /** Leads to the form. */
  focus(): void {
    this.element.open = true;
    this.#first?.focus();
  }

  /** A button that reads the capture again with other settings of the calibration. */
  button(text: string, change: InUse): HTMLElement {
    const act = (): Promise<void> => this.#read(change);
    const faults = faultPlace();
    return h('div', {}, actionButton(this.context, text, faults, act), faults);
  }

  async #read(change: InUse): Promise<void> {
    this.onStart(await readAgain(this.context, this.latest(), { calibration: change }));
  }

  #uses({ board, correct, ground }: InUse, calibration: Calibration | null): Child[] {
    const used: [string, string, InUse][] = [];
    if (board) used.push(['A board measures the poses.', 'Use the recorded calibration', { board: null }]);
    if (correct === true) used.push(['A camera is moved by the correction of the report.', 'Undo the correction', { correct: false }]);
    if (ground === 'detected') used.push(['The ground is the detected plane.', 'Use the recorded ground', { ground: 'recorded' }]);
    const errors = (calibration?.cameras ?? []).map(({ name, reprojection_px: px }) => {
      return [name, px === null || px === undefined ? '–' : `${px.toFixed(2)} px`] as const;
    });
    return [
      ...used.map(([text, word, change]) => h('div', { class: 'row' }, text, this.button(word, change))),
      errors.some(([, px]) => px !== '–') && [h('h3', {}, 'Reprojection error'), facts(errors)],
    ];
  }

  #form(board: Board | null): HTMLElement {
    const initial = formOf(board);
    const patterns = Object.entries(PATTERNS).map(([value, { label }]) =>
      h('option', { value, selected: value === initial.pattern }, label));
    const pattern = h('select', {}, ...patterns);
    const names = DICTIONARIES.includes(initial.dictionary) ? DICTIONARIES : [initial.dictionary, ...DICTIONARIES];
    const dictionary = h('select', {}, ...names.map((name) => h('option', { selected: name === initial.dictionary }, name)));
    const legacy = h('input', { type: 'checkbox', checked: initial.legacy });
    const legacyField = h('p', {}, h('label', {}, legacy, ' Drawn by OpenCV before version 4.6 (legacy pattern)'));
    const inputs = FIELDS.map((name) => {
      const input = h('input', { inputmode: name.endsWith('Mm') ? 'decimal' : 'numeric', value: initial[name], required: true });
      const fault = h('p', { class: 'fault', id: `board-${name}-fault` });
      const labelled = field('', input);
      labelled.append(fault);
      input.setAttribute('aria-describedby', fault.id);
      return { name, input, fault, labelled };
    });
    const hint = h('p', { class: 'hint' });
    const word = (): void => {
      const words = PATTERNS[pattern.value as Board['pattern']];
      for (const { name, labelled } of inputs) labelled.querySelector('label')!.textContent = words[name];
      hint.textContent = words.hint;
      legacyField.hidden = pattern.value !== 'charuco';
    };
    pattern.addEventListener('change', () => {
      dictionary.value = PATTERNS[pattern.value as Board['pattern']].dictionary;
      word();
    });
    word();
    this.#first = pattern;
    const submit = h('button', { type: 'submit', class: 'primary' }, 'Calibrate');
    const send = async (event: Event): Promise<void> => {
      event.preventDefault();
      const entries = inputs.map(({ name, input }) => [name, input.value] as const);
      const read = readBoard({
        ...(Object.fromEntries(entries) as Pick<BoardForm, (typeof FIELDS)[number]>),
        pattern: pattern.value as Board['pattern'],
        dictionary: dictionary.value,
        legacy: legacy.checked,
      });
      const faults = 'faults' in read ? read.faults : new Map<string, string>();
      for (const { name, input, fault } of inputs) {
        const own = faults.get(name);
        fault.textContent = own === undefined ? '' : `It must be ${own}.`;
        if (own === undefined) input.removeAttribute('aria-invalid');
        else input.setAttribute('aria-invalid', 'true');
      }
      inputs.find(({ name }) => faults.has(name))?.input.focus();
      if ('faults' in read) return;
      submit.disabled = true;
      this.#faults.replaceChildren();
      try {
        await this.#read({ board: read.board });
      } catch (error) {
        if (!this.context.signal.aborted) this.#faults.replaceChildren(problemBox(error));
      }
      submit.disabled = false;
    };
    return h(
      'form',
      { novalidate: true, onsubmit: (event) => void send(event) },
      field('Board', pattern),
      h('div', { class: 'field-row' }, ...inputs.map(({ labelled }) => labelled)),
      hint,
      field('Dictionary of the markers', dictionary),
      legacyField,
      h('div', { class: 'buttons' }, submit),
    );
  }
}
