import { badge } from '../../ui/badge';
import { h } from '../../ui/dom';
import { facts } from '../../ui/form';
import { count, millimetres, percent } from '../../ui/format';
import { table } from '../../ui/table';
import { prose } from '../parts/text';
import {
  choiceText,
  measuresOf,
  renderedRowsOf,
  rowsOf,
  spreadText,
  type Errors,
  type Likeness,
  type Quality,
  type Recording,
  type RenderedRow,
  type Row,
} from './quality';

const TONES: Record<string, Parameters<typeof badge>[1]> = {
  good: 'good',
  fair: 'warn',
  poor: 'bad',
  unknown: 'neutral',
};

/** The tone of a level of trust. */
export function assessmentTone(level: string): Parameters<typeof badge>[1] {
  return TONES[level] ?? 'neutral';
}

/** Assessment of a twin: its level, the reasons, and what to do next. */
export function assessmentView({ assessment, warnings = [] }: Quality): HTMLElement | null {
  if (assessment === undefined && warnings.length === 0) return null;
  return h(
    'section',
    { class: 'card assessment', 'aria-label': 'Assessment' },
    assessment !== undefined &&
      h('p', {}, badge(assessment.level, assessmentTone(assessment.level)), ' ', prose(assessment.why)),
    assessment !== undefined && h('p', {}, h('strong', {}, prose(assessment.next))),
    warnings.length > 0 && h('ul', {}, ...warnings.map((warning) => h('li', {}, prose(warning)))),
  );
}

/** The quality table: errors over the frames of the fit and over those after, beside the baselines. */
export function qualityView(quality: Quality): HTMLElement {
  const rows = rowsOf(quality);
  const choice = choiceText(quality);
  const spread = spreadText(quality);
  return h(
    'section',
    {},
    h('h2', {}, 'Errors'),
    rows.length === 0
      ? h(
          'p',
          { class: 'muted' },
          'This twin has no measured errors. Evaluate it on a capture to measure them.',
        )
      : errorTable(
          'Mean errors over the frames of the fit (training) and over later frames (future)',
          'Prediction',
          rows,
          ({ text }) => text,
        ),
    choice !== null && h('p', { class: 'muted' }, choice),
    spread !== null && h('p', { class: 'muted' }, spread),
    recordingsView(quality.recordings ?? []),
    renderedView(quality),
    fastView(quality),
  );
}

/** Columns of training and future errors by the measures that there are. */
function errorTable<R extends { train: Errors; future: Errors }>(
  caption: string,
  header: string,
  rows: readonly R[],
  text: (row: R) => string,
): HTMLElement {
  const measures = measuresOf(rows.map((row): Row => ({ ...row, text: text(row) })));
  const columns = (['train', 'future'] as const).flatMap((part) =>
    measures.map(([measure, word]) => ({
      header: `${part === 'train' ? 'Training' : 'Future'}: ${word}`,
      isNumeric: true,
      cell: (row: R) => millimetres(row[part][measure]),
    })),
  );
  return table<R>({ caption, rows, columns: [{ header, cell: (row) => h('bdi', {}, text(row)) }, ...columns] });
}

function recordingsView(recordings: readonly Recording[]): HTMLElement | null {
  if (recordings.length === 0) return null;
  const registered = recordings.flatMap(({ name, registered: own }) =>
    own === undefined
      ? []
      : [
          `${name}: the first frame lies ${own.median_mm.toFixed(1)} mm from the twin (median), ` +
            `${percent(own.explained)} of it explained.`,
        ],
  );
  return h(
    'div',
    {},
    h('h3', {}, 'By recording'),
    errorTable('Errors in each recording', 'Recording', recordings, ({ name }) => name),
    registered.length > 0 && h('ul', { class: 'muted' }, ...registered.map((text) => h('li', {}, h('bdi', {}, text)))),
  );
}

/** Likenesses, their decimals and how they are read from a row. */
const LIKENESSES: readonly (readonly [string, number, (likeness: Likeness) => number | null | undefined])[] = [
  ['IoU', 3, (likeness) => likeness.iou],
  ['PSNR [dB]', 1, (likeness) => likeness.psnr_db],
  ['SSIM', 3, (likeness) => likeness.ssim],
  ['FLIP', 3, (likeness) => likeness.flip],
  ['LPIPS', 3, (likeness) => likeness.lpips],
];

function renderedView(quality: Quality): HTMLElement | null {
  const rows = renderedRowsOf(quality);
  if (rows.length === 0) return null;
  const columns = (['train', 'future'] as const).flatMap((part) =>
    LIKENESSES.filter(([, , of]) => rows.some((row) => typeof of(row[part]) === 'number')).map(
      ([word, decimals, of]) => ({
        header: `${part === 'train' ? 'Training' : 'Future'}: ${word}`,
        isNumeric: true,
        cell: (row: RenderedRow) => of(row[part])?.toFixed(decimals) ?? '–',
      }),
    ),
  );
  return h(
    'div',
    {},
    h('h3', {}, 'Renderings'),
    table<RenderedRow>({
      caption: 'Likeness of renderings to the recorded images',
      rows,
      columns: [{ header: 'Prediction', cell: ({ text }) => h('bdi', {}, text) }, ...columns],
    }),
  );
}

function fastView({ fast }: Quality): HTMLElement | null {
  if (fast === undefined) return null;
  return h(
    'details',
    { class: 'card' },
    h('summary', {}, 'Fast variant'),
    facts([
      ['Substeps per frame', count(fast.substeps)],
      ['Mean deviation', millimetres(fast.mean_deviation_m)],
      ['Largest deviation', millimetres(fast.max_deviation_m)],
      ['Nodes move by', millimetres(fast.mean_travel_m)],
      ['Measured over', `${fast.frames} frames`],
    ]),
  );
}
