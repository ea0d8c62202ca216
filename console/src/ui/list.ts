import type { PageContext } from '../page';
import { h } from './dom';
import type { Child } from './dom';
import { keepingFocus } from './focus';
import { problemBox } from './problem';
import { table } from './table';
import type { Column, Order } from './table';

/** Query of a page of a list, as the API has it. */
export interface PageQuery {
  readonly page_token: string;
  readonly order_by: string;
}

export interface ListOptions<Row> {
  readonly caption: string;
  readonly hidesCaption?: boolean;
  readonly columns: readonly Column<Row>[];
  /** Asks the server for a page of rows. */
  readonly load: (query: PageQuery) => Promise<{ rows: readonly Row[]; next_page_token: string }>;
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
      show(page.rows, page.next_page_token);
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
  const show = (rows: readonly Row[], next: string): void => {
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
    keepingFocus(content, () =>
      content.replaceChildren(
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
