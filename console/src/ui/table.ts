import { h } from './dom';
import type { Child } from './dom';

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

/** A table in a frame that scrolls sideways on small screens. The first column names the rows. */
export function table<Row>(options: TableOptions<Row>): HTMLElement {
  const { caption, columns, rows } = options;
  const body = rows.map((row) =>
    h(
      'tr',
      {},
      ...columns.map(({ cell, isNumeric }, index) => {
        const attributes = { class: isNumeric ? 'numeric' : null };
        return index === 0
          ? h('th', { scope: 'row', ...attributes }, cell(row))
          : h('td', attributes, cell(row));
      }),
    ),
  );
  const hidden = options.hidesCaption === true ? 'visually-hidden' : null;
  return framed(
    caption,
    h(
      'table',
      {},
      h('caption', { class: hidden }, caption),
      h('thead', {}, groupRow(columns), h('tr', {}, ...columns.map((column) => header(column, options)))),
      h('tbody', {}, ...body),
    ),
  );
}

/** A table in a frame, which scrolls, and can be reached by keys to do so, only while it is too narrow for the table. */
function framed(caption: string, content: HTMLTableElement): HTMLElement {
  const frame = h('div', { class: 'table-frame', role: 'region', 'aria-label': caption, tabindex: '0' }, content);
  const measure = (): void => {
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
    { class: 'groups' },
    ...cells.map(({ text, span }) =>
      text === '' ? h('td', { colspan: span }) : h('th', { scope: 'colgroup', colspan: span }, text),
    ),
  );
}

function header<Row>(column: Column<Row>, { order, onOrder }: TableOptions<Row>): HTMLElement {
  const by = column.orderBy;
  const attributes = { scope: 'col', class: column.isNumeric ? 'numeric' : null };
  if (by === undefined || onOrder === undefined) return h('th', attributes, column.header);
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
  );
}
