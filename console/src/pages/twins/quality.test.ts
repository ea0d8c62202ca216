import { expect, test } from 'vitest';

import {
  bestText,
  choiceText,
  comparedText,
  headlineOf,
  measuresOf,
  renderedRowsOf,
  rowsOf,
  spreadText,
  type Errors,
  type Likeness,
} from './quality';

const NONE: Errors = { chamfer_l1_m: null, chamfer_l2_m: null, track_m: null, coordinate_m: null };

test('a table has the rows and the measures that there are', () => {
  const quality = {
    scores: [
      {
        predictor: 'bending',
        train: { ...NONE, track_m: 0.001 },
        future: NONE,
        at_nodes: { train: NONE, future: NONE },
      },
      { predictor: 'standing_still', train: NONE, future: { ...NONE, chamfer_l2_m: 0 } },
      { predictor: 'another', train: NONE, future: NONE },
    ],
  };
  const rows = rowsOf(quality);
  expect(rows.map(({ text }) => text)).toEqual(['This twin', 'This twin, at its nodes', 'Standing still', 'another']);
  expect(measuresOf(rows).map(([measure]) => measure)).toEqual(['track_m', 'chamfer_l2_m']);
  expect(rowsOf({})).toEqual([]);
});

test('the mean of several fits says of how many', () => {
  const scores = [{ predictor: 'mean_of_fits', train: NONE, future: NONE }];
  const spread = { fits: 4, mean_m: 0.001, error_m: 0.002, within: 1 };
  expect(rowsOf({ scores }).map(({ text }) => text)).toEqual(['Mean of its fits']);
  expect(rowsOf({ scores, spread }).map(({ text }) => text)).toEqual(['Mean of 4 fits']);
});

test('renderings have a row for each prediction and for each camera of the first', () => {
  const likeness = (iou: number): Likeness => ({ iou, psnr_db: null, ssim: null, flip: null });
  const span = (iou: number) => ({ train: likeness(iou), future: likeness(iou / 2) });
  const score = (predictor: string, iou: number) => ({
    predictor,
    train: NONE,
    future: NONE,
    rendered: {
      gaussians: 9,
      ...span(iou),
      cameras: [
        { name: 'left', ...span(iou) },
        { name: 'top', held_out: true, ...span(iou) },
      ],
    },
  });
  const scores = [score('bending', 0.9), score('axial', 0.8), { predictor: 'another', train: NONE, future: NONE }];
  const rows = renderedRowsOf({ scores });
  expect(rows.map(({ text }) => text)).toEqual([
    'This twin',
    'Axial springs alone',
    'camera left',
    'camera top (held out)',
  ]);
  expect(rows.map(({ train }) => train.iou)).toEqual([0.9, 0.8, 0.9, 0.9]);
  expect(renderedRowsOf({})).toEqual([]);
});

test('the error of a twin is of tracks, else of coordinates, else of surfaces', () => {
  const headline = (future: Errors) => {
    const found = headlineOf({ scores: [{ predictor: 'bending', train: NONE, future }] });
    return found === null ? null : [found.error_m, found.word];
  };
  expect(headline({ ...NONE, track_m: 1, coordinate_m: 2, chamfer_l2_m: 3 })).toEqual([1, 'tracks']);
  expect(headline({ ...NONE, coordinate_m: 2, chamfer_l2_m: 3 })).toEqual([2, 'coordinates']);
  expect(headline({ ...NONE, chamfer_l2_m: 0 })).toEqual([0, 'Chamfer']);
  expect([headline({ ...NONE, chamfer_l1_m: 1 }), headlineOf({})]).toEqual([null, null]);
});

test('the spread of several fits is put into words', () => {
  const spread = { fits: 4, mean_m: 0.002, error_m: 0.005, within: 0.87, rank_correlation: 0.4 };
  expect(spreadText({ spread })).toBe(
    'The predictions of 4 fits are 2 mm apart where the twin is off by 5 mm. ' +
      '87 % of the points have at most twice the expected error, and spread and error agree in rank by 0.40.',
  );
  expect(spreadText({ spread: { ...spread, rank_correlation: null } })).toMatch(/expected error\.$/);
  expect(spreadText({})).toBeNull();
});

test('differences are put into words', () => {
  expect(comparedText('A', 'B', 0.004, 0.01)).toBe(
    'A is better than B by a factor of 2.50 on frames that were not fitted: 4 mm against 10 mm.',
  );
  expect(comparedText('A', 'B', 0.01, 0.004)).toBe(
    'B is better than A by a factor of 2.50 on frames that were not fitted: 4 mm against 10 mm.',
  );
  expect(comparedText('A', 'B', 0.01, 0.0092)).toBe(
    'No difference between A and B beyond that of seeds: 10 mm against 9.2 mm.',
  );
  expect(comparedText('A', 'B', 0, 0)).toContain('No difference');
  expect(comparedText('A', 'B', 0.01, 0.0085)).toContain('B is better');
  expect(comparedText('A', 'B', null, 0.1)).toBeNull();
  const choice = { start: 1, held_back_frames: 0, losses: [2, 1, null] };
  expect(choiceText({ choice })).toBe(
    'Start 2 of 3 was chosen: it has the lowest loss over the training frames.',
  );
  expect(choiceText({ choice: { ...choice, held_back_frames: 6 } })).toContain('6 held-back frames');
  expect(choiceText({})).toBeNull();
});

test('the best of several errors is named, with those that are not worse than by chance', () => {
  expect(bestText(['a', 'b', 'c'], [0.002, 0.001, 0.0011])).toBe(
    'b has the lowest error on frames that were not fitted, 1 mm; that of c is no different beyond seeds.',
  );
  expect(bestText(['a', 'b', 'c'], [0.002, 0.001, 0.003])).toMatch(/^b has the lowest error .* 1 mm\.$/);
  expect(bestText(['a', 'b'], [0.002, null])).toBeNull();
});
