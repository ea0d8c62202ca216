import type { PageContext } from '../page';
import { h } from './dom';
import type { Child } from './dom';
import { keepingFocus } from './focus';
import { counted } from './format';
import { problemBox } from './problem';
import { table } from './table';
import type { Column, Order } from './table';

/** Query of a page of a list, as the API has it. */
export interface PageQuery {
  readonly page_token: string;
  readonly order_by: string;
}

/** A page of a list; `total_size` is the number of rows on all pages, if the server says it. */
export interface ListPage<Row> {
  readonly rows: readonly Row[];
  readonly next_page_token: string;
  readonly total_size?: number | undefined;
  /** What is to be known about the rows, in place of their number. */
  readonly remark?: string | undefined;
}

/** The number of all entries that a reply of a list states; undefined if it states none. */
export function totalOf(reply: object): number | undefined {
  return (reply as { readonly total_size?: number }).total_size;
}

export interface ListOptions<Row> {
  readonly caption: string;
  readonly hidesCaption?: boolean;
  readonly columns: readonly Column<Row>[];
  /** Asks the server for a page of rows. */
  readonly load: (query: PageQuery) => Promise<ListPage<Row>>;
  /** What a row is, as `capture`: the number of all rows is then shown, if it is known. */
  readonly noun?: string;
  /** What the rows have in common, behind their number, as ` with state “failed”`. */
  readonly filtered?: () => string;
  /** Shown in the place of a table without rows. */
  readonly empty: () => Child;
}

/** A list, and a way to ask for it again after something in it has changed. */
export interface List {
  readonly element: HTMLElement;
  /** Loads the page that is shown once more, without a flicker. */
  reload(): Promise<void>;
  /** Begins again at the first page, as after a change of filters. */
  restart(): Promise<void>;
}

/** A table of a list of the API, page by page, sorted by the server. Loading begins immediately. */
export function list<Row>(context: PageContext, options: ListOptions<Row>): List {
  /** Tokens of the pages up to the one that is shown. */
  let tokens: string[] = [''];
  let order: Order | null = null;
  let asked = 0;
  const content = h('div', { 'aria-busy': 'true' }, h('p', { class: 'muted' }, 'Loading…'));

  const reload = async (): Promise<void> => {
    const mine = (asked += 1);
    const order_by = order === null ? '' : order.by + (order.descends ? ' desc' : '');
    try {
      const page = await options.load({ page_token: tokens.at(-1) ?? '', order_by });
      if (mine !== asked || context.signal.aborted) return;
      show(page);
    } catch (error) {
      if (mine !== asked || context.signal.aborted) return;
      content.replaceChildren(problemBox(error, () => void reload()));
    }
    content.removeAttribute('aria-busy');
  };
  const turn = (next: string[]): Promise<void> => {
    tokens = next;
    return reload();
  };
  const show = ({ rows, next_page_token: next, total_size, remark }: ListPage<Row>): void => {
    if (rows.length === 0 && tokens.length === 1) {
      content.replaceChildren(h('div', {}, options.empty()));
      return;
    }
    const onOrder = (wanted: Order): void => {
      order = wanted;
      void turn(['']);
    };
    const go = {
      back: () => void turn(tokens.slice(0, -1)),
      on: () => void turn([...tokens, next]),
    };
    // Without a further page all rows are here.
    const total = total_size ?? (next === '' && tokens.length === 1 ? rows.length : undefined);
    const number = options.noun === undefined || total === undefined ? '' : counted(total, options.noun) + (options.filtered?.() ?? '');
    const said = remark ?? number;
    keepingFocus(content, () =>
      content.replaceChildren(
        said === '' ? '' : h('p', { class: 'muted' }, h('bdi', {}, said)),
        table({ ...options, rows, order, onOrder }),
        pages(tokens.length, next !== '', go),
      ),
    );
  };
  context.api.connection.addEventListener('back', () => void reload(), { signal: context.signal });
  void reload();
  return { element: content, reload, restart: () => turn(['']) };
}

function pages(number: number, hasNext: boolean, go: { back: () => void; on: () => void }): HTMLElement | string {
  if (number === 1 && !hasNext) return '';
  return h(
    'nav',
    { class: 'pages', 'aria-label': 'Pages of the list' },
    h('button', { type: 'button', disabled: number === 1, onclick: go.back }, 'Previous'),
    h('span', {}, `Page ${number}`),
    h('button', { type: 'button', disabled: !hasNext, onclick: go.on }, 'Next'),
  );
}
