import { h } from './dom';
import type { Child } from './dom';
import { help } from './help';

/** An order of rows: of what, and whether it descends. */
export interface Order {
  readonly by: string;
  readonly descends: boolean;
}

export interface Column<Row> {
  readonly header: string;
  /** Header over this column and the ones beside it that have the same. */
  readonly group?: string;
  readonly cell: (row: Row) => Child;
  /** Word by which rows can be sorted, as `create_time` of the API's `order_by`. */
  readonly orderBy?: string;
  /** What the column means, behind a `?` in its header. */
  readonly help?: string;
  /** Numbers stand at the right, so that their digits are below each other. */
  readonly isNumeric?: boolean;
}

export interface TableOptions<Row> {
  readonly caption: string;
  /** True if a heading says the same: the caption is then for screen readers. */
  readonly hidesCaption?: boolean;
  readonly columns: readonly Column<Row>[];
  readonly rows: readonly Row[];
  readonly order?: Order | null;
  /** Called with the order that a click on a header asks for. */
  readonly onOrder?: (order: Order) => void;
}

/** A table in a frame; on small screens that it does not fit its rows are blocks. The first column names the rows. */
export function table<Row>(options: TableOptions<Row>): HTMLElement {
  const { caption, columns, rows } = options;
  const body = rows.map((row) =>
    h(
      'tr',
      { role: 'row' },
      ...columns.map(({ cell, isNumeric, header: text, group }, index) => {
        const attributes = { class: isNumeric ? 'numeric' : null };
        if (index === 0) return h('th', { scope: 'row', role: 'rowheader', ...attributes }, cell(row));
        return h('td', { role: 'cell', 'data-label': group ? `${group}: ${text}` : text, ...attributes }, cell(row));
      }),
    ),
  );
  const hidden = options.hidesCaption === true ? 'visually-hidden' : null;
  return framed(
    caption,
    h(
      'table',
      // Roles are explicit: laid out as blocks, elements of tables lose theirs.
      { role: 'table' },
      h('caption', { class: hidden }, caption),
      h('thead', { role: 'rowgroup' }, groupRow(columns), h('tr', { role: 'row' }, ...columns.map((column) => header(column, options)))),
      h('tbody', { role: 'rowgroup' }, ...body),
    ),
  );
}

/** Screens on which a table that does not fit becomes blocks. */
const SMALL = '(width < 44rem)';

/**
 * A table in a frame. While it is too wide for that, it becomes blocks on a small screen; elsewhere the frame scrolls,
 * and can be reached by keys to do so.
 */
function framed(caption: string, content: HTMLTableElement): HTMLElement {
  const frame = h('div', { class: 'table-frame', role: 'region', 'aria-label': caption, tabindex: '0' }, content);
  let needed = 0;
  const measure = (): void => {
    if (!frame.classList.contains('stacked')) needed = content.offsetWidth;
    const hasRows = (content.tBodies[0]?.rows.length ?? 0) > 0;
    frame.classList.toggle('stacked', hasRows && matchMedia(SMALL).matches && needed > frame.clientWidth);
    const fits = content.offsetWidth <= frame.clientWidth;
    frame.classList.toggle('fits', fits);
    if (fits) frame.removeAttribute('tabindex');
    else frame.tabIndex = 0;
  };
  const resized = new ResizeObserver(measure);
  resized.observe(frame);
  resized.observe(content);
  return frame;
}

/** The row of headers over several columns, if there are any. */
function groupRow<Row>(columns: readonly Column<Row>[]): HTMLElement | null {
  if (columns.every(({ group }) => group === undefined)) return null;
  const cells: { text: string; span: number }[] = [];
  for (const { group: text = '' } of columns) {
    const last = cells.at(-1);
    if (last !== undefined && last.text === text) last.span += 1;
    else cells.push({ text, span: 1 });
  }
  return h(
    'tr',
    { class: 'groups', role: 'row' },
    ...cells.map(({ text, span }) =>
      text === '' ? h('td', { role: 'cell', colspan: span }) : h('th', { scope: 'colgroup', role: 'columnheader', colspan: span }, text),
    ),
  );
}

function header<Row>(column: Column<Row>, { order, onOrder }: TableOptions<Row>): HTMLElement {
  const by = column.orderBy;
  const attributes = { scope: 'col', role: 'columnheader', class: column.isNumeric ? 'numeric' : null };
  const explanation = column.help === undefined ? '' : [' ', help(column.header, column.help)];
  if (by === undefined || onOrder === undefined) return h('th', attributes, column.header, explanation);
  const isSorted = order?.by === by;
  const descends = isSorted && order.descends;
  const sort = isSorted ? (descends ? 'descending' : 'ascending') : null;
  return h(
    'th',
    { ...attributes, 'aria-sort': sort },
    h(
      'button',
      { type: 'button', class: 'sort', onclick: () => onOrder({ by, descends: isSorted && !descends }) },
      column.header,
      h('span', { 'aria-hidden': 'true', class: 'sort-mark' }, isSorted ? (descends ? '▼' : '▲') : ''),
    ),
    explanation,
  );
}
