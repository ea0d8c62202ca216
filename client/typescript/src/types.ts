/** Resources of the API, as the description has them. */
import type { components } from './schema.js';

type Schemas = components['schemas'];

export type Fault = Schemas['Fault'];
export type Progress = Schemas['Progress'];
export type Job = Schemas['Job'];
export type Capture = Schemas['Capture'];
export type Supplement = Schemas['Supplement'];
export type Fit = Schemas['Fit'];
export type FitPreview = Schemas['FitPreview'];
export type Twin = Schemas['Twin'];
export type TrashedResource = Schemas['TrashedResource'];
export type Worker = Schemas['Worker'];
export type Share = Schemas['Share'];
export type OwnerUsage = Schemas['OwnerUsage'];
export type SignIn = Schemas['SignInOptions'];
export type LossCurve = Schemas['FitLosses.LossCurve'];
export type Evaluation = Schemas['Evaluation'];
export type PredictedMotion = Schemas['PredictedMotion'];
export type TwinGeometry = Schemas['TwinGeometry'];
export type TwinSurface = Schemas['TwinSurface'];
export type World = Schemas['World'];
export type Collider = Schemas['Collider'];
export type Tensor = Schemas['Tensor'];
export type RollOutRequest = Schemas['RollOutRequest'];
export type RollOutResponse = Schemas['RollOutResponse'];

/** True if a job will not change any more. */
export function hasEnded(job: Job): boolean {
  return job.state !== 'QUEUED' && job.state !== 'RUNNING';
}

/** Time from the start of a job to its end [s]; null before. */
export function tookS({ start_time, end_time }: Job): number | null {
  return start_time && end_time ? (Date.parse(end_time) - Date.parse(start_time)) / 1000 : null;
}
