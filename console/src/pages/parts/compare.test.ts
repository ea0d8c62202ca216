import { expect, test } from 'vitest';

import { comparedIds, differingSettings, distinctNames } from './compare';

const A = '01a20b85-0861-757d-acc9-0ccb40e9f730';
const B = '01a20b85-0861-757d-acc9-0ccb40e9f731';

test('ids of an address are those that are some, once each', () => {
  expect(comparedIds(new URLSearchParams({ ids: `${A},${B},${A},../x,<b>` }))).toEqual([A, B]);
  expect(comparedIds(new URLSearchParams())).toEqual([]);
});

test('only settings that differ are listed', () => {
  const lines = differingSettings([
    { seed: 1, graph: { max_nodes: null } },
    { seed: 2, graph: { max_nodes: null } },
    null,
  ]);
  expect(lines).toEqual([
    { text: 'seed', cells: ['1', '2', '–'] },
    { text: 'graph.max_nodes', cells: ['open', 'open', '–'] },
  ]);
  expect(differingSettings([{ a: [1] }, { a: [1] }])).toEqual([]);
});

test('names that several have get a number', () => {
  expect(distinctNames(['rope', 'toy', 'rope', ''])).toEqual(['rope (1)', 'toy', 'rope (3)', 'without a name']);
});

test('numbers of settings have three digits, or as many as tell them apart', () => {
  const cells = (one: unknown, other: unknown) => differingSettings([{ a: one }, { a: other }])[0]?.cells;
  expect(cells(0.16666666666666666, 0.123456)).toEqual(['0.167', '0.123']);
  expect(cells(0.12345, 0.12349)).toEqual(['0.12345', '0.12349']);
  expect(cells(1234567, 12)).toEqual(['1234567', '12']);
  // Single precision makes no difference.
  expect(cells(0.1, 0.10000000149011612)).toBeUndefined();
});
