import { h, type Child } from '../../ui/dom';
import { facts } from '../../ui/form';
import { capitalised, count, millimetres } from '../../ui/format';
import { table } from '../../ui/table';
import {
  choiceText,
  measuresOf,
  renderedRowsOf,
  rowsOf,
  spreadText,
  type Errors,
  type Likeness,
  type Quality,
  type RenderedRow,
  type Row,
} from './quality';
import { verdictLine, warningList } from './verdict/level';
import { recordingsView } from './recordings';

/** The two spans of frames, with their words: those that matter first. */
const SPANS = [
  ['future', 'Later frames'],
  ['train', 'Fitted frames'],
] as const;

/** Assessment of a twin: its verdict, then `more` about that, and warnings. */
export function assessmentView(quality: Quality, more: Child): HTMLElement | null {
  const { assessment, warnings = [] } = quality;
  if (assessment === undefined && warnings.length === 0) return null;
  return h(
    'section',
    { class: 'card assessment', 'aria-label': 'Assessment' },
    verdictLine(quality),
    assessment !== undefined && more,
    warningList(warnings),
  );
}

/** The quality table: errors over later frames and over those of the fit, beside the baselines. */
export function qualityView(quality: Quality): HTMLElement {
  const rows = rowsOf(quality);
  const choice = choiceText(quality);
  const spread = spreadText(quality);
  return h(
    'section',
    {},
    h('h2', {}, 'Errors'),
    rows.length === 0
      ? h('p', { class: 'muted' }, 'This twin has no measured errors. Evaluate it on a capture to measure them.')
      : errorTable('Mean errors of predictions over frames that were not fitted (later) and that were', 'Prediction', rows),
    choice !== null && h('p', { class: 'muted' }, choice),
    spread !== null && h('p', { class: 'muted' }, spread),
    recordingsView(quality.recordings ?? []),
    renderedView(quality),
    fastView(quality),
  );
}

/** Errors of rows by the measures that there are, in each span of frames. */
function errorTable(caption: string, header: string, rows: readonly Row[]): HTMLElement {
  const columns = SPANS.flatMap(([part, group]) =>
    measuresOf(rows).map(([measure, word]) => ({
      header: capitalised(word),
      group,
      isNumeric: true,
      cell: (row: Row) => millimetres((row[part] as Errors)[measure]),
    })),
  );
  return table<Row>({ caption, rows, columns: [{ header, cell: ({ text }) => h('bdi', {}, text) }, ...columns] });
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
  const columns = SPANS.flatMap(([part, group]) =>
    LIKENESSES.filter(([, , of]) => rows.some((row) => typeof of(row[part]) === 'number')).map(([header, decimals, of]) => ({
      header,
      group,
      isNumeric: true,
      cell: (row: RenderedRow) => of(row[part])?.toFixed(decimals) ?? '–',
    })),
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
