// Headsets (WebXR): a button that is there where a headset is, and the loop that draws both eyes.
quadratura.headset = (() => {
  "use strict";

  // Returns the lens in pixels of an eye's projection, a matrix by columns, in a picture of this size.
  function lensOf(projection, width, height) {
    return { fx: projection[0] * width / 2, fy: projection[5] * height / 2, cx: (1 - projection[8]) * width / 2, cy: (1 + projection[9]) * height / 2, width, height };
  }

  // Draws frames until the session ends. Places are in metres from where the head was at first.
  async function show(session, target, visitor) {
    const gl = target.gl;
    await gl.makeXRCompatible();
    const layer = new XRWebGLLayer(session, gl, { antialias: false, depth: false });
    session.updateRenderState({ baseLayer: layer });
    const local = await session.requestReferenceSpace("local");
    let origin = null;
    const draw = (time, frame) => {
      session.requestAnimationFrame(draw);
      const pose = frame.getViewerPose(origin || local);
      if (!pose || gl.isContextLost()) return;
      if (!origin) {
        const { x, y, z } = pose.transform.position;
        origin = local.getOffsetReferenceSpace(new XRRigidTransform({ x, y, z }));
        return;
      }
      for (const eye of pose.views) {
        const { x, y, width, height } = layer.getViewport(eye);
        visitor.drawEye({ lens: lensOf(eye.projectionMatrix, width, height), projection: eye.projectionMatrix, place: eye.transform.matrix, worldToEye: eye.transform.inverse.matrix });
        target.show(layer.framebuffer, [x, y, width, height]);
      }
    };
    session.addEventListener("select", (event) => {
      const ray = visitor.point && origin && event.frame.getPose(event.inputSource.targetRaySpace, origin);
      if (ray) visitor.point(ray.transform.matrix);
    });
    session.requestAnimationFrame(draw);
  }

  // Lets a button show a visitor's view in a headset. `visitor` has drawEye, which draws an eye on the target, and may have point, which
  // is called with the place of a pointing hand, and left, which is called at the end.
  async function offer(button, target, visitor) {
    button.hidden = !navigator.xr || !await navigator.xr.isSessionSupported("immersive-vr").catch(() => false);
    const enter = async () => {
      const session = await navigator.xr.requestSession("immersive-vr");
      quadratura.inHeadset = true;
      session.addEventListener("end", () => {
        quadratura.inHeadset = false;
        if (visitor.left) visitor.left();
      });
      await show(session, target, visitor).catch((error) => { session.end(); throw error; });
    };
    button.onclick = () => enter().catch((error) => quadratura.say("The headset does not start: " + error.message));
  }

  return { offer, lensOf };
})();
