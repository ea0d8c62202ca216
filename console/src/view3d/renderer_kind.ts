/** Names of renderers that need no GPU. */
const SOFTWARE = /swiftshader|llvmpipe|software|basic render/i;

/** True if the browser draws without a GPU: smooth edges would cost more than they are worth there. */
export function drawsInSoftware(): boolean {
  const probe = document.createElement('canvas').getContext('webgl2', { failIfMajorPerformanceCaveat: true });
  if (probe === null) return true;
  const names = probe.getExtension('WEBGL_debug_renderer_info');
  const name = String(probe.getParameter(names?.UNMASKED_RENDERER_WEBGL ?? probe.RENDERER));
  probe.getExtension('WEBGL_lose_context')?.loseContext();
  return SOFTWARE.test(name);
}
