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
