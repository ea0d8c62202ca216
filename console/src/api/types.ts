/** Resources of the API, with the types of nested documents that the description leaves open. */
import type { components } from './schema';

type Schemas = components['schemas'];

export type JobState = 'QUEUED' | 'RUNNING' | 'SUCCEEDED' | 'FAILED' | 'CANCELLED';

/** A reason for a failure. */
export interface Fault {
  readonly category: string;
  readonly reason: string;
  readonly message: string;
}

/** Loss of a model after an iteration, in the fit's own units. */
export interface ModelLoss {
  readonly stage: string;
  readonly variant: string;
  readonly iteration: number;
  readonly loss: number | null;
  readonly best_loss: number | null;
}

/** A progress report of a running job. `fraction` is of the whole job, 0..=1. */
export interface Progress extends ModelLoss {
  readonly iterations: number;
  readonly fraction: number;
  readonly eta_s: number | null;
  readonly note: string | null;
  readonly models: readonly ModelLoss[];
}

/** Work that a worker does for a fit, or for the ingest of a capture. */
export type Job = Omit<Schemas['Job'], 'state' | 'settings' | 'progress' | 'fault' | 'attempt_faults'> & {
  readonly state: JobState;
  readonly settings: Record<string, unknown>;
  readonly progress?: Progress | null;
  readonly fault?: Fault | null;
  readonly attempt_faults: readonly Fault[];
};

export type Capture = Omit<Schemas['Capture'], 'ingest'> & { readonly ingest: Job };
export type Fit = Omit<Schemas['Fit'], 'job'> & { readonly job: Job };
export type Twin = Schemas['Twin'];
export type Worker = Schemas['Worker'];

/** True if a job will not change any more. */
export function hasEnded(job: Job): boolean {
  return job.state !== 'QUEUED' && job.state !== 'RUNNING';
}
