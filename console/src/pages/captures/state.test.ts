import type { Capture } from '@bendtwin/client';
import { expect, test } from 'vitest';
import { mayHavePicture, stateOf, whyNoFit } from './state';

function capture(state: string, verdict: string | null = null, settings: object = {}): Capture {
  return { verdict, ingest: { state, settings } } as unknown as Capture;
}

test('the state of a capture is that of its reading, then its verdict', () => {
  const states = [
    capture('QUEUED', 'good'),
    capture('RUNNING'),
    capture('SUCCEEDED', 'good'),
    capture('SUCCEEDED', 'usable'),
    capture('SUCCEEDED', 'usable', { until: 'masks' }),
    capture('FAILED', 'unusable'),
    capture('FAILED', 'good'),
    capture('FAILED'),
    capture('CANCELLED'),
  ].map(stateOf);
  expect(states).toEqual(['reading', 'reading', 'good', 'usable', 'masks', 'unusable', 'failed', 'failed', 'failed']);
});

test('captures that have points, or will have them, can be fitted', () => {
  expect([capture('SUCCEEDED', 'good'), capture('QUEUED'), capture('RUNNING', 'usable')].map(whyNoFit)).toEqual([null, null, null]);
  const not = [
    capture('FAILED', 'unusable'),
    capture('FAILED'),
    capture('CANCELLED'),
    capture('SUCCEEDED', 'good', { until: 'masks' }),
    capture('RUNNING', 'good', { until: 'masks' }),
  ];
  expect(not.map(whyNoFit).every((text) => text !== null)).toBe(true);
});

test('what could not be read has no picture', () => {
  const unread = { ...capture('FAILED', 'unusable') };
  (unread.ingest as { fault?: object }).fault = { reason: 'UNKNOWN_CAPTURE_KIND' };
  expect([capture('QUEUED'), capture('CANCELLED', 'good'), capture('FAILED'), unread].map(mayHavePicture)).toEqual([false, false, false, false]);
  expect([capture('SUCCEEDED', 'good'), capture('FAILED', 'unusable')].map(mayHavePicture)).toEqual([true, true]);
});
