/** Resources of the API, as the description has them. */
import type { components } from './schema';

type Schemas = components['schemas'];

export type Fault = Schemas['Fault'];
export type Progress = Schemas['Progress'];
export type Job = Schemas['Job'];
export type JobState = Job['state'];
export type Capture = Schemas['Capture'];
export type Fit = Schemas['Fit'];
export type Twin = Schemas['Twin'];
export type Worker = Schemas['Worker'];

/** True if a job will not change any more. */
export function hasEnded(job: Job): boolean {
  return job.state !== 'QUEUED' && job.state !== 'RUNNING';
}
