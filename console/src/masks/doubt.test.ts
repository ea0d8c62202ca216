import { expect, it } from 'vitest';
import { levelOf, nextDoubtful, summary } from './doubt';

it('doubt has levels in words', () => {
  const words = [0, 0.1, 0.12, 0.24, 0.25, 1, null, undefined].map((doubt) => levelOf(doubt)?.word);
  expect(words).toEqual(['sure', 'sure', 'some doubt', 'some doubt', 'doubtful', 'doubtful', undefined, undefined]);
});

it('the doubt of a camera is stated in words', () => {
  expect(summary([0, 0.05, 0.1])).toBe('sure in all frames');
  expect(summary([null, null])).toBe('no images');
  expect(summary([0, 0.9, 0])).toBe('doubtful in frame 1');
  expect(summary([0, 0.9, 0.8, 0.2, null])).toBe('doubtful in frames 1 to 2, some doubt in 1 frame, no image in 1 frame');
  const many = Array.from({ length: 10 }, (_, t) => (t % 2 === 0 ? 0.7 : 0));
  expect(summary(many)).toBe('doubtful in frames 0, 2, 4 and in 2 more places');
});

it('the next doubtful stretch is found in any camera, from the start again after the last', () => {
  const cameras = [
    [0, 0.6, 0.7, 0.6, 0, 0],
    [0, 0, 0, 0, null, 0.9],
  ];
  expect([0, 2, 5].map((frame) => nextDoubtful(cameras, frame))).toEqual([2, 5, 2]);
  expect(nextDoubtful([[0, 0.1]], 0)).toBeNull();
  expect(nextDoubtful([], 0)).toBeNull();
});
