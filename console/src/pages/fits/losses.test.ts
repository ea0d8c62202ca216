import type { LossCurve } from '@bendtwin/client';
import { expect, test } from 'vitest';

import { chartsOf, errorCharts, lastLosses, lossText } from './losses';

const CURVES: LossCurve[] = [
  { stage: 'search', variant: 'bending 1/2', iterations: [1, 2, 4], losses: [3, null, 1], best_losses: [3, 3, 1], errors_m: [null, 0.02, null] },
  { stage: 'search', variant: 'bending 2/2', iterations: [1, 3], losses: [0, 2], best_losses: [0, 0], errors_m: [null, null] },
  { stage: 'refine', variant: 'bending 2/2', iterations: [1], losses: [0.5], best_losses: [0.5], errors_m: [0.005] },
];

test('curves become a chart a stage, whose lines share their iterations', () => {
  const [search, refine, ...others] = chartsOf(CURVES);
  expect(others).toEqual([]);
  expect(search?.iterations).toEqual([1, 2, 3, 4]);
  expect(search?.lines.map(({ values }) => values)).toEqual([
    [3, null, null, 1],
    [3, 3, null, 1],
    [null, null, 2, null],
    [null, null, null, null],
  ]);
  // A model keeps its colour from one stage to the next.
  expect(refine?.lines.map(({ model, label }) => [model, label])).toEqual([
    [1, 'bending 2/2'],
    [1, 'bending 2/2, best'],
  ]);
  expect(chartsOf([])).toEqual([]);
});

test('errors are drawn in millimetres where they were measured, beside standing still', () => {
  const [search, refine, ...others] = errorCharts(CURVES, 0.04);
  expect(others).toEqual([]);
  expect(search).toEqual({
    stage: 'search',
    iterations: [2],
    lines: [
      { label: 'bending 1/2', isSolid: true, model: 0, values: [20] },
      { label: 'standing still', isSolid: false, model: 2, values: [40] },
    ],
  });
  expect(refine?.lines.map(({ label, model }) => [label, model])).toEqual([
    ['bending 2/2', 1],
    ['standing still', 2],
  ]);
  expect(errorCharts(CURVES, null)[0]?.lines).toHaveLength(1);
  expect(errorCharts(CURVES.slice(1, 2), 0.04)).toEqual([]);
});

test('the ends of curves say where models are', () => {
  expect(lastLosses(CURVES)[0]).toEqual({ stage: 'search', variant: 'bending 1/2', iteration: 4, loss: 1, best: 1, error_m: 0.02 });
  expect([null, 0, 0.00003251, 0.1234, 12345].map(lossText)).toEqual([
    'not finite',
    '0',
    '3.25e-5',
    '0.123',
    '1.23e+4',
  ]);
});
