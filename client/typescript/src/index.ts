/** Client of BendTwin's HTTP API. */
export { pauseMs, sleep } from './backoff.js';
export { Client, type ClientOptions } from './client.js';
export { Connection, ServerLost } from './connection.js';
export { watch, type WatchOptions } from './events.js';
export { Problem, problemOf } from './problem.js';
export { addressOf, idOf, type Arguments, type Body, type Path, type Query, type Reply, type Verb } from './routes.js';
export type { components, operations, paths } from './schema.js';
export { messages, Parser, type Message } from './sse.js';
export { base64, bytes, bytesOfBase64, doubles, floats, indices, packed, type PackedTensor } from './tensor.js';
export { openTwinFile, readHeader, startOfData, type Entry, type OpenTwinFile } from './twin_file.js';
export * from './types.js';
