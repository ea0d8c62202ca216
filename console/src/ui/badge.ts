import { h } from './dom';

type Tone = 'neutral' | 'busy' | 'good' | 'warn' | 'bad';

const TONES: Record<string, Tone> = {
  QUEUED: 'neutral',
  RUNNING: 'busy',
  SUCCEEDED: 'good',
  FAILED: 'bad',
  CANCELLED: 'neutral',
  good: 'good',
  usable: 'warn',
  unusable: 'bad',
};

/** A state in a word, as of a job (`RUNNING`) or of a capture's verdict (`usable`). */
export function badge(state: string, tone: Tone = TONES[state] ?? 'neutral'): HTMLElement {
  return h('span', { class: `badge badge-${tone}` }, state.toLowerCase());
}
