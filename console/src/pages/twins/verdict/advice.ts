import type { Compared, Reason } from './reasons';

/** What one can do next in the console. */
export type Step = 'starts' | 'finer' | 'report' | 'upload' | 'evaluate';

/** What to do about a verdict: sentences, and the steps that they speak of. */
export interface Advice {
  readonly text: string;
  readonly steps: readonly Step[];
}

const GOOD: Advice = { text: 'Use it for rollouts and plans of motions like those of its recording.', steps: [] };
const UNSEEN: Advice = {
  text: 'Measure it on another recording of the object, or fit again with frames left over: only frames that the fit did not see show what its predictions are worth.',
  steps: ['evaluate', 'upload'],
};
const ALONE: Advice = { text: 'There is nothing to compare that with: measure it on a recording.', steps: ['evaluate'] };
const DOES_NOT_FOLLOW: Advice = {
  text: 'Do not plan with it. If the object hardly moves on later frames, record a larger motion; otherwise see what the recording lacks, and fit again with more starts.',
  steps: ['report', 'starts', 'upload'],
};
const FOLLOWS_ROUGHLY: Advice = {
  text: 'Plan over short times with it. A fit with more starts, or with recordings of more motions, can lower its error.',
  steps: ['starts', 'upload'],
};
const FINER: Advice = {
  text: 'Allow for that error in plans. A fit with more nodes and more starts can lower it.',
  steps: ['finer'],
};
const OF_MOTION: Advice = {
  text: 'Allow for that error in plans. It is one of motion, not of the graph: more starts, or recordings of more motions, can lower it; more nodes hardly.',
  steps: ['starts', 'upload'],
};
const MISSES_TRAINING: Advice = {
  text: 'It misses even the frames that it was fitted to: see what the recording lacks, and fit again with more nodes and more starts.',
  steps: ['report', 'finer'],
};
const LASTS: Advice = {
  text: 'Its error lasts: a program that uses it should correct its states by what cameras see while it runs.',
  steps: [],
};

/**
 * What to do about a verdict, by the first comparison that it is due to, as the server chooses (crates/eval/src/assess.rs).
 * Null if the comparisons that are known do not explain the level.
 */
export function adviceOf(level: string, reasons: readonly Reason[]): Advice | null {
  if (level === 'unknown') return reasons.length === 0 ? UNSEEN : ALONE;
  const worst = (['poor', 'fair', 'good'] as const).find((own) => reasons.some((reason) => reason.level === own));
  if (worst !== level) return null;
  const due = reasons.find((reason) => reason.level === level);
  return level === 'good' || due === undefined ? GOOD : ADVICE[due.of](level === 'poor', reasons);
}

/** Advice by the comparison that decides; the error itself and that without bending do not. */
const ADVICE: Readonly<Record<Compared, (isPoor: boolean, reasons: readonly Reason[]) => Advice>> = {
  error: () => ALONE,
  still: (isPoor) => (isPoor ? DOES_NOT_FOLLOW : FOLLOWS_ROUGHLY),
  size: (isPoor, reasons) => {
    const isFine = (reasons.find(({ of }) => of === 'spacing')?.share ?? Infinity) <= 1;
    return isPoor ? DOES_NOT_FOLLOW : isFine ? FINER : OF_MOTION;
  },
  spacing: () => OF_MOTION,
  bias: () => LASTS,
  train: () => MISSES_TRAINING,
  axial: () => ALONE,
};
