import { describe, expect, it, vi } from 'vitest';
import { MOST_POINTS, MOST_STROKES, Strokes, readStrokes, type Stroke } from './strokes';

const click = (changes: Partial<Stroke> = {}): Stroke => ({
  part: 'object', camera: 0, frame: 0, points: [[12, 8]], radius_px: 4, ...changes,
});

describe('strokes', () => {
  it('are added, removed, undone and redone', () => {
    const changed = vi.fn();
    const strokes = new Strokes([click()], changed);
    strokes.add(click({ part: 'hand' }));
    strokes.remove(0);
    expect(strokes.all.map(({ part }) => part)).toEqual(['hand']);
    strokes.undo();
    expect(strokes.all.map(({ part }) => part)).toEqual(['object', 'hand']);
    strokes.undo();
    expect([strokes.canUndo, strokes.has('hand')]).toEqual([false, false]);
    strokes.undo();
    strokes.redo();
    strokes.redo();
    expect([strokes.canRedo, strokes.has('object')]).toEqual([false, false]);
    strokes.undo();
    strokes.clear();
    expect([strokes.all.length, strokes.canRedo]).toEqual([0, false]);
    expect(changed).toHaveBeenCalledTimes(8);
  });

  it('are those of their image', () => {
    const strokes = new Strokes([click(), click({ frame: 3 }), click({ camera: 1, frame: 3 })], () => undefined);
    expect(strokes.in(0, 3)).toEqual([click({ frame: 3 })]);
    expect(strokes.in(2, 3)).toEqual([]);
  });

  it('stay within the bounds of the server', () => {
    const strokes = new Strokes(Array.from({ length: MOST_STROKES - 1 }, () => click()), () => undefined);
    const long = Array.from({ length: 10_000 }, (_, i) => [i / 3, 1] as const);
    expect(strokes.add(click({ points: long }))).toBe(true);
    const { points } = strokes.all.at(-1)!;
    expect(points.length).toBeLessThanOrEqual(MOST_POINTS);
    expect([points[0], points[1]]).toEqual([[0, 1], [1.3, 1]]);
    expect(strokes.add(click())).toBe(false);
  });

  it('are compared by their values', () => {
    const strokes = new Strokes([click()], () => undefined);
    const { part, camera, frame, points, radius_px } = click();
    expect(strokes.differFrom([{ radius_px, points, frame, camera, part }])).toBe(false);
    expect(strokes.differFrom([click({ frame: 1 })])).toBe(true);
    expect(strokes.differFrom([])).toBe(true);
  });
});

it('strokes are read from settings, and nothing else is', () => {
  const short = { part: 'hand', camera: 1, points: [[120, 88]] };
  expect(readStrokes({ strokes: [short] })).toEqual([{ ...short, frame: 0, radius_px: 4 }]);
  const wrong = [null, 3, {}, { ...short, part: 'x' }, { ...short, points: [] }, { ...short, points: [[1]] }, { ...short, camera: 0.5 }];
  expect(readStrokes({ strokes: wrong })).toEqual([]);
  expect(readStrokes({})).toEqual([]);
});
