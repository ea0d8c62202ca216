import { expect, it } from 'vitest';
import { Draft } from './drafts';
import type { Stroke } from './strokes';

it('strokes that were not sent are kept by capture, and forgotten', () => {
  const kept = new Map<string, string>();
  const storage = {
    getItem: (key: string) => kept.get(key) ?? null,
    setItem: (key: string, value: string) => void kept.set(key, value),
    removeItem: (key: string) => void kept.delete(key),
  };
  const stroke: Stroke = { part: 'hand', camera: 1, frame: 3, points: [[1, 2]], radius_px: 4 };
  const draft = new Draft('a', storage);
  expect(draft.get()).toBeNull();
  draft.keep([stroke]);
  expect(draft.get()).toEqual([stroke]);
  expect(new Draft('b', storage).get()).toBeNull();
  draft.keep([]);
  expect(draft.get()).toEqual([]);
  draft.forget();
  expect(draft.get()).toBeNull();
  kept.set('bendtwin.strokes.a', '{');
  expect(draft.get()).toBeNull();
  const full = new Draft('a', { ...storage, setItem: () => { throw new Error('full'); } });
  expect(() => full.keep([stroke])).not.toThrow();
});
