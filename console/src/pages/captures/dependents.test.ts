import { expect, test } from 'vitest';

import type { Api } from '../../api/client';
import type { PageContext } from '../../page';
import { deleteQuestion, textOf } from './dependents';

/** The context of a page whose server has these replies for each capture. */
function context(replies: Record<string, object>): PageContext {
  const get: unknown = (route: string, { query }: { query: { capture: string } }) =>
    Promise.resolve(replies[`${route} ${query.capture}`]);
  return { api: { get } as unknown as Api, signal: new AbortController().signal } as unknown as PageContext;
}

test('what depends on captures is counted', async () => {
  const page = context({
    '/v1/twins a': { twins: [1], next_page_token: 'x', total_size: 120 },
    '/v1/fits a': { fits: [1, 2], next_page_token: '' },
    '/v1/twins b': { twins: [], next_page_token: '' },
    '/v1/fits b': { fits: [1], next_page_token: '' },
  });
  const both = await deleteQuestion(page, ['a', 'b']);
  expect(both.title).toBe('Delete 2 captures?');
  expect(both.text).toMatch(/^120 twins and 3 fits depend on them\. /);
  expect((await deleteQuestion(page, ['b'])).text).toMatch(/^1 fit depends on it\. /);
});

test('more than were counted are at least as many', () => {
  expect(textOf({ twins: 100, fits: 1, isLeast: true }, false)).toMatch(/^At least 100 twins and 1 fit depend on it/);
  expect(textOf({ twins: 0, fits: 0, isLeast: false }, false)).toBe('');
});
